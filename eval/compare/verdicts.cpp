// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/verdicts.h"

#include <algorithm>
#include <cmath>

#include <boost/math/distributions/students_t.hpp>

#include "eval/statistics/bootstrap.h"
#include "eval/statistics/significance.h"
#include "eval/statistics/statistics.h"

namespace sightline {
namespace {

// Changes of a mean by less are rounding, whatever their interval.
constexpr double kRounding = 1e-9;

// A number of a summary; NaN for null.
double number_in(const Json& json) {
  return json.is_number() ? json.get<double>() : kNoNumber;
}

// p-values of one side each: now above base, and below.
struct Sides {
  double worse = 1;
  double better = 1;
};

// The verdict stands if the p-value, adjusted, is small enough.
void set_sides(Difference& difference, const Sides& sides, double allowed) {
  difference.p = std::min(1.0, 2 * std::min(sides.worse, sides.better));
  if (difference.ci95[0] > allowed) difference.verdict = Verdict::kWorse;
  if (difference.ci95[1] < -allowed) difference.verdict = Verdict::kBetter;
}

void set_p(Difference& difference, double two_sided, double tolerance) {
  const double change = difference.now - difference.base;
  if (std::abs(change) <= tolerance) return;
  difference.p = two_sided;
  difference.verdict = change > 0 ? Verdict::kWorse : Verdict::kBetter;
}

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

Difference paired_error(const PairedCell& cell, size_t quantity, double tolerance,
                        const std::string& stream) {
  const std::vector<double>& differences = cell.differences[quantity];
  Difference result;
  result.quantity = kComparedErrors[quantity].name;
  result.trials = static_cast<int64_t>(differences.size());
  result.base = mean_of(cell.base[quantity]);
  result.now = result.base + mean_of(differences);
  result.ci95 = bca_mean_interval(differences, 1, stream);
  const double allowed = std::max(tolerance, kRounding) * result.base;
  set_sides(result,
            {p_mean_above_zero(affine(differences, 1, -allowed)),
             p_mean_above_zero(affine(differences, -1, -allowed))},
            allowed);
  return result;
}

Difference paired_failures(const PairedCell& cell, double tolerance, const std::string& stream) {
  Difference result;
  result.quantity = "failures";
  result.trials = static_cast<int64_t>(cell.failures.size());
  const double n = static_cast<double>(result.trials);
  result.base = static_cast<double>(cell.base_failures) / n;
  result.now = static_cast<double>(cell.now_failures) / n;
  result.ci95 = bca_mean_interval(cell.failures, 1, stream);
  const int64_t only_now = std::count(cell.failures.begin(), cell.failures.end(), 1);
  const int64_t only_base = std::count(cell.failures.begin(), cell.failures.end(), -1);
  set_p(result, mcnemar_p(only_base, only_now), tolerance);
  return result;
}

Difference stored_error(const Json& base, const Json& now, const char* name, double tolerance) {
  Difference result;
  result.quantity = name;
  result.trials = now.at("trials").get<int64_t>();
  result.base = number_in(base.at(name).at("mean"));
  result.now = number_in(now.at(name).at("mean"));
  const auto interval = [name](const Json& cell) {
    const Json& ends = cell.at(name).at("mean_ci95");
    return Interval95{number_in(ends.at(0)), number_in(ends.at(1))};
  };
  result.ci95 = difference_interval(result.base, interval(base), result.now, interval(now));
  const int64_t fewer = std::min(base.at("trials").get<int64_t>(), result.trials);
  const double change = result.now - result.base;
  const double allowed = std::max(tolerance, kRounding) * result.base;
  if (fewer < 2 || !std::isfinite(result.ci95[0]) || !std::isfinite(result.ci95[1])) return result;
  const boost::math::students_t t(static_cast<double>(fewer - 1));
  // The interval's half-width on the side of zero stands for its standard error.
  const auto p_beyond = [&](double excess, double half_width) {
    if (half_width <= 0) return excess > 0 ? 0.0 : 1.0;
    return boost::math::cdf(t, -excess / (half_width / normal_quantile(0.975)));
  };
  set_sides(result,
            {p_beyond(change - allowed, change - result.ci95[0]),
             p_beyond(-change - allowed, result.ci95[1] - change)},
            allowed);
  return result;
}

Difference stored_failures(const Json& base, const Json& now, double tolerance) {
  Difference result;
  result.quantity = "failures";
  const int64_t trials_base = base.at("trials").get<int64_t>();
  const int64_t trials_now = now.at("trials").get<int64_t>();
  const int64_t failures_base = base.at("failures").get<int64_t>();
  const int64_t failures_now = now.at("failures").get<int64_t>();
  result.trials = trials_now;
  result.base = static_cast<double>(failures_base) / static_cast<double>(trials_base);
  result.now = static_cast<double>(failures_now) / static_cast<double>(trials_now);
  result.ci95 = difference_interval(result.base, wilson_interval(failures_base, trials_base),
                                    result.now, wilson_interval(failures_now, trials_now));
  set_p(result, fisher_p(failures_base, trials_base, failures_now, trials_now), tolerance);
  return result;
}

}  // namespace

std::vector<Difference> compare_cell(const Json& base, const Json& now, const PairedCell* pairs,
                                     double tolerance, const std::string& stream) {
  std::vector<Difference> differences;
  for (size_t i = 0; i < kComparedErrors.size(); ++i) {
    differences.push_back(pairs != nullptr
                              ? paired_error(*pairs, i, tolerance, stream + kComparedErrors[i].name)
                              : stored_error(base, now, kComparedErrors[i].name, tolerance));
  }
  differences.push_back(pairs != nullptr ? paired_failures(*pairs, tolerance, stream + "failures")
                                         : stored_failures(base, now, tolerance));
  return differences;
}

void judge(std::vector<CellDifference>& cells) {
  std::vector<double> p_values;
  for (const CellDifference& cell : cells) {
    for (const Difference& difference : cell.differences) p_values.push_back(difference.p);
  }
  const std::vector<double> adjusted = holm_adjusted(p_values);
  size_t next = 0;
  for (CellDifference& cell : cells) {
    for (Difference& difference : cell.differences) {
      difference.p = adjusted[next++];
      if (difference.p >= kVerdictLevel) difference.verdict = Verdict::kUnchanged;
      if (difference.verdict == Verdict::kWorse) cell.verdict = Verdict::kWorse;
      if (difference.verdict == Verdict::kBetter && cell.verdict == Verdict::kUnchanged) {
        cell.verdict = Verdict::kBetter;
      }
    }
  }
}

}  // namespace sightline
