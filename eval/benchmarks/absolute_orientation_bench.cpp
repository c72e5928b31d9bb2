// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// absolute_orientation/<method>/<n>: the setting of Li et al. 2012, section 3, points uniform in
// [-10, 10]^3, any rotation, translations in [-100, 100]^3, noise of 0.5 in each coordinate.
// Everyone gets the points in the layout that is native to him. Small problems are drawn by the
// hundred and taken in turn, so that no branch can be learnt by heart.

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/calib3d.hpp>
#include <opengv/math/arun.hpp>

#include "eval/benchmarks/benches.h"
#include "pose/absolute_orientation.h"

namespace sightline {
namespace {

constexpr int kSizes[] = {3, 10, 28, 100, 1000, 100000};
constexpr int kMostProblems = 256;
/// As many as fit the second-level cache, both clouds of each.
constexpr int kMostPoints = 8000;

/// One problem in everyone's layout.
struct Problem {
  std::vector<Eigen::Vector3d> in_a, in_b;
  Eigen::Matrix3Xd matrix_a, matrix_b;
  std::vector<cv::Point3d> cv_a, cv_b;
  opengv::points_t gv_a, gv_b;
};

using Problems = std::vector<Problem>;

class Draw {
 public:
  Eigen::Vector3d in_box(double half_width) { return half_width * vector(uniform_); }
  Eigen::Vector3d noise(double sigma) { return sigma * vector(normal_); }
  Eigen::Quaterniond rotation() {
    Eigen::Vector4d q;
    for (double& x : q) x = normal_(engine_);
    return Eigen::Quaterniond(q.normalized());
  }

 private:
  template <typename Distribution>
  Eigen::Vector3d vector(Distribution& distribution) {
    Eigen::Vector3d v;
    for (double& x : v) x = distribution(engine_);
    return v;
  }

  std::mt19937_64 engine_{1};
  std::uniform_real_distribution<double> uniform_{-1, 1};
  std::normal_distribution<double> normal_;
};

Problem draw_problem(int n, Draw& draw) {
  Problem problem;
  const Eigen::Quaterniond rotation = draw.rotation();
  const Eigen::Vector3d translation = draw.in_box(100);
  problem.matrix_a.resize(3, n);
  problem.matrix_b.resize(3, n);
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector3d a = draw.in_box(10);
    const Eigen::Vector3d b = rotation * a + translation + draw.noise(0.5);
    problem.in_a.push_back(a);
    problem.in_b.push_back(b);
    problem.matrix_a.col(i) = a;
    problem.matrix_b.col(i) = b;
    problem.cv_a.emplace_back(a.x(), a.y(), a.z());
    problem.cv_b.emplace_back(b.x(), b.y(), b.z());
    problem.gv_a.push_back(a);
    problem.gv_b.push_back(b);
  }
  return problem;
}

std::shared_ptr<const Problems> draw_problems(int n) {
  Draw draw;
  auto problems = std::make_shared<Problems>();
  const int count = std::clamp(kMostPoints / n, 1, kMostProblems);
  for (int i = 0; i < count; ++i) problems->push_back(draw_problem(n, draw));
  return problems;
}

/// Drawn when first asked for: a filtered run does not wait for what it does not use.
const Problems& problems_of(int n) {
  static std::map<int, std::shared_ptr<const Problems>> drawn;
  auto& problems = drawn[n];
  if (!problems) problems = draw_problems(n);
  return *problems;
}

template <typename Solve>
void register_solver(std::string_view name, int n, Solve solve) {
  const std::string full = "absolute_orientation/" + std::string(name) + "/" + std::to_string(n);
  benchmark::RegisterBenchmark(full.c_str(), [n, solve](benchmark::State& state) {
    const Problems& problems = problems_of(n);
    std::size_t i = 0;
    for (auto _ : state) {
      benchmark::DoNotOptimize(solve(problems[i]));
      if (++i == problems.size()) i = 0;
    }
  });
}

void register_ours(int n) {
  for (const OrientationMethod& method : orientation_methods()) {
    if (n == 3 && method.name == "direct_linear") continue;  // needs four points
    register_solver(method.name, n,
                    [&method](const Problem& p) { return method.estimate(p.in_a, p.in_b); });
  }
}

void register_peers(int n) {
  register_solver("umeyama_eigen", n, [](const Problem& p) -> Eigen::Matrix4d {
    return Eigen::umeyama(p.matrix_a, p.matrix_b, false);
  });
  register_solver("opencv_estimate_affine", n, [](const Problem& p) {
    return cv::estimateAffine3D(p.cv_a, p.cv_b, nullptr, true);
  });
  register_solver("opengv_arun", n,
                  [](const Problem& p) { return opengv::math::arun_complete(p.gv_b, p.gv_a); });
}

}  // namespace

PeerComparison register_absolute_orientation() {
  for (const int n : kSizes) {
    register_ours(n);
    register_peers(n);
  }
  return {
      "absolute_orientation", "fast", {"umeyama_eigen", "opencv_estimate_affine", "opengv_arun"}};
}

}  // namespace sightline
