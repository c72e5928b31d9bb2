// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/tables/plan_table.h"

#include <cstdint>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "eval/output/text_table.h"
#include "eval/summary/cells.h"
#include "eval/tables/labels.h"

namespace sightline {

std::string plan_table(const Study& study, const Summary& summary, double target) {
  std::vector<TextGroup> groups;
  std::optional<int64_t> most;
  for (const std::string& solver : study.solver_names()) {
    TextColumn column{solver, {}};
    for (const CellSummary* cell : cells_of(summary, solver)) {
      const std::optional<int64_t> needed = trials_needed(*cell, target);
      column.cells.push_back(needed ? fmt::to_string(*needed) : "-");
      if (needed && (!most || *needed > *most)) most = needed;
    }
    groups.push_back({"", {column}});
  }
  const std::string heading = fmt::format(
      "Trials a condition for 95 % intervals of the mean theta_error and T_error of ± {:g} %",
      100 * target);
  std::string text = wrapped(fmt::format("{}: a pilot of {} trials a condition, seed {}",
                                         study.name, study.draws, study.seed)) +
                     text_block(heading, condition_labels(study), groups) + "\n";
  if (!most) return text + wrapped("The pilot says nothing: no mean of it is above zero.");
  return text + wrapped(fmt::format("The most: --trials {}", *most));
}

Json plan_json(const Study& study, const Summary& summary, double target) {
  Json json = {{"study", study.name},
               {"seed", study.seed},
               {"pilot_trials", study.draws},
               {"relative_half_width", target},
               {"cells", Json::array()}};
  Json most = nullptr;
  for (const std::string& solver : study.solver_names()) {
    const auto cells = cells_of(summary, solver);
    for (size_t i = 0; i < cells.size(); ++i) {
      const std::optional<int64_t> needed = trials_needed(*cells[i], target);
      const Json trials = needed ? Json(*needed) : Json(nullptr);
      json["cells"].push_back(
          {{"condition", study.conditions[i].label}, {"solver", solver}, {"trials", trials}});
      if (needed && (most.is_null() || *needed > most)) most = *needed;
    }
  }
  json["trials"] = most;
  return json;
}

}  // namespace sightline
