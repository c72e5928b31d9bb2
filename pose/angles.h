// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

namespace sightline {

/// One degree in radians. The code computes in radians, files and options speak of degrees:
/// `30 * kDegree` is an angle in radians, `angle_rad / kDegree` one in degrees.
inline constexpr double kDegree = std::numbers::pi / 180;

}  // namespace sightline
