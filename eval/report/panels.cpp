// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/panels.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/output/words.h"
#include "eval/summary/quantities.h"

namespace sightline {
namespace {

constexpr const char* kGivenPose = "pose";  // a number that is no quantity
constexpr size_t kMostGroups = 12;
constexpr double kSpread = 0.6;  // of the room between two places

using Values = std::map<std::string, std::set<std::string>>;

std::string shown(double value) {
  return fmt::format("{}", value);
}

// What is swept, and its values.
Values swept_values(const Study& study) {
  Values values;
  for (const Condition& condition : study.conditions) {
    for (const auto& [key, value] : condition.values) values[key].insert(shown(value));
    for (const auto& [key, value] : condition.words) values[key].insert(value);
  }
  std::erase_if(values, [](const auto& entry) { return entry.second.size() < 2; });
  return values;
}

// The key of numbers with the most values; empty where there is none.
std::string axis_key(const Study& study, const Values& values) {
  std::string best;
  for (const auto& of_key : values) {
    const std::string& key = of_key.first;
    const bool is_number = std::all_of(study.conditions.begin(), study.conditions.end(),
                                       [&](const Condition& c) { return c.values.contains(key); });
    if (key == kGivenPose || !is_number) continue;
    if (best.empty() || of_key.second.size() > values.at(best).size()) best = key;
  }
  return best;
}

// "noise_px" becomes "noise, px".
std::string key_label(const std::string& key) {
  static constexpr std::array<std::array<std::string_view, 2>, 6> kUnits = {
      {{"_px", "px"},
       {"_m", "m"},
       {"_deg", "°"},
       {"_percent", "%"},
       {"_grey", "grey levels"},
       {"_electrons", "electrons"}}};
  for (const auto& [ending, unit] : kUnits) {
    if (!key.ends_with(ending)) continue;
    return fmt::format("{}, {}", words(key.substr(0, key.size() - ending.size())), unit);
  }
  return words(key);
}

// The swept values of a condition other than that of the axis.
std::string rest_of(const Condition& condition, const Values& values, const std::string& axis) {
  std::string text;
  for (const auto& [key, of_key] : values) {
    if (key == axis) continue;
    const auto number = condition.values.find(key);
    const std::string value =
        number != condition.values.end() ? shown(number->second) : condition.words.at(key);
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", words(key), value);
  }
  return text;
}

SweepPanel panel_of_words(const Study& study) {
  SweepPanel panel;
  for (size_t i = 0; i < study.conditions.size(); ++i) {
    panel.axis.names.push_back(study.conditions[i].label);
    panel.conditions.push_back(static_cast<int>(i));
    panel.x.push_back(static_cast<double>(i));
  }
  return panel;
}

void sort_by_x(SweepPanel& panel, const Study& study, const std::string& key) {
  const auto x_of = [&](int c) { return study.conditions[c].values.at(key); };
  std::stable_sort(panel.conditions.begin(), panel.conditions.end(),
                   [&](int a, int b) { return x_of(a) < x_of(b); });
  for (const int condition : panel.conditions) panel.x.push_back(x_of(condition));
  choose_sweep_scale(panel.axis, panel.x);
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Infinite where there is no pose.
double estimate_error(const TrialRecord& trial, size_t solver, double EstimateRecord::*error) {
  if (solver >= trial.estimates().size()) return kInfinity;
  const EstimateRecord& estimate = trial.estimates()[solver];
  return estimate.is_ok() && estimate.*error >= 0 ? estimate.*error : kInfinity;
}

// A mean over a trial's copies, in which a failed copy counts as the cap already.
double copies_error(const TrialRecord& trial, size_t method, double OrientationRecord::*error) {
  if (method >= trial.orientations().size()) return kInfinity;
  const double value = trial.orientations()[method].*error;
  return value >= 0 ? value : kInfinity;
}

TrialError error_of_poses(const Quantity& quantity) {
  return {quantity.id, quantity.label, quantity.cap,
          [error = quantity.of_estimate](const TrialRecord& trial, size_t solver) {
            return estimate_error(trial, solver, error);
          }};
}

TrialError error_of_orientations(const Quantity& quantity) {
  return {quantity.id, quantity.label, quantity.cap,
          [error = quantity.of_orientation](const TrialRecord& trial, size_t method) {
            return copies_error(trial, method, error);
          }};
}

}  // namespace

std::vector<SweepPanel> sweep_panels(const Study& study) {
  if (study.conditions.size() < 2) return {};
  const Values values = swept_values(study);
  const std::string key = axis_key(study, values);
  if (key.empty()) return {panel_of_words(study)};
  std::vector<SweepPanel> panels;
  for (size_t i = 0; i < study.conditions.size(); ++i) {
    const std::string option = rest_of(study.conditions[i], values, key);
    auto panel = std::find_if(panels.begin(), panels.end(),
                              [&](const SweepPanel& p) { return p.option == option; });
    if (panel == panels.end()) {
      panel = panels.insert(panels.end(), SweepPanel{option, {key_label(key)}, {}, {}});
    }
    panel->conditions.push_back(static_cast<int>(i));
  }
  for (SweepPanel& panel : panels) sort_by_x(panel, study, key);
  return panels;
}

double beside(double place, size_t index, size_t count) {
  if (count < 2) return place;
  return place + kSpread * (static_cast<double>(index) / static_cast<double>(count - 1) - 0.5);
}

std::vector<TrialError> trial_errors(const Study& study) {
  const bool is_orientation = study.orientation() != nullptr;
  std::vector<TrialError> errors;
  for (const Quantity& quantity : quantities()) {
    if (is_orientation && quantity.in_orientation_studies.is_charted) {
      errors.push_back(error_of_orientations(quantity));
    }
    if (!is_orientation && quantity.in_pose_studies.is_charted) {
      errors.push_back(error_of_poses(quantity));
    }
  }
  return errors;
}

TrialError geodesic_error() {
  return error_of_poses(quantity("geodesic_deg"));
}

std::string label_in(const Study& study, const std::string& solver) {
  return words(study.orientation() != nullptr ? solver : solver_label(solver));
}

std::vector<TrialGroup> trial_groups(const Study& study) {
  const size_t conditions = study.conditions.size();
  if (conditions < 2) return {{"", -1}};
  std::vector<TrialGroup> groups = {{"all conditions", -1}};
  for (size_t i = 0; i < std::min(conditions, kMostGroups); ++i) {
    groups.push_back({study.conditions[i].label, static_cast<int>(i)});
  }
  return groups;
}

std::string outlier_limit_px(const ImageStudy& study) {
  std::set<double> limits;
  for (const ImageSetup& setup : study.setups) limits.insert(setup.limits.outlier_px);
  const std::string last = fmt::to_string(*limits.rbegin());
  if (limits.size() == 1) return last;
  limits.erase(std::prev(limits.end()));
  return fmt::format("the swept {} or {}", fmt::join(limits, ", "), last);
}

std::string chart_id(const std::string& group, size_t number) {
  return fmt::format("{}-{}", group, number + 1);
}

}  // namespace sightline
