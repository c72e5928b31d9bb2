// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// A study without images: every quantity against what is swept, a table each; and before them the
// answer in short, each solver's worst condition.
#include "eval/sweep.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <kainjow/mustache.hpp>

#include "eval/report/figures.h"
#include "eval/report/means.h"
#include "eval/report/text.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

constexpr const char* kTables = R"html(
<div class="sweeps">
{{#tables}}
<div class="scroll" role="region" aria-label="{{heading}}, table" tabindex="0">
<table class="sweep">
<caption><span>{{heading}}{{#has_intervals}}, and its 95&nbsp;% interval{{/has_intervals}}.</span>
</caption>
<thead><tr><th scope="col">{{axis}}</th>{{#solvers}}<th scope="col">{{.}}</th>{{/solvers}}
{{#has_bound}}<th scope="col" class="group">bound</th>{{/has_bound}}</tr></thead>
<tbody>
{{#rows}}
<tr><th scope="row">{{label}}</th>{{#cells}}<td>{{value}}{{#has_interval}} <span
class="interval">{{interval}}</span>{{/has_interval}}</td>{{/cells}}
{{#has_bound}}<td class="group">{{bound}}</td>{{/has_bound}}</tr>
{{/rows}}
</tbody>
</table>
</div>
{{/tables}}
</div>
)html";

constexpr const char* kDetails = R"html(
<details>
<summary>More of the same conditions</summary>
{{{tables}}}
</details>
)html";

constexpr const char* kAnswer = R"html(
{{#has_question}}<p class="question">{{question}}</p>{{/has_question}}
{{#has_claim}}<p class="lead">The paper: {{claim}}</p>{{/has_claim}}
{{#has_verdict}}<p class="lead">Here: {{verdict}}</p>{{/has_verdict}}
<div class="scroll" role="region" aria-label="Worst conditions, table" tabindex="0">
<table class="sweep">
<caption><span>Over {{trials}} in {{conditions}}: the worst condition of each, by its value over all
its trials.</span></caption>
<thead><tr><th scope="col">{{what}}</th>{{#headings}}<th scope="col">{{.}}</th>{{/headings}}
{{#has_peer}}<th scope="col" class="group">Euler-angle error, °: greatest difference from {{peer}}</th>
{{#is_timed}}<th scope="col">time over that of {{peer}}</th>{{/is_timed}}{{/has_peer}}</tr></thead>
<tbody>
{{#rows}}
<tr><th scope="row">{{solver}}{{#evaluation_only}} <span
class="note">(told the truth)</span>{{/evaluation_only}}</th>
{{#cells}}<td>{{value}} <span class="interval">{{where}}</span></td>{{/cells}}
{{#has_peer}}<td class="group">{{difference}}</td>{{#is_timed}}<td>{{times}}</td>{{/is_timed}}
{{/has_peer}}</tr>
{{/rows}}
</tbody>
</table>
</div>
<p class="note">Each error is capped at {{angle_cap}}° and {{t_cap}}&nbsp;%, and a trial without a
pose counts as the cap. <a href="#provenance">Definitions</a> stand at the end.</p>
)html";

int condition_count(const Study& study) {
  return static_cast<int>(study.conditions.size());
}

bool is_orientation(const Study& study) {
  return study.kind == StudyKind::kOrientation;
}

bool is_timed(const Study& study) {
  return study.pairs.timed_repeats > 0;
}

// Spellings are those of the pose solvers; methods of absolute orientation go by their names. As
// words, so that the heads of columns can break.
std::string label_of(const Study& study, const std::string& solver) {
  return words(is_orientation(study) ? solver : solver_label(solver));
}

mustache::data labels_of_solvers(const Study& study) {
  mustache::data list(mustache::data::type::list);
  for (const std::string& solver : study.solver_names()) list << label_of(study, solver);
  return list;
}

mustache::data row(const ReportInput& input, const SweepQuantity& quantity, int condition) {
  const int decimals = sweep_decimals(input.summary, quantity);
  mustache::data cells(mustache::data::type::list);
  for (const std::string& solver : input.study.solver_names()) {
    const CellSummary cell = sweep_cell(input.summary, condition, solver);
    const bool has_interval = quantity.interval != nullptr;
    cells << mustache::object{
        {"value", fixed(quantity.value(cell), decimals)},
        {"has_interval", has_interval},
        {"interval", has_interval ? interval(quantity.interval(cell), decimals) : ""}};
  }
  const CellObservations* found = find_observations(input.summary, condition);
  const bool has_bound = quantity.bound != nullptr && found != nullptr;
  return mustache::object{{"label", input.study.conditions[condition].label},
                          {"cells", cells},
                          {"bound", has_bound ? fixed(found->*quantity.bound, decimals) : ""}};
}

mustache::object table(const ReportInput& input, const SweepQuantity& quantity) {
  mustache::data rows(mustache::data::type::list);
  for (int c = 0; c < condition_count(input.study); ++c) rows << row(input, quantity, c);
  return {{"heading", quantity.heading},
          {"axis", "Condition"},
          {"solvers", labels_of_solvers(input.study)},
          {"has_intervals", quantity.interval != nullptr},
          {"has_bound", quantity.bound != nullptr},
          {"rows", rows}};
}

std::string tables(const ReportInput& input, bool are_details) {
  mustache::data list(mustache::data::type::list);
  for (const SweepQuantity& quantity : sweep_quantities(input.study, input.summary)) {
    if (quantity.is_detail == are_details) list << mustache::data(table(input, quantity));
  }
  return mustache::mustache(kTables).render(mustache::object{{"tables", list}});
}

mustache::data worst(const ReportInput& input, const SweepQuantity& quantity,
                     const std::string& solver) {
  double value = ErrorSummary::kNone;
  std::string where;
  for (int condition = 0; condition < condition_count(input.study); ++condition) {
    const double here = quantity.value(sweep_cell(input.summary, condition, solver));
    const bool is_worse = quantity.is_better_high ? here < value : here > value;
    if (!is_worse && !(std::isnan(value) && !std::isnan(here))) continue;
    value = here;
    where = input.study.conditions[condition].label;
  }
  return mustache::object{{"value", fixed(value, sweep_decimals(input.summary, quantity))},
                          {"where", where.empty() ? "" : "at " + where}};
}

// A method beside the first of the study.
struct Comparison {
  double greatest_difference_deg = 0;
  double least_time_ratio = ErrorSummary::kNone;
  double greatest_time_ratio = ErrorSummary::kNone;
};

Comparison compare(const ReportInput& input, const std::string& method, const std::string& peer) {
  Comparison comparison;
  for (int condition = 0; condition < condition_count(input.study); ++condition) {
    const CellSummary a = sweep_cell(input.summary, condition, method);
    const CellSummary b = sweep_cell(input.summary, condition, peer);
    if (a.trials == 0) continue;
    comparison.greatest_difference_deg =
        std::max(comparison.greatest_difference_deg,
                 std::abs(a.angle_error_deg.mean - b.angle_error_deg.mean));
    const double time_ratio = a.time_ns.mean / b.time_ns.mean;
    comparison.least_time_ratio = std::fmin(comparison.least_time_ratio, time_ratio);
    comparison.greatest_time_ratio = std::fmax(comparison.greatest_time_ratio, time_ratio);
  }
  return comparison;
}

mustache::object answer_row(const ReportInput& input, const std::string& solver) {
  mustache::data cells(mustache::data::type::list);
  for (const SweepQuantity& quantity : sweep_quantities(input.study, input.summary)) {
    if (!quantity.is_detail) cells << worst(input, quantity, solver);
  }
  const PoseSolver* const pose_solver = find_pose_solver(solver);
  mustache::object row = {
      {"solver", label_of(input.study, solver)},
      {"cells", cells},
      {"evaluation_only",
       !is_orientation(input.study) && pose_solver != nullptr && pose_solver->evaluation_only}};
  const Comparison comparison = compare(input, solver, input.study.solver_names().front());
  row["difference"] = fmt::format("{:.1e}", comparison.greatest_difference_deg);
  row["times"] = fmt::format("{} to {}", fixed(comparison.least_time_ratio, 2),
                             fixed(comparison.greatest_time_ratio, 2));
  return row;
}

}  // namespace

std::string sweep_answer(const ReportInput& input) {
  const Study& study = input.study;
  mustache::data headings(mustache::data::type::list);
  for (const SweepQuantity& quantity : sweep_quantities(study, input.summary)) {
    if (!quantity.is_detail) headings << quantity.heading;
  }
  const std::vector<std::string> solvers = study.solver_names();
  const std::vector<std::string> verdicts = claim_verdicts(study, input.summary);
  mustache::data rows(mustache::data::type::list);
  for (const std::string& solver : solvers) rows << mustache::data(answer_row(input, solver));
  return mustache::mustache(kAnswer).render(mustache::object{
      {"has_question", !study.question.empty()},
      {"question", study.question},
      {"has_claim", !study.claim.empty()},
      {"claim", study.claim},
      {"has_verdict", !verdicts.empty()},
      {"verdict", fmt::to_string(fmt::join(verdicts, " "))},
      {"trials", counted(trials_of(input.summary), "trial")},
      {"conditions", counted(condition_count(study), "condition")},
      {"what", is_orientation(study) ? "Method" : "Solver"},
      {"headings", headings},
      {"has_peer", is_orientation(study) && solvers.size() > 1},
      {"peer", solvers.empty() ? "" : label_of(study, solvers.front())},
      {"is_timed", is_timed(study)},
      {"rows", rows},
      {"angle_cap", fmt::to_string(kAngleCapDeg)},
      {"t_cap", fmt::to_string(kTranslationCapPercent)},
  });
}

std::string sweep_figure(const ReportInput& input) {
  if (input.study.kind == StudyKind::kImages) return "";
  return tables(input, false) +
         mustache::mustache(kDetails).render(mustache::object{{"tables", tables(input, true)}});
}

}  // namespace sightline
