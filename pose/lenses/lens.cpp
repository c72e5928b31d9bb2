// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/lenses/lens.h"

namespace sightline {

Eigen::Vector2d distorted(const Lens& lens, const Eigen::Vector2d& normalised) {
  return std::visit([&](const auto& model) { return distorted(model, normalised); }, lens);
}

Eigen::Matrix2d distortion_jacobian(const Lens& lens, const Eigen::Vector2d& normalised) {
  return std::visit([&](const auto& model) { return distortion_jacobian(model, normalised); },
                    lens);
}

std::optional<Eigen::Vector2d> undistorted(const Lens& lens, const Eigen::Vector2d& image) {
  return std::visit([&](const auto& model) { return undistorted(model, image); }, lens);
}

double fold_radius(const Lens& lens, double limit) {
  return std::visit([&](const auto& model) { return fold_radius(model, limit); }, lens);
}

}  // namespace sightline
