// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// `solve` and `align`: a pose or an alignment from a file of points, without any study.
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "eval/output/terminal.h"
#include "eval/program/commands/commands.h"
#include "eval/solve/answers.h"
#include "eval/solve/camera_file.h"
#include "eval/solve/number_rows.h"
#include "pose/entry/all_poses.h"
#include "pose/line_observation.h"
#include "pose/robust_alignment.h"
#include "pose/solver.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

constexpr int kNoAnswerExit = 1;

struct SolveArguments {
  std::string points;
  std::string lines;
  std::string camera;
  std::string solver = "consensus";
  double sigma_px = 0;
  bool wants_all = false;
  bool is_json = false;
};

// The lines of a file, each through two pixels, with the noise of its row or of --sigma.
std::vector<LineObservation> read_lines(const SolveArguments& arguments) {
  std::vector<LineObservation> lines;
  const auto rows = read_number_rows(arguments.lines, 10, 11, "X Y Z X Y Z u v u v [sigma]");
  if (rows.front().size() == 10 && arguments.sigma_px <= 0) {
    throw InputError(
        fmt::format("{}: lines need their noise: an eleventh number a row, or --sigma for all",
                    arguments.lines));
  }
  for (const std::vector<double>& row : rows) {
    const double sigma_px = row.size() == 11 ? row[10] : arguments.sigma_px;
    LineObservation line = line_through({row[6], row[7]}, {row[8], row[9]}, sigma_px);
    line.begin_in_target = {row[0], row[1], row[2]};
    line.end_in_target = {row[3], row[4], row[5]};
    if (!(sigma_px > 0) || !is_usable(line)) {
      throw InputError(fmt::format(
          "{}: row {} is no line: its two points and its two pixels must differ, its numbers be "
          "finite and its sigma above 0",
          arguments.lines, lines.size() + 1));
    }
    lines.push_back(line);
  }
  return lines;
}

PoseProblem read_problem(const SolveArguments& arguments) {
  PoseProblem problem;
  problem.camera = read_camera_file(arguments.camera);
  problem.sigma_px = arguments.sigma_px;
  if (!arguments.lines.empty()) problem.lines = read_lines(arguments);
  if (arguments.points.empty()) return problem;
  for (const auto& row : read_number_rows(arguments.points, 5, 6, "X Y Z u v [sigma]")) {
    problem.points_in_target.emplace_back(row[0], row[1], row[2]);
    problem.pixels.emplace_back(row[3], row[4]);
    if (row.size() < 6) continue;
    problem.covariances_px2.push_back(row[5] * row[5] * Eigen::Matrix2d::Identity());
  }
  if (arguments.sigma_px > 0 && !problem.covariances_px2.empty()) {
    throw InputError(
        fmt::format("--sigma: {} states the sigma of each point already", arguments.points));
  }
  return problem;
}

int run_solve(const SolveArguments& arguments) {
  const PoseSolver* const solver = find_pose_solver(arguments.solver);
  if (solver == nullptr || solver->evaluation_only) {
    std::vector<std::string> names;
    for (const PoseSolver& known : pose_solvers()) {
      if (!known.evaluation_only) names.emplace_back(known.name);
    }
    throw InputError(fmt::format("--solver {}: cannot be asked{}", arguments.solver,
                                 suggestion(arguments.solver, names)));
  }
  if (arguments.points.empty() && arguments.lines.empty()) {
    throw InputError("solve: give a file of points, --lines FILE, or both");
  }
  if (!arguments.lines.empty() && (solver->with_lines == nullptr || arguments.wants_all)) {
    throw InputError(fmt::format("--lines {}: {}", arguments.lines,
                                 arguments.wants_all
                                     ? "--all looks at points alone"
                                     : "only consensus and lspe use lines (--solver)"));
  }
  const PoseProblem problem = read_problem(arguments);
  const PoseEstimate estimate = solver->solve(problem);
  if (arguments.wants_all) {
    // Three points have poses, though no solver says which of them is meant.
    const bool is_ok = estimate.status == PoseStatus::kOk;
    const std::vector<int> removed = is_ok ? estimate.removed : std::vector<int>{};
    const PoseMinima minima = solve_all(problem, removed);
    std::cout << (arguments.is_json ? json_of(problem, minima, removed)
                                    : shown(text_of(problem, minima, removed)));
    return minima.status == PoseStatus::kOk ? 0 : kNoAnswerExit;
  }
  std::cout << (arguments.is_json ? json_of(problem, estimate) : shown(text_of(problem, estimate)));
  return estimate.status == PoseStatus::kOk ? 0 : kNoAnswerExit;
}

struct AlignArguments {
  std::string pairs;
  std::string method = "consensus";
  RobustAlignmentOptions options;
  bool is_json = false;
};

int run_align(const AlignArguments& arguments) {
  const RobustAlignmentMethod* const method = find_robust_alignment_method(arguments.method);
  if (method == nullptr) {
    std::vector<std::string> names;
    for (const RobustAlignmentMethod& known : robust_alignment_methods()) {
      names.emplace_back(known.name);
    }
    throw InputError(fmt::format("--method {}: is not known{}", arguments.method,
                                 suggestion(arguments.method, names)));
  }
  std::vector<Eigen::Vector3d> in_a;
  std::vector<Eigen::Vector3d> in_b;
  std::vector<double> weights;
  for (const auto& row :
       read_number_rows(arguments.pairs, 6, 7, "x y z in a, x y z in b [weight]")) {
    in_a.emplace_back(row[0], row[1], row[2]);
    in_b.emplace_back(row[3], row[4], row[5]);
    if (row.size() == 7) weights.push_back(row[6]);
  }
  const RobustAlignment alignment = method->align({in_a, in_b, weights}, arguments.options);
  std::cout << (arguments.is_json ? json_of(alignment) : shown(text_of(alignment)));
  return alignment.status == OrientationStatus::kOk ? 0 : kNoAnswerExit;
}

}  // namespace

void add_solve(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SolveArguments>();
  CLI::App* sub = app.add_subcommand("solve", "The pose from a file of points and their pixels");
  sub->add_option("points", arguments->points,
                  "File of X Y Z (metres, target) u v (pixels) [sigma (px)] a line; separated by "
                  "commas, tabs or spaces");
  sub->add_option(
      "--lines", arguments->lines,
      "File of straight edges seen as lines, beside points or in their place: X Y Z X Y "
      "Z (metres, two points of the edge) u v u v (two pixels of the line, anywhere "
      "along it) [sigma (px, across the line at either pixel)] a line");
  sub->add_option(
         "--camera", arguments->camera,
         "Calibration of OpenCV (.yaml, .json, .xml), Kalibr (.yaml) or COLMAP (cameras.txt), or a "
         ".toml with [camera]; FILE#NAME is one of several cameras")
      ->required();
  sub->add_option("--solver", arguments->solver, "See `sightline list solvers`")
      ->capture_default_str();
  sub->add_option("--sigma", arguments->sigma_px,
                  "Standard deviation of an inlier's noise in u and in v, px [it is found]")
      ->check(CLI::PositiveNumber);
  sub->add_flag(
      "--all", arguments->wants_all,
      "Every pose that explains the points which the solver keeps, the best first: both of "
      "a plane, and up to four of three points");
  sub->add_flag("--json", arguments->is_json, "For programs");
  sub->callback([arguments, &exit_code] { exit_code = run_solve(*arguments); });
}

void add_align(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<AlignArguments>();
  CLI::App* sub = app.add_subcommand(
      "align", "The rotation and translation between two clouds of matched points");
  sub->add_option("pairs", arguments->pairs,
                  "File of x y z in a, x y z in b [weight] a line; separated by commas, tabs or "
                  "spaces")
      ->required();
  sub->add_option("--method", arguments->method, "consensus, orpe or ransac_umeyama")
      ->capture_default_str();
  sub->add_option("--sigma", arguments->options.sigma_m,
                  "Standard deviation of each coordinate's noise in b [it is found]")
      ->check(CLI::PositiveNumber);
  sub->add_flag("--scale", arguments->options.estimates_scale, "The scale is to be found as well");
  sub->add_flag("--json", arguments->is_json, "For programs");
  sub->callback([arguments, &exit_code] { exit_code = run_align(*arguments); });
}

}  // namespace sightline
