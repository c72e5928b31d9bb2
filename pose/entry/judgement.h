// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pose/solver.h"

namespace sightline::entry {

/// Adds to an estimate of status ok what its solver did not say itself: the root mean square of the
/// residuals, whether they look like noise, whether chance would explain that the points agree, and
/// for targets that are not clearly solid whether another pose, the mirror pose of a plane or
/// another one of three points, explains the kept points nearly as well, which is then the second
/// pose. A solver that started from an initial pose alone and saw no other is corrected.
void judge(const PoseProblem& problem, PoseEstimate& estimate);

}  // namespace sightline::entry
