// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The tables are quantiles of 150 000 draws a row: points uniform in a box, attitude uniform, range
// a hundred boxes, f = 15000 px, noise of 0.5 px. To draw them again:
//
//   pose_test --gtest_also_run_disabled_tests --gtest_filter='*PrintTheNullTables'
//
// (tests/pose/minimax_null_test.cpp). One entry errs by 0.3 to 3 % of itself, most at the last
// tail; the ratio for five points, whose law falls off as slowly as a power, by up to 10 %.

#include "pose/minimax_null.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace sightline {
namespace {

constexpr std::size_t kTails = 7;
constexpr std::array<double, kTails> kTail = {0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001};
constexpr std::size_t kMostPoints = 16;

/// Of min max f / sigma^2, from four points on.
constexpr std::size_t kFewestPoints = 4;
constexpr std::array<std::array<double, kTails>, 13> kQuantiles = {{
    {1.417, 1.853, 2.425, 2.884, 3.318, 3.908, 4.385},  // 4
    {2.076, 2.555, 3.184, 3.64, 4.105, 4.702, 5.222},   // 5
    {2.562, 3.061, 3.707, 4.203, 4.687, 5.325, 5.801},  // 6
    {2.936, 3.452, 4.13, 4.629, 5.137, 5.761, 6.219},   // 7
    {3.259, 3.789, 4.446, 4.941, 5.446, 6.142, 6.556},  // 8
    {3.525, 4.073, 4.732, 5.256, 5.766, 6.502, 7.036},  // 9
    {3.767, 4.311, 4.997, 5.504, 5.966, 6.597, 7.195},  // 10
    {3.982, 4.524, 5.202, 5.729, 6.236, 6.962, 7.449},  // 11
    {4.181, 4.739, 5.436, 5.939, 6.445, 7.066, 7.605},  // 12
    {4.357, 4.908, 5.613, 6.127, 6.643, 7.351, 7.94},   // 13
    {4.507, 5.066, 5.783, 6.29, 6.805, 7.483, 7.995},   // 14
    {4.651, 5.201, 5.928, 6.449, 6.948, 7.603, 8.098},  // 15
    {4.812, 5.378, 6.067, 6.586, 7.104, 7.738, 8.252},  // 16
}};

/// Of Lambda, from five points on.
constexpr std::size_t kFewestRatioPoints = 5;
constexpr std::array<std::array<double, kTails>, 12> kRatioQuantiles = {{
    {21.93, 44.95, 110.3, 224.9, 455.6, 1202, 2444},    // 5
    {6.047, 8.937, 14.54, 20.91, 30.26, 48.74, 71.03},  // 6
    {3.825, 5.05, 7.164, 9.197, 11.9, 16.16, 20.74},    // 7
    {2.973, 3.719, 4.916, 6.017, 7.398, 9.501, 11.59},  // 8
    {2.565, 3.108, 3.939, 4.666, 5.514, 6.753, 8.019},  // 9
    {2.32, 2.754, 3.417, 3.967, 4.557, 5.542, 6.479},   // 10
    {2.158, 2.527, 3.07, 3.523, 4.006, 4.778, 5.319},   // 11
    {2.037, 2.358, 2.829, 3.235, 3.647, 4.275, 4.811},  // 12
    {1.946, 2.238, 2.658, 3.013, 3.374, 3.91, 4.344},   // 13
    {1.878, 2.141, 2.521, 2.829, 3.182, 3.623, 3.975},  // 14
    {1.821, 2.063, 2.396, 2.671, 2.962, 3.38, 3.726},   // 15
    {1.777, 2.007, 2.328, 2.594, 2.86, 3.243, 3.531},   // 16
}};

/// Linear in the logarithm of the tail. Beyond the first tail its segment is prolonged, beyond the
/// last one the line through the fourth and the last entries, which errs less than the last
/// segment.
template <typename Value>
double interpolate(double tail, const Value& value) {
  constexpr double kSmallestTail = 1e-6;
  constexpr double kLargestTail = 0.5;
  // Written so that NaN becomes the smallest tail, which removes least.
  const double x = std::log(tail > kSmallestTail ? std::min(tail, kLargestTail) : kSmallestTail);
  const auto line = [&](std::size_t from, std::size_t to) {
    const double x0 = std::log(kTail[from]);
    const double x1 = std::log(kTail[to]);
    return value(from) + (value(to) - value(from)) * (x - x0) / (x1 - x0);
  };
  if (x < std::log(kTail[kTails - 1])) return line(3, kTails - 1);
  std::size_t to = 1;
  while (to + 1 < kTails && x < std::log(kTail[to])) ++to;
  return line(to - 1, to);
}

/// Points that are met exactly, whatever is minimised.
constexpr std::size_t kMetExactly = 3;

}  // namespace

double minimax_quantile(std::size_t points, double tail) {
  if (points < kFewestPoints) return 0;
  const auto& row = kQuantiles[std::min(points, kMostPoints) - kFewestPoints];
  const double value = interpolate(tail, [&row](std::size_t i) { return row[i]; });
  // The largest of many squared residuals grows as 2 ln n.
  const double many = static_cast<double>(std::max(points, kMostPoints));
  return std::max(value, 0.0) + 2 * std::log(many / static_cast<double>(kMostPoints));
}

double minimax_ratio_quantile(std::size_t points, double tail) {
  if (points < kFewestRatioPoints) return std::numeric_limits<double>::infinity();
  const auto& row = kRatioQuantiles[std::min(points, kMostPoints) - kFewestRatioPoints];
  // Its law falls off as a power: logarithms are nearly linear.
  return std::exp(interpolate(tail, [&row](std::size_t i) { return std::log(row[i]); }));
}

double minimax_variance_factor(std::size_t points) {
  if (points <= kMetExactly) return 1;
  const double n = static_cast<double>(points);
  return 0.37 * n / std::log(n);
}

}  // namespace sightline
