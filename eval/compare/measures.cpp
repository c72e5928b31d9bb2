// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <string_view>

#include <fmt/format.h>

#include "eval/compare/run_numbers.h"
#include "eval/score/target_numbers.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

struct NamedStatistic {
  const char* name;
  Statistic statistic;
  bool needs_cap;
};

constexpr std::array kStatistics = {NamedStatistic{"mean", Statistic::kMean, true},
                                    NamedStatistic{"middle", Statistic::kMiddle, false},
                                    NamedStatistic{"median", Statistic::kMedian, false},
                                    NamedStatistic{"p90", Statistic::kP90, false},
                                    NamedStatistic{"rms", Statistic::kRms, true}};

bool is_error(const TrialNumber& number) {
  return number.kind == NumberKind::kError || number.kind == NumberKind::kOpenError;
}

// What an error's name alone stands for.
bool is_usual(const Measure& measure) {
  return measure.statistic == Statistic::kWhole || measure.statistic == Statistic::kMean ||
         measure.statistic == Statistic::kMiddle;
}

std::vector<Measure> measures_of_number(const TrialNumber& number) {
  if (!is_error(number)) return {{number.name, number, Statistic::kWhole}};
  std::vector<Measure> measures;
  for (const NamedStatistic& named : kStatistics) {
    if (named.needs_cap && number.kind == NumberKind::kOpenError) continue;
    measures.push_back({fmt::format("{}.{}", number.name, named.name), number, named.statistic});
  }
  return measures;
}

void add_named(const std::string& name, Subject subject, std::vector<Measure>& found) {
  std::vector<std::string> known;
  bool is_known = false;
  for (const TrialNumber& number : trial_numbers(subject)) {
    known.push_back(number.name);
    for (const Measure& measure : measures_of_number(number)) {
      if (measure.name != number.name) known.push_back(measure.name);
      const bool is_named =
          is_called(name, measure.name) || (is_called(name, number.name) && is_usual(measure));
      const bool is_there = std::any_of(found.begin(), found.end(),
                                        [&](const Measure& m) { return m.name == measure.name; });
      is_known = is_known || is_named;
      if (is_named && !is_there) found.push_back(measure);
    }
  }
  if (is_known) return;
  const std::string close = closest_name(name, known);
  throw InputError(fmt::format("--measure {}: these have no such measure{}", name,
                               close.empty() ? "; `sightline list measures` has them all"
                                             : fmt::format(" (did you mean '{}'?)", close)));
}

NumberKind kind_of(const TargetNumber& number) {
  switch (number.kind) {
    case TargetNumberKind::kFlag:
      return NumberKind::kFlag;
    case TargetNumberKind::kShare:
      return NumberKind::kRate;
    case TargetNumberKind::kError:
      break;
  }
  return std::isfinite(number.cap) ? NumberKind::kError : NumberKind::kOpenError;
}

std::vector<TrialNumber> numbers_of_scores() {
  std::vector<TrialNumber> numbers;
  for (const TargetNumber& number : target_numbers()) {
    numbers.push_back({.name = number.name,
                       .meaning = number.meaning,
                       .kind = kind_of(number),
                       .cap = number.cap,
                       .is_more_better = number.kind != TargetNumberKind::kError});
  }
  numbers.push_back({.name = "failure_rate",
                     .meaning = "targets without an estimate",
                     .kind = NumberKind::kFlag});
  return numbers;
}

std::string section_of(std::string_view title, Subject subject) {
  std::string text = fmt::format("{}\n", title);
  for (const TrialNumber& number : trial_numbers(subject)) {
    const std::string statistics = number.kind == NumberKind::kError ? ".mean .middle .median "
                                                                       ".p90 .rms"
                                   : number.kind == NumberKind::kOpenError ? ".middle .median .p90"
                                                                           : "";
    text += fmt::format("  {:<22} {}{}{}\n", number.name, number.meaning,
                        number.is_more_better ? "; more is better" : "",
                        statistics.empty() ? "" : fmt::format(" [{}]", statistics));
  }
  return text;
}

}  // namespace

std::vector<TrialNumber> trial_numbers(Subject subject) {
  if (subject == Subject::kScores) return numbers_of_scores();
  std::vector<TrialNumber> numbers;
  for (const RunNumber& number : run_numbers()) {
    const bool is_of_poses = number.of_estimate || number.of_features;
    const bool is_of_subject =
        subject == Subject::kPoses ? is_of_poses : static_cast<bool>(number.of_orientation);
    if (is_of_subject) numbers.push_back(number);
  }
  return numbers;
}

std::vector<Measure> measures_of(Subject subject) {
  std::vector<Measure> measures;
  for (const TrialNumber& number : trial_numbers(subject)) {
    for (Measure& measure : measures_of_number(number)) measures.push_back(std::move(measure));
  }
  return measures;
}

std::vector<Measure> default_measures(Subject subject) {
  std::vector<std::string> names = {"geodesic_deg", "t_error_percent", "failure_rate"};
  // Without depth there is no AR, but there are two of its parts.
  if (subject == Subject::kScores)
    names.insert(names.begin(), {"ar", "ar_mssd", "ar_mspd", "add_recall"});
  std::vector<Measure> measures;
  for (const std::string& name : names) add_named(name, subject, measures);
  return measures;
}

std::vector<Measure> find_measures(std::span<const std::string> names, Subject subject) {
  if (names.empty()) return default_measures(subject);
  std::vector<Measure> measures;
  for (const std::string& list : names) {
    std::istringstream stream(list);
    for (std::string name; std::getline(stream, name, ',');) add_named(name, subject, measures);
  }
  if (measures.empty()) throw InputError("--measure: names no measure");
  return measures;
}

std::string measures_list() {
  return section_of("measures of runs", Subject::kPoses) + "\n" +
         section_of("measures of runs of orientation studies", Subject::kOrientations) + "\n" +
         section_of("measures of scores", Subject::kScores);
}

}  // namespace sightline
