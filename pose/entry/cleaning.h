// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "pose/solver.h"

namespace sightline::entry {

/// A part of a problem's points that makes a problem of its own, and where they stand in the whole.
struct Part {
  PoseProblem problem;
  std::vector<int> given_index;
  std::vector<int> left_out;  ///< the others, ascending
};

/// The problem without those points (`left_out`, ascending).
Part without_points(const PoseProblem& problem, std::vector<int> left_out);

/// The problem without the points that cannot be used: those with a number that is not finite or
/// too large to be squared, with a pixel that the lens model cannot undo, or with a covariance that
/// is not positive definite. An initial pose that is a rotation but for rounding is made
/// orthonormal; one that is not is left out.
Part usable_part(const PoseProblem& problem);

/// The points that an initial pose has behind the camera, ascending.
std::vector<int> points_behind(const PoseProblem& problem, const Pose& cam_from_target);

/// The estimate of a part as one of the whole: its points by their places there, the others
/// ignored.
PoseEstimate of_whole(PoseEstimate estimate, const Part& part);

/// Whether every covariance is that of noise, as far as a glance says. True where there are none.
bool are_covariances_plausible(const PoseProblem& problem);

/// Whether the points that are kept are as many different ones as a pose takes. Also true where an
/// M-estimator lists nearly all points as removed, for it goes on using them.
bool is_determined(const PoseProblem& problem, const PoseEstimate& estimate);

}  // namespace sightline::entry
