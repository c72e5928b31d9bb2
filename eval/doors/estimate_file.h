// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Poses that somebody else's pipeline estimated, as a file has them.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "eval/datasets/sightings.h"
#include "eval/doors/trial_solver.h"
#include "scenes/scene/keys.h"

namespace sightline {

enum class EstimateFormat {
  kByHeader,   ///< which of the others its first line says
  kBop,        ///< BOP results CSV
  kSpeed,      ///< filename, then q0 to q3 and three coordinates in metres, as ESA's challenges
  kSightline,  ///< results.csv of a run
};

/// What a study says of a file of estimates: a table of [[estimates]].
struct EstimateSource {
  std::string name;  ///< of the solver
  std::filesystem::path file;
  EstimateFormat format = EstimateFormat::kByHeader;
};

std::vector<Key> keys_of(EstimateSource& source);

/// A solver that answers with what the file has for a trial: BOP's results and ESA's by the trial's
/// picture (of several instances in a picture each estimate goes to the nearest, best score first;
/// without a data set the best score counts), results.csv by the trial's number. `set` is the data
/// set that the trials show, null where they are rendered or numeric; then pictures are named as
/// TrialName says, and poses are of the target's own frame. Of results.csv the estimates of the
/// solver with the source's name count, or of the only one. Throws InputError, with file and line,
/// for whatever is not so.
TrialSolver recorded_solver(const EstimateSource& source, const SightedSet* set);

}  // namespace sightline
