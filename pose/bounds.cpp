// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "pose/attitude.h"
#include "pose/edge_points.h"
#include "pose/point_spread.h"
#include "pose/reprojection.h"

namespace sightline {
namespace {

/// sqrt of the mean variance of (pitch, yaw, roll). A turn w from the left moves the angles by
/// E^-1 w, the columns of E being the axes about which the camera sees them turn.
double attitude_rms(const Eigen::Matrix3d& rotation, const Eigen::Matrix3d& w_covariance) {
  const double roll = attitude_from_rotation(rotation).roll_rad;
  Eigen::Matrix3d axes;
  axes.col(0) = rotation.col(0);                                      // Rz Ry e_x
  axes.col(1) = Eigen::Vector3d(-std::sin(roll), std::cos(roll), 0);  // Rz e_y
  axes.col(2) = Eigen::Vector3d::UnitZ();
  // The determinant is the cosine of the yaw: in gimbal lock two axes are one.
  if (!(std::abs(axes.determinant()) > std::numeric_limits<double>::epsilon())) {
    return std::numeric_limits<double>::infinity();
  }
  const Eigen::Matrix3d angles_from_w = axes.inverse();
  return std::sqrt((angles_from_w * w_covariance * angles_from_w.transpose()).trace() / 3);
}

/// sum J_i^T C_i^-1 J_i of the pixels, lens included. None when a point is behind the camera.
std::optional<Matrix6d> information(const Camera& camera, const Correspondences& c,
                                    const Pose& cam_from_centred,
                                    std::span<const Eigen::Matrix2d> covariances_px2) {
  Matrix6d sum = Matrix6d::Zero();
  for (std::size_t i = 0; i < c.size(); ++i) {
    const std::optional<Reprojection> r = reproject(c, i, cam_from_centred);
    if (!r) return std::nullopt;
    const Eigen::Vector3d x_in_cam = cam_from_centred * c.points_in_centred[i];
    const Eigen::Matrix<double, 2, 6> jacobian =
        lens_jacobian(camera, x_in_cam.head<2>() / x_in_cam.z()) * r->jacobian;
    sum += jacobian.transpose() * covariances_px2[i].inverse() * jacobian;
  }
  return sum;
}

/// The same of lines, about another origin of the target. None when one cannot be used or seen.
std::optional<Matrix6d> information_of_lines(const Camera& camera,
                                             std::span<const LineObservation> lines,
                                             const Eigen::Vector3d& origin_in_target,
                                             const Pose& cam_from_centred) {
  Matrix6d sum = Matrix6d::Zero();
  for (LineObservation line : lines) {
    line.begin_in_target -= origin_in_target;
    line.end_in_target -= origin_in_target;
    const auto points = edge_points_of(line, camera);
    if (!points) return std::nullopt;
    for (const EdgePoint& point : *points) {
      const auto r = edge_residual(point, cam_from_centred);
      if (!r) return std::nullopt;
      sum += r->jacobian.transpose() * r->jacobian / point.variance_px2;
    }
  }
  return sum;
}

bool is_positive_definite(const Eigen::Matrix2d& m) {
  return m(0, 0) > 0 && m.determinant() > 0 && m.allFinite();
}

}  // namespace

std::optional<PoseBound> cramer_rao_bound(const Camera& camera,
                                          std::span<const Eigen::Vector3d> points_in_target,
                                          const Pose& cam_from_target,
                                          std::span<const Eigen::Matrix2d> covariances_px2) {
  return cramer_rao_bound(camera, points_in_target, cam_from_target, covariances_px2, {});
}

std::optional<PoseBound> cramer_rao_bound(const Camera& camera,
                                          std::span<const Eigen::Vector3d> points_in_target,
                                          const Pose& cam_from_target,
                                          std::span<const Eigen::Matrix2d> covariances_px2,
                                          std::span<const LineObservation> lines) {
  const bool is_usable =
      points_in_target.size() + lines.size() > 0 &&
      covariances_px2.size() == points_in_target.size() &&
      std::all_of(covariances_px2.begin(), covariances_px2.end(), is_positive_definite) &&
      is_valid(cam_from_target);
  if (!is_usable) return std::nullopt;
  Correspondences c;
  c.fx_px = camera.fx_px;
  c.fy_px = camera.fy_px;
  c.centroid_in_target =
      points_in_target.empty()
          ? Eigen::Vector3d((lines[0].begin_in_target + lines[0].end_in_target) / 2)
          : mean_of(points_in_target);
  for (const Eigen::Vector3d& p : points_in_target) {
    c.points_in_centred.push_back(p - c.centroid_in_target);
  }
  c.pixels.assign(c.size(), Eigen::Vector2d::Zero());

  const Pose cam_from_centred = to_centred(cam_from_target, c);
  const std::optional<Matrix6d> of_points =
      information(camera, c, cam_from_centred, covariances_px2);
  const std::optional<Matrix6d> of_lines =
      information_of_lines(camera, lines, c.centroid_in_target, cam_from_centred);
  if (!of_points || !of_lines) return std::nullopt;
  const std::optional<Matrix6d> covariance = inverse_information(*of_points + *of_lines);
  if (!covariance) return std::nullopt;

  return pose_bound(covariance_from_centred(*covariance, cam_from_centred, c), cam_from_target);
}

std::optional<Matrix6d> root_of(const Matrix6d& covariance) {
  if (!covariance.allFinite() || !(covariance.diagonal().minCoeff() > 0)) return std::nullopt;
  const Vector6d scale = covariance.diagonal().cwiseSqrt();
  const Matrix6d correlation =
      scale.cwiseInverse().asDiagonal() * covariance * scale.cwiseInverse().asDiagonal();
  const Eigen::LLT<Matrix6d> factor(correlation);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return Matrix6d(scale.asDiagonal() * Matrix6d(factor.matrixL()));
}

PoseBound pose_bound(const Matrix6d& covariance, const Pose& cam_from_target) {
  PoseBound bound;
  bound.covariance = covariance;
  const Eigen::Matrix3d w_covariance = bound.covariance.topLeftCorner<3, 3>();
  bound.geodesic_rms_rad = std::sqrt(w_covariance.trace());
  bound.attitude_rms_rad = attitude_rms(cam_from_target.rotation, w_covariance);
  bound.translation_rms = std::sqrt(bound.covariance.bottomRightCorner<3, 3>().trace() / 3) /
                          cam_from_target.translation.norm();
  return bound;
}

std::optional<PoseBound> cramer_rao_bound(const Camera& camera,
                                          std::span<const Eigen::Vector3d> points_in_target,
                                          const Pose& cam_from_target, double sigma_px) {
  const Eigen::Matrix2d covariance_px2 =
      std::copysign(sigma_px * sigma_px, sigma_px) * Eigen::Matrix2d::Identity();
  return cramer_rao_bound(camera, points_in_target, cam_from_target,
                          std::vector<Eigen::Matrix2d>(points_in_target.size(), covariance_px2));
}

}  // namespace sightline
