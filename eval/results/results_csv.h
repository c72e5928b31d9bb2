// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <ostream>
#include <set>
#include <string>
#include <vector>

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

/// Neighbouring columns of a CSV file that mean one thing: one column, or the numbers of a pose.
struct CsvColumns {
  std::vector<std::string> names;
  std::string unit;  ///< empty of what has none
  std::string meaning;
};

/// The columns of results.csv of a study with solvers, from left to right. `keys` are the keys that
/// its conditions sweep; only data sets have sightings.
std::vector<CsvColumns> estimate_columns(const std::set<std::string>& keys, bool has_sightings);
/// The columns of results.csv of an orientation study.
std::vector<CsvColumns> orientation_columns(const std::set<std::string>& keys);
/// The columns of timings.csv.
std::vector<CsvColumns> timing_columns(const std::set<std::string>& keys);

}  // namespace sightline
