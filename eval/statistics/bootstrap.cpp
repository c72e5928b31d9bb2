// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/statistics/bootstrap.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "scenes/random/random.h"

namespace sightline {
namespace {

constexpr int kResamples = 2000;

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// Sums of squares and cubes about the mean.
struct CentralSums {
  double squares = 0;
  double cubes = 0;
};

CentralSums sums_about(std::span<const double> values, double mean) {
  CentralSums sums;
  for (const double value : values) {
    const double d = value - mean;
    sums.squares += d * d;
    sums.cubes += d * d * d;
  }
  return sums;
}

// The jackknife's acceleration of a mean, in closed form as leaving out x_i moves it by
// (mean - x_i) / (n - 1).
double acceleration_of(double squares, double cubes) {
  return cubes / (6 * std::pow(squares, 1.5));
}

double standard_error_of(double squares, double n) {
  return std::sqrt(squares / (n - 1) / n);
}

std::vector<double> sorted_resample_means(std::span<const double> values, RandomStream& random) {
  std::vector<double> means(kResamples);
  for (double& mean : means) {
    double sum = 0;
    for (size_t i = 0; i < values.size(); ++i) {
      sum += values[(uint64_t{random.bits()} * values.size()) >> 32];
    }
    mean = sum / static_cast<double>(values.size());
  }
  std::sort(means.begin(), means.end());
  return means;
}

// z0: how far the resamples' median lies from the mean, in standard deviations.
double bias_correction(std::span<const double> sorted_means, double mean) {
  const auto [first, last] = std::equal_range(sorted_means.begin(), sorted_means.end(), mean);
  const double below = static_cast<double>(first - sorted_means.begin());
  const double tied = static_cast<double>(last - first);
  const double fraction = (below + tied / 2) / kResamples;
  return normal_quantile(std::clamp(fraction, 0.5 / kResamples, 1 - 0.5 / kResamples));
}

// The fraction of the resamples' distribution that bounds the interval in place of `tail`. The
// denominator stays positive: |acceleration| < 1/6 for a mean, |bias + z| < 5.5 by the clamp above.
double corrected_tail(double tail, double bias, double acceleration) {
  const double z = bias + normal_quantile(tail);
  return normal_cdf(bias + z / (1 - acceleration * z));
}

// An end of the ABC interval of a mean: a linear statistic has no curvature, so that its bias
// correction is the acceleration itself.
double abc_end(double mean, double standard_error, double tail, double acceleration) {
  const double w = acceleration + normal_quantile(tail);
  return mean + standard_error * w / std::pow(1 - acceleration * w, 2);
}

}  // namespace

Interval95 abc_mean_interval(double n, double mean, double squares, double cubes) {
  const double acceleration = acceleration_of(squares, cubes);
  const double standard_error = standard_error_of(squares, n);
  return {abc_end(mean, standard_error, kTail95, acceleration),
          abc_end(mean, standard_error, 1 - kTail95, acceleration)};
}

Interval95 bca_mean_interval(std::span<const double> values, uint64_t seed,
                             std::string_view stream) {
  if (values.size() < 2) return kNoInterval;  // one says nothing of how the next would differ
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  if (*least == *greatest) return {*least, *least};

  const double mean = mean_of(values);
  const CentralSums sums = sums_about(values, mean);
  if (values.size() > kMostValuesToResample) {
    return abc_mean_interval(static_cast<double>(values.size()), mean, sums.squares, sums.cubes);
  }
  const double acceleration = acceleration_of(sums.squares, sums.cubes);
  RandomStream random(seed, stream, 0);
  const std::vector<double> means = sorted_resample_means(values, random);
  const double bias = bias_correction(means, mean);
  return {percentile_of_sorted(means, corrected_tail(kTail95, bias, acceleration)),
          percentile_of_sorted(means, corrected_tail(1 - kTail95, bias, acceleration))};
}

Interval95 bootstrap_interval(size_t count, uint64_t seed, std::string_view stream,
                              const ResampledNumber& number) {
  constexpr size_t kMostDraws = 4'000'000;  // of all resamples together
  constexpr size_t kFewestResamples = 200;
  if (count < 2) return kNoInterval;
  const size_t resamples = std::clamp(kMostDraws / count, kFewestResamples, size_t{kResamples});
  RandomStream random(seed, stream, 0);
  std::vector<uint32_t> drawn(count);
  std::vector<double> numbers;
  for (size_t i = 0; i < resamples; ++i) {
    for (uint32_t& index : drawn) {
      index = static_cast<uint32_t>((uint64_t{random.bits()} * count) >> 32);
    }
    const double value = number(drawn);
    if (!std::isnan(value)) numbers.push_back(value);
  }
  if (numbers.empty()) return kNoInterval;
  std::sort(numbers.begin(), numbers.end());
  return {percentile_of_sorted(numbers, kTail95), percentile_of_sorted(numbers, 1 - kTail95)};
}

}  // namespace sightline
