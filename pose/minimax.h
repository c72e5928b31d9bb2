// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "pose/fit_points.h"
#include "pose/pose.h"
#include "pose/solver.h"

namespace sightline {

/// Squared residuals below this count as zero. It is (1e-6 px)^2, far below any noise and far above
/// rounding; whitened residuals are compared with the same number, in their own unit.
inline constexpr double kZeroResidualPx2 = 1e-12;

/// What of a pose a minimax fit may change.
enum class FreePart { kPose, kRotation, kTranslation };

/// Options of the minimax fit.
struct MinimaxOptions {
  /// Stops when the largest squared residual is proven to be above the least one by no more than
  /// this part of itself.
  double relative_gap = 1e-9;
  FreePart free = FreePart::kPose;  ///< the rest stays as it is at the start
};

/// The pose of least largest squared residual, min over poses of max_i f_i.
struct Minimax {
  /// kOk: the relative gap is at most kMinimaxGap, or what was asked for if that is more, or the
  /// residuals are zero. kBehindCamera: the start has a point behind the camera. kDiverged: no
  /// convergence. minimax() also fails with what least squares fails with.
  PoseStatus status = PoseStatus::kDiverged;
  Pose cam_from_centred;
  double largest_px2 = 0;  ///< max f_i; zero when below kZeroResidualPx2
  /// One for each fitted point, of its constraint f_i <= max: none is negative, and their sum is
  /// one. The points whose multiplier is not (nearly) zero are the support: they alone have the
  /// same minimax.
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
