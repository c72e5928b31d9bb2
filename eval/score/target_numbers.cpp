// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/score/target_numbers.h"

#include <string_view>

#include "eval/score/measures.h"

namespace sightline {
namespace {

using RecallPart = double (*)(const TargetRecalls& recalls);

TargetNumber average_recall(const char* name, const char* meaning, bool needs_vsd,
                            RecallPart part) {
  return {.name = name,
          .meaning = meaning,
          .kind = TargetNumberKind::kShare,
          .of = [needs_vsd, part](const BopScores& scores, const BopTarget& target) {
            const bool is_known = scores.has_models && (scores.has_vsd || !needs_vsd);
            return is_known ? part(recalls_of(target)) : kNoNumber;
          }};
}

TargetNumber recall(const RecallMeasure& measure) {
  return {.name = std::string(measure.key),
          .meaning = std::string(measure.text_label),
          .kind = TargetNumberKind::kFlag,
          .of = [measure](const BopScores& scores, const BopTarget& target) {
            const bool is_known = scores.has_models || !measure.needs_model;
            return is_known ? static_cast<double>(measure.is_good(target)) : kNoNumber;
          }};
}

// What the summary caps is capped; a flag among the numbers of pairs has its recall.
double cap_of(std::string_view column) {
  for (const SummaryMeasure& measure : summary_measures()) {
    const auto* error = std::get_if<ErrorMeasure>(&measure);
    if (error != nullptr && error->key == column) return error->cap;
  }
  return std::numeric_limits<double>::infinity();
}

TargetNumber error(const PairMeasure& measure) {
  return {.name = std::string(measure.column),
          .meaning = "error of the estimate; a missed target errs by more than any other",
          .kind = TargetNumberKind::kError,
          .cap = cap_of(measure.column),
          .of = [measure](const BopScores& scores, const BopTarget& target) {
            const auto number = measure.number;
            if (measure.needs_model && !scores.has_models) return kNoNumber;
            return target.chosen ? target.pairs[*target.chosen].*number
                                 : std::numeric_limits<double>::infinity();
          }};
}

std::vector<TargetNumber> all_target_numbers() {
  std::vector<TargetNumber> numbers = {
      average_recall("ar", "average recall of BOP: mean of the next three", true,
                     [](const TargetRecalls& r) { return r.mean(); }),
      average_recall("ar_mssd", "average recall by MSSD", false,
                     [](const TargetRecalls& r) { return r.mssd; }),
      average_recall("ar_mspd", "average recall by MSPD", false,
                     [](const TargetRecalls& r) { return r.mspd; }),
      average_recall("ar_vsd", "average recall by VSD", true,
                     [](const TargetRecalls& r) { return r.vsd; })};
  for (const SummaryMeasure& measure : summary_measures()) {
    if (const auto* flag = std::get_if<RecallMeasure>(&measure)) numbers.push_back(recall(*flag));
  }
  numbers.push_back({.name = "add_s_recall",
                     .meaning = "ADD(-S) < 0.1 d: ADI of objects with symmetries, else ADD",
                     .kind = TargetNumberKind::kFlag,
                     .of = [](const BopScores& scores, const BopTarget& target) {
                       return scores.has_models ? static_cast<double>(is_add_s_good(target))
                                                : kNoNumber;
                     }});
  for (const PairMeasure& measure : pair_measures()) {
    if (!measure.column.starts_with("is_")) numbers.push_back(error(measure));
  }
  return numbers;
}

}  // namespace

bool is_called(std::string_view given, std::string_view name) {
  std::string lower;
  for (const char c : given) lower += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (lower == "add(-s)") lower = "add_s";
  if (lower == "add-s") lower = "adi";
  return lower == name || lower + "_recall" == name;
}

const std::vector<TargetNumber>& target_numbers() {
  static const std::vector<TargetNumber> numbers = all_target_numbers();
  return numbers;
}

}  // namespace sightline
