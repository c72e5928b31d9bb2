// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "pose/camera.h"
#include "pose/pose.h"

namespace sightline {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// What a pose solver is given: n points of the target and where the camera saw them.
struct PoseProblem {
  Camera camera;
  std::vector<Eigen::Vector3d> points_in_target;  ///< metres
  std::vector<Eigen::Vector2d> pixels;            ///< one a point
  /// Covariance of each pixel; empty or one a point. The papers' LSPE, ORPE and minimax, and with
  /// them the oracle and orpe_calibrated, ignore it.
  std::vector<Eigen::Matrix2d> covariances_px2;
  /// Standard deviation of an inlier's noise in each coordinate, where there are no covariances; 0:
  /// not known. Solvers that need it estimate it then. LSPE and ORPE, as printed, do not.
  double sigma_px = 0;
  /// Where to start. Without it solvers start from orthogonal iteration, which needs no truth.
  std::optional<Pose> initial_cam_from_target;
  /// For the oracle alone, which exists for evaluation: which points are true inliers.
  std::vector<bool> true_inliers;
};

enum class PoseStatus {
  kOk,
  kTooFewPoints,  ///< fewer than the solver needs, or lists of different lengths
  kDegenerate,    ///< the input does not determine a pose: points that are collinear or coincide,
                  ///< numbers that are not finite, a pixel that the lens model cannot undo
  kBehindCamera,  ///< the initial pose has a point behind the camera
  kDiverged,      ///< no convergence
};

std::string_view to_string(PoseStatus status);

struct PoseEstimate {
  PoseStatus status = PoseStatus::kTooFewPoints;
  Pose cam_from_target;      ///< meaningful only with status kOk
  std::vector<int> removed;  ///< indices of points judged outliers, ascending; for status kOk
  /// Covariance of (w, dt), cam_from_target = (Exp(w) R, t + dt), radians and metres, for unit
  /// pixel noise on the points as the solver weighed them (those that remove: on the kept ones).
  /// From the comparators (pose/robust.h), where there are covariances, for noise of those.
  Matrix6d unit_covariance = Matrix6d::Zero();
  int iterations = 0;  ///< of the innermost optimiser, all calls together

  // From orpe_weighed; others leave them as they are.
  Pose most_probable_cam_from_target;  ///< with exactly `removed` removed
  /// Of (w, dt): what the noise leaves, its size as stated or found, and the scatter of hypotheses.
  Matrix6d covariance = Matrix6d::Zero();
  double removed_probability = 1;  ///< of exactly `removed` being the outliers
  bool is_ambiguous = false;       ///< another pose explains the pixels nearly as well
  // From all that test what they keep.
  bool is_removal_limit_reached = false;  ///< more outliers may be left than could be removed
  bool is_test_failed = false;  ///< what is kept does not look like noise of the stated size
};

struct LspeOptions {
  int max_iterations = 100;
  /// Converged when a step turns by less than this angle and moves by less than this part of the
  /// range.
  double step_tolerance = 1e-10;
};

struct OrpeOptions {
  /// What the pose is the minimiser of, on the points that are left.
  enum class Final { kMinimax, kLeastSquares };

  double rho = 10;  ///< an outlier lowers the minimax residual at least by this factor (squared px)
  Final final = Final::kMinimax;
};

/// What is known of outliers before any pixel is seen. Which solver uses what is said in its file.
struct OutlierOptions {
  double probability = 0.1;        ///< of a point being an outlier
  double scale_px = 20;            ///< standard deviation of an outlier's error, each coordinate
  double false_alarm_rate = 0.01;  ///< of removing anything from points that have no outlier
  std::optional<int> max_removed;  ///< none: the solver's own limit, which its file states
};

struct SolverOptions {
  LspeOptions lspe;
  OrpeOptions orpe;
  OutlierOptions outliers;
};

/// One way to estimate a pose. To add a solver: write pose/solvers/<name>.cpp with one function of
/// this signature, declare it in pose/solvers/solvers.h, and give it a line in the catalogue
/// (pose/solver.cpp).
struct PoseSolver {
  std::string_view name;
  std::string_view summary;
  int minimum_points;    ///< without an initial pose; with one, three may do
  bool evaluation_only;  ///< needs the truth; never in a default list
  PoseEstimate (*solve)(const PoseProblem& problem, const SolverOptions& options);
};

/// What holds for every solver: a pose with status kOk is a rigid one with all kept points in front
/// of the camera; no number of an estimate is NaN; the order of the points, the choice of the
/// target's frame and the unit of length do not matter.

/// The catalogue, in the order in which it is listed.
std::span<const PoseSolver> pose_solvers();

/// The solver of that name, or null.
const PoseSolver* find_pose_solver(std::string_view name);

}  // namespace sightline
