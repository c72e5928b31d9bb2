// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// lines/<solver>/<points>/<lines>: the pose of a cube's corners and edges with noise of 1 px, of
// points and of edge pixels, begun 0.6 degrees and 1 % off. Ceres minimises the same squares with
// derivatives of its own making: `off_sd`, the root-mean-square distance from its minimum as a part
// of the Cramér-Rao bound's standard deviation of the attitude, says that both find one pose.
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <ceres/ceres.h>
#include <fmt/format.h>

#include "eval/benchmarks/benches.h"
#include "eval/benchmarks/ceres_residuals.h"
#include "eval/benchmarks/pose_problems.h"
#include "pose/bounds.h"
#include "pose/edge_points.h"
#include "scenes/random/random.h"

namespace sightline {
namespace {

/// The image of the straight edge between two of the problem's points, under noise of edge pixels.
LineObservation seen_edge(const PoseCase& c, int from, int to, RandomStream& stream) {
  const PoseProblem& problem = c.problem;
  const Eigen::Vector3d& a = problem.points_in_target[static_cast<size_t>(from)];
  const Eigen::Vector3d& b = problem.points_in_target[static_cast<size_t>(to)];
  const Eigen::Vector2d begin = project(problem.camera, c.true_cam_from_target * a).value();
  const Eigen::Vector2d end = project(problem.camera, c.true_cam_from_target * b).value();
  LineObservation line = line_through(begin, end, 1);
  line.begin_in_target = a;
  line.end_in_target = b;
  line.covariance = covariance_of_edge_pixels((end - begin).norm(), 1, 1);
  const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
  line.pixel += std::sqrt(line.covariance(0, 0)) * stream.normal() * normal;
  line.direction += std::sqrt(line.covariance(1, 1)) * stream.normal() * normal;
  return line;
}

std::vector<PoseCase> draw_cases(int points, int lines) {
  std::vector<PoseCase> cases = draw_pose_cases({.points = 8});
  RandomStream stream(1, "lines", 0);
  for (PoseCase& c : cases) {
    for (int i = 0; i < lines; ++i) {
      c.problem.lines.push_back(seen_edge(c, i % 8, (i + 1 + i / 8) % 8, stream));
    }
    c.problem.points_in_target.resize(static_cast<size_t>(points));
    c.problem.pixels.resize(static_cast<size_t>(points));
    c.problem.sigma_px = 1;
    Vector6d error;
    for (double& number : error) number = 0.01 * stream.normal();
    error.tail<3>() *= c.true_cam_from_target.translation.norm();
    c.problem.initial_cam_from_target = retract(c.true_cam_from_target, error);
  }
  return cases;
}

/// Where the image of the edge's two ends puts the line between them, at the pixel.
struct CeresEdge {
  EdgePoint edge;

  template <typename T>
  bool operator()(const T* pose, T* residual) const {
    T image[2][2];
    for (const int end : {0, 1}) {
      const Eigen::Vector3d& given = end == 0 ? edge.begin_in_target : edge.end_in_target;
      T x[3];
      move_by_ceres(pose, given, x);
      image[end][0] = x[0] / x[2];
      image[end][1] = x[1] / x[2];
    }
    const T across[2] = {image[0][1] - image[1][1], image[1][0] - image[0][0]};
    const T way =
        across[0] * (image[0][0] - edge.ray.x()) + across[1] * (image[0][1] - edge.ray.y());
    const T one = across[0] * edge.normal_per_px.x() + across[1] * edge.normal_per_px.y();
    residual[0] = way / one / std::sqrt(edge.variance_px2);
    return true;
  }
};

Pose solve_by_ceres(const PoseCase& c) {
  const Pose& start = *c.problem.initial_cam_from_target;
  double pose[6];
  Eigen::Map<Eigen::Vector3d> rotation(pose), translation(pose + 3);
  rotation = vector_from_rotation(start.rotation);
  translation = start.translation;
  ceres::Problem sum;
  for (size_t i = 0; i < c.problem.pixels.size(); ++i) {
    sum.AddResidualBlock(
        new ceres::AutoDiffCostFunction<CeresPoint, 2, 6>(
            new CeresPoint{c.problem.points_in_target[i], c.problem.pixels[i], &c.problem.camera}),
        nullptr, pose);
  }
  for (const LineObservation& line : c.problem.lines) {
    const EdgePoints points = edge_points_of(line, c.problem.camera).value();
    for (const EdgePoint& edge : points) {
      sum.AddResidualBlock(new ceres::AutoDiffCostFunction<CeresEdge, 1, 6>(new CeresEdge{edge}),
                           nullptr, pose);
    }
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.logging_type = ceres::SILENT;
  options.function_tolerance = 1e-12;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &sum, &summary);
  return {rotation_from_vector(rotation), translation};
}

using Method = std::function<Pose(const PoseCase&)>;

Method ours(const char* solver) {
  return [solver = find_pose_solver(solver)](const PoseCase& c) {
    SolverOptions options;
    options.is_judged = false;
    return solver->solve(c.problem, options).cam_from_target;
  };
}

double off_sd(const PoseCase& c, const Pose& estimate) {
  const std::vector<Eigen::Matrix2d> covariances(c.problem.pixels.size(),
                                                 Eigen::Matrix2d::Identity());
  const auto bound = cramer_rao_bound(c.problem.camera, c.problem.points_in_target,
                                      c.true_cam_from_target, covariances, c.problem.lines);
  return geodesic_angle_rad(estimate.rotation, solve_by_ceres(c).rotation) /
         bound.value().geodesic_rms_rad;
}

void add(const std::string& name, const Method& method, int points, int lines) {
  const std::string full = fmt::format("lines/{}/{}/{}", name, points, lines);
  benchmark::RegisterBenchmark(full.c_str(), [=](benchmark::State& state) {
    const std::vector<PoseCase> cases = draw_cases(points, lines);
    double squares = 0;
    for (const PoseCase& c : cases) squares += std::pow(off_sd(c, method(c)), 2);
    size_t next = 0;
    for (auto _ : state) {
      benchmark::DoNotOptimize(method(cases[next]));
      next = (next + 1) % cases.size();
    }
    state.counters["off_sd"] = std::sqrt(squares / static_cast<double>(cases.size()));
  });
}

}  // namespace

void register_lines() {
  for (const auto& [points, lines] : {std::pair(8, 0), {8, 8}, {0, 8}, {8, 20}}) {
    add("lspe", ours("lspe"), points, lines);
    add("consensus", ours("consensus"), points, lines);
    add("ceres", solve_by_ceres, points, lines);
  }
}

}  // namespace sightline
