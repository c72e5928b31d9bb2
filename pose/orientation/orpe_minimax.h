// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "pose/orientation/consensus_pairs.h"

namespace sightline {

/// The map of least largest distance of some pairs, min max_i f_i, f_i = |r_i|^2 / v_i.
struct DistanceMinimax {
  pair_consensus::Similarity map;
  double largest = 0;  ///< max f_i
  /// No map has a largest f below this.
  double lower_bound = 0;
  /// One an index: the weights l_i of the bound, none negative, their sum one. Zero but for the few
  /// pairs that hold the maximum.
  std::vector<double> multipliers;

  /// Position among the indices of the largest multiplier.
  std::size_t most_binding() const;
};

/// Minimises max f_i by a primal-dual interior point method on min t subject to f_i <= t (as
/// pose/minimax.cpp does for pixels) over the few pairs that hold the maximum, others joining as
/// they exceed it.
///
/// The certificate: for weights l_i >= 0 that sum to one, max f_i >= sum l_i f_i for every map,
/// hence min max f_i >= min sum l_i f_i, which is weighted least squares, whose minimum the closed
/// form gives. So the bound is good for all maps and not only for those nearby. None where the
/// pairs do not determine a map.
std::optional<DistanceMinimax> minimise_largest_distance(const pair_consensus::PairSet& set,
                                                         std::span<const int> indices);

}  // namespace sightline
