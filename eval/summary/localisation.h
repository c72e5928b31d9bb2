// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "eval/records/records.h"
#include "eval/study/study.h"

namespace sightline {

/// A number and its 95 % interval; NaN where nothing was measured.
struct Measured {
  double value = std::numeric_limits<double>::quiet_NaN();
  std::array<double, 2> ci95{value, value};
};

/// The ratio of two sums over trials, such as features found over features to be seen. Features of
/// one trial share its light, background and prior, so that the trial is what is drawn: the
/// variance is that of a ratio of means over clusters (Cochran, Sampling Techniques, 3rd ed. 1977,
/// eq. 6.13, with trials as the sample). Five sums, whatever the number of trials.
class ClusteredRatio {
 public:
  void add(double numerator, double denominator);
  double value() const;
  /// Symmetric, by the normal law; none of fewer than two trials.
  Measured measured() const;
  /// For a rate: Wilson's interval of as many independent draws as have the same variance, so that
  /// it stays within 0 and 1 and says something where nothing or everything happened.
  Measured rate() const;
  double denominator() const { return denominator_; }

 private:
  double variance() const;

  int64_t trials_ = 0;
  double numerator_ = 0, denominator_ = 0;
  double numerator2_ = 0, denominator2_ = 0, product_ = 0;
};

inline constexpr double kNearPx = 3;  ///< from the truth: near enough for any pose

/// How well and how often features were found: of one feature or of all, in one cell.
struct Localisation {
  int64_t visible = 0;
  int64_t found = 0;
  Measured found_rate;    ///< of those that are to be seen
  Measured outlier_rate;  ///< of those found
  // Of those that are to be seen alone:
  Measured near_rate;          ///< found within kNearPx of the truth
  Measured seen_outlier_rate;  ///< outliers of those found
  /// Of those within kNearPx, the distance from the truth: its median and its root mean square.
  double near_median_px = std::numeric_limits<double>::quiet_NaN();
  double near_rms_px = std::numeric_limits<double>::quiet_NaN();
  Measured rms_px;     ///< of the inliers' error, one coordinate
  Measured bias_u_px;  ///< mean error of the inliers
  Measured bias_v_px;
  Measured rms_sigmas;  ///< of the inliers' error in its own sigmas, one coordinate: 1 is honest
  std::map<ObservationLabel, int64_t> labels;  ///< how many observations bear each label
  /// Of the outliers: the 10th, 50th and 90th percentile of their distance from the truth, and the
  /// mean of the unit vectors towards them (long where they all lie to one side).
  std::array<double, 3> outlier_px{};
  std::array<double, 2> outlier_side{};
};

/// Gathers observations trial by trial.
class LocalisationStatistics {
 public:
  /// All observations of a trial, or those of these features where any are named.
  void add(const TrialRecord& trial, std::span<const std::string> features = {});
  Localisation summary() const;

 private:
  ClusteredRatio found_, outliers_, near_, seen_outliers_, squares_px2_, bias_u_px_, bias_v_px_,
      squares_sigmas_;
  std::map<ObservationLabel, int64_t> labels_;
  int64_t visible_ = 0, found_count_ = 0, outlier_count_ = 0;
  double side_u_ = 0, side_v_ = 0;
  std::vector<double> outlier_px_, near_px_;  // of the first kMostKept
  static constexpr size_t kMostKept = 100'000;
};

/// How many features a trial has: of one cell.
struct FeatureCounts {
  int64_t trials = 0;
  int fewest_visible = 0;
  int fewest_inliers = 0;
  int64_t few_inliers = 0;  ///< trials with fewer than kFewFeatures

  void add(const TrialRecord& trial);
};

inline constexpr int kFewFeatures = 5;  ///< the paper has five: with fewer no outlier shows

/// What an image study says of the extraction of features: by cell, by feature over all cells, and
/// by feature in each cell.
class ExtractionStatistics {
 public:
  explicit ExtractionStatistics(const Study& study);

  void add(const TrialRecord& trial);

  Localisation of_cell(int condition) const;
  Localisation of_feature(const std::string& feature) const;
  Localisation of(int condition, const std::string& feature) const;
  Localisation of_kind(int condition, FeatureKind kind) const;
  const FeatureCounts& counts(int condition) const { return counts_[condition]; }
  /// In the study's order.
  const std::vector<std::string>& features() const { return features_; }

 private:
  std::vector<std::string> features_;
  std::array<std::vector<std::string>, kFeatureKinds.size()> of_kind_;  // features
  std::vector<LocalisationStatistics> cells_;
  std::vector<LocalisationStatistics> of_features_;
  std::vector<std::vector<LocalisationStatistics>> of_both_;  // by condition, then feature
  std::vector<std::array<LocalisationStatistics, kFeatureKinds.size()>> of_kinds_;  // by condition
  std::vector<FeatureCounts> counts_;                                               // alike
};

}  // namespace sightline
