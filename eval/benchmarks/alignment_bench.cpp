// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// align/<method>/<pairs>/<share of wrong pairs in %>: absolute orientation with outliers, noise of
// 1 % of the cube's side, which is known, outliers uniform in the cube. `wrong` is the share of
// solves without a pose, or whose rotation is off by more than five degrees.
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "eval/benchmarks/benches.h"
#include "pose/angles.h"
#include "pose/robust_alignment.h"

namespace sightline {
namespace {

constexpr double kSigma = 0.01;

struct Size {
  int pairs;
  int wrong_percent;
};

// The comparator takes a second at 95 % of 1000.
constexpr Size kAlignmentSizes[] = {{8, 0},     {20, 50},   {20, 80},   {100, 50},  {100, 90},
                                    {1000, 50}, {1000, 80}, {1000, 95}, {10000, 50}};
constexpr Size kOursAlone[] = {{100, 95}, {1000, 98}, {1000, 99}, {10000, 95}};

struct AlignmentCase {
  std::vector<Eigen::Vector3d> in_a, in_b;
  Eigen::Matrix3d rotation;
};

std::vector<AlignmentCase> draw_alignment_cases(const Size& size) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  std::normal_distribution<double> normal;
  const auto in_cube = [&] {
    Eigen::Vector3d x;
    for (double& coordinate : x) coordinate = uniform(engine);
    return x;
  };
  std::vector<AlignmentCase> cases(16);
  for (AlignmentCase& one : cases) {
    Eigen::Vector4d q;
    for (double& x : q) x = normal(engine);
    one.rotation = rotation_from_quaternion_wxyz(q);
    for (int i = 0; i < size.pairs; ++i) {
      one.in_a.push_back(in_cube());
      const bool is_wrong = 100 * i < size.wrong_percent * size.pairs;
      Eigen::Vector3d noise;
      for (double& x : noise) x = normal(engine);
      one.in_b.push_back(
          is_wrong ? in_cube() : Eigen::Vector3d(one.rotation * one.in_a.back() + kSigma * noise));
    }
  }
  return cases;
}

void run_alignment(benchmark::State& state, const RobustAlignmentMethod& method, const Size& size) {
  const std::vector<AlignmentCase> cases = draw_alignment_cases(size);
  std::size_t next = 0;
  int wrong = 0;
  for (auto _ : state) {
    const AlignmentCase& one = cases[next];
    const RobustAlignment alignment = method.align({one.in_a, one.in_b}, {.sigma_m = kSigma});
    wrong += alignment.status != OrientationStatus::kOk ||
             geodesic_angle_rad(alignment.b_from_a.rotation, one.rotation) > 5 * kDegree;
    next = (next + 1) % cases.size();
  }
  state.counters["wrong"] = benchmark::Counter(wrong, benchmark::Counter::kAvgIterations);
}

void add_alignment(const RobustAlignmentMethod& method, const Size& size) {
  const std::string name = "align/" + std::string(method.name) + "/" + std::to_string(size.pairs) +
                           "/" + std::to_string(size.wrong_percent);
  benchmark::RegisterBenchmark(name.c_str(), [&method, size](benchmark::State& state) {
    run_alignment(state, method, size);
  });
}

}  // namespace

PeerComparison register_alignment() {
  for (const RobustAlignmentMethod& method : robust_alignment_methods()) {
    for (const Size& size : kAlignmentSizes) add_alignment(method, size);
    if (method.name == "ransac_umeyama") continue;
    for (const Size& size : kOursAlone) add_alignment(method, size);
  }
  return {"align", "consensus", {"orpe", "ransac_umeyama"}};
}

}  // namespace sightline
