// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "eval/records/records.h"
#include "eval/results/store.h"
#include "eval/work/shard.h"

namespace sightline {

struct Study;

/// What the store of a whole run holds. A folder of others may have been edited: trials may be
/// missing, which would be missing from every mean, or say what cannot be.
struct ExpectedTrials {
  int64_t count = 0;  ///< of all shards
  Shard shard;        ///< which of them the store has
  int64_t conditions = 1;
  std::vector<std::string> solvers;     ///< of each trial, or methods, in their order
  std::vector<std::string> features{};  ///< of each trial that was imaged; empty: not known
};

/// What a run of the study has; the store's own meta says which shard it is.
ExpectedTrials expected_trials(const Study& study, const Store& store);
/// The same of which a summary alone is known: the names of the solvers, and how many conditions.
ExpectedTrials expected_trials(const Store& store, int64_t conditions,
                               std::vector<std::string> solvers);

/// Trials one by one as they are handed out by their numbers, each once it is seen to be what is
/// expected: its number and condition, an estimate of every solver with finite poses and errors
/// where it is ok, an observation of every feature, or of none. Throws InputError that names the
/// store and the trial, of a trial that is missing as of one that is wrong. Both must outlive it.
NextTrial checked_reader(const Store& store, const ExpectedTrials& expected);

}  // namespace sightline
