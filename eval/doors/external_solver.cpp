// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/doors/external_solver.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "eval/doors/process_json.h"

namespace sightline {
namespace {

constexpr double kUnitTolerance = 1e-2;  // what few printed digits leave of a quaternion's length

// The true inliers, which some problems have, are not told.
Json question_of(const SolverQuestion& asked) {
  const PoseProblem& problem = asked.problem;
  Json question = question_about("solve", asked.trial);
  question["camera"] = json_of(problem.camera);
  question["features"] = asked.features;
  Json& points = question["points_m"] = Json::array();
  for (const Eigen::Vector3d& point : problem.points_in_target) {
    points.push_back(json_of_point(point));
  }
  Json& pixels = question["pixels"] = Json::array();
  for (const Eigen::Vector2d& pixel : problem.pixels) pixels.push_back(json_of_point(pixel));
  if (!problem.covariances_px2.empty()) {
    Json& covariances = question["covariances_px2"] = Json::array();
    for (const Eigen::Matrix2d& one : problem.covariances_px2) covariances.push_back(json_of(one));
  }
  if (problem.sigma_px > 0) question["sigma_px"] = problem.sigma_px;
  if (problem.initial_cam_from_target) {
    question["initial"] = json_of(*problem.initial_cam_from_target);
  }
  return question;
}

// The rotation of an answer; none where its quaternion is no rotation.
std::optional<Eigen::Matrix3d> rotation_of(const Json& answer) {
  if (!answer.contains("quaternion")) return square_matrix_at(answer, "rotation", 3);
  const Eigen::VectorXd q = vector_at(answer, "quaternion", 4);
  if (!(std::abs(q.norm() - 1) <= kUnitTolerance)) return std::nullopt;
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
}

std::vector<int> removed_in(const Json& answer, const std::vector<std::string>& features) {
  std::set<int> removed;
  for (const Json& name : answer.value("removed", Json::array())) {
    removed.insert(static_cast<int>(place_of(name.get<std::string>(), features)));
  }
  return {removed.begin(), removed.end()};
}

EstimateOutcome read_estimate(const Json& answer, const std::vector<std::string>& features,
                              PoseEstimate& estimate) {
  const std::optional<Eigen::Matrix3d> rotation = rotation_of(answer);
  estimate.cam_from_target.translation = vector_at(answer, "translation_m", 3);
  if (answer.contains("covariance")) estimate.covariance = covariance_at(answer, "covariance", 6);
  estimate.removed = removed_in(answer, features);
  if (!rotation) return EstimateOutcome::kNotRigid;
  estimate.cam_from_target.rotation = *rotation;
  estimate.status = PoseStatus::kOk;
  return EstimateOutcome::kOk;
}

}  // namespace

TrialSolver external_solver(const ProcessSource& source) {
  TrialSolver solver;
  solver.name = source.name;
  solver.summary = fmt::format("the process: {}", source.command);
  solver.process = std::make_shared<ExternalProcess>(source, "solver");
  solver.solve = [process = solver.process](const SolverQuestion& asked) {
    SolverAnswer out;
    out.outcome = process->ask(question_of(asked), asked.trial.trial, [&](const Json& answer) {
      return read_estimate(answer, asked.features, out.estimate);
    });
    return out;
  };
  return solver;
}

}  // namespace sightline
