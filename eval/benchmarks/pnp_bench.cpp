// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// pnp/<method>/<points>: the least-squares pose of points with noise of 1 px, no outliers. Methods
// that refine begin 10 degrees and 5 % off; the others take no start. Besides its time every method
// states `off_sd`: its root-mean-square distance from the least-squares minimum, as a part of the
// Cramér-Rao bound's standard deviation of the attitude; peers stop where theirs is comparable.
//
// p3p/<method>: all poses of three points, the first three of each problem.
#include <cmath>
#include <functional>
#include <string>

#include <benchmark/benchmark.h>
#include <ceres/ceres.h>
#include <opencv2/calib3d.hpp>
#include <opengv/absolute_pose/CentralAbsoluteAdapter.hpp>
#include <opengv/absolute_pose/methods.hpp>

#include "eval/benchmarks/benches.h"
#include "eval/benchmarks/ceres_residuals.h"
#include "eval/benchmarks/pose_problems.h"
#include "pose/bounds.h"
#include "pose/p3p.h"

namespace sightline {
namespace {

/// A step of 1e-3 rad and 1e-3 of the range is taken and not looked at again: the pose is then
/// within a thousandth of the bound's sd of the minimum (off_sd says so).
constexpr double kStepTolerance = 1e-3;

/// A problem as the peers take it, made ready outside the time that is measured.
struct PeerCase {
  PoseCase ours;
  std::vector<cv::Point3d> cv_points;
  std::vector<cv::Point2d> cv_pixels;
  cv::Matx33d cv_camera;
  cv::Vec3d start_rotation;
  cv::Vec3d start_translation;
  opengv::points_t points;
  opengv::bearingVectors_t bearings;
};

PeerCase peer_case(const PoseCase& ours) {
  PeerCase c = {ours, {}, {}, {}, {}, {}, {}, {}};
  const Camera& camera = ours.problem.camera;
  c.cv_camera = {camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1};
  for (std::size_t i = 0; i < ours.problem.pixels.size(); ++i) {
    const Eigen::Vector3d& p = ours.problem.points_in_target[i];
    const Eigen::Vector2d& u = ours.problem.pixels[i];
    c.cv_points.emplace_back(p.x(), p.y(), p.z());
    c.cv_pixels.emplace_back(u.x(), u.y());
    c.points.push_back(p);
    c.bearings.push_back(*bearing(camera, u));
  }
  if (ours.problem.initial_cam_from_target) {
    const Pose& start = *ours.problem.initial_cam_from_target;
    const Eigen::Vector3d w = vector_from_rotation(start.rotation);
    c.start_rotation = {w.x(), w.y(), w.z()};
    c.start_translation = {start.translation.x(), start.translation.y(), start.translation.z()};
  }
  return c;
}

using Method = std::function<Pose(const PeerCase&)>;

Pose pose_from_vectors(const cv::Vec3d& rotation, const cv::Vec3d& translation) {
  return {rotation_from_vector({rotation[0], rotation[1], rotation[2]}),
          {translation[0], translation[1], translation[2]}};
}

Pose lspe(const PeerCase& c) {
  SolverOptions options;
  options.lspe.step_tolerance = kStepTolerance;
  return find_pose_solver("lspe")->solve(c.ours.problem, options).cam_from_target;
}

Method opencv_solve(int flags, bool has_start) {
  return [=](const PeerCase& c) {
    cv::Vec3d rotation = c.start_rotation;
    cv::Vec3d translation = c.start_translation;
    cv::solvePnP(c.cv_points, c.cv_pixels, c.cv_camera, cv::noArray(), rotation, translation,
                 has_start, flags);
    return pose_from_vectors(rotation, translation);
  };
}

Pose opencv_refine(const PeerCase& c) {
  cv::Vec3d rotation = c.start_rotation;
  cv::Vec3d translation = c.start_translation;
  const cv::TermCriteria stop(cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 20, 1e-3);
  cv::solvePnPRefineLM(c.cv_points, c.cv_pixels, c.cv_camera, cv::noArray(), rotation, translation,
                       stop);
  return pose_from_vectors(rotation, translation);
}

Pose from_opengv(const opengv::transformation_t& target_from_cam) {
  return inverse({target_from_cam.leftCols<3>(), target_from_cam.col(3)});
}

Pose opengv_epnp(const PeerCase& c) {
  opengv::absolute_pose::CentralAbsoluteAdapter adapter(c.bearings, c.points);
  return from_opengv(opengv::absolute_pose::epnp(adapter));
}

/// It minimises the angle of the bearings, not pixels: at this field of view the same.
Pose opengv_nonlinear(const PeerCase& c) {
  const Pose target_from_cam = inverse(*c.ours.problem.initial_cam_from_target);
  opengv::absolute_pose::CentralAbsoluteAdapter adapter(
      c.bearings, c.points, target_from_cam.translation, target_from_cam.rotation);
  return from_opengv(opengv::absolute_pose::optimize_nonlinear(adapter));
}

Pose ceres_solve(const PeerCase& c) {
  const PoseProblem& problem = c.ours.problem;
  double pose[6];
  for (int i = 0; i < 3; ++i) {
    pose[i] = c.start_rotation[i];
    pose[3 + i] = c.start_translation[i];
  }
  ceres::Problem sum;
  for (std::size_t i = 0; i < problem.pixels.size(); ++i) {
    sum.AddResidualBlock(new ceres::AutoDiffCostFunction<CeresPoint, 2, 6>(new CeresPoint{
                             problem.points_in_target[i], problem.pixels[i], &problem.camera}),
                         nullptr, pose);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.logging_type = ceres::SILENT;
  options.function_tolerance = 1e-4;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &sum, &summary);
  return {rotation_from_vector(Eigen::Map<Eigen::Vector3d>(pose)),
          Eigen::Map<Eigen::Vector3d>(pose + 3)};
}

/// Of the attitude, from the least-squares minimum that the truth leads to.
double off_sd(const PeerCase& c, const Pose& estimate) {
  PoseProblem from_truth = c.ours.problem;
  from_truth.initial_cam_from_target = c.ours.true_cam_from_target;
  const PoseEstimate minimum = find_pose_solver("lspe")->solve(from_truth, {});
  const auto bound = cramer_rao_bound(from_truth.camera, from_truth.points_in_target,
                                      c.ours.true_cam_from_target, from_truth.sigma_px);
  return geodesic_angle_rad(estimate.rotation, minimum.cam_from_target.rotation) /
         bound->geodesic_rms_rad;
}

void run(benchmark::State& state, const Method& method, const ProblemLaw& law) {
  std::vector<PeerCase> cases;
  for (const PoseCase& c : draw_pose_cases(law)) cases.push_back(peer_case(c));
  double sum2 = 0;
  try {
    for (const PeerCase& c : cases) sum2 += std::pow(off_sd(c, method(c)), 2);
  } catch (const cv::Exception& error) {
    // SQPnP takes many points of a small target for coincident.
    state.SkipWithError(error.err.c_str());
    return;
  }
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(method(cases[next]));
    next = (next + 1) % cases.size();
  }
  state.counters["off_sd"] = std::sqrt(sum2 / static_cast<double>(cases.size()));
}

void add(const std::string& name, const Method& method, bool has_start) {
  for (const int points : {6, 8, 12, 50, 200}) {
    const ProblemLaw law = {.points = points, .has_start = has_start};
    benchmark::RegisterBenchmark(
        ("pnp/" + name + "/" + std::to_string(points)).c_str(),
        [method, law](benchmark::State& state) { run(state, method, law); });
  }
}

P3pPoses ours_p3p(const PeerCase& c) {
  return p3p({c.points[0], c.points[1], c.points[2]},
             {c.bearings[0], c.bearings[1], c.bearings[2]});
}

opengv::transformations_t opengv_p3p(const PeerCase& c) {
  const opengv::absolute_pose::CentralAbsoluteAdapter adapter(c.bearings, c.points);
  return opengv::absolute_pose::p3p_kneip(adapter, {0, 1, 2});
}

template <typename Solve>
void add_p3p(const std::string& name, const Solve& solve) {
  benchmark::RegisterBenchmark(("p3p/" + name).c_str(), [solve](benchmark::State& state) {
    std::vector<PeerCase> cases;
    for (const PoseCase& c : draw_pose_cases({})) cases.push_back(peer_case(c));
    std::size_t next = 0;
    for (auto _ : state) {
      benchmark::DoNotOptimize(solve(cases[next]));
      next = (next + 1) % cases.size();
    }
  });
}

}  // namespace

PeerComparison register_pnp() {
  add_p3p("ours", ours_p3p);
  add_p3p("opengv_kneip", opengv_p3p);
  add("lspe", lspe, true);
  add("lspe_start_free", lspe, false);
  add("opencv_iterative", opencv_solve(cv::SOLVEPNP_ITERATIVE, true), true);
  add("opencv_refine", opencv_refine, true);
  add("opengv_nonlinear", opengv_nonlinear, true);
  add("ceres", ceres_solve, true);
  add("opencv_epnp", opencv_solve(cv::SOLVEPNP_EPNP, false), false);
  add("opencv_sqpnp", opencv_solve(cv::SOLVEPNP_SQPNP, false), false);
  add("opengv_epnp", opengv_epnp, false);
  return {"pnp",
          "lspe",
          {"opencv_iterative", "opencv_refine", "opencv_epnp", "opencv_sqpnp", "opengv_nonlinear",
           "opengv_epnp", "ceres"}};
}

}  // namespace sightline
