// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// outlier/<solver>/<points>: every solver of the catalogue, start-free, on points with noise of 1
// px and one outlier. outlier/<solver>/8/k=<outliers>: the same with 0 to 3 outliers, consensus and
// orpe_weighed.
// outlier/<solver>/<points>/<share>: with this percentage of outliers, every solver at few points
// and those that are made for it at many.
#include <string>
#include <string_view>
#include <utility>

#include <benchmark/benchmark.h>

#include "eval/benchmarks/benches.h"
#include "eval/benchmarks/pose_problems.h"

namespace sightline {
namespace {

void run(benchmark::State& state, const PoseSolver& solver, const ProblemLaw& law) {
  const std::vector<PoseCase> cases = draw_pose_cases(law);
  const SolverOptions options;
  std::size_t next = 0;
  int failures = 0;
  for (auto _ : state) {
    const PoseEstimate estimate = solver.solve(cases[next].problem, options);
    failures += estimate.status != PoseStatus::kOk;
    next = (next + 1) % cases.size();
  }
  state.counters["failed"] = benchmark::Counter(failures, benchmark::Counter::kAvgIterations);
}

void add(const PoseSolver& solver, const ProblemLaw& law, const std::string& name) {
  benchmark::RegisterBenchmark(
      name.c_str(), [&solver, law](benchmark::State& state) { run(state, solver, law); });
}

}  // namespace

PeerComparison register_outlier() {
  for (const PoseSolver& solver : pose_solvers()) {
    for (const int points : {5, 8, 12}) {
      add(solver, {.points = points, .outliers = 1},
          "outlier/" + std::string(solver.name) + "/" + std::to_string(points));
    }
  }
  for (const std::string solver : {"orpe_weighed", "consensus"}) {
    for (const int outliers : {0, 1, 2, 3}) {
      add(*find_pose_solver(solver), {.points = 8, .outliers = outliers},
          "outlier/" + solver + "/8/k=" + std::to_string(outliers));
    }
  }
  const auto add_share = [](const PoseSolver& solver, int points, int share) {
    add(solver, {.points = points, .outliers = points * share / 100},
        "outlier/" + std::string(solver.name) + "/" + std::to_string(points) + "/" +
            std::to_string(share));
  };
  for (const PoseSolver& solver : pose_solvers()) {
    for (const auto& [points, share] : {std::pair(8, 25), {12, 50}})
      add_share(solver, points, share);
    const bool is_for_many = solver.name == "consensus" || solver.name == "orpe_consensus" ||
                             solver.name.find("ransac") != std::string_view::npos;
    if (!is_for_many) continue;
    for (const auto& [points, share] : {std::pair(50, 50), {200, 90}, {1000, 50}}) {
      add_share(solver, points, share);
    }
    if (solver.name != "consensus") continue;  // the others take a quarter of a second
    for (const int share : {90, 95}) add_share(solver, 1000, share);
  }
  return {"outlier", "orpe_weighed", {"huber_tukey", "gnc", "ransac_p3p", "opencv_ransac"}};
}

}  // namespace sightline
