// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "pose/pose.h"
#include "pose/reprojection.h"
#include "pose/solver.h"

namespace sightline {

/// Squared residuals below this count as zero, (1e-6 px)^2: far below any noise, far above
/// rounding. With whitening it is taken in its units.
inline constexpr double kZeroResidualPx2 = 1e-12;

/// The points that a fit is made to: some of a prepared problem, each residual seen through a 2x2
/// matrix. It only looks at what others own.
struct FitPoints {
  const Correspondences& correspondences;
  std::span<const int> kept;                   ///< indices of the points; empty: all
  std::span<const Eigen::Matrix2d> whitening;  ///< one a point of the problem; empty: identities

  std::size_t size() const { return kept.empty() ? correspondences.size() : kept.size(); }
  std::size_t index(std::size_t i) const {
    return kept.empty() ? i : static_cast<std::size_t>(kept[i]);
  }
};

/// The reprojection of the i-th of the fitted points, whitened. None for a point at or behind the
/// camera's plane.
std::optional<Reprojection> reproject(const FitPoints& points, std::size_t i,
                                      const Pose& cam_from_centred);

/// least_squares (pose/reprojection.h) on these points.
LeastSquares least_squares(const FitPoints& points, std::span<const Pose> cam_from_centred_starts,
                           const LspeOptions& options);

/// (J^T J)^-1 over these points, of cam_from_centred. None where the points do not determine the
/// pose.
std::optional<Matrix6d> unit_covariance(const FitPoints& points, const Pose& cam_from_centred);

/// The estimate with this pose and its unit covariance; kDegenerate, and without them, where the
/// points do not determine the pose.
PoseEstimate with_pose(PoseEstimate estimate, const FitPoints& points,
                       const Pose& cam_from_centred);

/// The estimate with the least-squares pose of these points from a start near it, and fails as
/// least squares does.
PoseEstimate with_least_squares(PoseEstimate estimate, const FitPoints& points,
                                const Pose& cam_from_centred_start, const LspeOptions& options);

/// How many of so many points may be removed at most: OutlierOptions::max_removed, or fewer than
/// half of them where that is not said, and in either case no more than leave two redundant
/// coordinates, 2 (points - removed) - 6 >= 2.
std::size_t minority_limit(std::size_t points, const OutlierOptions& options);

/// What of a pose a minimax fit may change.
enum class FreePart { kPose, kRotation, kTranslation };

struct MinimaxOptions {
  /// Stops when the largest squared residual is proven to be above the least one by no more than
  /// this part of itself.
  double relative_gap = 1e-9;
  FreePart free = FreePart::kPose;
};

/// The pose of least largest squared residual, min over poses of max_i f_i.
struct Minimax {
  /// kOk: the relative gap is at most kMinimaxGap, or what was asked for if that is more, or the
  /// residuals are zero. kBehindCamera: at the
  /// start. kDiverged: no convergence. From minimax() also what least squares fails with.
  PoseStatus status = PoseStatus::kDiverged;
  Pose cam_from_centred;
  double largest_px2 = 0;  ///< max f_i; zero when below kZeroResidualPx2
  /// Of the constraints f_i <= max, one a fitted point: non-negative, sum one. Those that are not
  /// (nearly) zero are the support: the points that alone have the same minimax.
  std::vector<double> multipliers;
  /// (max f_i - lower bound) / max f_i, see minimax_from.
  double relative_gap = 1;
  int iterations = 0;

  /// Position among the fitted points of the largest multiplier.
  std::size_t most_binding() const;
};

/// The gap that is promised with kOk.
inline constexpr double kMinimaxGap = 1e-6;

/// Minimises max_i f_i from one start by a primal-dual interior point method on
/// min t subject to f_i <= t (pose/minimax.cpp says how): 7 iterations at eight points, rarely more
/// than 40, at most 210.
///
/// The certificate: for weights lambda_i >= 0 that sum to one, max f_i >= sum lambda_i f_i for any
/// pose, hence min max f_i >= min sum lambda_i f_i, a weighted least-squares problem. Its minimum
/// is taken from the linearised residuals at the pose found (one Gauss-Newton step), and weighted
/// least squares has local minima too: the bound, and with it the pose, is exact among the poses
/// near the one found. Nothing is said of mirror poses; carry each start to the end.
Minimax minimax_from(const FitPoints& points, const Pose& cam_from_centred_start,
                     const MinimaxOptions& options = {});

/// minimax_from from the least-squares pose of every start; the lowest maximum wins. Fails where
/// least squares does but for its not converging.
Minimax minimax(const FitPoints& points, std::span<const Pose> cam_from_centred_starts,
                const SolverOptions& options, const MinimaxOptions& minimax_options = {});

}  // namespace sightline
