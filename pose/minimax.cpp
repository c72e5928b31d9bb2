// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// min t subject to f_i(x) + s_i = t, s_i >= 0, over poses x, f_i = |r_i|^2, by a primal-dual
// interior point method with Mehrotra's predictor and corrector (S. Wright: Primal-dual
// interior-point methods, 1997, chapter 10; for problems of this kind C. Olsson, A. Eriksson,
// F. Kahl: "Efficient optimization for L-infinity problems using pseudoconvexity", ICCV 2007).
//
// With multipliers l_i > 0, slopes g_i = 2 J_i^T r_i, w_i = l_i / s_i, misses m_i = f_i + s_i - t
// and p_i = (mu - correction_i + l_i m_i) / s_i, Newton's step for  sum l_i g_i = 0,  sum l_i = 1,
// l_i s_i = mu,  m_i = 0  is, ds_i and dl_i eliminated,
//
//   [H + sum w_i g_i g_i^T   -sum w_i g_i] [dx]   [-sum p_i g_i]
//   [-sum w_i g_i^T           sum w_i    ] [dt] = [ sum p_i - 1 ]
//   ds_i = dt - g_i . dx - m_i,   dl_i = (mu - correction_i - l_i ds_i) / s_i - l_i,
//   H = sum 2 l_i J_i^T J_i, and after a few iterations the second derivatives of r_i as well.
//
// The corrector takes into account ds_i dl_i, as Mehrotra's does, and |J_i dx|^2, the second order
// of f_i where the residual is linear in the pose. Seven iterations reach a gap of 1e-9.
//
// There is no line search. Where the iteration wanders (one problem in ten thousand, where the
// active constraints leave a direction almost free) it is begun again from the lowest maximum that
// it passed.

#include "pose/minimax.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

namespace sightline {
namespace {

/// One constraint f + slack = t: its residual, derivative and slope at the pose, and the unknowns
/// that are its own.
struct Constraint {
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, 6> jacobian;
  Vector6d slope;
  double f = 0;
  double slack = 0;
  double multiplier = 0;
  double miss = 0;        ///< f + slack - t
  double correction = 0;  ///< of second order: of l s
  double slack_change = 0;
  double multiplier_change = 0;
};

void fix_part(Eigen::Matrix<double, 2, 6>& jacobian, FreePart free) {
  if (free == FreePart::kRotation) jacobian.rightCols<3>().setZero();
  if (free == FreePart::kTranslation) jacobian.leftCols<3>().setZero();
}

/// Fills residuals, derivatives, slopes and f at a pose. False where a point is behind the camera
/// or a number is not finite.
bool evaluate(const FitPoints& points, const Pose& pose, FreePart free,
              std::vector<Constraint>& constraints) {
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const std::optional<Reprojection> r = reproject(points, i, pose);
    if (!r) return false;
    Constraint& c = constraints[i];
    c.residual = r->residual_px;
    c.jacobian = r->jacobian;
    if (free != FreePart::kPose) fix_part(c.jacobian, free);
    c.slope.noalias() = c.jacobian.transpose() * (2 * c.residual);
    c.f = r->residual_px.squaredNorm();
    if (!std::isfinite(c.f)) return false;
  }
  return true;
}

double largest_of(const std::vector<Constraint>& constraints) {
  double largest = 0;
  for (const Constraint& c : constraints) largest = std::max(largest, c.f);
  return largest;
}

double mean_product(const std::vector<Constraint>& constraints) {
  double sum = 0;
  for (const Constraint& c : constraints) sum += c.multiplier * c.slack;
  return sum / static_cast<double>(constraints.size());
}

/// A positive definite matrix, rows scaled to a unit diagonal, ready for solving. What is fixed has
/// a zero row and stays.
class ScaledCholesky {
 public:
  ScaledCholesky(const Matrix6d& matrix, double ridge) {
    for (int i = 0; i < 6; ++i) scale_[i] = matrix(i, i) > 0 ? 1 / std::sqrt(matrix(i, i)) : 0;
    Matrix6d scaled = scale_.asDiagonal() * matrix * scale_.asDiagonal();
    for (int i = 0; i < 6; ++i) scaled(i, i) = 1 + ridge;
    cholesky_.compute(scaled);
  }
  bool is_ok() const { return cholesky_.info() == Eigen::Success; }
  Vector6d solve(const Vector6d& right) const {
    return scale_.cwiseProduct(cholesky_.solve(scale_.cwiseProduct(right)));
  }

 private:
  Vector6d scale_;
  Eigen::LLT<Matrix6d> cholesky_;
};

/// The factored Newton matrix, dt and the multipliers eliminated.
struct NewtonSystem {
  std::optional<ScaledCholesky> matrix;
  Vector6d coupling = Vector6d::Zero();  ///< sum w g
  double weight_sum = 0;
  double ridge = 0;
};

/// Sum of l_i times the part of the second derivative of f_i that Gauss and Newton leave out,
/// 2 r_i . (second derivative of r_i), by (w, dt) in (Exp(w) R, t + dt).
Matrix6d residual_curvature(const FitPoints& points, const Pose& pose, FreePart free,
                            const std::vector<Constraint>& constraints) {
  const Correspondences& camera = points.correspondences;
  Matrix6d sum = Matrix6d::Zero();
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const std::size_t index = points.index(i);
    const Eigen::Vector3d q = pose.rotation * camera.points_in_centred[index];
    const Eigen::Vector3d x = q + pose.translation;
    Eigen::Vector2d pull = 2 * constraints[i].multiplier * constraints[i].residual;
    if (!points.whitening.empty()) pull = (points.whitening[index].transpose() * pull).eval();
    // Of a x / z + b y / z by the point: gradient and second derivative.
    const double inverse_z = 1 / x.z();
    const double a = pull.x() * camera.fx_px * inverse_z;
    const double b = pull.y() * camera.fy_px * inverse_z;
    const double c = (a * x.x() + b * x.y()) * inverse_z;
    const Eigen::Vector3d gradient(a, b, -c);
    Eigen::Matrix3d second;
    second << 0, 0, -a, 0, 0, -b, -a, -b, 2 * c;
    second *= inverse_z;
    // x moves by w x q + dt, and by w x (w x q) / 2 at second order.
    Eigen::Matrix<double, 3, 6> motion;
    motion << 0, q.z(), -q.y(), 1, 0, 0, -q.z(), 0, q.x(), 0, 1, 0, q.y(), -q.x(), 0, 0, 0, 1;
    sum.noalias() += motion.transpose() * second * motion;
    sum.topLeftCorner<3, 3>() += 0.5 * (gradient * q.transpose() + q * gradient.transpose()) -
                                 gradient.dot(q) * Eigen::Matrix3d::Identity();
  }
  if (free == FreePart::kRotation) sum.rightCols<3>().setZero(), sum.bottomRows<3>().setZero();
  if (free == FreePart::kTranslation) sum.leftCols<3>().setZero(), sum.topRows<3>().setZero();
  return sum;
}

/// `curvature` is residual_curvature or zero; where it makes the matrix indefinite the diagonal is
/// raised by a ridge, a part of itself, and by `least_ridge` in any case.
std::optional<NewtonSystem> newton_system(const std::vector<Constraint>& constraints,
                                          const Matrix6d& curvature, double least_ridge) {
  NewtonSystem system;
  Matrix6d matrix = Matrix6d::Zero();
  for (const Constraint& c : constraints) {
    const double weight = c.multiplier / c.slack;
    system.coupling += weight * c.slope;
    system.weight_sum += weight;
    // 2 l J^T J + w g g^T = J^T (2 l I + 4 w r r^T) J
    Eigen::Matrix2d core = (4 * weight) * c.residual * c.residual.transpose();
    core.diagonal().array() += 2 * c.multiplier;
    const Eigen::Matrix<double, 2, 6> cored = core * c.jacobian;
    matrix.noalias() += c.jacobian.transpose() * cored;
  }
  matrix.noalias() -= system.coupling * (system.coupling / system.weight_sum).transpose();
  matrix += curvature;
  for (const double ridge : {1e-13, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0}) {
    if (ridge < least_ridge) continue;
    system.ridge = ridge;
    system.matrix.emplace(matrix, ridge);
    if (system.matrix->is_ok()) return system;
  }
  return std::nullopt;
}

struct Step {
  Vector6d delta;
  double dt = 0;
};

/// The larger of a step's turn in radians and its move as a part of the range.
double length(const Step& step, const Pose& pose) {
  return std::max(step.delta.head<3>().norm(),
                  step.delta.tail<3>().norm() / pose.translation.norm());
}

/// Solves for the step towards l s = mu - correction and f + s = t, and stores the constraints' own
/// changes with them.
Step newton_step(const NewtonSystem& system, std::vector<Constraint>& constraints, double mu) {
  Vector6d right = Vector6d::Zero();
  double excess = -1;
  for (const Constraint& c : constraints) {
    const double pull = (mu - c.correction + c.multiplier * c.miss) / c.slack;
    right -= pull * c.slope;
    excess += pull;
  }
  Step step;
  step.delta = system.matrix->solve(right + (excess / system.weight_sum) * system.coupling);
  step.dt = (excess + system.coupling.dot(step.delta)) / system.weight_sum;
  for (Constraint& c : constraints) {
    c.slack_change = step.dt - c.slope.dot(step.delta) - c.miss;
    c.multiplier_change =
        (mu - c.correction - c.multiplier * c.slack_change) / c.slack - c.multiplier;
  }
  return step;
}

struct StepLengths {
  double primal = 1;
  double dual = 1;
};

/// The longest steps, at most 1, that keep slacks and multipliers at 1 - `part` of themselves.
StepLengths longest_steps(const std::vector<Constraint>& constraints, double part) {
  StepLengths lengths;
  for (const Constraint& c : constraints) {
    if (c.slack_change < 0) {
      lengths.primal = std::min(lengths.primal, -part * c.slack / c.slack_change);
    }
    if (c.multiplier_change < 0) {
      lengths.dual = std::min(lengths.dual, -part * c.multiplier / c.multiplier_change);
    }
  }
  return lengths;
}

/// Mehrotra's predictor: where a step straight to mu = 0 would bring the products says how far mu
/// may fall now, and what the step's second order is.
double predict(std::vector<Constraint>& constraints, const Step& step, double products) {
  const StepLengths lengths = longest_steps(constraints, 1);
  double predicted = 0;
  for (Constraint& c : constraints) {
    predicted += (c.slack + lengths.primal * c.slack_change) *
                 (c.multiplier + lengths.dual * c.multiplier_change);
    c.correction = c.slack_change * c.multiplier_change;
    // The residual is nearly linear in the pose, f its square.
    c.miss += (c.jacobian * step.delta).squaredNorm();
  }
  const double part = predicted / static_cast<double>(constraints.size()) / products;
  return products * part * part * part;
}

/// (max f - lower bound) / max f, the bound being the minimum of sum l f for residuals that are
/// linear in the pose.
double relative_gap(const std::vector<Constraint>& constraints) {
  double sum = 0;
  for (const Constraint& c : constraints) sum += c.multiplier;
  double largest = 0;
  double weighted = 0;
  Vector6d gradient = Vector6d::Zero();
  Matrix6d hessian = Matrix6d::Zero();
  for (const Constraint& c : constraints) {
    const double weight = c.multiplier / sum;
    largest = std::max(largest, c.f);
    weighted += weight * c.f;
    gradient += weight * c.slope;
    hessian.noalias() += c.jacobian.transpose() * (2 * weight * c.jacobian);
  }
  constexpr double kRidge = 1e-14;
  const ScaledCholesky cholesky(hessian, kRidge);
  if (!cholesky.is_ok()) return 1;
  const double bound = weighted - 0.5 * gradient.dot(cholesky.solve(gradient));
  const double gap = (largest - bound) / largest;
  return gap < 1 ? std::max(gap, 0.0) : 1;
}

/// The iteration from one start; storage for several.
class InteriorPoint {
 public:
  InteriorPoint(const FitPoints& points, const MinimaxOptions& options)
      : points_(points), options_(options), constraints_(points.size()) {}

  /// Where the maximum was lowest so far.
  const Pose& lowest() const { return lowest_; }

  /// Iterates until the gap is closed or the limit is reached. Second derivatives of the residuals
  /// are left out in the first `gauss_newton_iterations`.
  Minimax run(const Pose& start, int gauss_newton_iterations, int max_iterations) {
    Minimax result;
    result.cam_from_centred = start;
    result.multipliers.assign(constraints_.size(), 1 / static_cast<double>(constraints_.size()));
    lowest_ = start;
    if (!evaluate(points_, start, options_.free, constraints_)) {
      result.status = PoseStatus::kBehindCamera;
      return result;
    }
    lowest_px2_ = largest_of(constraints_);
    if (lowest_px2_ < kZeroResidualPx2) return exact(std::move(result));

    centre();
    while (result.iterations < max_iterations) {
      ++result.iterations;
      const bool is_exact = result.iterations > gauss_newton_iterations;
      if (!step(result.cam_from_centred, is_exact)) break;
      const double largest_px2 = largest_of(constraints_);
      if (largest_px2 < kZeroResidualPx2) return exact(std::move(result));
      if (largest_px2 < lowest_px2_) {
        lowest_px2_ = largest_px2;
        lowest_ = result.cam_from_centred;
      }
      const double products = mean_product(constraints_) * static_cast<double>(points_.size());
      if (products > options_.relative_gap * largest_px2) continue;
      const double gap = relative_gap(constraints_);
      if (gap > options_.relative_gap) continue;
      result.relative_gap = gap;
      break;
    }
    return finished(std::move(result));
  }

 private:
  /// Slacks and multipliers of equal products at a pose; the multipliers sum to one.
  void centre() {
    constexpr double kInitialSlack = 0.3;  // of the largest residual
    t_ = (1 + kInitialSlack) * largest_of(constraints_);
    double inverse_sum = 0;
    for (Constraint& c : constraints_) {
      c.slack = t_ - c.f;
      inverse_sum += 1 / c.slack;
    }
    for (Constraint& c : constraints_) c.multiplier = 1 / (c.slack * inverse_sum);
  }

  /// One predictor and corrector. False where there is none, or where it leads behind the camera.
  bool step(Pose& pose, bool is_exact) {
    constexpr double kTowardsBoundary = 0.99;
    constexpr double kSmallestMu = 1e-3;  // of what the gap allows
    constexpr double kLongestTurn = 0.3;
    constexpr double kLargestRidge = 0.05;
    constexpr int kMostHalvings = 8;
    const Matrix6d curvature = is_exact
                                   ? residual_curvature(points_, pose, options_.free, constraints_)
                                   : Matrix6d::Zero();
    std::optional<NewtonSystem> system = newton_system(constraints_, curvature, 0);
    if (!system) return false;
    for (Constraint& c : constraints_) {
      c.miss = c.f + c.slack - t_;
      c.correction = 0;
    }
    const double products = mean_product(constraints_);
    const double smallest_mu = kSmallestMu * options_.relative_gap * largest_of(constraints_) /
                               static_cast<double>(points_.size());
    Step predictor = newton_step(*system, constraints_, 0);
    while (is_exact && system->ridge < kLargestRidge && length(predictor, pose) > kLongestTurn) {
      system = newton_system(constraints_, curvature, 5 * system->ridge);
      if (!system) return false;
      predictor = newton_step(*system, constraints_, 0);
    }
    const double mu = std::max(predict(constraints_, predictor, products), smallest_mu);
    const Step corrected = newton_step(*system, constraints_, mu);

    StepLengths lengths = longest_steps(constraints_, kTowardsBoundary);
    const double turn = length(corrected, pose);
    if (lengths.primal * turn > kLongestTurn) lengths.primal = kLongestTurn / turn;
    Pose candidate = retract(pose, lengths.primal * corrected.delta);
    int halvings = 0;
    while (!evaluate(points_, candidate, options_.free, constraints_)) {
      if (++halvings > kMostHalvings) {
        evaluate(points_, pose, options_.free, constraints_);
        return false;
      }
      lengths.primal *= 0.5;
      candidate = retract(pose, lengths.primal * corrected.delta);
    }
    pose = candidate;
    t_ += lengths.primal * corrected.dt;
    for (Constraint& c : constraints_) {
      // A slack may grow to what there is: the constraint is then met.
      c.slack = std::max(c.slack + lengths.primal * c.slack_change, t_ - c.f);
      c.multiplier += lengths.dual * c.multiplier_change;
    }
    return true;
  }

  static Minimax exact(Minimax result) {
    result.status = PoseStatus::kOk;
    result.largest_px2 = 0;
    result.relative_gap = 0;
    return result;
  }

  Minimax finished(Minimax result) const {
    double sum = 0;
    for (const Constraint& c : constraints_) sum += c.multiplier;
    for (std::size_t i = 0; i < constraints_.size(); ++i) {
      result.multipliers[i] = constraints_[i].multiplier / sum;
    }
    result.largest_px2 = largest_of(constraints_);
    const double promised = std::max(kMinimaxGap, options_.relative_gap);
    if (!(result.relative_gap <= promised)) result.relative_gap = relative_gap(constraints_);
    if (result.relative_gap <= promised) result.status = PoseStatus::kOk;
    return result;
  }

  FitPoints points_;
  MinimaxOptions options_;
  std::vector<Constraint> constraints_;
  double t_ = 0;
  double lowest_px2_ = 0;
  Pose lowest_;
};

}  // namespace

std::size_t Minimax::most_binding() const {
  return static_cast<std::size_t>(std::max_element(multipliers.begin(), multipliers.end()) -
                                  multipliers.begin());
}

std::optional<Reprojection> reproject(const FitPoints& points, std::size_t i,
                                      const Pose& cam_from_centred) {
  const std::size_t index = points.index(i);
  std::optional<Reprojection> r = reproject(points.correspondences, index, cam_from_centred);
  if (!r || points.whitening.empty()) return r;
  const Eigen::Matrix2d& whitening = points.whitening[index];
  r->residual_px = (whitening * r->residual_px).eval();
  r->jacobian = (whitening * r->jacobian).eval();
  return r;
}

Minimax minimax_from(const FitPoints& points, const Pose& cam_from_centred_start,
                     const MinimaxOptions& options) {
  // Second derivatives cost a quarter more a step, and only one problem in a hundred needs them.
  constexpr int kGaussNewtonIterations = 8;
  constexpr std::array<int, 4> kAttempts = {30, 60, 60, 60};

  InteriorPoint iteration(points, options);
  Pose start = cam_from_centred_start;
  Minimax result;
  int iterations = 0;
  for (const int max_iterations : kAttempts) {
    result = iteration.run(start, iterations == 0 ? kGaussNewtonIterations : 0, max_iterations);
    iterations += result.iterations;
    if (result.status != PoseStatus::kDiverged) break;
    start = iteration.lowest();
  }
  result.iterations = iterations;
  return result;
}

namespace {

PackedPoints packed(const FitPoints& points) {
  std::vector<Eigen::Matrix2d> weights(points.correspondences.size(), Eigen::Matrix2d::Zero());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t point = points.index(i);
    weights[point] =
        points.whitening.empty()
            ? Eigen::Matrix2d(Eigen::Matrix2d::Identity())
            : Eigen::Matrix2d(points.whitening[point].transpose() * points.whitening[point]);
  }
  return PackedPoints(points.correspondences, weights);
}

}  // namespace

LeastSquares least_squares(const FitPoints& points, std::span<const Pose> cam_from_centred_starts,
                           const LspeOptions& options) {
  return least_squares(packed(points), cam_from_centred_starts, options);
}

std::optional<Matrix6d> unit_covariance(const FitPoints& points, const Pose& cam_from_centred) {
  const std::optional<Matrix6d> information = information_at(packed(points), cam_from_centred);
  return information ? inverse_information(*information) : std::nullopt;
}

PoseEstimate with_pose(PoseEstimate estimate, const FitPoints& points,
                       const Pose& cam_from_centred) {
  // For unit noise, whatever the points were weighted by.
  const FitPoints unweighted = {points.correspondences, points.kept, {}};
  const std::optional<Matrix6d> covariance = unit_covariance(unweighted, cam_from_centred);
  const Correspondences& c = points.correspondences;
  const Pose cam_from_target = from_centred(cam_from_centred, c);
  // A target that was pushed to the end of the numbers, where all its points fall on one pixel.
  const bool is_finite = covariance && covariance->allFinite() && is_valid(cam_from_target);
  if (!is_finite) {
    estimate.status = PoseStatus::kDegenerate;
    return estimate;
  }
  estimate.cam_from_target = cam_from_target;
  estimate.unit_covariance = covariance_from_centred(*covariance, cam_from_centred, c);
  return estimate;
}

PoseEstimate with_least_squares(PoseEstimate estimate, const FitPoints& points,
                                const Pose& cam_from_centred_start, const LspeOptions& options) {
  const LeastSquares fit = least_squares(points, {&cam_from_centred_start, 1}, options);
  estimate.iterations += fit.iterations;
  estimate.status = fit.status;
  if (fit.status != PoseStatus::kOk) return estimate;
  return with_pose(std::move(estimate), points, fit.cam_from_centred);
}

std::size_t minority_limit(std::size_t points, const OutlierOptions& options) {
  constexpr std::size_t kFewestKept = 4;
  const std::size_t most = points > kFewestKept ? points - kFewestKept : 0;
  const std::size_t minority = points > 0 ? (points - 1) / 2 : 0;
  const std::size_t asked =
      options.max_removed ? static_cast<std::size_t>(std::max(*options.max_removed, 0)) : minority;
  return std::min(most, asked);
}

Minimax minimax(const FitPoints& points, std::span<const Pose> cam_from_centred_starts,
                const SolverOptions& options, const MinimaxOptions& minimax_options) {
  Minimax best;
  best.status = PoseStatus::kDegenerate;
  int iterations = 0;
  for (const Pose& start : cam_from_centred_starts) {
    const LeastSquares begin = least_squares(points, {&start, 1}, options.lspe);
    iterations += begin.iterations;
    Minimax fit;
    fit.status = begin.status;
    // Where least squares stopped is a start as good as another.
    if (begin.status == PoseStatus::kOk || begin.status == PoseStatus::kDiverged) {
      fit = minimax_from(points, begin.cam_from_centred, minimax_options);
    }
    iterations += fit.iterations;
    const bool is_first = &start == cam_from_centred_starts.data();
    const bool is_ok = fit.status == PoseStatus::kOk;
    const bool was_ok = best.status == PoseStatus::kOk;
    if (is_first || (is_ok && (!was_ok || fit.largest_px2 < best.largest_px2))) {
      best = std::move(fit);
    }
  }
  best.iterations = iterations;
  return best;
}

}  // namespace sightline
