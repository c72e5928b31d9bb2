// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "pose/solver.h"

namespace sightline {

struct PoseCase {
  PoseProblem problem;
  Pose true_cam_from_target;
};

/// What a set of problems is drawn from: the ORPE paper's camera and cube (its corners, then points
/// within it), 50 to 150 m away.
struct ProblemLaw {
  int points = 8;
  double sigma_px = 1;
  int outliers = 0;        ///< 15 to 30 px on top of the noise
  bool has_start = false;  ///< 10 degrees and 5 % off the truth
};

/// As many problems as a benchmark goes through in turn: enough that no branch predictor learns
/// them. The same for every solver.
std::vector<PoseCase> draw_pose_cases(const ProblemLaw& law, std::size_t count = 64);

}  // namespace sightline
