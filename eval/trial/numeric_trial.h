// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

#include "eval/records/records.h"
#include "eval/study/study.h"

namespace sightline {

/// Runs trial number `index` of a numeric study with this seed: a drawn pose, the exact projections
/// of the target's features (none hides another, and the image has no border), Gaussian noise,
/// planted outliers, and what the solvers make of them. A point is an outlier if and only if it was
/// planted. It depends on nothing else. With a feature behind the camera it
/// is a failed trial, without observations.
TrialRecord run_numeric_trial(const NumericStudy& study, uint64_t seed, int64_t index);

}  // namespace sightline
