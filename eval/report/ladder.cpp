// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The ladder from what an image says of a pose to what the solvers make of it, a row a step.
#include <fmt/format.h>
#include <kainjow/mustache.hpp>

#include "eval/output/numbers.h"
#include "eval/report/figures.h"
#include "eval/report/page_text.h"
#include "eval/report/panels.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

// A solver's name as readers know it; other rungs are words already.
std::string rung_label(const Study& study, const std::string& rung) {
  return study.find_solver(rung) == nullptr ? rung : label_in(study, rung);
}

std::string factor_interval(const Measured& factor) {
  return interval(factor.ci95, 2);
}

}  // namespace

std::string ladder_figure(const ReportInput& input) {
  if (input.summary.ladder.empty()) return "";
  mustache::data steps(mustache::data::type::list);
  for (const LadderStep& step : input.summary.ladder) {
    steps << mustache::object{{"from", rung_label(input.study, step.from)},
                              {"to", rung_label(input.study, step.to)},
                              {"trials", fmt::to_string(step.trials)},
                              {"geodesic", fixed(step.geodesic.value, 2)},
                              {"geodesic_ci95", factor_interval(step.geodesic)},
                              {"translation", fixed(step.translation.value, 2)},
                              {"translation_ci95", factor_interval(step.translation)}};
  }
  return mustache::mustache(page_text("ladder.mustache"))
      .render(mustache::object{{"steps", steps}});
}

}  // namespace sightline
