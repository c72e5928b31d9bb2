// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// What the tests of the solvers share: calling one by its name, and the errors of its answer.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "pose/camera.h"
#include "pose/pose.h"
#include "pose/reprojection.h"
#include "pose/solver.h"
#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {

/// The answer of the solver of that name.
inline PoseEstimate solve(std::string_view name, const PoseProblem& problem,
                          const SolverOptions& options = {}) {
  return find_pose_solver(name)->solve(problem, options);
}

/// What an estimate's diagnosis says; where it does not say it, the test that asks fails.
inline bool is_test_failed(const PoseEstimate& estimate) {
  return estimate.diagnosis.value().is_test_failed.value();
}
inline bool is_removal_limit_reached(const PoseEstimate& estimate) {
  return estimate.diagnosis.value().is_removal_limit_reached.value();
}
inline bool is_ambiguous(const PoseEstimate& estimate) {
  return estimate.diagnosis.value().is_ambiguous.value();
}
inline double removed_probability(const PoseEstimate& estimate) {
  return estimate.diagnosis.value().removed_probability.value();
}

/// The squared reprojection error of one point; infinite for one that the camera does not see.
inline double squared_error_px2(const PoseProblem& problem, std::size_t i,
                                const Pose& cam_from_target) {
  const auto pixel = project(problem.camera, cam_from_target * problem.points_in_target[i]);
  return pixel ? (*pixel - problem.pixels[i]).squaredNorm() : kInfinity;
}

/// The largest of the squared reprojection errors.
inline double largest_squared_error_px2(const PoseProblem& problem, const Pose& cam_from_target) {
  double largest = 0;
  for (std::size_t i = 0; i < problem.pixels.size(); ++i) {
    largest = std::max(largest, squared_error_px2(problem, i, cam_from_target));
  }
  return largest;
}

/// The sum of the squared reprojection errors.
inline double sum_of_squares_px2(const PoseProblem& problem, const Pose& cam_from_target) {
  double sum = 0;
  for (std::size_t i = 0; i < problem.pixels.size(); ++i) {
    sum += squared_error_px2(problem, i, cam_from_target);
  }
  return sum;
}

/// The same problem with its first n points alone.
inline PoseProblem first_points(const PoseProblem& all, std::size_t n) {
  PoseProblem some = all;
  some.points_in_target.resize(n);
  some.pixels.resize(n);
  some.true_inliers.resize(n);
  return some;
}

/// Points drawn uniformly in a box about the origin.
inline std::vector<Eigen::Vector3d> points_in_box(int n, const Eigen::Vector3d& half_width,
                                                  Draw& draw) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < n; ++i) points.push_back(half_width.cwiseProduct(draw.in_box(1)));
  return points;
}

/// A noisy cube made ready for computing, with an outlier in every second one.
inline Correspondences noisy_cube(int i, double sigma_px, Draw& draw) {
  Synthetic s = cube_problem(sigma_px, draw);
  if (i % 2) add_outlier(s.problem, draw.index(8), draw.uniform(15, 30), draw);
  return prepare(s.problem).correspondences;
}

/// The largest of the squared reprojection errors at a pose of the centred frame.
inline double largest_px2(const Correspondences& c, const Pose& pose) {
  double largest = 0;
  for (std::size_t i = 0; i < c.size(); ++i) {
    const auto r = residual_px(c, i, pose);
    largest = std::max(largest, r ? r->squaredNorm() : kInfinity);
  }
  return largest;
}

}  // namespace sightline
