// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/paired.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "eval/compare/verdicts.h"
#include "eval/statistics/bootstrap.h"
#include "eval/statistics/signed_rank.h"
#include "eval/statistics/significance.h"

namespace sightline {
namespace {

constexpr uint64_t kBootstrapSeed = 1;

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

std::vector<double> affine(const std::vector<double>& values, double factor, double offset) {
  std::vector<double> result;
  for (const double value : values) result.push_back(factor * value + offset);
  return result;
}

std::vector<double> parts_of(const std::vector<Share>& shares) {
  std::vector<double> parts;
  for (const Share& share : shares) parts.push_back(share.part);
  return parts;
}

// Two failures differ by nothing, though both are infinite.
double change_of(double base, double now) {
  return base == now ? 0 : now - base;
}

std::vector<double> changes_of(const std::vector<double>& base, const std::vector<double>& now) {
  std::vector<double> changes;
  for (size_t i = 0; i < base.size(); ++i) changes.push_back(change_of(base[i], now[i]));
  return changes;
}

// ---- mean and middle

Difference mean_difference(const Measure& measure, const PairedNumber& pairs, double tolerance,
                           const std::string& stream) {
  const std::vector<double> base = parts_of(pairs.base);
  const std::vector<double> changes = changes_of(base, parts_of(pairs.now));
  Difference result;
  result.base = mean_of(base);
  result.now = result.base + mean_of(changes);
  result.ci95 = bca_mean_interval(changes, kBootstrapSeed, stream);
  const double allowed = allowed_change(measure, tolerance, result.base);
  set_sides(measure,
            {p_mean_above_zero(affine(changes, 1, -allowed)),
             p_mean_above_zero(affine(changes, -1, -allowed))},
            allowed, result);
  return result;
}

// A failure is worse than whatever has an error: for ranks and their interval it is enough to say
// that it is as much worse as the trials' errors reach.
std::vector<double> with_failures_finite(std::vector<double> changes) {
  double greatest = 0;
  for (const double change : changes) {
    if (std::isfinite(change)) greatest = std::max(greatest, std::abs(change));
  }
  const double beyond = greatest > 0 ? 2 * greatest : 1;
  for (double& change : changes) {
    if (!std::isfinite(change)) change = std::copysign(beyond, change);
  }
  return changes;
}

// The changes of the new run against the base times `factor`. With no tolerance a trial that is the
// same in both says nothing and is left out; with one it says that nothing changed.
std::vector<double> counted_changes(const std::vector<double>& base, const std::vector<double>& now,
                                    double factor, double rounding) {
  std::vector<double> changes;
  for (size_t i = 0; i < base.size(); ++i) {
    const double before = std::isfinite(base[i]) ? factor * base[i] : base[i];
    const double change = change_of(before, now[i]);
    if (factor != 1 || std::abs(change) > rounding) changes.push_back(change);
  }
  return with_failures_finite(std::move(changes));
}

Difference middle_difference(const Measure& measure, const PairedNumber& pairs, double tolerance) {
  const std::vector<double> base = parts_of(pairs.base);
  const std::vector<double> now = parts_of(pairs.now);
  Difference result;
  result.base = percentile(base, 0.5);
  const double rounding = allowed_change(measure, 0, result.base);
  const std::vector<double> changes = counted_changes(base, now, 1, rounding);
  for (const double change : changes) (change > 0 ? result.greater : result.less) += 1;
  const Measured middle = middle_of(changes);
  result.now = changes.empty() ? result.base : result.base + middle.value;
  result.ci95 = middle.ci95;
  // The test and its interval say the same, so that the interval beyond the tolerance need not be
  // asked for as well.
  const std::vector<double> beyond = counted_changes(base, now, 1 + tolerance, rounding);
  const std::vector<double> below = counted_changes(base, now, 1 - tolerance, rounding);
  set_sides(measure, {p_middle_above_zero(beyond), p_middle_above_zero(affine(below, -1, 0))},
            result);
  return result;
}

// ---- quantiles

double quantile_of(const std::vector<double>& values, std::span<const uint32_t> drawn, double p) {
  std::vector<double> of_drawn;
  of_drawn.reserve(drawn.size());
  for (const uint32_t index : drawn) of_drawn.push_back(values[index]);
  const auto rank = static_cast<std::ptrdiff_t>(p * static_cast<double>(drawn.size() - 1));
  std::nth_element(of_drawn.begin(), of_drawn.begin() + rank, of_drawn.end());
  return of_drawn[static_cast<size_t>(rank)];
}

// How likely so many more of `now` than of `base` lie beyond the p-quantile of both together.
double p_of_quantile_above(const std::vector<double>& base, const std::vector<double>& now,
                           double p) {
  std::vector<double> both = base;
  both.insert(both.end(), now.begin(), now.end());
  const double limit = percentile(both, p);
  int64_t only_base = 0;
  int64_t only_now = 0;
  for (size_t i = 0; i < base.size(); ++i) {
    only_base += base[i] > limit && now[i] <= limit;
    only_now += now[i] > limit && base[i] <= limit;
  }
  return mcnemar_p_of_more(only_base, only_now);
}

Difference quantile_difference(const Measure& measure, const PairedNumber& pairs, double tolerance,
                               const std::string& stream) {
  const double p = measure.statistic == Statistic::kP90 ? 0.9 : 0.5;
  const std::vector<double> base = parts_of(pairs.base);
  const std::vector<double> now = parts_of(pairs.now);
  Difference result;
  result.base = percentile(base, p);
  result.now = percentile(now, p);
  result.ci95 =
      bootstrap_interval(base.size(), kBootstrapSeed, stream, [&](std::span<const uint32_t> drawn) {
        return change_of(quantile_of(base, drawn, p), quantile_of(now, drawn, p));
      });
  const double allowed = allowed_change(measure, tolerance, result.base);
  set_sides(measure,
            {p_of_quantile_above(affine(base, 1, allowed), now, p),
             p_of_quantile_above(now, affine(base, 1, -allowed), p)},
            allowed, result);
  return result;
}

// ---- ratios of sums

// y and x of each trial, of which the ratio of the sums is asked.
std::vector<Share> shares_of(const Measure& measure, std::vector<Share> shares) {
  if (measure.statistic != Statistic::kRms) return shares;
  for (Share& share : shares) share.part *= share.part;
  return shares;
}

bool is_root(const Measure& measure) {
  return measure.statistic == Statistic::kRms || measure.number.kind == NumberKind::kRms;
}

template <typename Indices>
double ratio_of(const std::vector<Share>& shares, const Indices& indices, bool has_root) {
  Share sum{0, 0};
  for (const auto index : indices) {
    sum.part += shares[index].part;
    sum.whole += shares[index].whole;
  }
  const double ratio = sum.whole > 0 ? sum.part / sum.whole : kNoNumber;
  return has_root ? std::sqrt(ratio) : ratio;
}

// The base changed by so much of what the measure tells.
std::vector<Share> changed(const std::vector<Share>& shares, const Measure& measure, double base,
                           double change) {
  if (!(base > 0) && is_root(measure)) return shares;
  std::vector<Share> result = shares;
  const double factor = is_root(measure) ? std::pow((base + change) / base, 2) : 1;
  for (Share& share : result) {
    share.part = is_root(measure) ? share.part * factor : share.part + change * share.whole;
  }
  return result;
}

double p_of_ratio_above(const std::vector<Share>& base, const std::vector<Share>& now) {
  Share sum{0, 0};
  for (const std::vector<Share>* shares : {&base, &now}) {
    for (const Share& share : *shares) {
      sum.part += share.part;
      sum.whole += share.whole;
    }
  }
  if (!(sum.whole > 0)) return 1;
  const double ratio = sum.part / sum.whole;
  std::vector<double> excess;
  for (size_t i = 0; i < base.size(); ++i) {
    excess.push_back((now[i].part - ratio * now[i].whole) - (base[i].part - ratio * base[i].whole));
  }
  return p_mean_above_zero(excess);
}

Difference ratio_difference(const Measure& measure, const PairedNumber& pairs, double tolerance,
                            const std::string& stream) {
  const std::vector<Share> base = shares_of(measure, pairs.base);
  const std::vector<Share> now = shares_of(measure, pairs.now);
  const bool has_root = is_root(measure);
  std::vector<uint32_t> all(base.size());
  for (size_t i = 0; i < all.size(); ++i) all[i] = static_cast<uint32_t>(i);
  Difference result;
  result.base = ratio_of(base, all, has_root);
  result.now = ratio_of(now, all, has_root);
  result.ci95 =
      bootstrap_interval(base.size(), kBootstrapSeed, stream, [&](std::span<const uint32_t> drawn) {
        return change_of(ratio_of(base, drawn, has_root), ratio_of(now, drawn, has_root));
      });
  const double allowed = allowed_change(measure, tolerance, result.base);
  set_sides(measure,
            {p_of_ratio_above(changed(base, measure, result.base, allowed), now),
             p_of_ratio_above(now, changed(base, measure, result.base, -allowed))},
            allowed, result);
  return result;
}

// ---- what is true or not

Difference flag_difference(const Measure& measure, const PairedNumber& pairs, double tolerance,
                           const std::string& stream) {
  const std::vector<double> base = parts_of(pairs.base);
  const std::vector<double> now = parts_of(pairs.now);
  const std::vector<double> changes = changes_of(base, now);
  Difference result;
  result.base = mean_of(base);
  result.now = mean_of(now);
  result.ci95 = bca_mean_interval(changes, kBootstrapSeed, stream);
  const int64_t only_now = std::count(changes.begin(), changes.end(), 1);
  const int64_t only_base = std::count(changes.begin(), changes.end(), -1);
  set_p(measure, mcnemar_p(only_base, only_now), tolerance, result);
  return result;
}

Difference difference_by_kind(const Measure& measure, const PairedNumber& pairs, double tolerance,
                              const std::string& stream) {
  switch (measure.statistic) {
    case Statistic::kMean:
      return mean_difference(measure, pairs, tolerance, stream);
    case Statistic::kMiddle:
      return middle_difference(measure, pairs, tolerance);
    case Statistic::kMedian:
    case Statistic::kP90:
      return quantile_difference(measure, pairs, tolerance, stream);
    case Statistic::kRms:
    case Statistic::kWhole:
      break;
  }
  return measure.number.kind == NumberKind::kFlag
             ? flag_difference(measure, pairs, tolerance, stream)
             : ratio_difference(measure, pairs, tolerance, stream);
}

}  // namespace

Difference paired_difference(const Measure& measure, const PairedNumber& pairs, double tolerance,
                             const std::string& stream) {
  Difference result = difference_by_kind(measure, pairs, tolerance, stream + measure.name);
  result.quantity = measure.name;
  result.trials = static_cast<int64_t>(pairs.base.size());
  return result;
}

}  // namespace sightline
