// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "eval/study/study.h"
#include "eval/summary/summary.h"

namespace sightline {

/// For the terminal: how often features are found, wrong and how far off, a row a cell.
std::string localisation_block(const Study& study, const FeatureStatistics& statistics);

/// For the terminal: how many lines along edges a trial has, how many of them are right, and how
/// honest these are, a row a cell; empty where there are none.
std::string line_block(const Study& study, const FeatureStatistics& statistics);

/// For the terminal, of the features that are to be seen, by cell and by feature, by kind and in
/// all: how many are found, how many of them within 3 px of the truth and how near, how many
/// outliers; and how few of them a trial has. Without the single features where there are many
/// cells.
std::string accuracy_block(const Study& study, const FeatureStatistics& statistics);

/// What became of each feature over all trials, and where its outliers lie.
std::string failure_block(const FeatureStatistics& statistics);

/// The mean geodesic error of every solver with exact projections, with noise alone, with the
/// inliers and with all that was extracted; empty where the study does not ask for those inputs.
std::string impact_block(const Study& study, const Summary& summary);

}  // namespace sightline
