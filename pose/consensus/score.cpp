// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/consensus/score.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace sightline::consensus {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kMostScored = 1000;
/// Parts of the image's area beyond which a radius does not count, for either score.
constexpr double kWidest = 0.02;
constexpr double kWidestTight = 2e-4;
/// Agreement counts as significant within five deviations of noise that is known.
constexpr double kWidestDeviation = 5;
/// The chance, at most, that data without any pose are called significant.
constexpr double kChanceSignificance = 0.01;
/// The log odds that an inlier must have at least, so that outliers add nothing.
constexpr double kLeastOdds = 2.2;
/// The median residual of the points within t is about this part of it.
constexpr double kScaleOfRadius = 1.5;

/// Squares are counted by the exponent and the first bit of the mantissa of the float: two bins an
/// octave. The first bin holds all below 2^-44, which floats cannot tell from 0 here.
constexpr int kFirstBin = 2 * (127 - 44);
constexpr int kBins = 2 * 44 + 1;

int bin_of(float square) {
  const int bin = static_cast<int>(std::bit_cast<std::uint32_t>(square) >> 22) - kFirstBin;
  return std::clamp(bin, 0, kBins);
}

double upper_edge(int bin) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(bin + 1 + kFirstBin) << 22);
}

}  // namespace

double bernoulli_divergence(double p, double q) {
  const double yes = p > 0 ? p * std::log(p / q) : 0;
  return p < 1 ? yes + (1 - p) * std::log((1 - p) / (1 - q)) : yes;
}

double least_log_improbability(double triples, double n) {
  // Of all poses that were tried, and all radii about them.
  return std::log(3 * triples * 64 * n / kChanceSignificance);
}

void Scorer::fill(const Pose& pose, std::size_t count) {
  count_ = count;
  const std::size_t lanes = kernel::kScreenLanes;
  const std::size_t padded = (count + lanes - 1) / lanes * lanes;
  squares_.resize(padded);
  if (cloud_.whitening.empty()) {
    kernel::squared_distances(cloud_.screen, screen_pose(cloud_, pose), padded, squares_.data());
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    double r[2];
    const bool is_seen = residual_at(cloud_, pose, i, r);
    const double square = r[0] * r[0] + r[1] * r[1];
    squares_[i] = is_seen && square < kernel::kNotSeen ? static_cast<float>(square)  //
                                                       : kernel::kNotSeen;
  }
}

Score Scorer::known_noise() const {
  const double variance = cloud_.sigma * cloud_.sigma;
  const double inverse = 1 / (3 * variance);
  Score score;
  score.total = 0;
  score.scale = 2 * cloud_.sigma;
  for (std::size_t i = 0; i < count_; ++i) {
    const double most = std::log(cloud_.area(i) / (2 * kPi * variance)) - kLeastOdds;
    const double excess = squares_[i] * inverse;
    if (most > 0 && excess < std::exp(0.5 * most) - 1) {
      score.total += most - 2 * std::log1p(excess);
    }
  }
  return score;
}

Score Scorer::any_noise(double least_square, double widest) const {
  std::array<int, kBins + 1> counts = {};
  for (std::size_t i = 0; i < count_; ++i) {
    ++counts[bin_of(squares_[i] / static_cast<float>(cloud_.area(i)))];
  }
  Score best;
  const double others = static_cast<double>(count_) - 3;
  int within = 0;
  for (int bin = 0; bin < kBins; ++bin) {
    if (counts[bin] == 0) continue;
    within += counts[bin];
    const double square = std::max(upper_edge(bin), least_square);
    const double chance = kPi * square;
    if (chance > widest) break;
    const double share = (within - 3) / others;
    if (within <= 3 || share <= chance) continue;
    const double total = others * bernoulli_divergence(share, chance);
    const double scale = std::sqrt(0.5 * square) / kScaleOfRadius;
    if (total > best.total) best.total = total, best.scale = scale;
    if (chance <= kWidestTight && total > best.tight_total) {
      best.tight_total = total;
      best.tight_scale = scale;
    }
  }
  return best;
}

Score Scorer::score(const Pose& pose) {
  fill(pose, std::min(cloud_.size(), kMostScored));
  return cloud_.is_sigma_known() ? known_noise() : any_noise(0, kWidest);
}

double Scorer::log_improbability(const Pose& pose) {
  fill(pose, cloud_.size());
  const bool is_plain = cloud_.whitening.empty();
  const double noise2 = is_plain ? cloud_.sigma * cloud_.sigma : 0;
  const double widest = noise2 > 0 ? kPi * kWidestDeviation * kWidestDeviation * noise2  //
                                   : kWidestSignificant;
  return any_noise(noise2, std::min(widest, kWidest)).total;
}

}  // namespace sightline::consensus
