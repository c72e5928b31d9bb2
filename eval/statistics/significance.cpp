// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/statistics/significance.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <boost/math/distributions/binomial.hpp>

#include "eval/statistics/statistics.h"

namespace sightline {
namespace {

// The share of all choices of signs that give as great a sum as these.
double sign_flip_share(std::span<const double> values) {
  const double observed = std::accumulate(values.begin(), values.end(), 0.0);
  double scale = 0;
  for (const double value : values) scale += std::abs(value);
  const double rounding = 1e-12 * scale;
  const uint32_t choices = uint32_t{1} << values.size();
  uint32_t as_great = 0;
  for (uint32_t signs = 0; signs < choices; ++signs) {
    double sum = 0;
    for (size_t i = 0; i < values.size(); ++i)
      sum += (signs >> i & 1) != 0 ? -values[i] : values[i];
    as_great += sum >= observed - rounding;
  }
  return static_cast<double>(as_great) / choices;
}

}  // namespace

double p_mean_above_zero(std::span<const double> differences) {
  constexpr size_t kMostToEnumerate = 16;
  if (differences.empty()) return 1;
  if (differences.size() <= kMostToEnumerate) return sign_flip_share(differences);
  double sum = 0;
  double squares = 0;
  for (const double difference : differences) {
    sum += difference;
    squares += difference * difference;
  }
  return squares > 0 ? normal_cdf(-sum / std::sqrt(squares)) : 1;
}

double mcnemar_p(int64_t only_first, int64_t only_second) {
  const int64_t n = only_first + only_second;
  if (n == 0) return 1;
  const boost::math::binomial fair(static_cast<double>(n), 0.5);
  return std::min(
      1.0, 2 * boost::math::cdf(fair, static_cast<double>(std::min(only_first, only_second))));
}

double mcnemar_p_of_more(int64_t only_first, int64_t only_second) {
  if (only_second == 0) return 1;
  const boost::math::binomial fair(static_cast<double>(only_first + only_second), 0.5);
  return boost::math::cdf(boost::math::complement(fair, static_cast<double>(only_second - 1)));
}

double fisher_p(int64_t count_a, int64_t trials_a, int64_t count_b, int64_t trials_b) {
  const int64_t counts = count_a + count_b;
  if (counts == 0 || trials_a == 0 || trials_b == 0) return 1;
  // Of the gamma function: the library's hypergeometric law ends at some millions.
  const auto log_choose = [](int64_t n, int64_t k) {
    return std::lgamma(static_cast<double>(n + 1)) - std::lgamma(static_cast<double>(k + 1)) -
           std::lgamma(static_cast<double>(n - k + 1));
  };
  const auto log_chance = [&](int64_t in_a) {
    return log_choose(trials_a, in_a) + log_choose(trials_b, counts - in_a) -
           log_choose(trials_a + trials_b, counts);
  };
  constexpr double kRounding = 1e-7;  // tables as unlikely as this one count, as in R
  const double observed = log_chance(count_a);
  double p = 0;
  for (int64_t k = std::max<int64_t>(0, counts - trials_b); k <= std::min(counts, trials_a); ++k) {
    const double chance = log_chance(k);
    if (chance <= observed + kRounding) p += std::exp(chance);
  }
  return std::min(1.0, p);
}

std::vector<double> holm_adjusted(std::span<const double> p_values) {
  std::vector<size_t> order(p_values.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return p_values[a] < p_values[b]; });
  std::vector<double> adjusted(p_values.size());
  double greatest = 0;
  for (size_t rank = 0; rank < order.size(); ++rank) {
    const double factor = static_cast<double>(order.size() - rank);
    greatest = std::max(greatest, std::min(1.0, factor * p_values[order[rank]]));
    adjusted[order[rank]] = greatest;
  }
  return adjusted;
}

}  // namespace sightline
