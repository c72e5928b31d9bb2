// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/stored.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <boost/math/distributions/students_t.hpp>

#include "eval/compare/verdicts.h"
#include "eval/statistics/significance.h"
#include "eval/statistics/statistics.h"

namespace sightline {
namespace {

// A number of a summary; NaN for null.
double number_in(const Json& json) {
  return json.is_number() ? json.get<double>() : kNoNumber;
}

Measured measured_in(const Json& value, const Json& ends) {
  return {number_in(value), {number_in(ends.at(0)), number_in(ends.at(1))}};
}

// What a summary says of a measure, and of how many trials.
struct StoredNumber {
  Measured number;
  int64_t trials = 0;
};

const char* key_of(Statistic statistic) {
  switch (statistic) {
    case Statistic::kMean:
      return "mean";
    case Statistic::kMiddle:
    case Statistic::kMedian:
      return "median";
    case Statistic::kP90:
      return "p90";
    case Statistic::kRms:
      return "rms";
    case Statistic::kWhole:
      break;
  }
  return "";
}

std::optional<StoredNumber> stored_number(const Measure& measure, const Json& cell) {
  const std::string& name = measure.number.name;
  if (!cell.contains(name)) return std::nullopt;
  const auto trials = cell.at("trials").get<int64_t>();
  if (measure.statistic == Statistic::kWhole) {
    const std::string ends = name + "_ci95";
    if (!cell.contains(ends)) return std::nullopt;
    return StoredNumber{measured_in(cell.at(name), cell.at(ends)), trials};
  }
  const std::string key = key_of(measure.statistic);
  const Json& error = cell.at(name);
  if (!error.contains(key)) return std::nullopt;
  return StoredNumber{measured_in(error.at(key), error.at(key + "_ci95")), trials};
}

// A number that a summary has without an interval, as an RMS, cannot be compared by it.
bool lacks_interval(const StoredNumber& number) {
  const auto [low, high] = number.number.ci95;
  return number.trials > 1 && std::isfinite(number.number.value) && std::isnan(low) &&
         std::isnan(high);
}

Difference by_intervals(const Measure& measure, const StoredNumber& base, const StoredNumber& now,
                        double tolerance) {
  Difference result;
  result.quantity = measure.name;
  result.trials = now.trials;
  result.base = base.number.value;
  result.now = now.number.value;
  result.ci95 = difference_interval(result.base, base.number.ci95, result.now, now.number.ci95);
  const int64_t fewer = std::min(base.trials, now.trials);
  const double change = result.now - result.base;
  const double allowed = allowed_change(measure, tolerance, result.base);
  if (fewer < 2 || !std::isfinite(result.ci95[0]) || !std::isfinite(result.ci95[1])) return result;
  const boost::math::students_t t(static_cast<double>(fewer - 1));
  // The interval's half-width on the side of zero stands for its standard error.
  const auto p_beyond = [&](double excess, double half_width) {
    if (half_width <= 0) return excess > 0 ? 0.0 : 1.0;
    return boost::math::cdf(t, -excess / (half_width / kZ95));
  };
  set_sides(measure,
            {p_beyond(change - allowed, change - result.ci95[0]),
             p_beyond(-change - allowed, result.ci95[1] - change)},
            allowed, result);
  return result;
}

Difference stored_failures(const Measure& measure, const Json& base, const Json& now,
                           double tolerance) {
  Difference result;
  result.quantity = measure.name;
  const int64_t trials_base = base.at("trials").get<int64_t>();
  const int64_t trials_now = now.at("trials").get<int64_t>();
  const int64_t failures_base = base.at("failures").get<int64_t>();
  const int64_t failures_now = now.at("failures").get<int64_t>();
  result.trials = trials_now;
  result.base = static_cast<double>(failures_base) / static_cast<double>(trials_base);
  result.now = static_cast<double>(failures_now) / static_cast<double>(trials_now);
  result.ci95 = difference_interval(result.base, wilson_interval(failures_base, trials_base),
                                    result.now, wilson_interval(failures_now, trials_now));
  set_p(measure, fisher_p(failures_base, trials_base, failures_now, trials_now), tolerance, result);
  return result;
}

// The observations of a cell stand under names of their own in `extraction`.
std::optional<StoredNumber> stored_features(const Measure& measure, const Json& cell) {
  const std::string& name = measure.number.name;
  const std::string key = name == "inlier_rms_px" ? "rms_px" : name;
  if (!cell.contains(key)) return std::nullopt;
  const Json& number = cell.at(key);
  return StoredNumber{measured_in(number.at("value"), number.at("ci95")),
                      cell.at("trials").get<int64_t>()};
}

}  // namespace

std::optional<Difference> stored_difference(const Measure& measure, const Json& base,
                                            const Json& now, double tolerance) {
  if (measure.number.name == "failure_rate") return stored_failures(measure, base, now, tolerance);
  const auto before = stored_number(measure, base);
  const auto after = stored_number(measure, now);
  if (!before || !after || lacks_interval(*before) || lacks_interval(*after)) return std::nullopt;
  return by_intervals(measure, *before, *after, tolerance);
}

std::optional<Difference> stored_feature_difference(const Measure& measure, const Json& base,
                                                    const Json& now, double tolerance) {
  const auto before = stored_features(measure, base);
  const auto after = stored_features(measure, now);
  if (!before || !after) return std::nullopt;
  return by_intervals(measure, *before, *after, tolerance);
}

}  // namespace sightline
