// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "pose/pose.h"
#include "pose/solver.h"

namespace sightline {

/// A local minimum of the sum of squared reprojection errors.
struct PoseMinimum {
  Pose cam_from_target;
  double cost = 0;  ///< the sum, px^2; with covariances of whitened errors, without a unit
  Matrix6d unit_covariance = Matrix6d::Zero();  ///< as of a solver that weighs by the covariances
};

/// All of them, of the lowest cost first.
struct PoseMinima {
  PoseStatus status = PoseStatus::kTooFewPoints;  ///< kOk: there is one at least
  std::vector<PoseMinimum> minima;
  std::vector<int> ignored;  ///< points that could not be used, ascending
};

/// Every local minimum of least squares that its search meets, all points but those of `left_out`
/// (ascending) taking part: both poses of a plane, and with three points, which no initial pose is
/// needed for here, the up to four poses that meet them exactly (pose/p3p.h). An initial pose is
/// one more start.
///
/// With four points and more the starts are those of the solvers (pose/starts.h), the poses of
/// three points for up to kMostStartTriples triples, and the mirror pose of every minimum found; a
/// minimum that none of them leads to is missed. There is no removal of outliers: leave out what a
/// solver removed.
///
/// kTooFewPoints below three points or where lists differ in length, kDegenerate where fewer can be
/// used or they determine no pose, kDiverged where no start leads to a minimum.
PoseMinima solve_all(const PoseProblem& problem, std::span<const int> left_out = {});

inline constexpr int kMostStartTriples = 60;

}  // namespace sightline
