// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/consensus/cloud.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "pose/point_spread.h"
#include "pose/reprojection.h"
#include "pose/robust.h"

namespace sightline::consensus {
namespace {

/// Coordinates beyond it cannot be squared and summed.
constexpr double kLargestNumber = 1e150;
/// In units of the median distance from the middle: points farther away do not say where the middle
/// is, and points still farther say nothing of the target's shape and are not screened in floats.
constexpr double kFarFromMiddle = 10;
constexpr double kFarFromTarget = 1e5;
/// How far from a rigid pose the numbers of an initial pose may be: four decimals are within 1e-3.
constexpr double kRoundedRotation = 1e-2;
/// What rounding in a product of rotations, and in its transpose times itself, leaves.
constexpr double kRoundedProduct = 1e-15;
/// The image is taken for at least this many areas of the noise: where the pixels are spread no
/// wider, they cannot tell an outlier from noise anyway.
constexpr double kSmallestImage = 400;

template <typename Vector>
bool is_manageable(const Vector& v) {
  return v.allFinite() && v.cwiseAbs().maxCoeff() < kLargestNumber;
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Where the target is and how large, whatever a few points say that are far from the others.
struct Middle {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double length = 0;
};

Middle middle_of(const std::vector<UsablePoint>& points) {
  Eigen::Vector3d median;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const UsablePoint& p : points) values.push_back(p.x_in_target[axis]);
    median[axis] = median_of(std::move(values));
  }
  std::vector<double> distances;
  for (const UsablePoint& p : points) distances.push_back((p.x_in_target - median).norm());
  Middle middle;
  middle.length = median_of(distances);
  if (!(middle.length > 0)) middle.length = std::ranges::max(distances);
  int count = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(distances[i] <= kFarFromMiddle * middle.length)) continue;
    middle.centre += points[i].x_in_target - median;
    ++count;
  }
  middle.centre = median + middle.centre / std::max(count, 1);
  return middle;
}

/// The width of the interval over which numbers are spread evenly, from the distance between their
/// first and last sixths, so that a few of them may be anywhere. Sorts them.
double spread_width(std::vector<double>& values) {
  std::ranges::sort(values);
  const double last = static_cast<double>(values.size() - 1);
  const auto quantile = [&](double q) {
    const auto below = static_cast<std::size_t>(q * last);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    const double part = q * last - static_cast<double>(below);
    return values[below] + part * (values[above] - values[below]);
  };
  const double width = 1.5 * (quantile(5.0 / 6) - quantile(1.0 / 6));
  return width > 0 ? width : values.back() - values.front();
}

/// As far on either side of 0 as the farthest number, but not twice beyond the interval over which
/// the numbers and their opposites are spread, so that a few may be anywhere.
double width_about_zero(std::vector<double> values) {
  const std::size_t n = values.size();
  for (std::size_t i = 0; i < n; ++i) values.push_back(-values[i]);
  const double spread = spread_width(values);  // sorts them
  return 2 * std::min(values.back(), spread);
}

/// The root of the image's area about the principal point, in units of that of the pixels' spread.
double image_extent(const std::vector<Eigen::Vector2d>& image) {
  constexpr double kLargest = 3;  // a principal point outside of the image says nothing
  std::vector<double> u, v;
  for (const Eigen::Vector2d& pixel : image) {
    u.push_back(pixel.x());
    v.push_back(pixel.y());
  }
  const double area = width_about_zero(std::move(u)) * width_about_zero(std::move(v));
  return std::clamp(std::sqrt(area), 1.0, kLargest);
}

/// Of an ellipse of noise, as the radius of the circle of its area.
double noise_radius_px(const UsablePoint& point) {
  return 1 / std::sqrt(std::abs(point.whitening.determinant()));
}

double typical_noise_px(const PoseProblem& problem, const std::vector<UsablePoint>& points) {
  if (problem.covariances_px2.empty()) return problem.sigma_px;
  std::vector<double> radii;
  for (const UsablePoint& p : points) radii.push_back(noise_radius_px(p));
  return median_of(std::move(radii));
}

/// Sorted by where they are seen, which no change of unit or frame alters, then shuffled.
void put_in_hashed_order(std::vector<UsablePoint>& points, const Eigen::Vector3d& centre) {
  std::ranges::sort(points, [&centre](const UsablePoint& a, const UsablePoint& b) {
    if (a.pixel.x() != b.pixel.x()) return a.pixel.x() < b.pixel.x();
    if (a.pixel.y() != b.pixel.y()) return a.pixel.y() < b.pixel.y();
    return (a.x_in_target - centre).squaredNorm() < (b.x_in_target - centre).squaredNorm();
  });
  constexpr std::uint64_t kStream = 0x9e3779b97f4a7c15u;
  for (std::size_t i = points.size(); i > 1; --i) {
    std::swap(points[i - 1], points[mixed_bits(kStream * i) % i]);
  }
}

/// Whether there are as many different points as it takes; points given twice count once.
bool are_enough(const std::vector<Eigen::Vector3d>& points, std::size_t enough) {
  std::vector<Eigen::Vector3d> distinct;
  for (const Eigen::Vector3d& p : points) {
    if (std::ranges::find(distinct, p) == distinct.end()) distinct.push_back(p);
    if (distinct.size() >= enough) return true;
  }
  return false;
}

bool are_collinear(const std::vector<Eigen::Vector3d>& points) {
  std::vector<Eigen::Vector3d> near;
  for (const Eigen::Vector3d& p : points) {
    if (p.norm() < kFarFromTarget) near.push_back(p);
  }
  return near.empty() || spread_of(near).is_collinear();
}

kernel::ScreenPoints screen_points(const Cloud& cloud) {
  kernel::ScreenPoints screen;
  const std::size_t lanes = kernel::kScreenLanes;
  const std::size_t padded = (cloud.size() + lanes - 1) / lanes * lanes;
  constexpr float kNowhere = 1e9F;
  for (auto* values : {&screen.x, &screen.y, &screen.z, &screen.reach}) values->assign(padded, 0);
  screen.u.assign(padded, kNowhere);
  screen.v.assign(padded, kNowhere);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d& x = cloud.points_in_centred[i];
    if (!(x.norm() < kFarFromTarget) || !(cloud.image[i].norm() < kFarFromTarget)) continue;
    screen.x[i] = static_cast<float>(x.x());
    screen.y[i] = static_cast<float>(x.y());
    screen.z[i] = static_cast<float>(x.z());
    screen.u[i] = static_cast<float>(cloud.image[i].x());
    screen.v[i] = static_cast<float>(cloud.image[i].y());
    screen.reach[i] = 1;
    if (cloud.whitening.empty()) continue;
    // The circle about the ellipse of the noise.
    const Eigen::Matrix2d information = cloud.whitening[i].transpose() * cloud.whitening[i];
    const double half = 0.5 * information.trace();
    const double smallest =
        half - std::sqrt(std::max(half * half - information.determinant(), 0.0));
    screen.reach[i] = static_cast<float>(1 / std::max(smallest, 1e-30));
  }
  return screen;
}

Cloud cloud_of(const PoseProblem& problem, const std::vector<UsablePoint>& points,
               const Middle& middle, double unit_px) {
  Cloud cloud;
  cloud.centre_in_target = middle.centre;
  cloud.length_m = middle.length;
  cloud.image_unit_px = unit_px;
  cloud.focal = Eigen::Vector2d(problem.camera.fx_px, problem.camera.fy_px) / unit_px;
  const bool has_covariances = !problem.covariances_px2.empty();
  constexpr double kSmallestNoise = 1e-9;  // less is rounding
  if (has_covariances) cloud.sigma = 1;
  if (!has_covariances && problem.sigma_px > 0) {
    cloud.sigma = std::max(problem.sigma_px / unit_px, kSmallestNoise);
  }
  for (const UsablePoint& p : points) {
    cloud.points_in_centred.emplace_back((p.x_in_target - middle.centre) / middle.length);
    cloud.image.emplace_back(p.pixel / unit_px);
    cloud.given_index.push_back(p.index);
    if (!has_covariances) continue;
    cloud.whitening.emplace_back(p.whitening * unit_px);
    cloud.areas.push_back(std::abs(cloud.whitening.back().determinant()));
  }
  if (!cloud.is_sigma_known()) cloud.typical_noise = kTypicalNoise * image_extent(cloud.image);
  cloud.screen = screen_points(cloud);
  return cloud;
}

PreparedCloud failure(PoseStatus status) {
  PreparedCloud prepared;
  prepared.status = status;
  return prepared;
}

}  // namespace

double image_unit_px(const std::vector<Eigen::Vector2d>& pixels, double typical_noise_px) {
  std::vector<double> values(pixels.size());
  std::ranges::transform(pixels, values.begin(), [](const Eigen::Vector2d& p) { return p.x(); });
  const double width = spread_width(values);
  std::ranges::transform(pixels, values.begin(), [](const Eigen::Vector2d& p) { return p.y(); });
  const double height = spread_width(values);
  const double length = std::max(width, height);
  if (!(length > 0) || !std::isfinite(length)) return 0;
  const double area = std::max(width * height, length * length / 16);
  return std::sqrt(std::max(area, kSmallestImage * typical_noise_px * typical_noise_px));
}

std::optional<Pose> rigid_pose(const std::optional<Pose>& pose) {
  if (!pose || !is_manageable(pose->translation) || !pose->rotation.allFinite()) {
    return std::nullopt;
  }
  const Eigen::Matrix3d& r = pose->rotation;
  const Eigen::Matrix3d excess = r.transpose() * r - Eigen::Matrix3d::Identity();
  const double off = excess.cwiseAbs().maxCoeff();
  if (!(off < kRoundedRotation) || !(r.determinant() > 0)) return std::nullopt;
  if (off < kRoundedProduct) return pose;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(r, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return Pose{svd.matrixU() * svd.matrixV().transpose(), pose->translation};
}

std::optional<UsablePoint> usable_point(const PoseProblem& problem, std::size_t i) {
  const Camera& camera = problem.camera;
  UsablePoint p;
  p.index = static_cast<int>(i);
  p.x_in_target = problem.points_in_target[i];
  if (!is_manageable(p.x_in_target) || !problem.pixels[i].allFinite()) return std::nullopt;
  p.pixel = problem.pixels[i] - Eigen::Vector2d(camera.cx_px, camera.cy_px);
  if (!is_straight(camera)) {
    const auto ray = normalised_from_pixel(camera, problem.pixels[i]);
    // Beyond two folds the lens model turns the image about, which no lens does.
    if (!ray || !(distortion_jacobian(camera.lens, *ray).trace() > 0)) return std::nullopt;
    p.pixel = {camera.fx_px * ray->x(), camera.fy_px * ray->y()};
  }
  if (!is_manageable(p.pixel)) return std::nullopt;
  if (problem.covariances_px2.empty()) return p;
  const auto whitening = whitening_of(problem.covariances_px2[i]);
  if (!whitening) return std::nullopt;
  const Eigen::Vector2d normalised(p.pixel.x() / camera.fx_px, p.pixel.y() / camera.fy_px);
  p.whitening = *whitening * lens_jacobian(camera, normalised);
  const double determinant = std::abs(p.whitening.determinant());
  return determinant > 0 && std::isfinite(determinant) ? std::optional(p) : std::nullopt;
}

std::vector<int> unusable_points(const PoseProblem& problem) {
  std::vector<int> unusable;
  for (std::size_t i = 0; i < problem.pixels.size(); ++i) {
    if (!usable_point(problem, i)) unusable.push_back(static_cast<int>(i));
  }
  return unusable;
}

PreparedCloud prepare_cloud(const PoseProblem& problem) {
  const std::size_t n = problem.points_in_target.size();
  const std::size_t covariances = problem.covariances_px2.size();
  const auto fewest = [](bool has_initial) -> std::size_t {
    return has_initial ? kMinimumPosePointsFromInitial : kMinimumPosePoints;
  };
  if (n < fewest(problem.initial_cam_from_target.has_value()) || problem.pixels.size() != n ||
      (covariances > 0 && covariances != n)) {
    return failure(PoseStatus::kTooFewPoints);
  }
  const Camera& camera = problem.camera;
  const bool has_focal = camera.fx_px > 0 && camera.fy_px > 0 && std::isfinite(camera.fx_px) &&
                         std::isfinite(camera.fy_px);
  const bool has_noise = problem.sigma_px >= 0 && std::isfinite(problem.sigma_px);
  if (!has_focal || (covariances == 0 && !has_noise)) return failure(PoseStatus::kDegenerate);

  const std::optional<Pose> initial = rigid_pose(problem.initial_cam_from_target);
  std::vector<UsablePoint> points;
  PreparedCloud prepared;
  std::vector<int> ignored;
  for (std::size_t i = 0; i < n; ++i) {
    const std::optional<UsablePoint> point = usable_point(problem, i);
    if (point) points.push_back(*point);
    if (!point) ignored.push_back(static_cast<int>(i));
  }
  prepared.cloud.ignored = ignored;
  if (points.size() < fewest(initial.has_value())) return prepared;
  const Middle middle = middle_of(points);
  std::vector<Eigen::Vector2d> pixels;
  for (const UsablePoint& p : points) pixels.push_back(p.pixel);
  const double unit_px = image_unit_px(pixels, typical_noise_px(problem, points));
  if (!(middle.length > 0) || !(unit_px > 0)) return prepared;
  put_in_hashed_order(points, middle.centre);
  prepared.cloud = cloud_of(problem, points, middle, unit_px);
  prepared.cloud.ignored = std::move(ignored);
  const std::vector<Eigen::Vector3d>& centred = prepared.cloud.points_in_centred;
  if (!are_enough(centred, fewest(initial.has_value())) || are_collinear(centred)) return prepared;
  if (initial) prepared.cloud.initial_cam_from_centred = to_cloud(*initial, prepared.cloud);
  prepared.status = PoseStatus::kOk;
  return prepared;
}

Cloud with_unknown_noise(Cloud cloud) {
  cloud.whitening.clear();
  cloud.areas.clear();
  cloud.sigma = 0;
  cloud.typical_noise = kTypicalNoise * image_extent(cloud.image);
  cloud.screen = screen_points(cloud);
  return cloud;
}

Pose from_cloud(const Pose& cam_from_centred, const Cloud& cloud) {
  Pose pose = {cam_from_centred.rotation, cloud.length_m * cam_from_centred.translation};
  pose.translation -= pose.rotation * cloud.centre_in_target;
  return pose;
}

Pose to_cloud(const Pose& cam_from_target, const Cloud& cloud) {
  return {cam_from_target.rotation, (cam_from_target * cloud.centre_in_target) / cloud.length_m};
}

Matrix6d covariance_from_cloud(const Matrix6d& covariance, const Pose& cam_from_centred,
                               const Cloud& cloud) {
  Matrix6d scaled = covariance;
  scaled.bottomRows<3>() *= cloud.length_m;
  scaled.rightCols<3>() *= cloud.length_m;
  Correspondences frame;
  frame.centroid_in_target = cloud.centre_in_target;
  return covariance_from_centred(scaled, cam_from_centred, frame);
}

kernel::ScreenPose screen_pose(const Cloud& cloud, const Pose& pose) {
  kernel::ScreenPose screen;
  for (int k = 0; k < 3; ++k) {
    const double focal = k < 2 ? cloud.focal[k] : 1;
    for (int j = 0; j < 3; ++j) {
      screen.row[4 * k + j] = static_cast<float>(focal * pose.rotation(k, j));
    }
    screen.row[4 * k + 3] = static_cast<float>(focal * pose.translation[k]);
  }
  return screen;
}

}  // namespace sightline::consensus
