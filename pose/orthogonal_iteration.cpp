// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// With V_i = b_i b_i^T the projection onto the line of sight b_i of point p_i, the object-space
// collinearity error is (Lu, Hager, Mjolsness 2000, equations (18) to (21))
//
//   E(R, t) = sum_i |(I - V_i)(R p_i + t)|^2.
//
// Given R the best t is linear, t(R) = (1/n) (I - mean V)^-1 sum_i (V_i - I) R p_i; given t the
// next R is the absolute orientation of q_i = V_i (R p_i + t) against p_i. E never rises. At narrow
// fields of view E hardly changes with depth, and convergence is slow.

#include "pose/orthogonal_iteration.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "pose/absolute_orientation.h"
#include "pose/point_spread.h"
#include "pose/scaled_orthographic.h"

namespace sightline {
namespace {

struct ObjectSpaceFit {
  Pose cam_from_points;
  double error_m2 = 0;
};

/// The lines of sight and the points about their own mean.
struct Sights {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> bearings;
  Eigen::Matrix3d translation_solve;  ///< (1/n) (I - mean V)^-1
  PointSpread spread;
};

Sights sights_of(const Correspondences& c) {
  Sights sights;
  sights.spread = spread_of(c.points_in_centred);
  Eigen::Matrix3d off_sight = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < c.size(); ++i) {
    const Eigen::Vector3d b =
        Eigen::Vector3d(c.pixels[i].x() / c.fx_px, c.pixels[i].y() / c.fy_px, 1).normalized();
    sights.points.push_back(c.points_in_centred[i] - sights.spread.mean);
    sights.bearings.push_back(b);
    off_sight += Eigen::Matrix3d::Identity() - b * b.transpose();
  }
  sights.translation_solve = off_sight.inverse();
  return sights;
}

Eigen::Vector3d on_sight(const Eigen::Vector3d& bearing, const Eigen::Vector3d& x) {
  return bearing * bearing.dot(x);
}

Eigen::Vector3d best_translation(const Sights& sights, const Eigen::Matrix3d& rotation) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < sights.points.size(); ++i) {
    const Eigen::Vector3d q = rotation * sights.points[i];
    sum += on_sight(sights.bearings[i], q) - q;
  }
  return sights.translation_solve * sum;
}

/// The sum of q_i p_i^T whose best rotation is the next R, and the error at the present pose.
struct IterationSums {
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
  double error_m2 = 0;
};

IterationSums iteration_sums(const Sights& sights, const Pose& pose) {
  IterationSums sums;
  for (std::size_t i = 0; i < sights.points.size(); ++i) {
    const Eigen::Vector3d x = pose * sights.points[i];
    const Eigen::Vector3d q = on_sight(sights.bearings[i], x);
    sums.error_m2 += (x - q).squaredNorm();
    // The points are centred; taking t from q keeps the sum exact at long range.
    sums.cross.noalias() += (q - pose.translation) * sights.points[i].transpose();
  }
  return sums;
}

bool is_in_front(const Sights& sights, const Pose& pose) {
  return std::all_of(sights.points.begin(), sights.points.end(),
                     [&pose](const Eigen::Vector3d& p) { return (pose * p).z() > 0; });
}

std::optional<ObjectSpaceFit> iterate(const Sights& sights, const Eigen::Matrix3d& start,
                                      const OrthogonalIterationOptions& options) {
  Pose pose = {start, best_translation(sights, start)};
  IterationSums sums = iteration_sums(sights, pose);
  for (int i = 0; i < options.max_iterations; ++i) {
    const OrientationEstimate next = fast_rotation(sums.cross);
    if (next.status != OrientationStatus::kOk) return std::nullopt;
    const double before_m2 = sums.error_m2;
    pose.rotation = next.b_from_a.rotation;
    pose.translation = best_translation(sights, pose.rotation);
    sums = iteration_sums(sights, pose);
    if (!(before_m2 - sums.error_m2 > options.relative_tolerance * before_m2)) break;
  }
  if (!pose.translation.allFinite() || !is_in_front(sights, pose)) return std::nullopt;
  return ObjectSpaceFit{pose, sums.error_m2};
}

/// The 2x3 matrix of least squares that takes the points, in the frame of their axes, to normalised
/// image coordinates about their mean. Columns of axes without extent are zero.
Eigen::Matrix<double, 2, 3> affine_fit(const Sights& sights) {
  Eigen::Matrix<double, 2, 3> cross = Eigen::Matrix<double, 2, 3>::Zero();
  for (std::size_t i = 0; i < sights.points.size(); ++i) {
    const Eigen::Vector3d p_in_axes = sights.spread.axes.transpose() * sights.points[i];
    cross += sights.bearings[i].hnormalized() * p_in_axes.transpose();
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double sd = sights.spread.sd[axis];
    cross.col(axis) *= sd > 0 ? 1 / (sd * sd) : 0.0;
  }
  return cross;
}

std::vector<Eigen::Matrix3d> affine_rotations(const Sights& sights) {
  const Eigen::Matrix<double, 2, 3> affine = affine_fit(sights);
  std::vector<Eigen::Matrix3d> rotations;
  if (sights.spread.is_nearly_planar()) {
    rotations = rotations_from_plane_affine(affine.leftCols<2>());
  } else if (const std::optional<Eigen::Matrix3d> rotation = rotation_from_affine(affine)) {
    rotations = {*rotation};
  }
  for (Eigen::Matrix3d& cam_from_axes : rotations) {
    cam_from_axes = (cam_from_axes * sights.spread.axes.transpose()).eval();
  }
  return rotations;
}

}  // namespace

std::vector<Pose> centred_starts(const Correspondences& c,
                                 const OrthogonalIterationOptions& options) {
  const Sights sights = sights_of(c);
  std::vector<ObjectSpaceFit> fits;
  for (const Eigen::Matrix3d& rotation : affine_rotations(sights)) {
    const std::optional<ObjectSpaceFit> fit = iterate(sights, rotation, options);
    if (fit) fits.push_back(*fit);
  }
  std::stable_sort(fits.begin(), fits.end(), [](const ObjectSpaceFit& a, const ObjectSpaceFit& b) {
    return a.error_m2 < b.error_m2;
  });
  std::vector<Pose> cam_from_centred;
  for (const ObjectSpaceFit& fit : fits) {
    const Pose& pose = fit.cam_from_points;
    cam_from_centred.push_back({pose.rotation, pose * -sights.spread.mean});
  }
  return cam_from_centred;
}

std::vector<Pose> orthogonal_iteration_starts(const PoseProblem& problem,
                                              const OrthogonalIterationOptions& options) {
  const PreparedProblem prepared = prepare(problem);
  if (prepared.status != PoseStatus::kOk) return {};
  std::vector<Pose> poses = centred_starts(prepared.correspondences, options);
  for (Pose& pose : poses) pose = from_centred(pose, prepared.correspondences);
  return poses;
}

}  // namespace sightline
