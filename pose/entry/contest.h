// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pose/solver.h"

namespace sightline::entry {

/// Takes the answer from starts of the solver's own in the place of `estimate`, which is the one
/// from the problem's initial pose, where that is clearly better.
///
/// An initial pose is knowledge: between poses that explain the points about alike, as the two
/// mirror poses of a plane do from far away, it decides. It loses where the solver finds nothing
/// from it, and where the residuals from a free start are smaller by more than one of ten thousand
/// pairs of estimates of one variance differ. The free start is not even tried where the points are
/// clearly solid and their residuals look like noise of the size that is known.
///
/// A point behind the initial pose is no reason to refuse: the free start is one answer then, the
/// points in front alone are another, and the latter needs to be clearly better.
void contest(const PoseSolver& solver, const PoseProblem& problem, const SolverOptions& options,
             PoseEstimate& estimate);

}  // namespace sightline::entry
