// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "eval/doors/trial_solver.h"

namespace sightline {

/// The Cramér-Rao bounds of each trial's image as solvers of a trial, for evaluation alone:
/// image_bound (light, gain and offset unknown) and outline_bound (the outline alone). Their pose
/// is the truth with an error drawn from the bound's covariance, which they report: what an
/// estimator errs that uses all of the image. `seed` is the study's.
std::vector<TrialSolver> image_bound_solvers(uint64_t seed);

}  // namespace sightline
