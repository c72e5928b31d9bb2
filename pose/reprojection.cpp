// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/reprojection.h"

#include <cmath>

#include "pose/kernels/reprojection_kernel.h"
#include "pose/packed_points.h"
#include "pose/point_spread.h"

namespace sightline {
namespace {

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// As PointSpread::is_collinear, but most clouds are seen not to be without their eigenvalues.
bool is_collinear(const Correspondences& c) {
  const Eigen::Matrix3d scatter = moments_of(c.points_in_centred);
  const double trace = scatter.trace();
  // The second eigenvalue over the first is at least half this ratio less its rounding.
  if (second_invariant(scatter) > 1e-8 * trace * trace) return false;
  return spread_of(c.points_in_centred).is_collinear();
}

bool is_usable(const Camera& camera) {
  return std::isfinite(camera.fx_px) && std::isfinite(camera.fy_px) && camera.fx_px > 0 &&
         camera.fy_px > 0;
}

}  // namespace

PreparedProblem prepare(const PoseProblem& problem) {
  const std::size_t n = problem.points_in_target.size();
  const std::optional<Pose>& initial = problem.initial_cam_from_target;
  const std::size_t minimum = initial ? kMinimumPosePointsFromInitial : kMinimumPosePoints;
  if (n < minimum || problem.pixels.size() != n) return {PoseStatus::kTooFewPoints, {}};
  if (!is_usable(problem.camera)) return {PoseStatus::kDegenerate, {}};
  if (initial && !is_valid(*initial)) return {PoseStatus::kDegenerate, {}};

  PreparedProblem prepared;
  Correspondences& c = prepared.correspondences;
  c.fx_px = problem.camera.fx_px;
  c.fy_px = problem.camera.fy_px;
  c.centroid_in_target = mean_of(problem.points_in_target);
  if (!c.centroid_in_target.allFinite()) return prepared;
  c.points_in_centred.reserve(n);
  c.pixels.reserve(n);
  const Eigen::Vector2d principal_point(problem.camera.cx_px, problem.camera.cy_px);
  const bool is_bent = !is_straight(problem.camera);
  for (std::size_t i = 0; i < n; ++i) {
    c.points_in_centred.push_back(problem.points_in_target[i] - c.centroid_in_target);
    Eigen::Vector2d pixel = problem.pixels[i] - principal_point;
    if (!pixel.allFinite()) return prepared;
    if (is_bent) {
      const auto ray = normalised_from_pixel(problem.camera, problem.pixels[i]);
      if (!ray) return prepared;
      pixel = {c.fx_px * ray->x(), c.fy_px * ray->y()};
    }
    c.pixels.push_back(pixel);
  }
  if (!is_collinear(c)) prepared.status = PoseStatus::kOk;
  return prepared;
}

Correspondences without(const Correspondences& all, std::size_t index) {
  Correspondences rest = all;
  rest.points_in_centred.erase(rest.points_in_centred.begin() + static_cast<std::ptrdiff_t>(index));
  rest.pixels.erase(rest.pixels.begin() + static_cast<std::ptrdiff_t>(index));
  return rest;
}

Pose to_centred(const Pose& cam_from_target, const Correspondences& c) {
  return {cam_from_target.rotation, cam_from_target * c.centroid_in_target};
}

Pose from_centred(const Pose& cam_from_centred, const Correspondences& c) {
  return {cam_from_centred.rotation, cam_from_centred * -c.centroid_in_target};
}

Matrix6d covariance_from_centred(const Matrix6d& covariance, const Pose& cam_from_centred,
                                 const Correspondences& c) {
  // t_target = t_centred - R centroid, so that dt_target = dt_centred + C w, C = [R centroid]x.
  const Eigen::Matrix3d transfer = cross_matrix(cam_from_centred.rotation * c.centroid_in_target);
  const Eigen::Matrix3d w = covariance.topLeftCorner<3, 3>();
  const Eigen::Matrix3d t_w = covariance.bottomLeftCorner<3, 3>();
  const Eigen::Matrix3d moved_t_w = t_w + transfer * w;
  const Eigen::Matrix3d half = transfer * (t_w + 0.5 * transfer * w).transpose();
  Matrix6d moved;
  moved.topLeftCorner<3, 3>() = w;
  moved.bottomLeftCorner<3, 3>() = moved_t_w;
  moved.topRightCorner<3, 3>() = moved_t_w.transpose();
  moved.bottomRightCorner<3, 3>() = covariance.bottomRightCorner<3, 3>() + half + half.transpose();
  return moved;
}

std::optional<Eigen::Vector2d> residual_px(const Correspondences& c, std::size_t index,
                                           const Pose& cam_from_centred) {
  const Eigen::Vector3d x_in_cam = cam_from_centred * c.points_in_centred[index];
  if (!(x_in_cam.z() > 0)) return std::nullopt;
  return Eigen::Vector2d(c.fx_px * x_in_cam.x() / x_in_cam.z() - c.pixels[index].x(),
                         c.fy_px * x_in_cam.y() / x_in_cam.z() - c.pixels[index].y());
}

std::optional<Reprojection> reproject(const Correspondences& c, std::size_t index,
                                      const Pose& cam_from_centred) {
  const Eigen::Vector3d q = cam_from_centred.rotation * c.points_in_centred[index];
  const Eigen::Vector3d x_in_cam = q + cam_from_centred.translation;
  if (!(x_in_cam.z() > 0)) return std::nullopt;
  const double inverse_z = 1 / x_in_cam.z();
  const double u = x_in_cam.x() * inverse_z;
  const double v = x_in_cam.y() * inverse_z;
  const double su = c.fx_px * inverse_z;
  const double sv = c.fy_px * inverse_z;
  Reprojection result;
  result.residual_px << c.fx_px * u - c.pixels[index].x(), c.fy_px * v - c.pixels[index].y();
  result.jacobian << -su * u * q.y(), su * (q.z() + u * q.x()), -su * q.y(), su, 0, -su * u,  //
      -sv * (q.z() + v * q.y()), sv * v * q.x(), sv * q.x(), 0, sv, -sv * v;
  return result;
}

std::optional<Matrix6d> inverse_information(const Matrix6d& information) {
  double upper[21], inverse[21];
  double* next = upper;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) *next++ = information(row, column);
  }
  if (!kernel::invert(upper, inverse)) return std::nullopt;
  return symmetric_from(inverse);
}

}  // namespace sightline
