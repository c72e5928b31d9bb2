// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The short way to the answer for few points: where small sets of removals explain them clearly.
#pragma once

#include "pose/solver.h"

namespace sightline::consensus {

/// The estimate of consensus from one sweep over small sets of removals (the model of
/// pose/solvers/orpe_weighed.cpp, with outliers that err by the law of mixture.h), which takes some
/// microseconds. Only where that is decisive, and the search would find the same: five to twelve
/// points, all of which can be used, of a target that is clearly solid, so that its mirror pose
/// does not fit; noise that is known; what is kept, five points or more, looks like it; and no
/// other set of points or pose is nearly as probable. Otherwise its status is not kOk.
///
/// Starts where nobody says where to: an initial pose is not needed here, and cannot harm.
PoseEstimate estimate_of_few(const PoseProblem& problem, double false_alarm_rate);

/// The most points that it looks at.
inline constexpr std::size_t kMostOfFew = 12;

}  // namespace sightline::consensus
