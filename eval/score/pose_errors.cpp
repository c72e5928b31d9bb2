// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/score/pose_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <CGAL/Orthogonal_k_neighbor_search.h>
#include <CGAL/Search_traits_3.h>
#include <CGAL/Simple_cartesian.h>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

namespace sightline {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::Matrix3Xd moved(const Eigen::Matrix3Xd& points, const Pose& pose) {
  return (pose.rotation * points).colwise() + pose.translation;
}

double greatest_distance(const Eigen::Matrix3Xd& points, const Pose& a, const Pose& b) {
  const Eigen::Matrix3d rotation = a.rotation - b.rotation;
  const Eigen::Vector3d translation = a.translation - b.translation;
  return std::sqrt(
      ((rotation * points).colwise() + translation).colwise().squaredNorm().maxCoeff());
}

Eigen::Matrix2Xd projected(const Eigen::Matrix3Xd& points, const Eigen::Matrix3d& k,
                           const Pose& pose) {
  return (k * moved(points, pose)).colwise().hnormalized();
}

// Of the positions, over the true one's length.
double distance_fraction(const Pose& estimated, const Pose& truth) {
  return (estimated.translation - truth.translation).norm() / truth.translation.norm();
}

}  // namespace

Pose nearest_alike(const Eigen::Matrix3Xd& points_mm, const Pose& estimated, const Pose& truth,
                   std::span<const Pose> symmetries) {
  Pose nearest = truth;
  double least = kInfinity;
  for (const Pose& symmetry : symmetries) {
    const Pose alike = truth * symmetry;
    const double distance = greatest_distance(points_mm, estimated, alike);
    if (distance >= least) continue;
    least = distance;
    nearest = alike;
  }
  return nearest;
}

double mssd_mm(const Eigen::Matrix3Xd& points_mm, const Pose& estimated, const Pose& truth,
               std::span<const Pose> symmetries) {
  return greatest_distance(points_mm, estimated,
                           nearest_alike(points_mm, estimated, truth, symmetries));
}

double mspd_px(const Eigen::Matrix3Xd& points_mm, const Eigen::Matrix3d& k, const Pose& estimated,
               const Pose& truth, std::span<const Pose> symmetries) {
  const Eigen::Matrix2Xd pixels = projected(points_mm, k, estimated);
  double least = kInfinity;
  for (const Pose& symmetry : symmetries) {
    const Eigen::Matrix2Xd difference = pixels - projected(points_mm, k, truth * symmetry);
    if (!difference.allFinite()) continue;
    least = std::min(least, std::sqrt(difference.colwise().squaredNorm().maxCoeff()));
  }
  return least;
}

double add_mm(const Eigen::Matrix3Xd& points_mm, const Pose& estimated, const Pose& truth) {
  return (moved(points_mm, estimated) - moved(points_mm, truth)).colwise().norm().mean();
}

double projection_px(const Eigen::Matrix3Xd& points_mm, const Eigen::Matrix3d& k,
                     const Pose& estimated, const Pose& truth) {
  const double mean =
      (projected(points_mm, k, estimated) - projected(points_mm, k, truth)).colwise().norm().mean();
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

double adi_mm(const Eigen::Matrix3Xd& points_mm, const Pose& estimated, const Pose& truth) {
  using Kernel = CGAL::Simple_cartesian<double>;
  using Search = CGAL::Orthogonal_k_neighbor_search<CGAL::Search_traits_3<Kernel>>;
  const auto to_points = [](const Eigen::Matrix3Xd& matrix) {
    std::vector<Kernel::Point_3> points;
    for (const auto& column : matrix.colwise()) {
      points.emplace_back(column.x(), column.y(), column.z());
    }
    return points;
  };
  const std::vector<Kernel::Point_3> there = to_points(moved(points_mm, estimated));
  const Search::Tree tree(there.begin(), there.end());
  double sum = 0;
  for (const Kernel::Point_3& point : to_points(moved(points_mm, truth))) {
    sum += std::sqrt(Search(tree, point, 1).begin()->second);
  }
  return sum / static_cast<double>(points_mm.cols());
}

cv::Mat distances_of_depth(const cv::Mat& depth, const Eigen::Matrix3d& k) {
  cv::Mat distances(depth.size(), CV_64F);
  for (int v = 0; v < depth.rows; ++v) {
    const double y = (v - k(1, 2)) / k(1, 1);
    const double* from = depth.ptr<double>(v);
    double* to = distances.ptr<double>(v);
    for (int u = 0; u < depth.cols; ++u) {
      const double x = (u - k(0, 2)) / k(0, 0);
      to[u] = from[u] * std::sqrt(x * x + y * y + 1);
    }
  }
  return distances;
}

std::vector<double> vsd(const cv::Mat& test_mm, const cv::Mat& truth_mm,
                        const cv::Mat& estimated_mm, double delta_mm,
                        std::span<const double> taus_mm) {
  int in_either = 0;
  std::vector<double> differences;  // where both are visible
  for (int v = 0; v < test_mm.rows; ++v) {
    const double* test = test_mm.ptr<double>(v);
    const double* truth = truth_mm.ptr<double>(v);
    const double* estimated = estimated_mm.ptr<double>(v);
    for (int u = 0; u < test_mm.cols; ++u) {
      const auto is_before = [&](double model) {
        return model > 0 && (test[u] == 0 || model - test[u] <= delta_mm);
      };
      const bool is_true = is_before(truth[u]);
      const bool is_estimated = is_before(estimated[u]) || (is_true && estimated[u] > 0);
      if (is_true || is_estimated) ++in_either;
      if (is_true && is_estimated) differences.push_back(std::abs(truth[u] - estimated[u]));
    }
  }
  std::vector<double> errors;
  for (const double tau_mm : taus_mm) {
    const auto good = std::count_if(differences.begin(), differences.end(),
                                    [tau_mm](double difference) { return difference < tau_mm; });
    errors.push_back(in_either == 0 ? 1 : static_cast<double>(in_either - good) / in_either);
  }
  return errors;
}

}  // namespace sightline
