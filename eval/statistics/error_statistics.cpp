// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/statistics/error_statistics.h"

#include <algorithm>
#include <cmath>

#include "eval/statistics/bootstrap.h"

namespace sightline {
namespace {

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

}  // namespace

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

Interval95 ErrorStatistics::Moments::mean_interval() const {
  if (least == greatest) return {least, least};
  return abc_mean_interval(static_cast<double>(count), mean, squares, cubes);
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

Measured ErrorStatistics::median() const {
  if (errors_.count == 0) return {};
  std::vector<double> sorted = values_;
  std::sort(sorted.begin(), sorted.end());
  return {quantile_of(sorted, 0.5), quantile_interval(sorted, 0.5)};
}

Measured ErrorStatistics::mean_of(uint64_t seed, std::string_view stream) const {
  if (errors_.count == 0) return {};
  if (!bins_.empty() || values_.size() > kMostValuesToResample) {
    return {errors_.mean, errors_.mean_interval()};
  }
  std::vector<double> capped = values_;
  for (double& error : capped) error = std::min(error, cap_);
  return {errors_.mean, bca_mean_interval(capped, seed, stream)};
}

ErrorSummary ErrorStatistics::summary(uint64_t seed, std::string_view stream) const {
  ErrorSummary summary;
  if (errors_.count == 0) return summary;
  summary.resampled_mean_ci95 = mean_of(seed, stream).ci95;
  // The next error may be beyond all of these, and nothing in them says how far.
  Moments with_one_more = errors_;
  with_one_more.add(errors_.greatest);
  summary.mean_ci95 = summary.resampled_mean_ci95;
  summary.mean_ci95[1] =
      std::min(cap_, std::max(summary.mean_ci95[1], with_one_more.mean_interval()[1]));
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
