// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The mixture of inliers and outliers by which pose/orientation/consensus.cpp weighs the pairs.
#pragma once

#include <optional>
#include <vector>

#include "pose/orientation/consensus_pairs.h"

namespace sightline::pair_consensus {

/// Noise below this, in the set's units, is rounding.
inline constexpr double kLeastSigma = 1e-12;

/// A map, the noise about it, and how probably each pair belongs to it.
struct Mixture {
  Similarity map;
  double sigma = 0;
  double outlier_share = 0.5;
  std::vector<double> probability;  ///< of being an inlier, one a pair of those looked at
  double inliers = 0;               ///< their sum
};

/// Expectation and maximisation in turns, from a map and a noise that is rather too large, on the
/// first n pairs. None where fewer than three pairs are left.
std::optional<Mixture> fit_mixture(const PairSet& set, const Similarity& start, double start_sigma,
                                   int n);

/// Covariance of (w, dt), or of (w, dt, d ln scale) where a scale is estimated, in the set's units,
/// the doubt about who is an inlier included; where the noise was found, that of Student's law.
/// None where it is not determined.
std::optional<Eigen::MatrixXd> covariance_of(const PairSet& set, const Mixture& mixture);

}  // namespace sightline::pair_consensus
