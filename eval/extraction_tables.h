// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "eval/localisation.h"
#include "eval/study.h"
#include "eval/summary.h"

namespace sightline {

/// What an image study says of the extraction of features: by cell, by feature over all cells, and
/// by feature in each cell.
class ExtractionStatistics {
 public:
  explicit ExtractionStatistics(const Study& study);

  void add(const TrialRecord& trial);

  Localisation of_cell(int condition) const;
  Localisation of_feature(const std::string& feature) const;
  Localisation of(int condition, const std::string& feature) const;
  /// In the study's order.
  const std::vector<std::string>& features() const { return features_; }

 private:
  std::vector<std::string> features_;
  std::vector<LocalisationStatistics> cells_;
  std::vector<LocalisationStatistics> of_features_;
  std::vector<std::vector<LocalisationStatistics>> of_both_;  // by condition, then feature
};

/// For the terminal: how often features are found, wrong and how far off, a row a cell.
std::string localisation_block(const Study& study, const ExtractionStatistics& statistics);

/// What became of each feature over all trials, and where its outliers lie.
std::string failure_block(const ExtractionStatistics& statistics);

/// The mean geodesic error of every solver with exact projections, with noise alone, with the
/// inliers and with all that was extracted; empty where the study does not ask for those inputs.
std::string impact_block(const Study& study, const Summary& summary);

/// summary.json's "extraction": a list of cells, each with its features.
std::string to_json(const Study& study, const ExtractionStatistics& statistics);

}  // namespace sightline
