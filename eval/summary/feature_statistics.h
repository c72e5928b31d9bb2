// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "eval/records/records.h"
#include "eval/statistics/error_statistics.h"
#include "eval/statistics/statistics.h"
#include "eval/study/study.h"
#include "eval/summary/localisation.h"

namespace sightline {

inline constexpr int kAllConditions = -1;

/// What became of one feature in one cell, or in all of them.
struct FeatureSummary {
  int condition = 0;  ///< or kAllConditions
  std::string feature;
  int visible = 0;
  int found = 0;
  int outliers = 0;
  double inlier_rms_px = kNoNumber;          ///< of one coordinate; NaN of none
  double median_px = kNoNumber;              ///< of all that were found, outliers too; NaN of none
  int trials = 0;                            ///< that were imaged
  std::map<std::string, int64_t> missing{};  ///< how often it was not found, by status
};

/// How many features a trial has: of one cell.
struct FeatureCounts {
  int64_t trials = 0;
  int fewest_visible = 0;
  int fewest_inliers = 0;
  int64_t few_inliers = 0;  ///< trials with fewer than kFewFeatures

  void add(const TrialRecord& trial);
};

/// The lines along edges of one cell.
struct LineCounts {
  int64_t trials = 0;
  int64_t lines = 0;
  int64_t right = 0;
  double right_squares = 0;   ///< of the right lines' errors, in units of their own noise
  int64_t right_numbers = 0;  ///< that these lines state: offset, and slope where it is known

  void add(const TrialRecord& trial);
  void add(const LineCounts& other);
  /// Root mean square of a right line's error in its own sigmas, one number: 1 is honest.
  double rms_sigmas() const;
};

inline constexpr int kFewFeatures = 5;  ///< the paper has five: with fewer no outlier shows

/// What became of features, gathered in one pass over the trials: by feature in each cell and over
/// all cells; of a study of images also how well they were localised, by cell and by kind too. It
/// keeps ErrorStatistics::kMostValuesKept errors of each and no more.
class FeatureStatistics {
 public:
  explicit FeatureStatistics(const Study& study);

  void add(const TrialRecord& trial);

  /// By condition, then in the study's order. A feature that no trial of a cell has is left out.
  std::vector<FeatureSummary> summaries() const;
  /// One feature over all trials.
  FeatureSummary over_all_trials(const std::string& feature) const;
  /// What the found inliers err in one coordinate, RMS, by feature; NaN where there are none.
  std::map<std::string, double> inlier_rms_px(int condition) const;

  /// Of a study of images. Nothing of features that the study does not have.
  Localisation of_cell(int condition) const;
  Localisation of_feature(const std::string& feature) const;
  Localisation of(int condition, const std::string& feature) const;
  Localisation of_kind(int condition, FeatureKind kind) const;
  const FeatureCounts& counts(int condition) const { return cell(condition).counts; }

  const LineCounts& lines(int condition) const { return cell(condition).lines; }

  /// The study's, in its order.
  const std::vector<std::string>& features() const { return names_; }

 private:
  // One feature, in one cell or over all.
  struct Feature {
    FeatureSummary summary;
    MeanSquare inlier_error_px;  // of one coordinate
    ErrorStatistics error_px{std::numeric_limits<double>::infinity()};
    LocalisationStatistics localisation;

    void add(const ObservationRecord& observation);
    FeatureSummary finished() const;
  };
  // The study's features in its order, then others in the order in which they come.
  using Features = std::vector<Feature>;

  struct Cell {
    Features features;
    LocalisationStatistics all;
    std::array<LocalisationStatistics, kFeatureKinds.size()> kinds;
    FeatureCounts counts;
    LineCounts lines;
  };

  Features features_of_study(int condition) const;
  static size_t index_of(Features& features, const std::string& name, size_t guess, int condition);
  void end_trial(Cell& cell);
  const Cell& cell(int condition) const { return cells_[static_cast<size_t>(condition)]; }

  bool has_images_;
  std::vector<std::string> names_;
  std::vector<FeatureKind> kinds_;  // of the features named
  std::vector<Cell> cells_;         // by condition
  Features over_all_;
};

}  // namespace sightline
