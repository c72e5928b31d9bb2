// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/entry/cleaning.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "pose/consensus/cloud.h"

namespace sightline::entry {
namespace {

bool is_plausible(const Eigen::Matrix2d& c) {
  return c(0, 0) > 0 && c(1, 1) > 0 && c(0, 0) * c(1, 1) > c(0, 1) * c(1, 0) && c.allFinite();
}

std::size_t fewest_points(const PoseProblem& problem) {
  return problem.initial_cam_from_target ? kMinimumPosePointsFromInitial : kMinimumPosePoints;
}

}  // namespace

Part without_points(const PoseProblem& problem, std::vector<int> left_out) {
  Part part;
  part.problem.camera = problem.camera;
  part.problem.sigma_px = problem.sigma_px;
  part.problem.initial_cam_from_target = problem.initial_cam_from_target;
  auto next = left_out.begin();
  for (std::size_t i = 0; i < problem.pixels.size(); ++i) {
    if (next != left_out.end() && *next == static_cast<int>(i)) {
      ++next;
      continue;
    }
    part.given_index.push_back(static_cast<int>(i));
    part.problem.points_in_target.push_back(problem.points_in_target[i]);
    part.problem.pixels.push_back(problem.pixels[i]);
    if (!problem.covariances_px2.empty()) {
      part.problem.covariances_px2.push_back(problem.covariances_px2[i]);
    }
    if (i < problem.true_inliers.size()) {
      part.problem.true_inliers.push_back(problem.true_inliers[i]);
    }
  }
  part.left_out = std::move(left_out);
  return part;
}

Part usable_part(const PoseProblem& problem) {
  Part part = without_points(problem, consensus::unusable_points(problem));
  part.problem.initial_cam_from_target = consensus::rigid_pose(problem.initial_cam_from_target);
  return part;
}

std::vector<int> points_behind(const PoseProblem& problem, const Pose& cam_from_target) {
  std::vector<int> behind;
  for (std::size_t i = 0; i < problem.points_in_target.size(); ++i) {
    const bool is_in_front = (cam_from_target * problem.points_in_target[i]).z() > 0;
    if (!is_in_front) behind.push_back(static_cast<int>(i));
  }
  return behind;
}

PoseEstimate of_whole(PoseEstimate estimate, const Part& part) {
  const auto to_whole = [&part](std::vector<int>& indices) {
    for (int& index : indices) index = part.given_index[static_cast<std::size_t>(index)];
  };
  to_whole(estimate.removed);
  to_whole(estimate.ignored);
  estimate.ignored.insert(estimate.ignored.end(), part.left_out.begin(), part.left_out.end());
  std::ranges::sort(estimate.ignored);
  return estimate;
}

bool are_covariances_plausible(const PoseProblem& problem) {
  return std::ranges::all_of(problem.covariances_px2, is_plausible);
}

bool is_determined(const PoseProblem& problem, const PoseEstimate& estimate) {
  const std::size_t fewest = fewest_points(problem);
  if (problem.points_in_target.size() - estimate.removed.size() < fewest) return true;
  std::array<const Eigen::Vector3d*, kMinimumPosePoints> distinct = {};
  std::size_t count = 0;
  auto removed = estimate.removed.begin();
  for (std::size_t i = 0; i < problem.points_in_target.size(); ++i) {
    if (removed != estimate.removed.end() && *removed == static_cast<int>(i)) {
      ++removed;
      continue;
    }
    const Eigen::Vector3d& point = problem.points_in_target[i];
    const auto end = distinct.begin() + static_cast<std::ptrdiff_t>(count);
    if (std::any_of(distinct.begin(), end, [&point](const auto* p) { return *p == point; })) {
      continue;
    }
    distinct[count++] = &point;
    if (count == fewest) return true;
  }
  return false;
}

}  // namespace sightline::entry
