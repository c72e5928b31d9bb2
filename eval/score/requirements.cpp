// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/score/requirements.h"

#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "eval/output/junit.h"
#include "eval/output/numbers.h"
#include "eval/score/measures.h"
#include "eval/score/target_numbers.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

std::string without_spaces(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c != ' ') result += c;
  }
  return result;
}

std::vector<std::string> known_figures() {
  std::vector<std::string> names;
  for (const auto& [name, value] : summary_numbers({})) names.push_back(name);
  return names;
}

double figure(const BopSummary& summary, const std::string& name) {
  for (const auto& [known, value] : summary_numbers(summary)) {
    if (known == name) return value;
  }
  return kNoNumber;
}

}  // namespace

std::vector<std::pair<std::string, double>> summary_numbers(const BopSummary& summary) {
  const auto targets = static_cast<double>(summary.targets);
  const auto estimated = static_cast<double>(summary.estimated);
  std::vector<std::pair<std::string, double>> numbers = {
      {"failure_rate", summary.targets > 0 ? 1 - estimated / targets : kNoNumber},
      {"ar", summary.ar.value},
      {"ar_mssd", summary.ar_mssd.value},
      {"ar_mspd", summary.ar_mspd.value},
      {"ar_vsd", summary.ar_vsd.value},
      {"add_s_recall", summary.add_s.value}};
  for (const SummaryMeasure& measure : summary_measures()) {
    if (const auto* recall = std::get_if<RecallMeasure>(&measure)) {
      numbers.emplace_back(recall->key, (summary.*recall->summary).value);
      continue;
    }
    const auto& error = std::get<ErrorMeasure>(measure);
    const ErrorSummary& errors = summary.*error.summary;
    numbers.emplace_back(fmt::format("{}.mean", error.key), errors.mean);
    numbers.emplace_back(fmt::format("{}.median", error.key), errors.median);
    numbers.emplace_back(fmt::format("{}.p90", error.key), errors.p90);
    numbers.emplace_back(fmt::format("{}.rms", error.key), errors.rms);
  }
  return numbers;
}

Requirement parse_requirement(const std::string& text) {
  const std::string bare = without_spaces(text);
  const size_t sign = bare.find_first_of("<>");
  const bool has_sign = sign != std::string::npos && bare.substr(sign + 1, 1) == "=";
  const std::string limit = has_sign ? bare.substr(sign + 2) : "";
  Requirement requirement{.text = text, .name = bare.substr(0, sign), .is_least = false};
  const auto number = parsed_number(limit);
  if (!has_sign || !number || !std::isfinite(*number)) {
    throw InputError(fmt::format(
        "--require '{}': must be a figure, >= or <=, and a number, such as 'add_recall>=0.9'",
        text));
  }
  requirement.limit = *number;
  requirement.is_least = bare[sign] == '>';
  const std::vector<std::string> known = known_figures();
  for (const std::string& name : known) {
    if (!is_called(requirement.name, name)) continue;
    requirement.name = name;
    return requirement;
  }
  throw InputError(fmt::format("--require '{}': there is no figure '{}'{}", text, requirement.name,
                               suggestion(requirement.name, known)));
}

std::vector<RequirementResult> check_requirements(std::span<const Requirement> requirements,
                                                  std::span<const MethodScores> methods) {
  std::vector<RequirementResult> results;
  if (requirements.empty()) return results;
  for (const MethodScores& method : methods) {
    const BopSummary summary = summarise(method.scored.scores);
    for (const Requirement& requirement : requirements) {
      const double value = figure(summary, requirement.name);
      if (std::isnan(value)) {
        throw InputError(fmt::format("--require '{}': the data set does not let {} be known",
                                     requirement.text, requirement.name));
      }
      const bool is_met =
          requirement.is_least ? value >= requirement.limit : value <= requirement.limit;
      results.push_back({method.name, requirement, value, is_met});
    }
  }
  return results;
}

std::string to_text(const RequirementResult& result) {
  const Requirement& requirement = result.requirement;
  return fmt::format("{}: {} is {:.4g}, {} {:g} or {}", result.method, requirement.name,
                     result.value, result.is_met ? "which is" : "must be", requirement.limit,
                     requirement.is_least ? "more" : "less");
}

std::string to_junit(std::span<const RequirementResult> results, const std::string& set) {
  JunitSuite suite{.name = "scores", .properties = {{"dataset", set}}, .cases = {}};
  for (const RequirementResult& result : results) {
    const std::string text = to_text(result);
    suite.cases.push_back({.class_name = "scores." + result.method,
                           .name = result.requirement.text,
                           .failure = result.is_met ? "" : text,
                           .note = result.is_met ? text : ""});
  }
  return to_xml(suite);
}

}  // namespace sightline
