// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Points and lines of one problem together: what the solvers that use lines share.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "pose/edge_points.h"
#include "pose/kernels/reprojection_kernel.h"
#include "pose/packed_points.h"
#include "pose/pose.h"
#include "pose/reprojection.h"
#include "pose/solver.h"

namespace sightline::lines {

/// The fewest observations, points and lines, that make a pose: three say six numbers, but of up to
/// eight poses only an initial one says which is meant.
inline constexpr std::size_t kFewest = 4;
inline constexpr std::size_t kFewestFromInitial = 3;

/// A point or a line: where its numbers stand in a Joint, and how many they are.
struct Observed {
  int given_index = 0;  ///< among the problem's points, or its lines
  bool is_line = false;
  std::size_t first = 0;  ///< point, or first edge point
  int numbers = 2;        ///< that it says of the pose; an edge point says one
};

/// The observations of a problem that can be used, in units of their own noise, about a middle of
/// the target so that its frame does not matter. Points of one weight count as noise of one pixel
/// where theirs is not known; lines state theirs always.
struct Joint {
  Correspondences points;
  std::vector<Eigen::Matrix2d> point_weights;  ///< inverse covariances
  std::vector<EdgePoint> edges;                ///< in the target's own frame
  std::vector<Observed> observed;              ///< points first
  std::vector<int> ignored, ignored_lines;     ///< given, but of no use; ascending
  bool is_noise_known = false;                 ///< else all noise has one unknown factor
  std::optional<Pose> initial_cam_from_centred;

  PackedPoints packed_points() const { return {points, point_weights}; }
  PackedEdges packed_edges() const { return {edges, points.centroid_in_target}; }
};

struct PreparedJoint {
  PoseStatus status = PoseStatus::kDegenerate;  ///< kOk: the observations may be used
  Joint joint;
};

/// kTooFewPoints where there are fewer than kFewest observations (with a usable initial pose
/// kFewestFromInitial), kDegenerate where those that can be used say fewer numbers of the
/// pose than as many points would, or the camera has no positive focal length. A point or an edge
/// says two, however often it was observed: oftener only makes them more exact.
PreparedJoint prepare_joint(const PoseProblem& problem);

/// The spread of the pixels, px, by which an outlier's error is measured
/// (consensus::image_unit_px); 0 where all pixels are one.
double image_unit_px(const Joint& joint);

/// Whether what is said of points and lines together is in units of the noise that is stated: all
/// points state theirs, or there are none.
bool is_noise_known(const PoseProblem& problem);

/// The squares of an observation's residual at a pose, in units of its noise; none where it has
/// no residual there.
std::optional<double> squares_of(const Joint& joint, const Observed& observed,
                                 const Pose& cam_from_centred);

/// Least squares from one start, each observation's squares multiplied by a weight (one an
/// observation, or none for ones).
kernel::Fit fit(const Joint& joint, std::span<const double> weights, const Pose& start,
                int max_iterations, double step_tolerance);

/// Least squares on all observations from one start, however wrong: where edges are seen along the
/// normals of their lines, it comes nearer by the distances of lines from edges first. `has_all`
/// says whether every observation has a residual in the end.
kernel::Fit fit_all(const Joint& joint, const Pose& start, int max_iterations,
                    double step_tolerance, bool& has_all);

/// The sum of J^T W J at a pose. None where an observation of weight other than zero has no
/// residual.
std::optional<Matrix6d> information_at(const Joint& joint, std::span<const double> weights,
                                       const Pose& cam_from_centred);

/// Poses spread over all attitudes, each with the position that suits the observations best: where
/// to start when nothing else says where the target is.
std::vector<Pose> starts_over_attitudes(const Joint& joint);

/// The poses that say where the target is, as cam_from_centred: `from_points`, an answer to the
/// points alone, and the initial one. Where there is neither, or they lead nowhere, there are
/// starts_over_attitudes.
std::vector<Pose> starts_of(const Joint& joint, const PoseEstimate& from_points);

/// The problem without its lines.
PoseProblem points_of(PoseProblem problem);

/// Least squares on points and lines: what lspe makes of a problem with lines. Unlike on points
/// alone covariances count, for what a line says against a point needs their noise.
PoseEstimate solve_lspe(const PoseProblem& problem, const SolverOptions& options);

/// What consensus makes of a problem with lines. Every observation is weighed by its probability of
/// being an inlier among outliers near and far, by expectation maximisation; begun at the answer to
/// the points alone, at the initial pose, and at poses of three observations near these.
PoseEstimate solve_consensus(const PoseProblem& problem, const SolverOptions& options);

}  // namespace sightline::lines
