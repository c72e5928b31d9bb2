// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What `compare` can judge by. A number is what a trial (or a scored target) has; a measure is what
// becomes of the number over all of them, such as its mean.
#pragma once

#include <limits>
#include <span>
#include <string>
#include <vector>

namespace sightline {

/// What is compared: each has numbers of its own.
enum class Subject { kPoses, kOrientations, kScores };

/// How a number adds up over the trials.
enum class NumberKind {
  kError,      ///< capped, a failure counting as the cap
  kOpenError,  ///< without a cap, a failure counting as infinite: it has no mean
  kFlag,       ///< true or not of each trial; told as the share of the trials
  kRate,       ///< a part of a whole, each summed over the trials
  kCount,      ///< told as the mean of a trial
  kRms,        ///< a sum of squares and how many they are, each summed over the trials
};

struct TrialNumber {
  std::string name;  ///< as in summary.json, results.csv and scores.json
  std::string meaning;
  NumberKind kind = NumberKind::kError;
  double cap = std::numeric_limits<double>::infinity();  ///< of kError
  bool is_more_better = false;
  bool is_of_features = false;  ///< of a condition's images, whatever the solver

  /// Rates change by so many parts of one, all others by so many parts of their value.
  bool is_rate() const { return kind == NumberKind::kFlag || kind == NumberKind::kRate; }
};

/// What is made of a number that errors are; kWhole of all other numbers, which have one measure.
enum class Statistic { kMean, kMiddle, kMedian, kP90, kRms, kWhole };

struct Measure {
  std::string name;  ///< "geodesic_deg.middle", "found_rate"
  TrialNumber number;
  Statistic statistic = Statistic::kWhole;
};

/// Every number of a subject.
std::vector<TrialNumber> trial_numbers(Subject subject);

/// Every measure of a subject.
std::vector<Measure> measures_of(Subject subject);

/// Those that decide where nobody names any: mean and middle of the geodesic error and of T_error
/// and the failures; of scores also the recalls.
std::vector<Measure> default_measures(Subject subject);

/// The measures of these names, which may be lists with commas; an error's name alone stands for
/// its mean and its middle. The default ones of no names. Throws InputError for a name that the
/// subject has not, with the nearest that it has.
std::vector<Measure> find_measures(std::span<const std::string> names, Subject subject);

/// What `sightline list measures` prints.
std::string measures_list();

}  // namespace sightline
