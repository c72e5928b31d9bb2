// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "eval/records/records.h"
#include "eval/statistics/error_statistics.h"
#include "eval/study/study.h"
#include "eval/summary/trial_bounds.h"

namespace sightline {

/// A step of the ladder from what an image says of a pose to what a solver makes of it: by which
/// factor errors grow from one rung to the next, the geometric mean over the trials that have both,
/// conditions alike, with the interval of that mean.
struct LadderStep {
  std::string from, to;  ///< in words for readers
  int64_t trials = 0;
  Measured geodesic;     ///< of the geodesic angles
  Measured translation;  ///< of the translations' lengths
};

/// Puts the bounds of the image, of the target's outline and of the points found beside what
/// solvers made of the same trials. A bound's error is the mean logarithm of errors drawn from its
/// covariance, so that an estimator that attains a bound stands at a factor of 1 of it. Errors are
/// capped, and a failed trial counts as the cap, as everywhere.
class Ladder {
 public:
  /// Without steps of a study whose trials have no bound of the image (`bound.image`).
  explicit Ladder(const Study& study);

  /// `points`: the bound of the points found, where these determine a pose.
  void add(const TrialRecord& trial, const std::optional<TrialBound>& points);

  std::vector<LadderStep> steps() const;

 private:
  // A bound or a solver of which trials may have an error.
  struct Rung {
    std::string name;   // the solver's; of the points' bound empty
    std::string label;  // for readers
    bool is_bound = false;
  };
  // The logarithms of a rung's geodesic and translation error; none where there is no such error.
  using LogErrors = std::optional<std::array<double, 2>>;
  struct Step {
    size_t from, to;                        // rungs
    std::array<ErrorStatistics, 2> growth;  // of the logarithms
  };

  void add_step(size_t from, size_t to);
  LogErrors log_errors(const Rung& rung, const TrialRecord& trial,
                       const std::optional<TrialBound>& points) const;

  uint64_t seed_;
  std::vector<Rung> rungs_;
  std::vector<Step> steps_;
};

}  // namespace sightline
