// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The solve functions of the catalogue (pose/solver.cpp), one a file of this folder. Reach them
// through find_pose_solver.
#pragma once

#include "pose/solver.h"

namespace sightline {

PoseEstimate solve_consensus(const PoseProblem& problem, const SolverOptions& options);
PoseEstimate solve_drop_largest(const PoseProblem& problem, const SolverOptions& options);
PoseEstimate solve_gnc(const PoseProblem& problem, const SolverOptions& options);
PoseEstimate solve_huber(const PoseProblem& problem, const SolverOptions& options);
PoseEstimate solve_huber_tukey(const PoseProblem& problem, const SolverOptions& options);
PoseEstimate solve_lspe(const PoseProblem& problem, const SolverOptions& options);
PoseEstimate solve_minimax(const PoseProblem& problem, const SolverOptions& options);
PoseEstimate solve_minimax_two_step(const PoseProblem& problem, const SolverOptions& options);
/// Compiled only where CMake's SIGHTLINE_POSE_OPENCV is ON.
PoseEstimate solve_opencv_ransac(const PoseProblem& problem, const SolverOptions& options);
PoseEstimate solve_oracle(const PoseProblem& problem, const SolverOptions& options);
PoseEstimate solve_orpe(const PoseProblem& problem, const SolverOptions& options);
PoseEstimate solve_orpe_calibrated(const PoseProblem& problem, const SolverOptions& options);
PoseEstimate solve_orpe_consensus(const PoseProblem& problem, const SolverOptions& options);
PoseEstimate solve_orpe_tree(const PoseProblem& problem, const SolverOptions& options);
PoseEstimate solve_orpe_weighed(const PoseProblem& problem, const SolverOptions& options);
PoseEstimate solve_ransac_p3p(const PoseProblem& problem, const SolverOptions& options);

}  // namespace sightline
