// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/metrics/pose_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <CGAL/Orthogonal_k_neighbor_search.h>
#include <CGAL/Search_traits_3.h>
#include <CGAL/Simple_cartesian.h>
#include <Eigen/Geometry>

namespace sightline {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::Matrix3Xd moved(const Vertices& vertices, const Pose& pose) {
  return (pose.rotation * vertices).colwise() + pose.translation;
}

Eigen::Matrix2Xd pixels_of(const Eigen::Matrix3Xd& x_in_cam, const Eigen::Matrix3d& k) {
  return (k * x_in_cam).colwise().hnormalized();
}

// NaN of what the camera does not see.
Eigen::Matrix2Xd pixels_of(const Eigen::Matrix3Xd& x_in_cam, const Camera& camera) {
  Eigen::Matrix2Xd pixels(2, x_in_cam.cols());
  for (Eigen::Index i = 0; i < x_in_cam.cols(); ++i) {
    const auto pixel = project(camera, x_in_cam.col(i));
    pixels.col(i) =
        pixel.value_or(Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
  }
  return pixels;
}

// Between the columns of two matrices; infinite where one is not finite.
template <typename Columns>
double greatest_distance(const Columns& a, const Columns& b) {
  const Columns difference = a - b;
  if (!difference.allFinite()) return kInfinity;
  return std::sqrt(difference.colwise().squaredNorm().maxCoeff());
}

// The same of pixels, but for the vertices that the camera does not see in the true pose either.
double greatest_distance_px(Eigen::Matrix2Xd estimated, const Eigen::Matrix2Xd& truth) {
  Eigen::Matrix2Xd seen = truth;
  bool is_any_seen = false;
  for (Eigen::Index i = 0; i < truth.cols(); ++i) {
    if (truth.col(i).allFinite()) {
      is_any_seen = true;
    } else {
      seen.col(i).setZero();
      estimated.col(i).setZero();
    }
  }
  return is_any_seen ? greatest_distance(estimated, seen) : kInfinity;
}

template <typename Columns>
double mean_distance(const Columns& a, const Columns& b) {
  return (a - b).colwise().norm().mean();
}

// Of the positions, over the true one's length.
double distance_fraction(const Pose& estimated, const Pose& truth) {
  return (estimated.translation - truth.translation).norm() / truth.translation.norm();
}

}  // namespace

Eigen::Map<const Eigen::Matrix3Xd> vertices_of(const Mesh& mesh) {
  const double* first = mesh.vertices.empty() ? nullptr : mesh.vertices.front().data();
  return {first, 3, static_cast<Eigen::Index>(mesh.vertices.size())};
}

double add_distance(const Vertices& vertices, const Pose& estimated, const Pose& truth) {
  return mean_distance(moved(vertices, estimated), moved(vertices, truth));
}

double adi_distance(const Vertices& vertices, const Pose& estimated, const Pose& truth) {
  using Kernel = CGAL::Simple_cartesian<double>;
  using Search = CGAL::Orthogonal_k_neighbor_search<CGAL::Search_traits_3<Kernel>>;
  const auto to_points = [](const Eigen::Matrix3Xd& matrix) {
    std::vector<Kernel::Point_3> points;
    for (const auto& column : matrix.colwise()) {
      points.emplace_back(column.x(), column.y(), column.z());
    }
    return points;
  };
  const std::vector<Kernel::Point_3> there = to_points(moved(vertices, estimated));
  const Search::Tree tree(there.begin(), there.end());
  double sum = 0;
  for (const Kernel::Point_3& point : to_points(moved(vertices, truth))) {
    sum += std::sqrt(Search(tree, point, 1).begin()->second);
  }
  return sum / static_cast<double>(vertices.cols());
}

double mssd(const Vertices& vertices, const Pose& estimated, const Pose& truth) {
  return greatest_distance(moved(vertices, estimated), moved(vertices, truth));
}

Pose nearest_alike(const Vertices& vertices, const Pose& estimated, const Pose& truth,
                   std::span<const Pose> symmetries) {
  const Eigen::Matrix3Xd there = moved(vertices, estimated);
  Pose nearest = truth;
  double least = kInfinity;
  for (const Pose& symmetry : symmetries) {
    const Pose alike = truth * symmetry;
    const double distance = greatest_distance(there, moved(vertices, alike));
    if (distance >= least) continue;
    least = distance;
    nearest = alike;
  }
  return nearest;
}

namespace {

// `projection`: a camera matrix, or a camera with its lens.
template <typename Projection>
double least_greatest_px(const Vertices& vertices, const Projection& projection,
                         const Pose& estimated, const Pose& truth,
                         std::span<const Pose> symmetries) {
  const Eigen::Matrix2Xd there = pixels_of(moved(vertices, estimated), projection);
  double least = kInfinity;
  for (const Pose& symmetry : symmetries) {
    const Eigen::Matrix2Xd alike = pixels_of(moved(vertices, truth * symmetry), projection);
    least = std::min(least, greatest_distance_px(there, alike));
  }
  return least;
}

}  // namespace

double mspd_px(const Vertices& vertices, const Eigen::Matrix3d& k, const Pose& estimated,
               const Pose& truth, std::span<const Pose> symmetries) {
  return least_greatest_px(vertices, k, estimated, truth, symmetries);
}

VertexErrors vertex_errors(const Vertices& vertices, const Camera& camera, const Pose& estimated,
                           const Pose& truth) {
  const Eigen::Matrix3Xd there = moved(vertices, estimated);
  const Eigen::Matrix3Xd true_places = moved(vertices, truth);
  return {
      .add = mean_distance(there, true_places),
      .mssd = greatest_distance(there, true_places),
      .mspd_px = greatest_distance_px(pixels_of(there, camera), pixels_of(true_places, camera))};
}

double least_mspd_px(const Vertices& vertices, const Camera& camera, const Pose& estimated,
                     const Pose& truth, std::span<const Pose> symmetries) {
  return least_greatest_px(vertices, camera, estimated, truth, symmetries);
}

Pose turned_towards(const Pose& estimated, const Pose& pose, const Eigen::Vector3d& direction,
                    const Eigen::Vector3d& point) {
  // trace(M Rot) = cos (trace M - a^T M a) + sin trace(M [a]x) + a^T M a.
  const Eigen::Matrix3d m = estimated.rotation.transpose() * pose.rotation;
  const Eigen::Vector3d skew(m(1, 2) - m(2, 1), m(2, 0) - m(0, 2), m(0, 1) - m(1, 0));
  const double cosine = m.trace() - direction.dot(m * direction);
  const double angle_rad = std::atan2(direction.dot(skew), cosine);
  const Eigen::Matrix3d turn = rotation_from_vector(angle_rad * direction);
  return pose * Pose{turn, point - turn * point};
}

double projection_px(const Vertices& vertices, const Eigen::Matrix3d& k, const Pose& estimated,
                     const Pose& truth) {
  const double mean =
      mean_distance(pixels_of(moved(vertices, estimated), k), pixels_of(moved(vertices, truth), k));
  return std::isfinite(mean) ? mean : kInfinity;
}

bool is_within_5deg_5cm(const Pose& estimated, const Pose& truth) {
  constexpr double kAngleRad = 5 * std::numbers::pi / 180;
  constexpr double kDistanceMm = 50;
  return geodesic_angle_rad(estimated.rotation, truth.rotation) < kAngleRad &&
         (estimated.translation - truth.translation).norm() < kDistanceMm;
}

double speed_score(const Pose& estimated, const Pose& truth) {
  return geodesic_angle_rad(estimated.rotation, truth.rotation) +
         distance_fraction(estimated, truth);
}

double speed_plus_score(const Pose& estimated, const Pose& truth) {
  constexpr double kAngleRad = 0.169 * std::numbers::pi / 180;
  constexpr double kDistanceFraction = 2.173e-3;
  const double angle_rad = geodesic_angle_rad(estimated.rotation, truth.rotation);
  const double fraction = distance_fraction(estimated, truth);
  return (angle_rad < kAngleRad ? 0 : angle_rad) + (fraction < kDistanceFraction ? 0 : fraction);
}

}  // namespace sightline
