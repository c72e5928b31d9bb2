// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// ORPE, outlier-removal pose estimation, f_i = (u~_i - u_i)^2 + (v~_i - v_i)^2 the squared
// reprojection error of point i:
//
//   (theta, T) = arg min max_i f_i                                                   (5)
//              ~ arg min F_q,   F_q = (1/q) ln sum_i exp(q f_i)                      (6)
//   1. Minimise F_q on the current points; m is the point of largest error           (7)
//   2. Lambda = [min max_i f_i] / [min max_{i != m} f_i]
//   3. Lambda >= rho: remove m, go to 1.
//   4. The pose is the minimiser of (6) on what is left.
//
// Zhao, Zhang, Zuo, Xu: "A method of improving the measuring accuracy of the pose of targets based
// on outliers-removal", Acta Optica Sinica 29(9), 2009, section 3.
//
// Needs four points that are not collinear, or three with an initial pose. Never leaves fewer than
// four, and with four there is no test: three points are met exactly, so that Lambda would always
// be infinite (the paper has no such rule). A point without which the others are collinear is kept
// as well.
//
// Deviations and choices:
// - The paper prints F_q without the q in the exponent, and Lambda with the same pose above and
//   below; here every minimum has its own pose.
// - At the exact minimax about five points tie at the maximum. At finite q the tie is broken: m is
//   the point of the largest weight exp(q f_i) / sum, the multiplier of its constraint.
// - F_q is minimised by Marquardt's method on
//     gradient  g = sum w_i g_i,   g_i = 2 J_i^T r_i,
//     Hessian   sum w_i 2 J_i^T J_i + q (sum w_i g_i g_i^T - g g^T);
//   q = kSharpness / max f_i, the maximum being that of the LSPE solution brought within
//   kLeadingGap of the exact minimax (pose/minimax.h), from where Marquardt's method starts. At the
//   end max f_i is above the exact minimax by at most about ln(n) / 512 of itself (0.4 % for n = 8;
//   about a tenth of a percent was measured).
// - LSPE without m starts from the pose with m, and of a plane from both mirror starts as well.
// - Where the iteration meets its limit the exact minimax (pose/minimax.h) is taken in
//   its place, m being the point of its largest multiplier; where that fails too: kDiverged.
// - f_i below kZeroResidualPx2 count as zero: exact data have no largest error, and Lambda is 1.
// - OrpeOptions::final may ask for least squares on what is left in place of step 4.
// - Covariances of pixels are ignored, as in the paper.

#include <algorithm>
#include <cmath>
#include <numeric>

#include "pose/fit_points.h"
#include "pose/minimax.h"
#include "pose/minimise.h"
#include "pose/reprojection.h"
#include "pose/solvers/solvers.h"
#include "pose/starts.h"

namespace sightline {
namespace {

constexpr double kSharpness = 512;
constexpr int kMaxIterations = 100;
constexpr double kLeadingGap = 1e-3;

/// The entropy function of some points: what of its evaluation is kept between poses is storage.
class EntropyFunction {
 public:
  explicit EntropyFunction(const FitPoints& points) : points_(points), terms_(points.size()) {}

  /// F_q with its gradient and Hessian. None where a point is behind the camera.
  std::optional<LocalModel> operator()(const Pose& pose, double q) {
    if (!evaluate(pose)) return std::nullopt;
    double sum = 0;  // of exp(q (f_i - largest)): no exponent overflows
    for (Term& term : terms_) sum += term.weight = std::exp(q * (term.f - largest_px2_));
    LocalModel model;
    model.cost = largest_px2_ + std::log(sum) / q;
    for (const Term& term : terms_) {
      const Eigen::Vector2d& r = term.reprojection.residual_px;
      const Eigen::Matrix<double, 2, 6>& jacobian = term.reprojection.jacobian;
      const double weight = term.weight / sum;
      model.gradient.noalias() += jacobian.transpose() * (2 * weight * r);
      // 2 w J^T J + q w g g^T = J^T (2 w I + 4 q w r r^T) J
      Eigen::Matrix2d core = (4 * q * weight) * r * r.transpose();
      core.diagonal().array() += 2 * weight;
      const Eigen::Matrix<double, 2, 6> cored = core * jacobian;
      model.hessian.noalias() += jacobian.transpose() * cored;
    }
    model.hessian.noalias() -= q * model.gradient * model.gradient.transpose();
    return model;
  }

  /// Takes f_i and its derivatives at a pose. False where a point is behind the camera.
  bool evaluate(const Pose& pose) {
    largest_px2_ = 0;
    largest_index_ = 0;
    for (std::size_t i = 0; i < terms_.size(); ++i) {
      const std::optional<Reprojection> r = reproject(points_, i, pose);
      if (!r) return false;
      terms_[i].reprojection = *r;
      terms_[i].f = r->residual_px.squaredNorm();
      if (!(terms_[i].f > largest_px2_)) continue;
      largest_px2_ = terms_[i].f;
      largest_index_ = i;
    }
    return true;
  }
  double largest_px2() const { return largest_px2_; }
  std::size_t largest_index() const { return largest_index_; }

 private:
  struct Term {
    Reprojection reprojection;
    double f = 0;
    double weight = 0;
  };
  FitPoints points_;
  std::vector<Term> terms_;
  double largest_px2_ = 0;
  std::size_t largest_index_ = 0;
};

/// The minimum of step 1 and its point m, by its position among the points.
struct Stage {
  PoseStatus status = PoseStatus::kDiverged;
  Pose cam_from_centred;
  double largest_px2 = 0;  ///< max f_i, zero when below kZeroResidualPx2
  std::size_t largest_index = 0;
  int iterations = 0;
};

/// The exact minimax in place of an entropy function that was not minimised.
Stage exact_stage(const FitPoints& points, const Pose& start, int iterations) {
  const Minimax fit = minimax_from(points, start);
  return {fit.status, fit.cam_from_centred, fit.largest_px2, fit.most_binding(),
          iterations + fit.iterations};
}

/// Minimises F_q from the LSPE solution on the same points.
Stage minimise_entropy(const FitPoints& points, std::span<const Pose> starts,
                       const SolverOptions& options) {
  const LeastSquares begin = least_squares(points, starts, options.lspe);
  Stage result = {begin.status, begin.cam_from_centred, 0, 0, begin.iterations};
  // Where least squares stopped is a start as good as another.
  if (begin.status != PoseStatus::kOk && begin.status != PoseStatus::kDiverged) return result;

  MinimaxOptions leading;
  leading.relative_gap = kLeadingGap;
  const Minimax lead = minimax_from(points, begin.cam_from_centred, leading);
  result.iterations += lead.iterations;
  EntropyFunction entropy(points);
  entropy.evaluate(lead.cam_from_centred);
  result.cam_from_centred = lead.cam_from_centred;
  result.status = PoseStatus::kOk;
  if (entropy.largest_px2() < kZeroResidualPx2) return result;

  const double q = kSharpness / entropy.largest_px2();
  const auto evaluate = [&entropy, q](const Pose& pose) { return entropy(pose, q); };
  const Minimum minimum =
      minimise(lead.cam_from_centred, evaluate, kMaxIterations, options.lspe.step_tolerance);
  result.iterations += minimum.iterations;
  if (minimum.status != PoseStatus::kOk) {
    return exact_stage(points, minimum.pose, result.iterations);
  }
  entropy.evaluate(minimum.pose);
  result.cam_from_centred = minimum.pose;
  result.largest_px2 = entropy.largest_px2();
  result.largest_index = entropy.largest_index();
  return result;
}

/// Lambda of step 2.
double residual_ratio(const Stage& with_all, const Stage& without_m) {
  if (with_all.largest_px2 < kZeroResidualPx2) return 1;
  return with_all.largest_px2 / std::max(without_m.largest_px2, 1e-300);
}

}  // namespace

PoseEstimate solve_orpe(const PoseProblem& problem, const SolverOptions& options) {
  PoseEstimate estimate;
  const PreparedProblem prepared = prepare(problem);
  estimate.status = prepared.status;
  if (estimate.status != PoseStatus::kOk) return estimate;

  const Correspondences& c = prepared.correspondences;
  const std::vector<Pose> free_starts = starting_poses(c, problem.initial_cam_from_target);
  std::vector<int> kept(c.size());
  std::iota(kept.begin(), kept.end(), 0);

  Stage current = minimise_entropy({c, kept, {}}, free_starts, options);
  estimate.iterations = current.iterations;
  // A ratio of one says that nothing was gained; no number at all (NaN) removes nothing.
  const double rho = options.orpe.rho <= 1 ? std::nextafter(1.0, 2.0) : options.orpe.rho;
  while (current.status == PoseStatus::kOk && kept.size() > kMinimumPosePoints) {
    std::vector<Pose> starts = {current.cam_from_centred};
    if (free_starts.size() > 1) starts.insert(starts.end(), free_starts.begin(), free_starts.end());
    std::vector<int> rest = kept;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(current.largest_index));
    const Stage without_m = minimise_entropy({c, rest, {}}, starts, options);
    estimate.iterations += without_m.iterations;
    if (without_m.status != PoseStatus::kOk) break;  // collinear without m
    if (!(residual_ratio(current, without_m) >= rho)) break;
    estimate.removed.push_back(kept[current.largest_index]);
    kept = std::move(rest);
    current = without_m;
  }
  std::sort(estimate.removed.begin(), estimate.removed.end());
  estimate.status = current.status;
  if (estimate.status != PoseStatus::kOk) return estimate;

  const FitPoints points = {c, kept, {}};
  if (options.orpe.final == OrpeOptions::Final::kMinimax) {
    return with_minimax_pose(std::move(estimate), points, current.cam_from_centred);
  }
  return with_least_squares(std::move(estimate), points, current.cam_from_centred, options.lspe);
}

}  // namespace sightline
