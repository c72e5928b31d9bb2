// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "eval/records/records.h"
#include "eval/study/study.h"

namespace sightline {

/// Runs trial number `index` of an orientation study: one draw of points, rotation and translation,
/// and of it the study's number of noisy copies, which every method solves. It depends on nothing
/// but the study and the index, except for the times of a study that takes them: those are of the
/// first copy, solved again and again.
TrialRecord run_orientation_trial(const OrientationStudy& study, uint64_t seed, int64_t index);

}  // namespace sightline
