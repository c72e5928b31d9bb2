// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "pose/camera.h"
#include "pose/line_observation.h"
#include "pose/pose.h"

namespace sightline {

/// The fewest points that every solver needs. Three points have up to four poses: only an initial
/// pose says which of them is meant.
inline constexpr int kMinimumPosePoints = 4;
inline constexpr int kMinimumPosePointsFromInitial = 3;

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
  /// Straight edges of the target seen as lines, for the solvers that use them
  /// (PoseSolver::with_lines); the others look at the points alone.
  std::vector<LineObservation> lines;
  /// Where to start. Without it solvers find starts of their own (pose/starts.h).
  std::optional<Pose> initial_cam_from_target;
  /// For the oracle alone, which exists for evaluation: which points are true inliers.
  std::vector<bool> true_inliers;
};

/// Whether a solver has a pose, or why it has none.
enum class PoseStatus {
  kOk,
  kTooFewPoints,   ///< fewer than kMinimumPosePoints, or lists of different lengths
  kTooManyPoints,  ///< more than the solver has time for (PoseSolver::most_points)
  kDegenerate,     ///< the input does not determine a pose: points that are collinear or coincide,
                   ///< numbers that are not finite, a pixel that the lens model cannot undo
  kBehindCamera,   ///< every start has a point behind the camera
  kDiverged,       ///< no convergence
};

/// The name that files give to a status.
std::string_view to_string(PoseStatus status);

/// How far a solver trusts its own estimate. A member without a value means that the solver has
/// nothing to say of that question; what is said counts for status kOk alone.
struct Diagnosis {
  /// Whether another, clearly different pose explains the pixels nearly as well.
  std::optional<bool> is_ambiguous;
  /// The probability, between 0 and 1, that exactly the points of PoseEstimate::removed are the
  /// outliers.
  std::optional<double> removed_probability;
  /// Whether the solver could remove no more points than it did, so that outliers may be left.
  std::optional<bool> is_removal_limit_reached;
  /// Whether the points that are kept fail the test for looking like noise of the size that is
  /// known (orpe_tree: or was estimated). Where it is not known, the test is whether the largest
  /// residual stands out from the others.
  std::optional<bool> is_test_failed;
  /// The pose of least squares with exactly the points of PoseEstimate::removed left out, from a
  /// solver whose cam_from_target is a mean over several sets of points.
  std::optional<Pose> most_probable_cam_from_target;
  /// Whether so many points agree on the pose that chance does not explain it: false where the data
  /// fit no pose, as of a mirrored target, and where too few points are left to say.
  std::optional<bool> is_significant;
};

/// A solver's answer to a problem.
struct PoseEstimate {
  PoseStatus status = PoseStatus::kTooFewPoints;
  Pose cam_from_target;      ///< meaningful only with status kOk
  std::vector<int> removed;  ///< indices of points judged outliers, ascending; for status kOk
  /// Covariance of (w, dt), cam_from_target = (Exp(w) R, t + dt), radians and metres, for unit
  /// pixel noise on the points as the solver weighed them (those that remove: on the kept ones);
  /// with lines for noise as large as is stated.
  /// From the comparators (pose/robust.h), where there are covariances, for noise of those.
  Matrix6d unit_covariance = Matrix6d::Zero();
  /// Covariance of (w, dt) as the solver itself believes it, noise of its true size and doubt about
  /// the outliers included. Only consensus, orpe_consensus and orpe_weighed have one;
  /// of the others, unit_covariance times the noise's variance is the covariance.
  std::optional<Matrix6d> covariance;
  /// What the solver says of its answer, and what the common entry adds (SolverOptions::is_judged).
  std::optional<Diagnosis> diagnosis;
  int iterations = 0;  ///< of the innermost optimiser, all calls together
  /// Points that could not be used (a number that is not finite, a pixel that the lens model cannot
  /// undo, a covariance that is not positive definite, behind an initial pose that stands though),
  /// ascending; also where the status is not ok.
  std::vector<int> ignored;
  /// The same of lines: judged outliers, and of no use. Only from solvers that use lines.
  std::vector<int> removed_lines;
  std::vector<int> ignored_lines;
  /// The probability of each point to be an inlier, 0 of those ignored. Only from consensus.
  std::optional<std::vector<double>> inlier_probabilities;
  /// Another pose that explains the points nearly as well, where the diagnosis says that there is
  /// one (orpe_weighed may say so without one).
  std::optional<Pose> second_cam_from_target;
  /// The standard deviation of an inlier's noise in each coordinate, as the solver was told or
  /// found it; with covariances or lines in their units. Only from consensus and orpe_consensus.
  std::optional<double> noise_px;
  /// Root mean square of the residuals of the points that are kept, in each coordinate; with
  /// covariances or lines in their units.
  std::optional<double> residual_rms_px;
};

/// Options of the least-squares iteration.
struct LspeOptions {
  int max_iterations = 100;
  /// Converged when a step turns by less than this angle and moves by less than this part of the
  /// range.
  double step_tolerance = 1e-10;
};

/// Options of the solver orpe.
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

/// What every solver is given; each takes from it what it needs.
struct SolverOptions {
  LspeOptions lspe;
  OrpeOptions orpe;
  OutlierOptions outliers;
  /// Whether the common entry adds to the diagnosis what the solver does not say itself: residuals,
  /// whether they look like noise, whether chance explains the pose, the second pose of a plane.
  /// Studies, which judge by the truth, go without.
  bool is_judged = true;
};

/// One way to estimate a pose. To add a solver: write pose/solvers/<name>.cpp with one function of
/// the signature of `core`, declare it in pose/solvers/solvers.h, and give it a line in the
/// catalogue (pose/solver.cpp).
struct PoseSolver {
  std::string_view name;
  std::string_view summary;
  bool evaluation_only;  ///< needs the truth; never in a default list
  /// The solver's own function, for problems all of whose points can be used. Call `solve`.
  PoseEstimate (*core)(const PoseProblem& problem, const SolverOptions& options);
  std::size_t most_points = 0;  ///< more would take too long; 0: any number
  /// Whether `core` itself leaves out what cannot be used and is not bound to an initial pose.
  bool takes_any_input = false;
  /// Whether unit_covariance is that for noise of the covariances, where there are some.
  bool unit_covariance_is_whitened = false;
  /// What it makes of a problem with lines, whatever the input; null: it uses points alone. There
  /// points and lines together need be four, or three with an initial pose.
  PoseEstimate (*with_lines)(const PoseProblem& problem, const SolverOptions& options) = nullptr;

  /// The pose, whatever the input: points that cannot be used are left out and listed, an initial
  /// pose can only help, points given twice count once for what is determined
  /// (pose/entry/entry.cpp).
  PoseEstimate solve(const PoseProblem& problem, const SolverOptions& options = {}) const;
};

/// What holds for every solver: a pose with status kOk is a rigid one with all kept points in front
/// of the camera; no number of an estimate is NaN; the order of the points, the choice of the
/// target's frame and the unit of length do not matter.

/// The catalogue, in the order in which it is listed.
std::span<const PoseSolver> pose_solvers();

/// The solver of that name, or null.
const PoseSolver* find_pose_solver(std::string_view name);

}  // namespace sightline
