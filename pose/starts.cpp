// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/starts.h"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "pose/orthogonal_iteration.h"
#include "pose/point_spread.h"
#include "pose/scaled_orthographic.h"

namespace sightline {
namespace {

/// Root-mean-square extent over range below which least squares gets from the scaled-orthographic
/// pose to its minimum by itself: orthogonal iteration has nothing to correct, and is slow there.
constexpr double kWeakPerspective = 0.1;

}  // namespace

bool is_clearly_solid(const Eigen::Matrix3d& scatter) {
  const double pairs = second_invariant(scatter);
  // With eigenvalues l1 >= l2 >= l3: l3 >= det / pairs, and l2 <= 2 pairs / trace. Nearly planar is
  // l3 < 0.01 l2.
  return scatter.determinant() * scatter.trace() > 0.02 * pairs * pairs;
}

bool is_clearly_solid(std::span<const Eigen::Vector3d> points) {
  if (points.empty()) return false;
  Moments moments;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d p = point - points.front();  // far from the origin p p^T would round
    sum += p;
    moments.add(p);
  }
  const Eigen::Vector3d mean = sum / static_cast<double>(points.size());
  return is_clearly_solid(moments.matrix() - sum * mean.transpose());
}

std::optional<Pose> weak_perspective_start(const Correspondences& c) {
  Moments moments;
  Eigen::Matrix<double, 2, 3> cross = Eigen::Matrix<double, 2, 3>::Zero();
  Eigen::Vector3d p_sum = Eigen::Vector3d::Zero();
  Eigen::Vector2d u_sum = Eigen::Vector2d::Zero();
  const Eigen::Vector2d pixel_to_normalised(1 / c.fx_px, 1 / c.fy_px);
  for (std::size_t i = 0; i < c.size(); ++i) {
    const Eigen::Vector3d& p = c.points_in_centred[i];
    const Eigen::Vector2d u = c.pixels[i].cwiseProduct(pixel_to_normalised);
    p_sum += p;
    u_sum += u;
    moments.add(p);
    cross.noalias() += u * p.transpose();
  }
  const double n = static_cast<double>(c.size());
  const Eigen::Vector3d p_mean = p_sum / n;  // of a part of the points it is not zero
  const Eigen::Vector2d u_mean = u_sum / n;
  const Eigen::Matrix3d scatter = moments.matrix() - p_sum * p_mean.transpose();
  cross.noalias() -= u_sum * p_mean.transpose();
  if (!is_clearly_solid(scatter)) return std::nullopt;

  const Eigen::Matrix<double, 2, 3> affine = cross * scatter.inverse();
  const std::optional<Eigen::Matrix3d> rotation = rotation_from_affine(affine);
  if (!rotation) return std::nullopt;
  const double scale = 0.5 * (affine * rotation->topRows<2>().transpose()).trace();
  const double range = 1 / scale;
  const double extent = std::sqrt(scatter.trace() / n);
  if (!(extent < kWeakPerspective * range)) return std::nullopt;
  const Eigen::Vector3d mean_in_cam = range * u_mean.homogeneous();
  return Pose{*rotation, mean_in_cam - *rotation * p_mean};
}

std::vector<Pose> starting_poses(const Correspondences& c,
                                 const std::optional<Pose>& initial_cam_from_target) {
  if (initial_cam_from_target) return {to_centred(*initial_cam_from_target, c)};
  if (const std::optional<Pose> pose = weak_perspective_start(c)) return {*pose};
  return centred_starts(c, {.max_iterations = 20, .relative_tolerance = 1e-3});
}

}  // namespace sightline
