// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <variant>

#include <Eigen/Core>

#include "pose/lenses/brown_conrady.h"
#include "pose/lenses/kannala_brandt.h"
#include "pose/lenses/rational.h"

namespace sightline {

/// A lens: one of the models, each of which has its own file. Without coefficients it is the
/// first, which then bends nothing: a pinhole.
using Lens = std::variant<BrownConrady, RationalLens, KannalaBrandt>;

/// True of a lens that bends nothing.
inline bool is_pinhole(const Lens& lens) {
  const auto* const brown = std::get_if<BrownConrady>(&lens);
  return brown != nullptr && brown->is_zero();
}

/// Where the lens puts the ray (x/z, y/z), still in normalised coordinates.
Eigen::Vector2d distorted(const Lens& lens, const Eigen::Vector2d& normalised);

/// The derivative of `distorted`. Its determinant is positive wherever the lens can be undone.
Eigen::Matrix2d distortion_jacobian(const Lens& lens, const Eigen::Vector2d& normalised);

/// The inverse of `distorted`, within the fold of the model. None where there is no such ray or the
/// model's iteration, begun where the image is, does not find it.
std::optional<Eigen::Vector2d> undistorted(const Lens& lens, const Eigen::Vector2d& image);

/// The smallest radius |(x/z, y/z)| at which the model folds: beyond, two rays would fall on one
/// pixel. `limit` where there is none until there.
double fold_radius(const Lens& lens, double limit);

}  // namespace sightline
