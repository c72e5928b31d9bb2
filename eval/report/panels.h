// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "eval/records/records.h"
#include "eval/report/chart.h"
#include "eval/study/study.h"

namespace sightline {

// What charts of a study have in common.

/// Conditions that stand on one axis: those that differ in what is swept with the most values.
struct SweepPanel {
  std::string option;           ///< the value of whatever else is swept; empty of a single panel
  ChartAxis axis;               ///< of words where what is swept is no number, or a given pose
  std::vector<int> conditions;  ///< by x
  std::vector<double> x;        ///< of each condition
};

/// Every condition in one panel. Empty of a study with one condition.
std::vector<SweepPanel> sweep_panels(const Study& study);

/// Where the series `index` of `count` stands beside a place of an axis of words.
double beside(double place, size_t index, size_t count);

/// One of the errors that a study is judged by, of a single trial.
struct TrialError {
  std::string id;     ///< "theta", for names of files
  std::string label;  ///< "θ error, °"
  double cap = 0;
  /// By the solver's place in the study; infinite where it has no pose.
  std::function<double(const TrialRecord& trial, size_t solver)> of;
};

std::vector<TrialError> trial_errors(const Study& study);
/// The angle of the one rotation between estimate and truth.
TrialError geodesic_error();

/// A solver's or a method's name for readers.
std::string label_in(const Study& study, const std::string& solver);

/// Trials by what a reader may choose: all first, then each condition (of a dozen at most), where
/// there are several.
struct TrialGroup {
  std::string option;  ///< "all conditions", "pose 1"; empty of a study with one
  int condition = -1;  ///< or -1 for all

  bool holds(const TrialRecord& trial) const {
    return condition < 0 || trial.condition == condition;
  }
};

std::vector<TrialGroup> trial_groups(const Study& study);

/// How far from the truth, in pixels, a feature of an image study is an outlier: "5", or "the swept
/// 2, 5 or 8" where conditions differ in it. "0" of another study.
std::string outlier_limit_px(const ImageStudy& study);

/// "cumulative-theta-2": an id of the chart with this number in its group.
std::string chart_id(const std::string& group, size_t number);

}  // namespace sightline
