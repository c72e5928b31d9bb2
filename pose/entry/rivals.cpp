// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/entry/rivals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

#include "pose/entry/cleaning.h"
#include "pose/p3p.h"
#include "pose/point_spread.h"
#include "pose/pose.h"
#include "pose/robust.h"

namespace sightline::entry {
namespace {

/// Another pose is a rival above this share of both probabilities, and beyond this squared distance
/// in standard deviations, the 99.9 % quantile of chi-square of six degrees; consensus and
/// orpe_weighed have the same.
constexpr double kRivalShare = 0.05;
constexpr double kRivalDistance2 = 22.46;
/// A double root of three points comes twice.
constexpr double kSameRad = 1e-6;
/// Of the focal length: residuals as small come from rounding.
constexpr double kRivalRounding = 1e-9;

Part kept_part(const PoseProblem& problem, const PoseEstimate& estimate) {
  std::vector<int> left_out;
  std::ranges::set_union(estimate.removed, estimate.ignored, std::back_inserter(left_out));
  Part part = without_points(problem, std::move(left_out));
  // The initial pose is not used, but lets three points pass.
  part.problem.initial_cam_from_target = estimate.cam_from_target;
  return part;
}

/// The sum of the squares that least squares leaves, and where; infinite where it fails.
struct Minimum {
  Pose cam_from_centred;
  Matrix6d unit_covariance = Matrix6d::Zero();
  double squares = std::numeric_limits<double>::infinity();
};

Minimum minimum_from(const WhitenedCorrespondences& c, const Pose& start) {
  const LeastSquares fit = whitened_least_squares(c, {&start, 1}, {});
  Minimum minimum;
  if (fit.status != PoseStatus::kOk) return minimum;
  minimum = {fit.cam_from_centred, fit.unit_covariance, fit.cost_px2};
  return minimum;
}

/// How much more probable the first of two poses is, as a logarithm.
double log_odds(const WhitenedCorrespondences& c, double squares, double other_squares) {
  if (c.sigma > 0) return (other_squares - squares) / (2 * c.sigma * c.sigma);
  const double degrees = std::max(2 * static_cast<double>(c.size()) - 6, 1.0);
  return degrees / 2 * std::log(other_squares / squares);
}

bool is_far(const WhitenedCorrespondences& c, const Minimum& here, const Pose& there,
            double squares) {
  const double degrees = std::max(2 * static_cast<double>(c.size()) - 6, 1.0);
  const double variance = c.sigma > 0 ? c.sigma * c.sigma : squares / degrees;
  const std::optional<Matrix6d> information = inverse_information(here.unit_covariance);
  if (!information) return false;
  const Vector6d step = change_between(here.cam_from_centred, there);
  return step.dot(*information * step) > kRivalDistance2 * variance;
}

std::optional<Pose> mirror_rival(const WhitenedCorrespondences& c, const Pose& cam_from_centred) {
  const Minimum here = minimum_from(c, cam_from_centred);
  const Minimum there = minimum_from(c, mirror_of(c.points, cam_from_centred));
  if (!std::isfinite(here.squares) || !std::isfinite(there.squares)) return std::nullopt;
  const double rounding_px = kRivalRounding * std::max(c.points.fx_px, c.points.fy_px);
  const double rounding = rounding_px * rounding_px * static_cast<double>(c.size());
  const double squares = here.squares + rounding;
  const double odds = log_odds(c, squares, there.squares + rounding);
  if (odds > std::log((1 - kRivalShare) / kRivalShare)) return std::nullopt;
  if (!is_far(c, here, there.cam_from_centred, squares)) return std::nullopt;
  return there.cam_from_centred;
}

/// With three points: of the other poses that meet them exactly the nearest one.
std::optional<Pose> three_point_rival(const Correspondences& c, const Pose& cam_from_centred) {
  std::array<Eigen::Vector3d, 3> points, rays;
  for (std::size_t i = 0; i < 3; ++i) {
    points[i] = c.points_in_centred[i];
    rays[i] = {c.pixels[i].x() / c.fx_px, c.pixels[i].y() / c.fy_px, 1};
  }
  std::optional<Pose> rival;
  double least = std::numeric_limits<double>::infinity();
  const P3pPoses poses = p3p(points, rays);
  for (const Pose& pose : poses.all()) {
    const double turn = geodesic_angle_rad(pose.rotation, cam_from_centred.rotation);
    if (!(turn > kSameRad) || !(turn < least)) continue;
    least = turn;
    rival = pose;
  }
  return rival;
}

}  // namespace

Pose mirror_of(const Correspondences& c, const Pose& cam_from_centred) {
  const Eigen::Vector3d normal = spread_of(c.points_in_centred).axes.col(2);
  const Eigen::Vector3d ray = cam_from_centred.translation.normalized();
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  return {(one - 2 * ray * ray.transpose()) * cam_from_centred.rotation *
              (one - 2 * normal * normal.transpose()),
          cam_from_centred.translation};
}

std::optional<Pose> rival_of(const PoseProblem& problem, const PoseEstimate& estimate) {
  const Part part = kept_part(problem, estimate);
  const PreparedWhitened prepared = prepare_whitened(part.problem);
  if (prepared.status != PoseStatus::kOk) return std::nullopt;
  const WhitenedCorrespondences& c = prepared.correspondences;
  const Pose here = to_centred(estimate.cam_from_target, c.points);
  const std::optional<Pose> rival =
      c.size() == 3 ? three_point_rival(c.points, here) : mirror_rival(c, here);
  return rival ? std::optional(from_centred(*rival, c.points)) : std::nullopt;
}

}  // namespace sightline::entry
