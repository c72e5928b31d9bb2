// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// What the lens models share that bend an image without turning rays: Newton's iteration that
// undoes them, and the search for their fold.
#pragma once

#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Core>
#include <Eigen/LU>

namespace sightline::lenses {

inline constexpr int kMaxUndistortIterations = 30;
/// Of the normalised coordinate: at f = 15000 px this is 1.5e-9 px.
inline constexpr double kUndistortTolerance = 1e-13;

/// The point that the lens puts at `image`, by Newton's iteration from there. None where it meets
/// a fold or does not converge.
template <typename LensModel>
std::optional<Eigen::Vector2d> undistorted_by_newton(const LensModel& lens,
                                                     const Eigen::Vector2d& image) {
  Eigen::Vector2d normalised = image;
  for (int i = 0; i < kMaxUndistortIterations; ++i) {
    const Eigen::Matrix2d jacobian = distortion_jacobian(lens, normalised);
    // A fold of the lens model: beyond it two rays fall on one pixel. Beyond two folds the model
    // turns the image about, which no lens does.
    if (!(jacobian.determinant() > 0 && jacobian.trace() > 0)) return std::nullopt;
    const Eigen::Vector2d excess = distorted(lens, normalised) - image;
    const Eigen::Vector2d step = jacobian.inverse() * excess;
    normalised -= step;
    if (step.norm() <= kUndistortTolerance * (1 + normalised.norm())) return normalised;
  }
  return std::nullopt;
}

/// The smallest radius, up to `limit`, at which `is_folded` is true in one of 64 directions; the
/// limit where it is nowhere.
template <typename IsFolded>
double first_fold(double limit, IsFolded is_folded) {
  constexpr int kDirections = 64;
  constexpr int kSteps = 2000;
  double radius = limit;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2 * std::numbers::pi * i / kDirections;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    for (int step = 1; step <= kSteps; ++step) {
      const double r = limit * step / kSteps;
      if (r >= radius) break;
      if (is_folded(r * direction)) radius = r;
    }
  }
  return radius;
}

}  // namespace sightline::lenses
