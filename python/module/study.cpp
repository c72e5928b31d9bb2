// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Studies: read, run, compared.
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <pybind11/stl.h>

#include "eval/compare/compare.h"
#include "eval/compare/compare_text.h"
#include "eval/compare/junit.h"
#include "eval/run/run.h"
#include "eval/study/study_file.h"
#include "eval/work/shard.h"
#include "python/module/bindings.h"
#include "python/module/guests.h"
#include "python/module/long_call.h"
#include "python/module/study_handle.h"

namespace sightline {
namespace {

namespace py = pybind11;

std::shared_ptr<StudyHandle> read_with_guests(
    const std::string& name, const std::vector<std::string>& settings, std::optional<int> trials,
    std::optional<int64_t> seed, const NamedCallables& solvers, const NamedCallables& extractors) {
  StudyOverrides overrides;
  overrides.set = settings;
  overrides.trials = trials;
  overrides.seed = seed;
  overrides.guests = guests_from(solvers, extractors);
  const LongCall call;
  return std::make_shared<StudyHandle>(read_study(name, overrides));
}

py::tuple run_handle(const StudyHandle& handle, const std::string& out, int jobs,
                     const std::string& shard, bool is_resumed, bool show_progress,
                     const std::string& command) {
  RunOptions options;
  options.out = out;
  options.jobs = jobs;
  options.is_resumed = is_resumed;
  options.show_progress = show_progress;
  options.command = command;
  RunResult result;
  {
    const LongCall call;
    options.shard = chosen_shard(shard, /*is_told=*/false);
    result = run_study(handle.study, options);
  }
  return py::make_tuple(result.trials, result.resumed_trials, result.failed_trials,
                        result.figures_note);
}

py::list comparison_rows(const Comparison& comparison) {
  py::list rows;
  for (const CellDifference& cell : comparison.cells) {
    for (const Difference& d : cell.differences) {
      rows.append(py::make_tuple(cell.condition, cell.solver, to_string(cell.verdict), d.quantity,
                                 d.trials, d.base, d.now, d.ci95[0], d.ci95[1], d.p,
                                 to_string(d.verdict)));
    }
    if (cell.differences.empty()) {
      rows.append(py::make_tuple(cell.condition, cell.solver, to_string(cell.verdict)));
    }
  }
  return rows;
}

py::dict compare_folders(const std::string& base, const std::string& now, double tolerance,
                         const std::vector<std::string>& measures) {
  Comparison comparison;
  {
    const LongCall call;
    comparison = compare_runs(base, now, tolerance, measures);
  }
  py::dict out;
  out["study"] = comparison.study;
  out["how"] = comparison.how;
  out["rows"] = comparison_rows(comparison);
  out["is_worse"] = comparison.has_regression();
  out["text"] = to_text(comparison);
  out["markdown"] = to_markdown(comparison);
  out["junit"] = to_junit(comparison);
  return out;
}

std::string rewrite_report_of(const std::string& folder) {
  const LongCall call;
  return rewrite_report(folder).figures_note;
}

py::list conditions_of(const StudyHandle& handle) {
  py::list labels;
  for (const Condition& condition : handle.study.conditions) labels.append(condition.label);
  return labels;
}

const char* kind_of(const StudyHandle& handle) {
  if (handle.study.images() != nullptr) return "images";
  return handle.study.numeric() != nullptr ? "numeric" : "orientation";
}

}  // namespace

void bind_study(py::module_& module) {
  py::class_<StudyHandle, std::shared_ptr<StudyHandle>>(module, "Study")
      .def_property_readonly("name", [](const StudyHandle& h) { return h.study.name; })
      .def_property_readonly("title", [](const StudyHandle& h) { return h.study.title; })
      .def_property_readonly("question", [](const StudyHandle& h) { return h.study.question; })
      .def_property_readonly("seed", [](const StudyHandle& h) { return h.study.seed; })
      .def_property_readonly("toml", [](const StudyHandle& h) { return h.study.toml; })
      .def_property_readonly("trial_count",
                             [](const StudyHandle& h) { return h.study.trial_count(); })
      .def_property_readonly("solvers", [](const StudyHandle& h) { return h.study.solver_names(); })
      .def_property_readonly("conditions", &conditions_of)
      .def_property_readonly("kind", &kind_of);
  module.def("read_study", &read_with_guests);
  module.def("run", &run_handle);
  module.def("compare", &compare_folders);
  module.def("rewrite_report", &rewrite_report_of);
}

}  // namespace sightline
