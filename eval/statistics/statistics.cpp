// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/statistics/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/normal.hpp>

#include "scenes/random/random.h"

namespace sightline {
namespace {

constexpr int kResamples = 2000;
constexpr size_t kMostValuesToResample = 500;
constexpr double kTail = 0.025;  // on either side of a 95 % interval
constexpr double kZ95 = 1.959963984540054;

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

Interval95 abc_interval(double n, double mean, double squares, double acceleration) {
  const double standard_error = standard_error_of(squares, n);
  return {abc_end(mean, standard_error, kTail, acceleration),
          abc_end(mean, standard_error, 1 - kTail, acceleration)};
}

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

// Bins of errors by their logarithm: `kBinsAnOctave` linear ones in each octave, so that a bin is
// at most 0.2 % wide and its middle 0.1 % off. What is below is 0, what is above infinite.
constexpr int kBinsAnOctave = 512;
constexpr int kLeastExponent = -50;
constexpr int kMostExponent = 30;
constexpr size_t kBins = size_t{kBinsAnOctave} * (kMostExponent - kLeastExponent) + 2;

size_t bin_of(double error) {
  if (error < std::ldexp(0.5, kLeastExponent + 1)) return 0;
  int exponent = 0;
  const double fraction = std::frexp(error, &exponent);  // in [1/2, 1)
  if (!std::isfinite(error) || exponent > kMostExponent) return kBins - 1;
  const auto octave = static_cast<size_t>(exponent - kLeastExponent - 1);
  return 1 + octave * kBinsAnOctave + static_cast<size_t>((2 * fraction - 1) * kBinsAnOctave);
}

double middle_of_bin(size_t bin) {
  if (bin == 0) return 0;
  if (bin == kBins - 1) return std::numeric_limits<double>::infinity();
  const size_t octave = (bin - 1) / kBinsAnOctave;
  const double part = (static_cast<double>((bin - 1) % kBinsAnOctave) + 0.5) / kBinsAnOctave;
  return std::ldexp((1 + part) / 2, static_cast<int>(octave) + kLeastExponent + 1);
}

Interval95 root_of(const Interval95& squares) {
  return {std::sqrt(std::max(0.0, squares[0])), std::sqrt(squares[1])};
}

}  // namespace

double normal_cdf(double z) {
  return std::erfc(-z / std::numbers::sqrt2) / 2;
}

double normal_quantile(double p) {
  return boost::math::quantile(boost::math::normal(), p);
}

double percentile(std::span<const double> values, double p) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  return percentile_of_sorted(sorted, p);
}

Interval95 bca_mean_interval(std::span<const double> values, uint64_t seed,
                             std::string_view stream) {
  if (values.size() < 2) return kNoInterval;  // one says nothing of how the next would differ
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  if (*least == *greatest) return {*least, *least};

  const double mean = mean_of(values);
  const CentralSums sums = sums_about(values, mean);
  const double acceleration = acceleration_of(sums.squares, sums.cubes);
  if (values.size() > kMostValuesToResample) {
    return abc_interval(static_cast<double>(values.size()), mean, sums.squares, acceleration);
  }
  RandomStream random(seed, stream, 0);
  const std::vector<double> means = sorted_resample_means(values, random);
  const double bias = bias_correction(means, mean);
  return {percentile_of_sorted(means, corrected_tail(kTail, bias, acceleration)),
          percentile_of_sorted(means, corrected_tail(1 - kTail, bias, acceleration))};
}

Interval95 wilson_interval(int64_t count, int64_t trials) {
  if (trials <= 0) return kNoInterval;
  const double n = static_cast<double>(trials);
  const double rate = static_cast<double>(count) / n;
  const double z2 = kZ95 * kZ95;
  const double middle = (rate + z2 / (2 * n)) / (1 + z2 / n);
  const double half_width =
      kZ95 / (1 + z2 / n) * std::sqrt(rate * (1 - rate) / n + z2 / (4 * n * n));
  // Rounding must not put none or all outside.
  return {count == 0 ? 0 : middle - half_width, count == trials ? 1 : middle + half_width};
}

std::array<int64_t, 2> quantile_ranks(int64_t n, double p) {
  const boost::math::binomial below(static_cast<double>(n), p);
  // The chance that at most k of the values are below the quantile.
  const auto at_most = [&](int64_t k) { return boost::math::cdf(below, static_cast<double>(k)); };
  // The least k in [0, n] with at_most(k) > level.
  const auto first_above = [&](double level) {
    int64_t low = 0;
    int64_t high = n;
    while (low < high) {
      const int64_t middle = (low + high) / 2;
      at_most(middle) > level ? high = middle : low = middle + 1;
    }
    return low;
  };
  return {first_above(kTail) - 1, first_above(1 - kTail)};
}

std::optional<int64_t> trials_for(double target, int64_t n, double mean, const Interval95& ci95) {
  const double relative = (ci95[1] - ci95[0]) / 2 / mean;
  if (!(mean > 0) || !std::isfinite(relative)) return std::nullopt;
  return static_cast<int64_t>(std::ceil(static_cast<double>(n) * std::pow(relative / target, 2)));
}

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

Interval95 difference_interval(double a, const Interval95& a_ci95, double b,
                               const Interval95& b_ci95) {
  return {b - a - std::hypot(b - b_ci95[0], a_ci95[1] - a),
          b - a + std::hypot(b_ci95[1] - b, a - a_ci95[0])};
}

void RmsRatio::add(double numerator, double denominator) {
  const double a2 = numerator * numerator;
  const double b2 = denominator * denominator;
  ++count_;
  a2_ += a2;
  b2_ += b2;
  a4_ += a2 * a2;
  b4_ += b2 * b2;
  a2b2_ += a2 * b2;
}

double RmsRatio::numerator_rms() const {
  return count_ > 0 ? std::sqrt(a2_ / static_cast<double>(count_)) : kNoNumber;
}

double RmsRatio::denominator_rms() const {
  return count_ > 0 ? std::sqrt(b2_ / static_cast<double>(count_)) : kNoNumber;
}

double RmsRatio::value() const {
  return denominator_rms() > 0 ? numerator_rms() / denominator_rms() : kNoNumber;
}

Interval95 RmsRatio::ci95() const {
  const double ratio = value();
  if (count_ < 2 || !(ratio > 0)) return kNoInterval;
  const double n = static_cast<double>(count_);
  const double a = a2_ / n;
  const double b = b2_ / n;
  // The variance of x / a - y / b, whose mean is zero.
  const double variance = (a4_ / (a * a) - 2 * a2b2_ / (a * b) + b4_ / (b * b)) / (n - 1);
  const double half_width = kZ95 / 2 * std::sqrt(std::max(0.0, variance) / n);  // of log(ratio)
  return {ratio * std::exp(-half_width), ratio * std::exp(half_width)};
}

void ErrorStatistics::Moments::add(double value) {
  ++count;
  const double n = static_cast<double>(count);
  const double d = value - mean;
  const double step = d / n;
  const double term = d * step * (n - 1);
  mean += step;
  cubes += term * step * (n - 2) - 3 * step * squares;
  squares += term;
  least = std::min(least, value);
  greatest = std::max(greatest, value);
}

Interval95 ErrorStatistics::Moments::abc_mean_interval() const {
  if (least == greatest) return {least, least};
  return abc_interval(static_cast<double>(count), mean, squares, acceleration_of(squares, cubes));
}

void ErrorStatistics::add(double error) {
  if (std::isnan(error)) error = std::numeric_limits<double>::infinity();
  const double capped = std::min(error, cap_);
  errors_.add(capped);
  squares_.add(capped * capped);
  capped_ += capped == cap_;
  if (bins_.empty() && values_.size() < kMostValuesKept) {
    values_.push_back(error);
    return;
  }
  if (bins_.empty()) {
    bins_.resize(kBins);
    for (const double value : values_) ++bins_[bin_of(value)];
    values_ = {};
  }
  ++bins_[bin_of(error)];
}

double ErrorStatistics::value_at(std::span<const double> sorted, int64_t rank) const {
  if (bins_.empty()) return sorted[static_cast<size_t>(rank)];
  size_t bin = 0;
  for (int64_t up_to = bins_[0]; up_to <= rank; up_to += bins_[bin]) ++bin;
  return middle_of_bin(bin);
}

double ErrorStatistics::quantile_of(std::span<const double> sorted, double p) const {
  if (bins_.empty()) return percentile_of_sorted(sorted, p);
  return value_at(sorted, std::llround(p * static_cast<double>(errors_.count - 1)));
}

double ErrorStatistics::quantile(double p) const {
  return bins_.empty() ? percentile(values_, p) : quantile_of({}, p);
}

Interval95 ErrorStatistics::quantile_interval(std::span<const double> sorted, double p) const {
  const auto [low, high] = quantile_ranks(errors_.count, p);
  return {low < 0 ? kNoNumber : value_at(sorted, low),
          high >= errors_.count ? kNoNumber : value_at(sorted, high)};
}

ErrorSummary ErrorStatistics::summary(uint64_t seed, std::string_view stream) const {
  ErrorSummary summary;
  if (errors_.count == 0) return summary;
  if (bins_.empty() && values_.size() <= kMostValuesToResample) {
    std::vector<double> capped = values_;
    for (double& error : capped) error = std::min(error, cap_);
    summary.mean_ci95 = bca_mean_interval(capped, seed, stream);
    for (double& error : capped) error *= error;
    summary.rms_ci95 = root_of(bca_mean_interval(capped, seed, stream));
  } else {
    summary.mean_ci95 = errors_.abc_mean_interval();
    summary.rms_ci95 = root_of(squares_.abc_mean_interval());
  }
  std::vector<double> sorted = values_;
  std::sort(sorted.begin(), sorted.end());
  summary.mean = errors_.mean;
  summary.rms = std::sqrt(squares_.mean);
  summary.median = quantile_of(sorted, 0.5);
  summary.median_ci95 = quantile_interval(sorted, 0.5);
  summary.p90 = quantile_of(sorted, 0.9);
  summary.p90_ci95 = quantile_interval(sorted, 0.9);
  summary.capped = capped_;
  return summary;
}

ErrorSummary summarise(std::span<const double> errors, double cap, uint64_t seed,
                       std::string_view stream) {
  ErrorStatistics statistics(cap);
  for (const double error : errors) statistics.add(error);
  return statistics.summary(seed, stream);
}

}  // namespace sightline
