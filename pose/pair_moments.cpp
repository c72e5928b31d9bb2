// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/pair_moments.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "pose/kernels/orientation_kernels.h"

namespace sightline {
namespace {

template <typename Scalar>
using Points = std::span<const Eigen::Matrix<Scalar, 3, 1>>;

template <typename Scalar>
struct WeightedPairs {
  Points<Scalar> in_a;
  Points<Scalar> in_b;
  std::span<const double> weights;
  bool with_spread;
  double coordinate_epsilon;  ///< what the coordinates are rounded to, relative
};

struct Weights {
  OrientationStatus status = OrientationStatus::kOk;
  std::size_t first_positive = 0;
  std::size_t positive = 0;
};

template <typename Scalar>
Weights inspect_weights(const WeightedPairs<Scalar>& pairs) {
  const std::size_t n = pairs.in_a.size();
  if (pairs.in_b.size() != n) return {OrientationStatus::kTooFewPoints};
  if (pairs.weights.empty()) {
    return {n < 3 ? OrientationStatus::kTooFewPoints : OrientationStatus::kOk, 0, n};
  }
  if (pairs.weights.size() != n) return {OrientationStatus::kBadWeights};
  Weights weights{OrientationStatus::kOk, n, 0};
  for (std::size_t k = 0; k < n; ++k) {
    const double w = pairs.weights[k];
    if (!(w >= 0 && std::isfinite(w))) return {OrientationStatus::kBadWeights};
    if (w > 0) weights.first_positive = std::min(weights.first_positive, k);
    weights.positive += w > 0;
  }
  if (weights.positive < 3) weights.status = OrientationStatus::kTooFewPoints;
  return weights;
}

template <typename Scalar>
CentredSums sums_about(const WeightedPairs<Scalar>& pairs, const Eigen::Vector3d& origin_a,
                       const Eigen::Vector3d& origin_b) {
  return centred(
      sum_pairs(PairArrays<Scalar>{pairs.in_a.data()->data(),
                                   pairs.in_b.data()->data(),
                                   pairs.weights.empty() ? nullptr : pairs.weights.data(),
                                   pairs.in_a.size(),
                                   {origin_a.x(), origin_a.y(), origin_a.z()},
                                   {origin_b.x(), origin_b.y(), origin_b.z()}}));
}

template <typename Scalar>
Eigen::Matrix3d spread_about(const WeightedPairs<Scalar>& pairs, const Eigen::Vector3d& mean) {
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < pairs.in_a.size(); ++k) {
    const Eigen::Vector3d x = pairs.in_a[k].template cast<double>() - mean;
    const double w = pairs.weights.empty() ? 1.0 : pairs.weights[k];
    spread.noalias() += (w * x) * x.transpose();
  }
  return spread;
}

/// How much larger what was subtracted is than what was left, squared.
bool has_cancelled(const CentredSums& sums) {
  return sums.subtracted_norm2 > kTolerableCancellation * kTolerableCancellation * sums.norm2;
}

template <typename Scalar>
PairMoments moments_in_range(const WeightedPairs<Scalar>& pairs, const Weights& weights) {
  PairMoments m;
  m.positive_weights = static_cast<Eigen::Index>(weights.positive);
  m.origin_in_a = pairs.in_a[weights.first_positive].template cast<double>();
  m.origin_in_b = pairs.in_b[weights.first_positive].template cast<double>();
  CentredSums sums = sums_about(pairs, m.origin_in_a, m.origin_in_b);
  const double extent2_a = Eigen::Vector3d(sums.mean_x).squaredNorm();
  const double extent2_b = Eigen::Vector3d(sums.mean_y).squaredNorm();
  if (has_cancelled(sums)) {
    m.origin_in_a += Eigen::Vector3d(sums.mean_x);
    m.origin_in_b += Eigen::Vector3d(sums.mean_y);
    sums = sums_about(pairs, m.origin_in_a, m.origin_in_b);
  }
  const bool is_in_range = sums.norm2 >= kSmallestNorm2 && sums.norm2 <= kLargestNorm2;
  m.status = is_in_range ? OrientationStatus::kOk : OrientationStatus::kDegenerate;
  m.weight = sums.weight;
  m.mean_from_origin_a = Eigen::Vector3d(sums.mean_x);
  m.mean_from_origin_b = Eigen::Vector3d(sums.mean_y);
  m.cross = Eigen::Map<const Eigen::Matrix3d>(sums.cross);
  m.rounding = pairs.coordinate_epsilon * pairs.coordinate_epsilon * m.weight *
               std::sqrt((m.mean_in_a().squaredNorm() + extent2_a) *
                         (m.mean_in_b().squaredNorm() + extent2_b));
  if (pairs.with_spread) m.spread_a = spread_about(pairs, m.mean_in_a());
  return m;
}

template <typename Scalar>
double largest_coordinate(Points<Scalar> points) {
  double largest = 0;
  for (const auto& x : points) {
    const double here = x.cwiseAbs().template maxCoeff<Eigen::PropagateNaN>();
    if (!std::isfinite(here)) return std::numeric_limits<double>::infinity();
    largest = std::max(largest, here);
  }
  return largest;
}

/// A power of two, clamped so that neither it nor its inverse overflows.
double power_of_two_near(double x) {
  return std::ldexp(1.0, std::clamp(std::ilogb(x), -1000, 1000));
}

/// The points that have a weight: the others may hold anything.
template <typename Scalar>
std::vector<Eigen::Matrix<Scalar, 3, 1>> weighted(Points<Scalar> points,
                                                  std::span<const double> weights) {
  std::vector<Eigen::Matrix<Scalar, 3, 1>> result;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (weights[k] > 0) result.push_back(points[k]);
  }
  return result;
}

template <typename Scalar>
std::vector<Eigen::Vector3d> scaled(Points<Scalar> points, double factor) {
  std::vector<Eigen::Vector3d> result;
  for (const auto& x : points) result.push_back(factor * x.template cast<double>());
  return result;
}

std::vector<double> scaled(std::span<const double> weights) {
  if (weights.empty()) return {};
  const double unit = power_of_two_near(*std::max_element(weights.begin(), weights.end()));
  std::vector<double> result;
  for (const double w : weights) result.push_back(w / unit);
  return result;
}

/// For points (or weights) whose products leave the range of double: the same in other units.
/// Rarely needed, so it may copy.
template <typename Scalar>
PairMoments moments_out_of_range(const WeightedPairs<Scalar>& pairs, const Weights& weights) {
  PairMoments failed;
  const double largest =
      std::max(largest_coordinate<Scalar>(pairs.in_a), largest_coordinate<Scalar>(pairs.in_b));
  failed.status = OrientationStatus::kNotFinite;
  if (!std::isfinite(largest)) return failed;
  failed.status = OrientationStatus::kDegenerate;
  if (largest == 0) return failed;

  const double unit_m = power_of_two_near(largest);
  const std::vector<Eigen::Vector3d> in_a = scaled<Scalar>(pairs.in_a, 1 / unit_m);
  const std::vector<Eigen::Vector3d> in_b = scaled<Scalar>(pairs.in_b, 1 / unit_m);
  const std::vector<double> scaled_weights = scaled(pairs.weights);
  PairMoments m = moments_in_range<double>(
      {in_a, in_b, scaled_weights, pairs.with_spread, pairs.coordinate_epsilon}, weights);
  m.origin_in_a *= unit_m;
  m.origin_in_b *= unit_m;
  m.mean_from_origin_a *= unit_m;
  m.mean_from_origin_b *= unit_m;
  m.unit_m = unit_m;
  return m;
}

}  // namespace

template <typename Scalar>
PairMoments pair_moments(Points<Scalar> points_in_a, Points<Scalar> points_in_b,
                         std::span<const double> weights, bool with_spread) {
  const WeightedPairs<Scalar> pairs = {points_in_a, points_in_b, weights, with_spread,
                                       std::numeric_limits<Scalar>::epsilon()};
  const Weights inspected = inspect_weights(pairs);
  if (inspected.status != OrientationStatus::kOk) {
    PairMoments failed;
    failed.status = inspected.status;
    return failed;
  }
  PairMoments m = moments_in_range(pairs, inspected);
  if (m.status == OrientationStatus::kOk) return m;
  if (inspected.positive == points_in_a.size()) return moments_out_of_range(pairs, inspected);
  const auto in_a = weighted<Scalar>(points_in_a, weights);
  const auto in_b = weighted<Scalar>(points_in_b, weights);
  std::vector<double> positive;
  for (const double w : weights) {
    if (w > 0) positive.push_back(w);
  }
  return pair_moments<Scalar>(in_a, in_b, positive, with_spread);
}

template PairMoments pair_moments<double>(std::span<const Eigen::Vector3d>,
                                          std::span<const Eigen::Vector3d>, std::span<const double>,
                                          bool);
template PairMoments pair_moments<float>(std::span<const Eigen::Vector3f>,
                                         std::span<const Eigen::Vector3f>, std::span<const double>,
                                         bool);

}  // namespace sightline
