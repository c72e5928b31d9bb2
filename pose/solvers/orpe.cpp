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
// - F_q is minimised from the LSPE solution on the same points, by Marquardt's method on
//     gradient  g = sum w_i g_i,   g_i = 2 J_i^T r_i,
//     Hessian   sum w_i 2 J_i^T J_i + q (sum w_i g_i g_i^T - g g^T),
//   q rising in stages, q = c / max f_i with c = kStages. At the end max f_i is above the exact
//   minimax by at most ln(n) / 512 of itself (0.4 % for n = 8; about a tenth of a percent was
//   measured).
// - f_i below kZeroResidualPx2 count as zero: exact data have no largest error, and Lambda is 1.
// - Covariances of pixels are ignored, as in the paper.

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "pose/reprojection.h"
#include "pose/solvers/solvers.h"

namespace sightline {
namespace {

constexpr std::array<double, 3> kStages = {16, 64, 512};
constexpr int kMaxStageIterations = 100;
/// Stages but the last only lead to the next one.
constexpr double kLeadingTolerance = 1e-4;
/// (1e-6 px)^2: far below any noise, far above rounding.
constexpr double kZeroResidualPx2 = 1e-12;

/// Log-sum-exp of the squared residuals, shifted by the largest so that no exponent overflows.
struct Entropy {
  double value_px2 = 0;
  double largest_px2 = 0;
  double weight_sum = 0;  ///< of exp(q (f_i - largest))
  std::size_t largest_index = 0;
};

std::optional<Entropy> entropy(const Correspondences& c, const Pose& pose, double q) {
  Entropy e;
  for (std::size_t i = 0; i < c.size(); ++i) {
    const std::optional<Eigen::Vector2d> r = residual_px(c, i, pose);
    if (!r) return std::nullopt;
    const double f = r->squaredNorm();
    if (f > e.largest_px2 || i == 0) {
      e.weight_sum *= std::exp(q * (e.largest_px2 - f));
      e.largest_px2 = f;
      e.largest_index = i;
    }
    e.weight_sum += std::exp(q * (f - e.largest_px2));
  }
  e.value_px2 = e.largest_px2 + std::log(e.weight_sum) / q;
  return e;
}

std::optional<LocalModel> entropy_model(const Correspondences& c, const Pose& pose, double q) {
  const std::optional<Entropy> e = entropy(c, pose, q);
  if (!e) return std::nullopt;
  LocalModel model;
  model.cost = e->value_px2;
  for (std::size_t i = 0; i < c.size(); ++i) {
    const std::optional<Reprojection> r = reproject(c, i, pose);
    if (!r) return std::nullopt;
    const double f = r->residual_px.squaredNorm();
    const double weight = std::exp(q * (f - e->largest_px2)) / e->weight_sum;
    const Vector6d slope = 2 * r->jacobian.transpose() * r->residual_px;
    model.gradient += weight * slope;
    model.hessian.noalias() += (2 * weight) * r->jacobian.transpose() * r->jacobian;
    model.hessian.noalias() += (q * weight) * slope * slope.transpose();
  }
  model.hessian.noalias() -= q * model.gradient * model.gradient.transpose();
  return model;
}

struct Minimax {
  PoseStatus status = PoseStatus::kDiverged;
  Pose cam_from_centred;
  double largest_px2 = 0;         ///< max f_i, zero when below kZeroResidualPx2
  std::size_t largest_index = 0;  ///< the point m
  int iterations = 0;
};

/// Minimises F_q from the LSPE solution on the same points, q rising in stages.
Minimax minimax(const Correspondences& c, const std::optional<Pose>& initial_cam_from_target,
                const SolverOptions& options) {
  const LeastSquares start =
      least_squares(c, starting_poses(c, initial_cam_from_target), options.lspe);
  Minimax result = {start.status, start.cam_from_centred, 0, 0, start.iterations};
  if (result.status != PoseStatus::kOk) return result;

  for (const double stage : kStages) {
    const double largest = entropy(c, result.cam_from_centred, 1)->largest_px2;
    if (largest < kZeroResidualPx2) return result;
    const double q = stage / largest;
    const auto evaluate = [&c, q](const Pose& pose) { return entropy_model(c, pose, q); };
    const double tolerance =
        stage == kStages.back() ? options.lspe.step_tolerance : kLeadingTolerance;
    const Minimum minimum =
        minimise(result.cam_from_centred, evaluate, kMaxStageIterations, tolerance);
    result.cam_from_centred = minimum.pose;
    result.iterations += minimum.iterations;
  }
  const std::optional<Entropy> end = entropy(c, result.cam_from_centred, 1);
  result.largest_px2 = end->largest_px2;
  result.largest_index = end->largest_index;
  return result;
}

/// Lambda of step 2.
double residual_ratio(const Minimax& with_all, const Minimax& without_m) {
  if (with_all.largest_px2 < kZeroResidualPx2) return 1;
  return with_all.largest_px2 / std::max(without_m.largest_px2, 1e-300);
}

std::optional<Matrix6d> unit_covariance(const Correspondences& c, const Pose& cam_from_centred) {
  Matrix6d information = Matrix6d::Zero();
  for (std::size_t i = 0; i < c.size(); ++i) {
    const std::optional<Reprojection> r = reproject(c, i, cam_from_centred);
    if (!r) return std::nullopt;
    information.noalias() += r->jacobian.transpose() * r->jacobian;
  }
  return inverse_information(information);
}

}  // namespace

PoseEstimate solve_orpe(const PoseProblem& problem, const SolverOptions& options) {
  PoseEstimate estimate;
  PreparedProblem prepared = prepare(problem);
  estimate.status = prepared.status;
  if (estimate.status != PoseStatus::kOk) return estimate;

  Correspondences kept = std::move(prepared.correspondences);
  std::vector<int> kept_indices(kept.size());
  std::iota(kept_indices.begin(), kept_indices.end(), 0);

  Minimax current = minimax(kept, problem.initial_cam_from_target, options);
  estimate.iterations = current.iterations;
  while (current.status == PoseStatus::kOk && kept.size() > kMinimumPosePoints) {
    const std::size_t m = current.largest_index;
    Correspondences rest = without(kept, m);
    const Minimax without_m = minimax(rest, problem.initial_cam_from_target, options);
    estimate.iterations += without_m.iterations;
    if (without_m.status != PoseStatus::kOk) break;  // collinear without m
    if (residual_ratio(current, without_m) < options.orpe.rho) break;
    estimate.removed.push_back(kept_indices[m]);
    kept_indices.erase(kept_indices.begin() + static_cast<std::ptrdiff_t>(m));
    kept = std::move(rest);
    current = without_m;
  }
  std::sort(estimate.removed.begin(), estimate.removed.end());
  estimate.status = current.status;
  if (estimate.status != PoseStatus::kOk) return estimate;

  const std::optional<Matrix6d> covariance = unit_covariance(kept, current.cam_from_centred);
  if (!covariance) {
    estimate.status = PoseStatus::kDegenerate;
    return estimate;
  }
  estimate.cam_from_target = from_centred(current.cam_from_centred, kept);
  estimate.unit_covariance = covariance_from_centred(*covariance, current.cam_from_centred, kept);
  return estimate;
}

}  // namespace sightline
