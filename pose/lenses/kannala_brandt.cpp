// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/lenses/kannala_brandt.h"

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

/// The distance from the axis at which a ray at an angle to it is seen.
double distance_at(const KannalaBrandt& lens, double angle) {
  const double a2 = angle * angle;
  return angle * (1 + a2 * (lens.k1 + a2 * (lens.k2 + a2 * (lens.k3 + a2 * lens.k4))));
}

/// The derivative of distance_at.
double growth_at(const KannalaBrandt& lens, double angle) {
  const double a2 = angle * angle;
  return 1 + a2 * (3 * lens.k1 + a2 * (5 * lens.k2 + a2 * (7 * lens.k3 + a2 * 9 * lens.k4)));
}

/// Whether the distance grows all the way from the axis to an angle: of most lenses because the
/// terms that shorten it are too small to stop it, else by looking at steps of at most 2 degrees.
bool grows_until(const KannalaBrandt& lens, double angle) {
  const KannalaBrandt shortening{.k1 = std::min(lens.k1, 0.0),
                                 .k2 = std::min(lens.k2, 0.0),
                                 .k3 = std::min(lens.k3, 0.0),
                                 .k4 = std::min(lens.k4, 0.0)};
  if (growth_at(shortening, angle) > 0) return true;
  constexpr int kSteps = 45;
  for (int i = 1; i <= kSteps; ++i) {
    if (!(growth_at(lens, angle * i / kSteps) > 0)) return false;
  }
  return true;
}

/// The angle that is seen at a distance from the axis, by Newton's iteration from the equidistant
/// lens. None where the lens folds before it or the angle is beyond the most.
std::optional<double> angle_at(const KannalaBrandt& lens, double distance) {
  constexpr int kMaxIterations = 30;
  constexpr double kTolerance = 1e-15;
  // A step as short leaves an error of its square.
  constexpr double kShortStep = 1e-8;
  double angle = std::min(distance, kMostFisheyeAngle);
  for (int i = 0; i < kMaxIterations; ++i) {
    const double growth = growth_at(lens, angle);
    if (!(growth > 0)) return std::nullopt;
    const double step = (distance_at(lens, angle) - distance) / growth;
    angle = std::max(angle - step, 0.0);
    if (std::abs(step) > std::max(kShortStep * angle, kTolerance)) continue;
    if (angle <= kMostFisheyeAngle && grows_until(lens, angle)) return angle;
    return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

Eigen::Vector2d distorted(const KannalaBrandt& lens, const Eigen::Vector2d& normalised) {
  const double r = normalised.norm();
  if (!(r > 0)) return normalised;
  return normalised * (distance_at(lens, std::atan(r)) / r);
}

Eigen::Matrix2d distortion_jacobian(const KannalaBrandt& lens, const Eigen::Vector2d& normalised) {
  const double r = normalised.norm();
  if (!(r > 0)) return Eigen::Matrix2d::Identity();
  // Along the radius the distance grows with the angle, across it with the radius.
  const double angle = std::atan(r);
  const double along = growth_at(lens, angle) / (1 + r * r);
  const double across = distance_at(lens, angle) / r;
  const Eigen::Vector2d direction = normalised / r;
  return across * Eigen::Matrix2d::Identity() +
         (along - across) * direction * direction.transpose();
}

std::optional<Eigen::Vector2d> undistorted(const KannalaBrandt& lens,
                                           const Eigen::Vector2d& image) {
  const double distance = image.norm();
  if (!(distance > 0)) return image;
  const std::optional<double> angle = angle_at(lens, distance);
  if (!angle) return std::nullopt;
  return image * (std::tan(*angle) / distance);
}

double fold_angle(const KannalaBrandt& lens) {
  constexpr int kSteps = 2000;
  for (int i = 1; i <= kSteps; ++i) {
    const double angle = kMostFisheyeAngle * i / kSteps;
    if (!(growth_at(lens, angle) > 0)) return kMostFisheyeAngle * (i - 1) / kSteps;
  }
  return kMostFisheyeAngle;
}

double fold_radius(const KannalaBrandt& lens, double limit) {
  return std::min(limit, std::tan(fold_angle(lens)));
}

}  // namespace sightline
