// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/compare_text.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "eval/output/json.h"
#include "eval/output/numbers.h"
#include "eval/output/plain_text.h"
#include "eval/output/text_table.h"

namespace sightline {
namespace {

std::string short_number(double value) {
  return std::isfinite(value) ? fmt::format("{:.3g}", value) : "-";
}

std::string change_text(const Difference& d) {
  if (!(d.base > 0)) return short_number(d.now - d.base);
  return fmt::format("{:+.1f} %", 100 * (d.now - d.base) / d.base);
}

std::string change_interval(const Interval95& ends) {
  return bracketed(short_number(ends[0]), short_number(ends[1]));
}

std::string p_text(double p) {
  return p < 1e-4 ? "< 0.0001" : fmt::format("{:.4f}", p);
}

// How many cells have such a verdict in a measure of that ending.
int64_t cells_with(const Comparison& comparison, Verdict verdict, std::string_view ending) {
  return std::count_if(
      comparison.cells.begin(), comparison.cells.end(), [&](const CellDifference& cell) {
        return std::any_of(cell.differences.begin(), cell.differences.end(),
                           [&](const Difference& d) {
                             return d.verdict == verdict && d.quantity.ends_with(ending);
                           });
      });
}

// "3 worse (2 by a mean, 3 by a middle)": which of the two changed.
std::string verdict_count(const Comparison& comparison, Verdict verdict) {
  const std::string count = fmt::format("{} {}", comparison.count(verdict), to_string(verdict));
  const int64_t means = cells_with(comparison, verdict, ".mean");
  const int64_t middles = cells_with(comparison, verdict, ".middle");
  if (means + middles == 0) return count;
  return fmt::format("{} ({} by a mean, {} by a middle)", count, means, middles);
}

std::string counts_text(const Comparison& comparison) {
  std::string text = fmt::format(
      "{}: {}, {}, {} unchanged", counted(static_cast<int64_t>(comparison.cells.size()), "cell"),
      verdict_count(comparison, Verdict::kWorse), verdict_count(comparison, Verdict::kBetter),
      comparison.count(Verdict::kUnchanged));
  const int64_t missing = comparison.count(Verdict::kMissing);
  return missing > 0 ? fmt::format("{}, {} missing", text, missing) : text;
}

// "; greater in 957 of 1000 trials" of a middle.
std::string side_text(const Difference& d) {
  if (d.greater + d.less == 0) return "";
  const bool is_greater = d.greater >= d.less;
  return fmt::format(", {} in {} of {} trials", is_greater ? "greater" : "less",
                     is_greater ? d.greater : d.less, d.trials);
}

std::string rule_text(const Comparison& comparison) {
  return fmt::format(
      "Worse or better: the interval of the change lies beyond the tolerance of {:g} %, and p < {} "
      "adjusted by Holm over all numbers compared. A middle is that of the trials' changes "
      "(Wilcoxon's signed ranks), which a few outliers do not move as they move a mean.",
      100 * comparison.tolerance, kVerdictLevel);
}

}  // namespace

std::string changes_text(const CellDifference& cell) {
  if (cell.verdict == Verdict::kMissing) return "the new run lacks this cell";
  std::string text;
  for (const Difference& d : cell.differences) {
    if (d.verdict == Verdict::kUnchanged) continue;
    text +=
        fmt::format("{}{} is {}: {} to {} ({}), difference {}, p {}{}", text.empty() ? "" : "; ",
                    d.quantity, to_string(d.verdict), short_number(d.base), short_number(d.now),
                    change_text(d), change_interval(d.ci95), p_text(d.p), side_text(d));
  }
  return text;
}

std::string to_text(const Comparison& comparison) {
  constexpr size_t kMostRows = 30;
  constexpr size_t kLongestLabel = 40;
  std::vector<std::string> labels;
  TextColumn verdicts{"verdict", {}}, bases{"base", {}}, news{"new", {}}, changes{"change", {}},
      intervals{"95 % of new - base", {}}, p_values{"p", {}};
  size_t left_out = 0;
  for (const CellDifference& cell : comparison.cells) {
    const std::string name = fmt::format("{}, {}", cell.condition, cell.solver);
    std::vector<Difference> differences = cell.differences;
    if (cell.verdict == Verdict::kMissing) differences.emplace_back().verdict = cell.verdict;
    for (const Difference& d : differences) {
      if (d.verdict == Verdict::kUnchanged) continue;
      if (labels.size() == kMostRows) {
        ++left_out;
        continue;
      }
      // The cell's name may be long; which measure it is must be seen.
      labels.push_back(
          fmt::format("{} {}", shortened(name, kLongestLabel - d.quantity.size() - 1), d.quantity));
      verdicts.cells.emplace_back(to_string(d.verdict));
      bases.cells.push_back(short_number(d.base));
      news.cells.push_back(short_number(d.now));
      changes.cells.push_back(std::isfinite(d.base) ? change_text(d) : "-");
      intervals.cells.push_back(change_interval(d.ci95));
      p_values.cells.push_back(p_text(d.p));
    }
  }
  std::string text = wrapped(plain_line(fmt::format("{}, {}", comparison.study, comparison.how))) +
                     wrapped(plain_line(comparison.settings)) + wrapped(counts_text(comparison));
  if (labels.empty()) return text;
  text += text_block("What changed", labels,
                     {{"", {verdicts, bases, news, changes, intervals, p_values}}});
  if (left_out > 0) text += fmt::format("and {} more, which --markdown FILE lists\n", left_out);
  return text + "\n" + wrapped(rule_text(comparison));
}

std::string to_markdown(const Comparison& comparison) {
  std::string text = fmt::format("## {}: {}\n\n{}; {}; {}. {}\n\n", markdown_text(comparison.study),
                                 comparison.has_regression() ? "worse" : "no regression",
                                 counts_text(comparison), markdown_text(comparison.how),
                                 markdown_text(comparison.settings), rule_text(comparison));
  text +=
      "| condition | solver | number | verdict | base | new | change | 95 % of new - base | p |\n";
  text += "|---|---|---|---|--:|--:|--:|--:|--:|\n";
  for (const CellDifference& cell : comparison.cells) {
    if (cell.verdict == Verdict::kMissing) {
      text += fmt::format("| {} | {} | | **missing** | | | | | |\n", markdown_text(cell.condition),
                          markdown_text(cell.solver));
    }
    for (const Difference& d : cell.differences) {
      const std::string verdict(to_string(d.verdict));
      text += fmt::format(
          "| {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", markdown_text(cell.condition),
          markdown_text(cell.solver), markdown_text(d.quantity),
          d.verdict == Verdict::kUnchanged ? verdict : "**" + verdict + "**", short_number(d.base),
          short_number(d.now), change_text(d), change_interval(d.ci95), p_text(d.p));
    }
  }
  return text;
}

std::string to_json(const Comparison& comparison) {
  Json json = {{"study", comparison.study},
               {"how", comparison.how},
               {"settings", comparison.settings},
               {"tolerance", comparison.tolerance},
               {"has_regression", comparison.has_regression()},
               {"cells", Json::array()}};
  for (const CellDifference& cell : comparison.cells) {
    Json differences = Json::array();
    for (const Difference& d : cell.differences) {
      differences.push_back({{"measure", d.quantity},
                             {"trials", d.trials},
                             {"base", d.base},
                             {"new", d.now},
                             {"change_ci95", d.ci95},
                             {"p", d.p},
                             {"verdict", to_string(d.verdict)}});
    }
    json["cells"].push_back({{"condition", cell.condition},
                             {"solver", cell.solver},
                             {"verdict", to_string(cell.verdict)},
                             {"differences", std::move(differences)}});
  }
  return json_text(json);
}

}  // namespace sightline
