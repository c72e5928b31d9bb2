// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/orientation/consensus_pairs.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "pose/absolute_orientation.h"

namespace sightline::pair_consensus {
namespace {

/// What is left out on either side of a cloud's box, and the least side of it, of its longest.
constexpr double kTail = 0.05;
constexpr double kLeastSide = 0.02;
constexpr double kLeastSideOfSpan = 0.35;
/// A box that is so many times larger with all of its points has points far out.
constexpr double kFarOut = 4;
/// Medians and boxes are those of the first so many pairs, which are a fair sample.
constexpr std::size_t kMostForBox = 256;
/// Pairs with more noise than this agree with anything, and are left out of the search.
constexpr double kMostSearchedSigma = 0.1;
/// What noise is taken for that is not known, of the span.
constexpr double kGuessedSigma = 0.0107;
/// Unknown noise is at most this part of the span.
constexpr double kLargestSigma = 0.03;

/// The median of each coordinate, and the sides of the box that PairSet speaks of.
struct Box {
  Eigen::Vector3d middle;
  Eigen::Vector3d sides;
};

Box box_of(const std::vector<Eigen::Vector3d>& points) {
  const std::size_t n = std::min(points.size(), kMostForBox);
  const std::size_t left_out =
      n < 5 ? 0 : static_cast<std::size_t>(std::ceil(kTail * static_cast<double>(n)));
  // Of n uniform points, the span of those that are left to the whole.
  const auto widening = [n](std::size_t out) {
    return static_cast<double>(n + 1) / static_cast<double>(n - 1 - 2 * out);
  };
  Box box;
  std::vector<double> values(n);
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < n; ++i) values[i] = points[i][axis];
    std::sort(values.begin(), values.end());
    box.middle[axis] = values[n / 2];
    const double most = widening(left_out) * (values[n - 1 - left_out] - values[left_out]);
    const double whole = widening(0) * (values[n - 1] - values[0]);
    box.sides[axis] = whole > kFarOut * most && most > 0 ? most : whole;
  }
  return box;
}

bool is_usable(const MatchedPoints& points, std::size_t k) {
  const double weight = points.weights.empty() ? 1.0 : points.weights[k];
  return weight > 0 && std::isfinite(weight) && points.in_a[k].allFinite() &&
         points.in_b[k].allFinite();
}

void take_usable(const MatchedPoints& points, PairSet& set) {
  for (std::size_t k = 0; k < points.in_a.size(); ++k) {
    (is_usable(points, k) ? set.given_index : set.ignored).push_back(static_cast<int>(k));
  }
  std::vector<int>& order = set.given_index;
  for (int i = static_cast<int>(order.size()) - 1; i > 0; --i) {
    std::swap(order[static_cast<std::size_t>(i)],
              order[static_cast<std::size_t>(drawn_below(static_cast<std::uint64_t>(i), i + 1))]);
  }
  set.a.reserve(order.size());
  set.b.reserve(order.size());
  for (const int k : order) {
    set.a.push_back(points.in_a[static_cast<std::size_t>(k)]);
    set.b.push_back(points.in_b[static_cast<std::size_t>(k)]);
  }
}

/// Returns the weight that has a variance of 1.
double set_variances(const MatchedPoints& points, PairSet& set) {
  set.inverse_variance.assign(set.a.size(), 1.0);
  if (points.weights.empty()) return 1;
  std::vector<double> weights;
  for (const int k : set.given_index) {
    weights.push_back(points.weights[static_cast<std::size_t>(k)]);
  }
  std::vector<double> sorted = weights;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double median = *middle;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    set.inverse_variance[i] = weights[i] / median;
    set.least_variance = std::min(set.least_variance, median / weights[i]);
  }
  return median;
}

/// To the unit of length of the set, about the middles. False where a cloud has no size.
bool normalise(PairSet& set) {
  const Box box_a = box_of(set.a);
  const Box box_b = box_of(set.b);
  set.middle_a = box_a.middle;
  set.middle_b = box_b.middle;
  set.unit_b = box_b.sides.maxCoeff();
  set.unit_a = set.estimates_scale ? box_a.sides.maxCoeff() : set.unit_b;
  const auto is_size = [](double unit) { return unit > 0 && std::isfinite(unit); };
  if (!is_size(set.unit_a) || !is_size(set.unit_b)) return false;
  for (Eigen::Vector3d& x : set.a) x = (x - set.middle_a) / set.unit_a;
  for (Eigen::Vector3d& x : set.b) x = (x - set.middle_b) / set.unit_b;
  set.volume = (box_b.sides / set.unit_b).cwiseMax(kLeastSide).prod();
  set.span = std::cbrt((box_b.sides / set.unit_b).cwiseMax(kLeastSideOfSpan).prod());
  return true;
}

void fill_rows(PairSet& set) {
  kernel::PairRows& rows = set.rows;
  const double sigma = set.expected_sigma();
  const std::size_t n = std::min<std::size_t>(set.a.size(), kMostSearched);
  kernel::resize(rows, n);
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3f a = set.a[i].cast<float>();
    const Eigen::Vector3f b = set.b[i].cast<float>();
    rows.ax[i] = a.x();
    rows.ay[i] = a.y();
    rows.az[i] = a.z();
    rows.bx[i] = b.x();
    rows.by[i] = b.y();
    rows.bz[i] = b.z();
    const double variance = 1 / set.inverse_variance[i];
    const bool says_much = variance * sigma * sigma < kMostSearchedSigma * kMostSearchedSigma;
    if (says_much) rows.v[i] = static_cast<float>(variance);
  }
}

}  // namespace

double PairSet::largest_sigma() const {
  return sigma > 0 ? sigma : kLargestSigma * span;
}

double PairSet::expected_sigma() const {
  return sigma > 0 ? sigma : kGuessedSigma * span;
}

PairSet prepare_pairs(const MatchedPoints& points, const RobustAlignmentOptions& options) {
  PairSet set;
  set.estimates_scale = options.estimates_scale;
  if (!(options.sigma_m >= 0 && std::isfinite(options.sigma_m))) {
    set.status = OrientationStatus::kNotFinite;
    return set;
  }
  if (points.in_a.size() != points.in_b.size()) return set;
  if (!points.weights.empty() && points.weights.size() != points.in_a.size()) {
    set.status = OrientationStatus::kBadWeights;
    return set;
  }
  take_usable(points, set);
  if (set.n() < 3) return set;
  const double median_weight = set_variances(points, set);
  set.status = OrientationStatus::kDegenerate;
  if (!normalise(set)) return set;
  set.sigma_unit_m = set.unit_b * std::sqrt(median_weight);
  set.sigma = options.sigma_m / set.sigma_unit_m;
  fill_rows(set);
  set.status = OrientationStatus::kOk;
  return set;
}

Alignment in_given_units(const PairSet& set, const Similarity& map) {
  Alignment alignment;
  alignment.status = OrientationStatus::kOk;
  alignment.scale = set.estimates_scale ? map.scale * (set.unit_b / set.unit_a) : 1.0;
  alignment.b_from_a.rotation = map.rotation;
  alignment.b_from_a.translation =
      set.middle_b + set.unit_b * map.translation - alignment.scale * (map.rotation * set.middle_a);
  return alignment;
}

std::optional<Similarity> fit_pairs(const PairSet& set, std::span<const int> indices,
                                    std::span<const double> weights) {
  if (indices.size() < 3) return std::nullopt;
  // About one of the pairs, so that little cancels where they lie together.
  const Eigen::Vector3d origin_a = set.a[static_cast<std::size_t>(indices[0])];
  const Eigen::Vector3d origin_b = set.b[static_cast<std::size_t>(indices[0])];
  double sum = 0;
  double norm_a = 0;
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_b = Eigen::Vector3d::Zero();
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const auto k = static_cast<std::size_t>(indices[i]);
    const double w = (weights.empty() ? 1.0 : weights[i]) * set.inverse_variance[k];
    const Eigen::Vector3d x = set.a[k] - origin_a;
    const Eigen::Vector3d y = w * (set.b[k] - origin_b);
    sum += w;
    mean_a += w * x;
    mean_b += y;
    cross.noalias() += y * x.transpose();
    norm_a += w * x.squaredNorm();
  }
  if (!(sum > 0)) return std::nullopt;
  mean_a /= sum;
  mean_b /= sum;
  cross.noalias() -= (sum * mean_b) * mean_a.transpose();
  const OrientationEstimate estimate = fast_rotation(cross);
  if (estimate.status != OrientationStatus::kOk) return std::nullopt;
  Similarity map;
  map.rotation = estimate.b_from_a.rotation;
  if (set.estimates_scale) {
    map.scale = map.rotation.cwiseProduct(cross).sum() / (norm_a - sum * mean_a.squaredNorm());
  }
  if (!(map.scale > 0 && std::isfinite(map.scale))) return std::nullopt;
  map.translation = origin_b + mean_b - map.scale * (map.rotation * (origin_a + mean_a));
  return map;
}

Spread spread_of(const PairSet& set, const Similarity& map, std::span<const int> indices) {
  Spread spread;
  for (const int index : indices) {
    const auto k = static_cast<std::size_t>(index);
    spread.weight += set.inverse_variance[k];
    spread.mean += (map.scale * set.inverse_variance[k]) * (map.rotation * set.a[k]);
  }
  spread.mean /= spread.weight;
  for (const int index : indices) {
    const auto k = static_cast<std::size_t>(index);
    const Eigen::Vector3d x = map.scale * (map.rotation * set.a[k]) - spread.mean;
    spread.about_mean.noalias() += (set.inverse_variance[k] * x) * x.transpose();
  }
  return spread;
}

}  // namespace sightline::pair_consensus
