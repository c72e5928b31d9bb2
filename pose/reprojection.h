// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// What the solvers share: a problem made ready for computing, the reprojection errors with their
// analytic derivative, and the Marquardt iteration.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "pose/kernels/reprojection_kernel.h"
#include "pose/orthogonal_iteration.h"
#include "pose/pose.h"
#include "pose/solver.h"

namespace sightline {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Three points have up to four poses: only an initial pose says which is meant.
inline constexpr int kMinimumPosePoints = 4;
inline constexpr int kMinimumPosePointsFromInitial = 3;

/// A problem as the solvers see it. Points are taken about their centroid, so that the target's
/// frame does not matter and rotation and translation are nearly uncorrelated; this frame is called
/// `centred`. Pixels are free of distortion and relative to the principal point, so that the point
/// (x, y, z) of the camera frame is seen at (fx x / z, fy y / z).
struct Correspondences {
  double fx_px = 1;
  double fy_px = 1;
  Eigen::Vector3d centroid_in_target = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> points_in_centred;
  std::vector<Eigen::Vector2d> pixels;

  std::size_t size() const { return points_in_centred.size(); }
};

struct PreparedProblem {
  PoseStatus status = PoseStatus::kDegenerate;  ///< kOk: the correspondences may be used
  Correspondences correspondences;
};

/// Checks a problem and undoes the lens. kTooFewPoints below the minimum or when the lists
/// differ in length; kDegenerate when a number is not finite, a pixel cannot be undistorted, the
/// camera has no positive focal length, the initial pose is not a rigid one, or the points are
/// collinear or coincide.
PreparedProblem prepare(const PoseProblem& problem);

/// The same correspondences (in the same centred frame) but for one.
Correspondences without(const Correspondences& all, std::size_t index);

/// cam_from_centred = cam_from_target * target_from_centred, and back.
Pose to_centred(const Pose& cam_from_target, const Correspondences& c);
Pose from_centred(const Pose& cam_from_centred, const Correspondences& c);

/// The covariance of (w, dt) of cam_from_target, given that of cam_from_centred.
Matrix6d covariance_from_centred(const Matrix6d& covariance, const Pose& cam_from_centred,
                                 const Correspondences& c);

/// The principal axes of a cloud of points about its mean, longest first.
struct PointSpread {
  Eigen::Vector3d mean;
  Eigen::Matrix3d axes;  ///< columns: a right-handed orthonormal frame
  Eigen::Vector3d sd;    ///< along the axes, descending (not divided by n: roots of the sums)

  bool is_collinear() const { return !(sd[1] > 1e-6 * sd[0]); }
  bool is_nearly_planar() const { return sd[2] < 0.1 * sd[1]; }
};

PointSpread spread_of(std::span<const Eigen::Vector3d> points);

/// orthogonal_iteration_starts for a prepared problem; the poses are cam_from_centred.
std::vector<Pose> centred_starts(const Correspondences& c,
                                 const OrthogonalIterationOptions& options);

/// The scaled-orthographic pose of a target that is clearly not planar and far enough for it
/// (kWeakPerspective in orthogonal_iteration.cpp), as cam_from_centred; none otherwise.
std::optional<Pose> weak_perspective_start(const Correspondences& c);

/// Where the solvers begin, as cam_from_centred: at the initial pose if there is one, else at the
/// weak_perspective_start where that will do, else at what orthogonal iteration finds. Empty when
/// no start has all points in front of the camera.
std::vector<Pose> starting_poses(const Correspondences& c,
                                 const std::optional<Pose>& initial_cam_from_target);

/// The reprojection error of one point, predicted - observed in pixels, and its derivative by (w,
/// dt) in cam_from_centred = (Exp(w) R, t + dt).
struct Reprojection {
  Eigen::Vector2d residual_px;
  Eigen::Matrix<double, 2, 6> jacobian;
};

/// None for a point at or behind the camera's plane.
std::optional<Eigen::Vector2d> residual_px(const Correspondences& c, std::size_t index,
                                           const Pose& cam_from_centred);
std::optional<Reprojection> reproject(const Correspondences& c, std::size_t index,
                                      const Pose& cam_from_centred);

/// cost(delta) ~ cost + gradient . delta + 1/2 delta . hessian delta, delta = (w, dt).
struct LocalModel {
  double cost = 0;
  Vector6d gradient = Vector6d::Zero();
  Matrix6d hessian = Matrix6d::Zero();
};

/// (Exp(w) R, t + dt).
Pose retract(const Pose& pose, const Vector6d& delta);

/// Marquardt's step: minus the solution of (hessian + damping diag(hessian)) delta = gradient.
/// None where that matrix is not positive definite.
std::optional<Vector6d> marquardt_step(const LocalModel& model, double damping);

/// True when a step turns by less than `tolerance` radians and moves by less than that part of the
/// range.
bool is_short_step(const Vector6d& delta, const Pose& pose, double tolerance);

/// What the model says that a step gains.
double promised_decrease(const LocalModel& model, const Vector6d& delta);

/// The inverse of an information matrix. None unless it is positive definite by a margin, whatever
/// the units of its rows.
std::optional<Matrix6d> inverse_information(const Matrix6d& information);

struct Minimum {
  PoseStatus status = PoseStatus::kDiverged;  ///< kOk, kDiverged, or kBehindCamera for the start
  Pose pose;
  LocalModel model;  ///< at the pose
  int iterations = 0;
};

/// Minimises a cost over poses by Marquardt's method from one start. `evaluate` takes a Pose and
/// returns std::optional<LocalModel>, none where the cost is not defined (a point behind the
/// camera). Converged when an accepted step turns by less than `step_tolerance` radians and moves
/// by less than that part of the range, or when no step lowers the cost by more than rounding.
template <typename Evaluate>
Minimum minimise(const Pose& start, const Evaluate& evaluate, int max_iterations,
                 double step_tolerance) {
  constexpr double kInitialDamping = 1e-5;
  constexpr double kSmallestDamping = 1e-12;
  constexpr double kDampingFactor = 10;
  /// Damping that shortens steps noticeably: a short step then does not mean convergence.
  constexpr double kHeavyDamping = 0.1;
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

  /// Below this steps are rounding; it stands for tolerances that are no numbers as well.
  constexpr double kSmallestTolerance = 1e-14;
  const double tolerance =
      step_tolerance > kSmallestTolerance ? step_tolerance : kSmallestTolerance;

  const std::optional<LocalModel> first = evaluate(start);
  if (!first) return {PoseStatus::kBehindCamera, start, {}, 0};
  Minimum best = {PoseStatus::kDiverged, start, *first, 0};
  double damping = kInitialDamping;
  while (best.iterations < max_iterations) {
    ++best.iterations;
    const std::optional<Vector6d> delta = marquardt_step(best.model, damping);
    if (!delta) {
      damping *= kDampingFactor;
      continue;
    }
    const bool is_short = is_short_step(*delta, best.pose, tolerance) ||
                          promised_decrease(best.model, *delta) < kEpsilon * best.model.cost;
    const Pose candidate = retract(best.pose, *delta);
    const std::optional<LocalModel> model = evaluate(candidate);
    // Near the minimum costs differ by rounding only: an equal one is as good.
    const bool is_better = model && model->cost <= best.model.cost * (1 + 8 * kEpsilon);
    if (is_better) {
      best.pose = candidate;
      best.model = *model;
    }
    if (is_short && (damping < kHeavyDamping || !is_better)) {
      best.status = PoseStatus::kOk;
      return best;
    }
    damping =
        is_better ? std::max(damping / kDampingFactor, kSmallestDamping) : damping * kDampingFactor;
  }
  return best;
}

/// Correspondences as the kernel takes them; up to sixteen points cost no allocation.
class PackedPoints {
 public:
  /// `weights` multiply the squared residuals; none means ones. A point of weight zero is not
  /// looked at.
  explicit PackedPoints(const Correspondences& c, std::span<const double> weights = {});
  /// r^T W r with a symmetric matrix for each point, in px^-2.
  PackedPoints(const Correspondences& c, std::span<const Eigen::Matrix2d> weights);

  /// Marquardt's method from one start (kernel::fit).
  kernel::Fit fit(const Pose& start, int max_iterations, double step_tolerance) const;

  void scale_weight(std::size_t point, double factor);

  std::span<const kernel::PointLanes> lanes() const { return {data(), count_}; }

 private:
  static constexpr std::size_t kInline = 4;

  PackedPoints(const Correspondences& c, std::size_t lanes);
  kernel::PointLanes* data() { return heap_.empty() ? inline_.data() : heap_.data(); }
  const kernel::PointLanes* data() const { return heap_.empty() ? inline_.data() : heap_.data(); }

  std::size_t count_;
  std::array<kernel::PointLanes, kInline> inline_;
  std::vector<kernel::PointLanes> heap_;
};

Pose pose_from(const kernel::RigidPose& pose);
kernel::RigidPose rigid_from(const Pose& pose);

/// The inverse of a fit's Hessian, as inverse_information.
std::optional<Matrix6d> inverse_of(const kernel::NormalEquations& model);

/// J^T W J at a pose. None when a point that counts is behind the camera.
std::optional<Matrix6d> information_at(const PackedPoints& points, const Pose& cam_from_centred);

/// Least squares on correspondences.
struct LeastSquares {
  PoseStatus status = PoseStatus::kDiverged;
  Pose cam_from_centred;
  Matrix6d unit_covariance = Matrix6d::Zero();  ///< of cam_from_centred
  double cost_px2 = 0;                          ///< sum of squared residuals
  int iterations = 0;                           ///< of all starts
};

/// The LSPE iteration (pose/solvers/lspe.cpp) from every start; the lowest cost wins. `weights`
/// multiply the squared residuals; none means ones. A point of weight zero does not take part, may
/// lie behind the camera, and is not looked at.
LeastSquares least_squares(const Correspondences& c, std::span<const Pose> cam_from_centred_starts,
                           const LspeOptions& options, std::span<const double> weights = {});

/// The same on points packed with weights of any kind; unit_covariance is then the inverse of the
/// weighted Hessian.
LeastSquares least_squares(const PackedPoints& points,
                           std::span<const Pose> cam_from_centred_starts,
                           const LspeOptions& options);

}  // namespace sightline
