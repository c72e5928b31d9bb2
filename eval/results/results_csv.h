// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <ostream>

#include "eval/records/records.h"
#include "eval/study/study.h"

namespace sightline {

/// Writes results.csv: one row a trial and solver, by trial and then in the study's order; no wall
/// times. Of a data set's image also its path in the set, scene_id, im_id and gt_id (see Sighting).
/// RFC 4180 but for its line ends, which are "\n". A failed trial's numbers are empty
/// fields, but for the removals, which count as in CellSummary. Quaternions are scalar first.
void write_csv(const Study& study, const TrialSource& trials, std::ostream& out);

/// Writes timings.csv: one row a trial and method, as in results.csv, with the mean wall time of a
/// solve.
void write_timings_csv(const Study& study, const TrialSource& trials, std::ostream& out);

}  // namespace sightline
