// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace sightline {

inline constexpr uint64_t kMostPointPairs = 2'000'000'000;  ///< compared in some two seconds

/// The greatest distance between two of the points; 0 of fewer than two. By branch and bound over a
/// tree of boxes along principal axes: milliseconds for a vehicle, a few seconds for five million
/// points on a sphere or another body of constant width, where no pair stands out. It is exact
/// unless `most_pairs` did not suffice, as between two small and far clusters, all of whose
/// distances are alike but for the rounding; then it may be too small by up to 1e-13 of itself.
double diameter(std::vector<Eigen::Vector3d> points, uint64_t most_pairs = kMostPointPairs);

}  // namespace sightline
