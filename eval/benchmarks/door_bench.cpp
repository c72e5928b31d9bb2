// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// door/process/<client>/<points>: one question to a process and its answer, through the reference
// clients of docs/external.md, which answer with the initial pose: what the door costs a trial.
#include <filesystem>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <unistd.h>

#include "eval/benchmarks/benches.h"
#include "eval/benchmarks/pose_problems.h"
#include "eval/doors/external_solver.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// As a study of images asks: with covariances and a pose to start from.
PoseProblem problem_of(const PoseCase& drawn) {
  PoseProblem problem = drawn.problem;
  problem.initial_cam_from_target = Pose{};
  problem.covariances_px2.assign(problem.pixels.size(), 0.09 * Eigen::Matrix2d::Identity());
  return problem;
}

void ask(benchmark::State& state, const std::string& command, int points) {
  ProcessSource source;
  source.name = "door";
  source.command = command;
  const TrialSolver solver = external_solver(source);
  const fs::path logs = fs::temp_directory_path() / ("sightline-door-" + std::to_string(getpid()));
  fs::create_directories(logs);
  solver.process->begin({logs, logs, 0});
  const PoseProblem problem = problem_of(draw_pose_cases({.points = points}).front());
  std::vector<std::string> features;
  for (int i = 0; i < points; ++i) features.push_back("feature_" + std::to_string(i));
  const SolverOptions options;
  int64_t trial = 0;
  int failures = 0;
  const auto ask_once = [&] {
    const SolverAnswer answer = solver.solve({problem, options, features, {.trial = trial++}});
    failures += answer.outcome != EstimateOutcome::kOk;
  };
  ask_once();  // which starts it
  for (auto _ : state) ask_once();
  solver.process->end();
  fs::remove_all(logs);
  state.counters["failed"] = failures;
}

void add(const std::string& client, const std::string& command) {
  for (const int points : {5, 20}) {
    const std::string name = "door/process/" + client + "/" + std::to_string(points);
    benchmark::RegisterBenchmark(name.c_str(), [command, points](benchmark::State& state) {
      ask(state, command, points);
    })->UseRealTime();  // the process works while this one waits
  }
}

}  // namespace

void register_door() {
  add("cxx", SIGHTLINE_CLIENT);
  add("python", std::string("python3 '") + SIGHTLINE_SOURCE_DIR + "/docs/clients/client.py'");
}

}  // namespace sightline
