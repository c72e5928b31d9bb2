// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/edge_points.h"

#include <cmath>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace sightline {
namespace {

/// A place along a line and the variance of its offset there.
struct Offset {
  double along_px;
  double variance_px2;
};

/// Offsets that err independently and together say what the line says.
std::array<Offset, 2> independent_offsets(const Eigen::Matrix2d& covariance) {
  const double inverse_slope = 1 / covariance(1, 1);
  const double pivot_px = -covariance(0, 1) * inverse_slope;
  const double variance_px2 = covariance(0, 0) + pivot_px * covariance(0, 1);
  const double half_px = std::sqrt(variance_px2 * inverse_slope);
  return {{{pivot_px - half_px, 2 * variance_px2}, {pivot_px + half_px, 2 * variance_px2}}};
}

/// A line without the lens. With M the derivative of (x/z, y/z) by the pixel, what goes along
/// `direction` goes along M direction, and a way of one pixel across it is det(M) / |M direction|
/// across that.
struct Unbent {
  Eigen::Vector2d ray;
  Eigen::Vector2d along_per_px;
  double determinant;

  Eigen::Vector2d normal_per_px() const {
    const double x = along_per_px.x(), y = along_per_px.y();
    const double stretch = determinant / (x * x + y * y);
    return {-stretch * y, stretch * x};
  }
};

std::optional<Unbent> unbent(const Camera& camera, const Eigen::Vector2d& pixel,
                             const Eigen::Vector2d& direction) {
  const double u = 1 / camera.fx_px, v = 1 / camera.fy_px;
  if (is_straight(camera)) {
    return Unbent{{u * (pixel.x() - camera.cx_px), v * (pixel.y() - camera.cy_px)},
                  {u * direction.x(), v * direction.y()},
                  u * v};
  }
  const auto ray = normalised_from_pixel(camera, pixel);
  if (!ray) return std::nullopt;
  const Eigen::Matrix2d m =
      Eigen::Vector2d(u, v).asDiagonal() * lens_jacobian(camera, *ray).inverse();
  return Unbent{*ray, m * direction, m.determinant()};
}

EdgePoint edge_point(const LineObservation& line, const Unbent& seen, const Offset& offset) {
  const double x = seen.ray.x() + offset.along_px * seen.along_per_px.x();
  const double y = seen.ray.y() + offset.along_px * seen.along_per_px.y();
  return {
      line.begin_in_target, line.end_in_target, {x, y}, seen.normal_per_px(), offset.variance_px2};
}

}  // namespace

std::optional<EdgePoints> edge_points_of(const LineObservation& line, const Camera& camera) {
  if (!is_usable(line)) return std::nullopt;
  const auto seen = unbent(camera, line.pixel, line.direction.normalized());
  if (!seen) return std::nullopt;
  std::optional<EdgePoints> points(std::in_place);
  if (!std::isfinite(line.covariance(1, 1))) {
    points->add(edge_point(line, *seen, {0, line.covariance(0, 0)}));
    return points;
  }
  for (const Offset& offset : independent_offsets(line.covariance)) {
    points->add(edge_point(line, *seen, offset));
    if (!std::isfinite((*points)[points->size() - 1].ray.sum())) return std::nullopt;
  }
  return points;
}

std::optional<EdgePoint> edge_point_at(const LineObservation& line, const Camera& camera,
                                       double along_px) {
  if (!is_usable(line)) return std::nullopt;
  const auto seen = unbent(camera, line.pixel, line.direction.normalized());
  return seen ? std::optional(edge_point(line, *seen, {along_px, 1})) : std::nullopt;
}

std::optional<EdgeResidual> edge_residual(const EdgePoint& point, const Pose& cam_from_target) {
  const Eigen::Vector3d p = cam_from_target.rotation * point.begin_in_target;
  const Eigen::Vector3d a = p + cam_from_target.translation;
  const Eigen::Vector3d d =
      cam_from_target.rotation * (point.end_in_target - point.begin_in_target);
  const Eigen::Vector3d q = point.ray.homogeneous();
  const Eigen::Vector3d n(point.normal_per_px.x(), point.normal_per_px.y(), 0);
  // The plane through the camera and the edge has the normal a x d, so that the edge passes where
  // (a x d) . (q + residual n) = 0.
  const Eigen::Vector3d plane = a.cross(d);
  const double m = plane.dot(n);
  const double tilt2 = plane.head<2>().squaredNorm() * n.squaredNorm();
  if (!(m * m > kernel::kLeastCrossing2 * tilt2)) return std::nullopt;
  EdgeResidual result;
  result.residual_px = -plane.dot(q) / m;
  const Eigen::Vector3d place = q + result.residual_px * n;
  const Eigen::Vector3d c = d.cross(place);
  const double inverse_depth = -c.dot(n) / m;
  if (!(inverse_depth > 0)) return std::nullopt;
  result.jacobian << -(p.cross(c) + d.cross(place.cross(a))).transpose() / m, -c.transpose() / m;
  return result;
}

PackedEdges::PackedEdges(std::span<const EdgePoint> points, const Eigen::Vector3d& origin_in_target)
    : count_((points.size() + kernel::kLanes - 1) / kernel::kLanes) {
  if (count_ > kInline) heap_.resize(count_);
  for (std::size_t i = 0; i < count_ * kernel::kLanes; ++i) {
    kernel::EdgeLanes& e = data()[i / kernel::kLanes];
    const std::size_t lane = i % kernel::kLanes;
    // Lanes of no weight hold an edge all the same, so that no number in them is undefined.
    const bool is_there = i < points.size();
    const EdgePoint point = is_there ? points[i] : EdgePoint{};
    const Eigen::Vector3d begin = point.begin_in_target - origin_in_target;
    const Eigen::Vector3d along = point.end_in_target - point.begin_in_target;
    e.x[lane] = begin.x();
    e.y[lane] = begin.y();
    e.z[lane] = begin.z();
    e.dx[lane] = along.x();
    e.dy[lane] = along.y();
    e.dz[lane] = along.z();
    e.u[lane] = point.ray.x();
    e.v[lane] = point.ray.y();
    e.nu[lane] = point.normal_per_px.x();
    e.nv[lane] = point.normal_per_px.y();
    e.weight[lane] = is_there ? 1 / point.variance_px2 : 0;
  }
}

void PackedEdges::set_weight(std::size_t point, double weight) {
  data()[point / kernel::kLanes].weight[point % kernel::kLanes] = weight;
}

}  // namespace sightline
