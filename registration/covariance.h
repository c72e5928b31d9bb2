// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "registration/adaptive_solve.h"

namespace sightline {

/// The covariance of a registered pose.
struct PoseSpread {
  Matrix6d covariance = Matrix6d::Zero();
  /// How much larger the covariance is that the blocks' own disagreement shows, over the one of
  /// independent pixels: trace(C^-1 S) / 6, S the sandwich over clusters of blocks.
  double cluster_factor = 1;
};

/// The inverse of the solution's information, enlarged by what the residuals and the disagreement
/// of neighbouring blocks show beyond noise.
PoseSpread pose_spread(const BlockRows& rows, const Solution& solution, const FitQuality& quality);

}  // namespace sightline
