// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// How many points a solver may remove. (orpe_weighed, which tries every set of points, has a limit
// of its own: pose/removal_sets.h.)
#pragma once

#include <cstddef>

#include "pose/solver.h"

namespace sightline {

/// A solver removes no point that would leave fewer: any three points are met exactly by some pose,
/// so that it takes a fourth to contradict. Four leave two redundant coordinates, 2 * 4 - 6.
inline constexpr std::size_t kMinimumKeptPoints = 4;

/// How many of so many points may be removed: OutlierOptions::max_removed, as many as there are
/// where that is not said, and never so many that fewer than kMinimumKeptPoints are left.
std::size_t removal_limit(const OutlierOptions& options, std::size_t points);

/// The same, but fewer than half of the points where OutlierOptions::max_removed is not said.
std::size_t minority_limit(const OutlierOptions& options, std::size_t points);

}  // namespace sightline
