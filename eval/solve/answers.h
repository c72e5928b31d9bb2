// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The answers of `sightline solve` and `sightline align`, for readers and for programs.
#pragma once

#include <string>
#include <vector>

#include "pose/entry/all_poses.h"
#include "pose/robust_alignment.h"
#include "pose/solver.h"

namespace sightline {

/// The pose with 95 % intervals, the points that were taken for outliers or could not be used, and
/// a warning where it should not be trusted; of a status other than kOk that alone.
std::string text_of(const PoseProblem& problem, const PoseEstimate& estimate);
/// The same as JSON, everything the estimate has.
std::string json_of(const PoseProblem& problem, const PoseEstimate& estimate);

/// All poses that explain the points but those of `left_out`, the best first, each with the root
/// mean square of its residuals (in u and in v, px; with sigmas of points in their unit).
std::string text_of(const PoseProblem& problem, const PoseMinima& minima,
                    const std::vector<int>& left_out);
std::string json_of(const PoseProblem& problem, const PoseMinima& minima,
                    const std::vector<int>& left_out);

std::string text_of(const RobustAlignment& alignment);
std::string json_of(const RobustAlignment& alignment);

}  // namespace sightline
