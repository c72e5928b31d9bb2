// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/solver.h"

#include <array>

#include "pose/lines/joint.h"
#include "pose/solvers/solvers.h"

namespace sightline {
namespace {

constexpr std::array kCatalogue = {
    PoseSolver{"consensus", "any number of points and lines, any share of outliers, any start",
               false, solve_consensus, 0, true, true, lines::solve_consensus},
    PoseSolver{"lspe", "least squares on all points and lines", false, solve_lspe, 0, false, false,
               lines::solve_lspe},
    PoseSolver{"orpe", "minimax with removal of outliers, as the paper prints it", false,
               solve_orpe},
    PoseSolver{"orpe_calibrated", "minimax with outward tests at a stated false-alarm rate", false,
               solve_orpe_calibrated, 300},
    PoseSolver{"orpe_consensus", "a largest set of points whose minimax passes for noise", false,
               solve_orpe_consensus, 0, true},
    PoseSolver{"orpe_tree", "the fewest removals whose minimax passes for noise", false,
               solve_orpe_tree, 100},
    PoseSolver{"orpe_weighed", "every small set of removals, weighed by likelihood", false,
               solve_orpe_weighed},
    PoseSolver{"minimax", "exact minimax on all points", false, solve_minimax},
    PoseSolver{"minimax_two_step", "minimax on all points, attitude and position in turns", false,
               solve_minimax_two_step},
    PoseSolver{"drop_largest", "least squares, dropping the largest studentised residual in turn",
               false, solve_drop_largest, 0, false, true},
    PoseSolver{"huber", "Huber's M-estimator", false, solve_huber, 0, false, true},
    PoseSolver{"huber_tukey", "Tukey's biweight M-estimator from Huber's", false, solve_huber_tukey,
               0, false, true},
    PoseSolver{"gnc", "graduated non-convexity, Geman-McClure", false, solve_gnc, 0, false, true},
    PoseSolver{"ransac_p3p", "consensus over three-point poses, refined by least squares", false,
               solve_ransac_p3p, 0, false, true},
#ifdef SIGHTLINE_POSE_OPENCV
    PoseSolver{"opencv_ransac", "OpenCV's solvePnPRansac with SQPnP, refined by least squares",
               false, solve_opencv_ransac, 0, false, true},
#endif
    PoseSolver{"oracle", "least squares on the true inliers", true, solve_oracle},
};

}  // namespace

std::string_view to_string(PoseStatus status) {
  switch (status) {
    case PoseStatus::kOk:
      return "ok";
    case PoseStatus::kTooFewPoints:
      return "too_few_points";
    case PoseStatus::kTooManyPoints:
      return "too_many_points";
    case PoseStatus::kDegenerate:
      return "degenerate";
    case PoseStatus::kBehindCamera:
      return "behind_camera";
    case PoseStatus::kDiverged:
      return "diverged";
  }
  return "unknown";
}

std::span<const PoseSolver> pose_solvers() {
  return kCatalogue;
}

const PoseSolver* find_pose_solver(std::string_view name) {
  for (const PoseSolver& solver : kCatalogue) {
    if (solver.name == name) return &solver;
  }
  return nullptr;
}

}  // namespace sightline
