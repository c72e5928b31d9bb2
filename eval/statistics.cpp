// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "scenes/random.h"

namespace sightline {
namespace {

constexpr int kResamples = 2000;
constexpr size_t kMostValuesToResample = 500;
constexpr double kTail = 0.025;  // on either side of a 95 % interval

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double rms_of(std::span<const double> values) {
  const double squares = std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
  return std::sqrt(squares / static_cast<double>(values.size()));
}

// Sums of squares and cubes about the mean.
struct Moments {
  double squares = 0;
  double cubes = 0;
};

Moments moments_about(std::span<const double> values, double mean) {
  Moments moments;
  for (const double value : values) {
    const double d = value - mean;
    moments.squares += d * d;
    moments.cubes += d * d * d;
  }
  return moments;
}

double percentile_of_sorted(std::span<const double> sorted, double p) {
  const double position = p * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<size_t>(position);
  const double fraction = position - static_cast<double>(below);
  // Infinity minus infinity is no number: ask for the difference only where it counts.
  if (fraction == 0 || sorted[below] == sorted[below + 1]) return sorted[below];
  return sorted[below] + fraction * (sorted[below + 1] - sorted[below]);
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

std::array<double, 2> abc_interval(size_t count, double mean, double squares, double acceleration) {
  const double n = static_cast<double>(count);
  const double standard_error = std::sqrt(squares / (n - 1) / n);
  return {abc_end(mean, standard_error, kTail, acceleration),
          abc_end(mean, standard_error, 1 - kTail, acceleration)};
}

double acklam_lower_half(double p) {
  constexpr std::array a{-3.969683028665376e+01, 2.209460984245205e+02,  -2.759285104469687e+02,
                         1.383577518672690e+02,  -3.066479806614716e+01, 2.506628277459239e+00};
  constexpr std::array b{-5.447609879822406e+01, 1.615858368580409e+02,  -1.556989798598866e+02,
                         6.680131188771972e+01,  -1.328068155288572e+01, 1.0};
  constexpr std::array c{-7.784894002430293e-03, -3.223964580411365e-01, -2.400758277161838e+00,
                         -2.549732539343734e+00, 4.374664141464968e+00,  2.938163982698783e+00};
  constexpr std::array d{7.784695709041462e-03, 3.224671290700398e-01, 2.445134137142996e+00,
                         3.754408661907416e+00, 1.0};
  const auto horner = [](const auto& coefficients, double x) {
    double sum = 0;
    for (const double coefficient : coefficients) sum = sum * x + coefficient;
    return sum;
  };
  constexpr double kCentralRegion = 0.02425;
  if (p < kCentralRegion) {
    const double q = std::sqrt(-2 * std::log(p));
    return horner(c, q) / horner(d, q);
  }
  const double q = p - 0.5;
  return horner(a, q * q) * q / horner(b, q * q);
}

}  // namespace

double normal_cdf(double z) {
  return std::erfc(-z / std::numbers::sqrt2) / 2;
}

double normal_quantile(double p) {
  // In the upper half the distribution function has no digits left for the refinement.
  if (p > 0.5) return -normal_quantile(1 - p);
  const double z = acklam_lower_half(p);
  const double density = std::exp(-z * z / 2) / std::sqrt(2 * std::numbers::pi);
  const double newton_step = (normal_cdf(z) - p) / density;
  return z - newton_step / (1 + z * newton_step / 2);
}

double percentile(std::span<const double> values, double p) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  return percentile_of_sorted(sorted, p);
}

std::array<double, 2> bca_mean_interval(std::span<const double> values, uint64_t seed,
                                        std::string_view stream) {
  if (values.size() < 2) {  // one value says nothing of how the next would differ
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    return {kNone, kNone};
  }
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  if (*least == *greatest) return {*least, *least};

  const double mean = mean_of(values);
  const Moments moments = moments_about(values, mean);
  // The jackknife's acceleration, in closed form as leaving out x_i moves a mean by
  // (mean - x_i) / (n - 1).
  const double acceleration = moments.cubes / (6 * std::pow(moments.squares, 1.5));
  if (values.size() > kMostValuesToResample) {
    return abc_interval(values.size(), mean, moments.squares, acceleration);
  }
  RandomStream random(seed, stream, 0);
  const std::vector<double> means = sorted_resample_means(values, random);
  const double bias = bias_correction(means, mean);
  return {percentile_of_sorted(means, corrected_tail(kTail, bias, acceleration)),
          percentile_of_sorted(means, corrected_tail(1 - kTail, bias, acceleration))};
}

ErrorSummary summarise(std::span<const double> errors, double cap, uint64_t seed,
                       std::string_view stream) {
  if (errors.empty()) return {};
  std::vector<double> sorted(errors.begin(), errors.end());
  for (double& error : sorted) {
    if (std::isnan(error)) error = std::numeric_limits<double>::infinity();
  }
  std::vector<double> capped = sorted;
  for (double& error : capped) error = std::min(error, cap);
  std::sort(sorted.begin(), sorted.end());

  ErrorSummary summary;
  summary.mean = mean_of(capped);
  summary.mean_ci95 = bca_mean_interval(capped, seed, stream);
  summary.median = percentile_of_sorted(sorted, 0.5);
  summary.rms = rms_of(capped);
  summary.p90 = percentile_of_sorted(sorted, 0.9);
  summary.capped = static_cast<int>(std::count(capped.begin(), capped.end(), cap));
  return summary;
}

}  // namespace sightline
