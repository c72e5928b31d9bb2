// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Matched points made ready for the search of pose/orientation/consensus.cpp: what cannot be used
// is left out, the clouds are brought to the size of 1 about their middles, and the order is
// shuffled.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "pose/kernels/pair_kernel.h"
#include "pose/robust_alignment.h"

namespace sightline::pair_consensus {

/// Of more pairs so many, a fair sample, are searched; the others are only in the way before the
/// end.
inline constexpr int kMostSearched = 1024;

/// x_b = scale R x_a + t.
struct Similarity {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  double scale = 1;

  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const {
    return scale * (rotation * x) + translation;
  }
};

/// The pairs that can be used, in an order shuffled by a hash of the position, so that every run of
/// them is a fair sample. Far outliers shall not decide what the unit is: middles are medians, and
/// the unit is the longest side of the box of b, or, where that is clearly larger than without a
/// twentieth of the points on every side, of the box without them. Boxes are widened to what they
/// would be for any number of points that are uniform in them.
struct PairSet {
  OrientationStatus status = OrientationStatus::kTooFewPoints;  ///< kOk: the rest may be used
  std::vector<int> given_index;                                 ///< of each pair
  std::vector<int> ignored;                                     ///< given indices, ascending
  std::vector<Eigen::Vector3d> a, b;                            ///< about the middles, in units
  std::vector<double> inverse_variance;  ///< of the noise: 1 at the median weight
  double least_variance = 1;
  kernel::PairRows rows;  ///< the first kMostSearched in single precision
  Eigen::Vector3d middle_a = Eigen::Vector3d::Zero();
  Eigen::Vector3d middle_b = Eigen::Vector3d::Zero();
  double unit_a = 1;        ///< of coordinates of a, metres: that of b unless a scale is estimated
  double unit_b = 1;        ///< of coordinates of b
  double sigma_unit_m = 1;  ///< noise of 1 here is that of so many metres at a weight of 1
  double sigma = 0;         ///< of the noise, here; 0: not known
  double volume = 1;        ///< of the box of b: outliers are uniform in it
  double span = 1;          ///< the mean side of the box, were it not flat
  bool estimates_scale = false;

  int n() const { return static_cast<int>(a.size()); }
  /// How many unknowns a pose has.
  int unknowns() const { return estimates_scale ? 7 : 6; }
  /// The noise that is known, or what it is taken for.
  double expected_sigma() const;
  /// Noise that is not known is at most this much.
  double largest_sigma() const;
};

PairSet prepare_pairs(const MatchedPoints& points, const RobustAlignmentOptions& options);

/// A map between the coordinates of the set, as one between those that were given.
Alignment in_given_units(const PairSet& set, const Similarity& map);

/// The weighted least-squares map of some pairs, by the closed form; the weights, one an index, are
/// divided by the pairs' variances. None where they do not determine one.
std::optional<Similarity> fit_pairs(const PairSet& set, std::span<const int> indices,
                                    std::span<const double> weights = {});

/// sum w (x - mean)(x - mean)^T of the mapped points x = scale R x_a, w = weight / variance, about
/// their mean, with what else their covariance needs.
struct Spread {
  double weight = 0;  ///< sum of weight / variance
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d about_mean = Eigen::Matrix3d::Zero();
};

Spread spread_of(const PairSet& set, const Similarity& map, std::span<const int> indices);

/// A number in which every bit depends on every bit of `x`: the finaliser of SplitMix64 (Steele,
/// Lea, Flood, OOPSLA 2014).
inline std::uint64_t hash_of(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// A number below `count`, the same for the same counter.
inline int drawn_below(std::uint64_t counter, int count) {
  return static_cast<int>(((hash_of(counter) >> 32) * static_cast<std::uint64_t>(count)) >> 32);
}

}  // namespace sightline::pair_consensus
