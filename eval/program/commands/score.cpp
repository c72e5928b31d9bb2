// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/score/score.h"

#include <filesystem>
#include <iostream>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "eval/output/json.h"
#include "eval/output/output_folder.h"
#include "eval/output/plain_text.h"
#include "eval/output/terminal.h"
#include "eval/program/commands/commands.h"
#include "eval/report/gnuplot.h"
#include "eval/score/requirements.h"
#include "eval/score/score_report.h"
#include "eval/score/scored_set.h"
#include "eval/score/scores_files.h"
#include "eval/score/targets_file.h"
#include "eval/work/interrupt.h"
#include "eval/work/progress.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr int kRequirementExit = 3;

struct ScoreArguments {
  std::vector<std::string> results;
  std::string dataset;
  std::string split;
  std::string sensor;
  std::string out;
  double vsd_delta_mm = 15;
  std::vector<std::string> required;
  std::string junit;
  bool is_quiet = false;
  bool is_json = false;
};

// One method: its name, the file as it was given, and what it says.
struct Method {
  std::string name;
  std::string file;
  std::vector<BopEstimate> estimates;
  BopScores scores;
};

// NAME=FILE, or a file that is named by its own name.
Method named_method(const std::string& given) {
  const size_t sign = given.find('=');
  const bool is_named = sign != std::string::npos && !fs::exists(given);
  Method method;
  method.file = is_named ? given.substr(sign + 1) : given;
  method.name = is_named ? given.substr(0, sign) : unpacked_name(given).stem().string();
  const bool is_folder_name =
      !method.name.empty() && method.name[0] != '.' && method.name.find('/') == std::string::npos;
  if (is_folder_name) return method;
  throw InputError(fmt::format("'{}': the method's name must be one of a folder", given));
}

std::vector<Method> read_methods(const ScoreArguments& arguments) {
  std::vector<Method> methods;
  for (const std::string& given : arguments.results) {
    Method method = named_method(given);
    for (const Method& other : methods) {
      if (other.name != method.name) continue;
      throw InputError(fmt::format("{} and {} are both called {}; say NAME=FILE", other.file,
                                   method.file, method.name));
    }
    methods.push_back(std::move(method));
  }
  return methods;
}

void score_methods(const ScoreArguments& arguments, const BopDataset& dataset,
                   std::vector<Method>& methods) {
  Progress progress("score", static_cast<int64_t>(dataset.images.size() * methods.size()),
                    !arguments.is_quiet);
  for (Method& method : methods) {
    method.scores = score_bop(dataset, method.estimates, arguments.vsd_delta_mm, [&] {
      stop_if_interrupted();
      progress.advance(1);
    });
  }
}

// What one method's scores are told in; returns a note of the figures, if there is one.
std::string write_scores(const ScoredResults& scored, const fs::path& folder) {
  write_file(folder / "scores.json", scores_json(scored));
  write_file(folder / "errors.csv", [&](std::ostream& file) { write_errors_csv(scored, file); });
  write_file(folder / "report.html", score_report(scored));
  return write_figures(folder / "figures", score_charts(scored));
}

// Names of files and folders may hold anything.
void print_note(const std::string& note) {
  if (!note.empty()) std::cerr << "sightline: " << in_one_line(note) << "\n";
}

void print_notes(const BopDataset& dataset, const std::vector<Method>& methods) {
  for (const std::string& note : dataset.notes) print_note(note);
  for (const Method& method : methods) {
    const std::string failed = failed_rows(method.estimates);
    if (!failed.empty()) print_note(method.file + ": " + failed);
    const std::string units = note_on_units(dataset, method.estimates, method.scores);
    if (!units.empty()) print_note(method.file + ": " + units);
    if (method.scores.ignored_estimates == 0) continue;
    print_note(fmt::format("{}{} of nothing that is asked for, or more than are",
                           methods.size() > 1 ? method.name + ": " : "",
                           method.scores.ignored_estimates == 1
                               ? "1 estimate is"
                               : fmt::format("{} estimates are", method.scores.ignored_estimates)));
  }
  const BopScores& scores = methods.front().scores;
  const std::string vsd_note = note_on_vsd(scores);
  if (!scores.has_models) {
    std::cerr << "sightline: the data set has no model, so there are errors of poses alone\n";
  } else if (!vsd_note.empty()) {
    std::cerr << "sightline: " << vsd_note << "\n";
  }
}

// Writes the folder; a single method's files stand in it, those of several in a folder each.
std::string write_folder(const ScoreArguments& arguments, std::span<const MethodScores> methods) {
  OutputFolder out(arguments.out);
  std::string note;
  if (methods.size() == 1) {
    note = write_scores(methods.front().scored, out.staging());
  } else {
    for (const MethodScores& method : methods) {
      fs::create_directory(out / method.name);
      note = write_scores(method.scored, out / method.name);
    }
    write_file(out / "scores.json", scores_json(methods));
  }
  write_file(out / kTargetsFile, [&](std::ostream& file) { write_targets_csv(methods, file); });
  out.commit();
  return note;
}

// scores.json and, where something is required, whether it is so.
void print_json(std::span<const MethodScores> methods,
                std::span<const RequirementResult> requirements) {
  Json json =
      Json::parse(methods.size() == 1 ? scores_json(methods.front().scored) : scores_json(methods));
  for (const RequirementResult& result : requirements) {
    json["requirements"].push_back({{"method", result.method},
                                    {"requirement", result.requirement.text},
                                    {"value", result.value},
                                    {"is_met", result.is_met}});
  }
  std::cout << json_text(json);
}

void print_scores(const ScoreArguments& arguments, std::span<const MethodScores> methods) {
  std::cout << shown(score_table(methods)) << "\n";
  for (const MethodScores& method : methods) {
    const fs::path folder =
        methods.size() == 1 ? fs::path(arguments.out) : fs::path(arguments.out) / method.name;
    std::cout << fmt::format("report: {}\n", plain_line((folder / "report.html").string()));
  }
}

int run_score(const ScoreArguments& arguments) {
  remember_interrupts();
  std::vector<Requirement> requirements;
  for (const std::string& text : arguments.required) {
    requirements.push_back(parse_requirement(text));
  }
  if (requirements.empty() && !arguments.junit.empty()) {
    throw InputError("--junit: has nothing to tell without --require");
  }
  std::vector<Method> methods = read_methods(arguments);
  const ScoredSet set = read_scored_set(arguments.dataset, arguments.split, arguments.sensor);
  for (Method& method : methods) method.estimates = read_estimates(method.file, set);
  score_methods(arguments, set.dataset, methods);
  std::vector<MethodScores> scored;
  for (const Method& method : methods) {
    scored.push_back({method.name,
                      {method.file, arguments.dataset, arguments.vsd_delta_mm, set.dataset,
                       method.estimates, method.scores}});
  }
  const std::vector<RequirementResult> results = check_requirements(requirements, scored);
  const std::string figures_note = write_folder(arguments, scored);
  if (!arguments.junit.empty()) write_file(arguments.junit, to_junit(results, arguments.dataset));
  print_notes(set.dataset, methods);
  if (!figures_note.empty()) std::cerr << "sightline: " << figures_note << "\n";
  if (arguments.is_json) {
    print_json(scored, results);
  } else if (!arguments.is_quiet) {
    print_scores(arguments, scored);
  }
  int exit_code = 0;
  for (const RequirementResult& result : results) {
    if (!result.is_met) exit_code = kRequirementExit;
    if (arguments.is_json || (result.is_met && arguments.is_quiet)) continue;
    std::cout << shown(to_text(result)) << "\n";
  }
  return exit_code;
}

}  // namespace

void add_score(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ScoreArguments>();
  CLI::App* sub = app.add_subcommand("score",
                                     "Score anyone's estimates against a data set; exit 3 if they "
                                     "are not what is required");
  sub->add_option("results", arguments->results,
                  "The estimates of each method, FILE or NAME=FILE: a BOP results CSV "
                  "(scene_id,im_id,obj_id,score,R,t,time with t in mm) or, of SPEED+, its list or "
                  "filename,q0,q1,q2,q3,x,y,z")
      ->required();
  sub->add_option("--dataset", arguments->dataset,
                  "Folder of the data set, in BOP's format or SPEED+'s")
      ->required();
  sub->add_option(
         "--out", arguments->out,
         "Folder for report.html, figures/, scores.json, errors.csv and targets.csv, which "
         "`compare` takes")
      ->required();
  sub->add_option("--split", arguments->split,
                  "BOP: its folder of scenes [test, or the only test*]; SPEED+: its list without "
                  ".json");
  sub->add_option("--sensor", arguments->sensor,
                  "BOP: the camera of a scene that has several, by the name behind scene_gt_ [that "
                  "which BOP evaluates]");
  sub->add_option("--require", arguments->required,
                  "What a figure must be, such as 'add_recall>=0.9' or "
                  "'geodesic_deg.median<=0.5'; exit 3 where it is not")
      ->type_name("FIGURE>=NUMBER")
      ->allow_extra_args(false);
  sub->add_option("--junit", arguments->junit, "Also write JUnit XML, a test case a requirement");
  sub->add_option("--vsd-delta-mm", arguments->vsd_delta_mm,
                  "How much nearer than the model the depth may be where VSD calls it visible")
      ->check(CLI::Range(1e-6, 1e9))
      ->capture_default_str();
  sub->add_flag("--quiet", arguments->is_quiet, "No progress and no table");
  sub->add_flag("--json", arguments->is_json,
                "Print what scores.json holds, and whether what is required is so, instead of the "
                "tables");
  sub->callback([arguments, &exit_code] { exit_code = run_score(*arguments); });
}

}  // namespace sightline
