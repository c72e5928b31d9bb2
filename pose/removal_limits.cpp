// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/removal_limits.h"

#include <algorithm>

namespace sightline {
namespace {

std::size_t limit(const OutlierOptions& options, std::size_t points, std::size_t unsaid) {
  const std::size_t most = points > kMinimumKeptPoints ? points - kMinimumKeptPoints : 0;
  if (!options.max_removed) return std::min(most, unsaid);
  return std::min(most, static_cast<std::size_t>(std::max(*options.max_removed, 0)));
}

}  // namespace

std::size_t removal_limit(const OutlierOptions& options, std::size_t points) {
  return limit(options, points, points);
}

std::size_t minority_limit(const OutlierOptions& options, std::size_t points) {
  return limit(options, points, points > 0 ? (points - 1) / 2 : 0);
}

}  // namespace sightline
