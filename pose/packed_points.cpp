// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/packed_points.h"

#include <utility>

namespace sightline {
namespace {

using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

std::size_t lanes_for(std::size_t points) {
  return (points + kernel::kLanes - 1) / kernel::kLanes;
}

}  // namespace

PackedPoints::PackedPoints(const Correspondences& c, std::size_t lanes) : count_(lanes) {
  if (lanes > kInline) heap_.resize(lanes);
  const auto place = [&](std::size_t i) -> std::pair<kernel::PointLanes&, std::size_t> {
    return {data()[i / kernel::kLanes], i % kernel::kLanes};
  };
  const Eigen::Vector2d normalised_from_px(1 / c.fx_px, 1 / c.fy_px);
  for (std::size_t i = 0; i < c.size(); ++i) {
    const auto [p, lane] = place(i);
    p.x[lane] = c.points_in_centred[i].x();
    p.y[lane] = c.points_in_centred[i].y();
    p.z[lane] = c.points_in_centred[i].z();
    p.u[lane] = c.pixels[i].x() * normalised_from_px.x();
    p.v[lane] = c.pixels[i].y() * normalised_from_px.y();
  }
  for (std::size_t i = c.size(); i < lanes * kernel::kLanes; ++i) {
    const auto [p, lane] = place(i);
    p.x[lane] = p.y[lane] = p.z[lane] = p.u[lane] = p.v[lane] = 0;
    p.w_uu[lane] = p.w_uv[lane] = p.w_vv[lane] = 0;
  }
}

PackedPoints::PackedPoints(const Correspondences& c, std::span<const double> weights, double common)
    : PackedPoints(c, lanes_for(c.size())) {
  for (std::size_t i = 0; i < c.size(); ++i) {
    kernel::PointLanes& p = data()[i / kernel::kLanes];
    const std::size_t lane = i % kernel::kLanes;
    const double weight = weights.empty() ? common : common * weights[i];
    p.w_uu[lane] = weight * c.fx_px * c.fx_px;
    p.w_uv[lane] = 0;
    p.w_vv[lane] = weight * c.fy_px * c.fy_px;
  }
}

PackedPoints::PackedPoints(const Correspondences& c, std::span<const Eigen::Matrix2d> weights)
    : PackedPoints(c, lanes_for(c.size())) {
  for (std::size_t i = 0; i < c.size(); ++i) {
    kernel::PointLanes& p = data()[i / kernel::kLanes];
    const std::size_t lane = i % kernel::kLanes;
    p.w_uu[lane] = weights[i](0, 0) * c.fx_px * c.fx_px;
    p.w_uv[lane] = weights[i](0, 1) * c.fx_px * c.fy_px;
    p.w_vv[lane] = weights[i](1, 1) * c.fy_px * c.fy_px;
  }
}

kernel::Fit PackedPoints::fit(const Pose& start, int max_iterations, double step_tolerance) const {
  return kernel::fit({.points = data(), .point_count = count_}, rigid_from(start), max_iterations,
                     step_tolerance);
}

void PackedPoints::scale_weight(std::size_t point, double factor) {
  kernel::PointLanes& p = data()[point / kernel::kLanes];
  const std::size_t lane = point % kernel::kLanes;
  p.w_uu[lane] *= factor;
  p.w_uv[lane] *= factor;
  p.w_vv[lane] *= factor;
}

Pose pose_from(const kernel::RigidPose& pose) {
  return {Eigen::Map<const RowMajor3d>(pose.rotation),
          Eigen::Map<const Eigen::Vector3d>(pose.translation)};
}

kernel::RigidPose rigid_from(const Pose& pose) {
  kernel::RigidPose rigid;
  Eigen::Map<RowMajor3d>(rigid.rotation) = pose.rotation;
  Eigen::Map<Eigen::Vector3d>(rigid.translation) = pose.translation;
  return rigid;
}

Matrix6d symmetric_from(const double (&upper)[21]) {
  Matrix6d m;
  const double* next = upper;
#pragma GCC unroll 6
  for (int row = 0; row < 6; ++row) {
#pragma GCC unroll 6
    for (int column = row; column < 6; ++column) m(row, column) = m(column, row) = *next++;
  }
  return m;
}

Matrix6d hessian_of(const kernel::NormalEquations& model) {
  return symmetric_from(model.hessian);
}

std::optional<Matrix6d> inverse_of(const kernel::NormalEquations& model) {
  double upper[21];
  if (!kernel::invert(model.hessian, upper)) return std::nullopt;
  return symmetric_from(upper);
}

std::optional<Matrix6d> information_at(const PackedPoints& points, const Pose& cam_from_centred) {
  kernel::NormalEquations model;
  const auto lanes = points.lanes();
  if (!kernel::normal_equations(lanes.data(), lanes.size(), rigid_from(cam_from_centred), model)) {
    return std::nullopt;
  }
  return hessian_of(model);
}

}  // namespace sightline
