// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/feature_statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace sightline {

void FeatureCounts::add(const TrialRecord& trial) {
  int visible = 0, inliers = 0;
  for (const ObservationRecord& o : trial.observations()) {
    visible += o.is_visible;
    inliers += o.is_visible && o.is_found() && !o.is_outlier;
  }
  fewest_visible = trials == 0 ? visible : std::min(fewest_visible, visible);
  fewest_inliers = trials == 0 ? inliers : std::min(fewest_inliers, inliers);
  few_inliers += inliers < kFewFeatures;
  ++trials;
}

void LineCounts::add(const TrialRecord& trial) {
  ++trials;
  for (const LineRecord& line : trial.lines()) {
    ++lines;
    if (!line.is_right()) continue;
    ++right;
    right_squares += line.error_sigmas * line.error_sigmas;
    right_numbers += std::isfinite(line.slope_variance) ? 2 : 1;
  }
}

void LineCounts::add(const LineCounts& other) {
  trials += other.trials;
  lines += other.lines;
  right += other.right;
  right_squares += other.right_squares;
  right_numbers += other.right_numbers;
}

double LineCounts::rms_sigmas() const {
  return std::sqrt(right_squares / static_cast<double>(right_numbers));
}

void FeatureStatistics::Feature::add(const ObservationRecord& observation) {
  ++summary.trials;
  summary.visible += observation.is_visible;
  summary.outliers += observation.is_outlier;
  if (!observation.is_found()) {
    ++summary.missing[std::string(to_string(observation.status))];
    return;
  }
  ++summary.found;
  error_px.add(observation.error_px);
  if (!observation.is_outlier) inlier_error_px.add(observation.error_px / std::numbers::sqrt2);
}

FeatureSummary FeatureStatistics::Feature::finished() const {
  FeatureSummary finished = summary;
  finished.inlier_rms_px = inlier_error_px.root();
  finished.median_px = error_px.quantile(0.5);
  return finished;
}

FeatureStatistics::FeatureStatistics(const Study& study)
    : has_images_(study.images() != nullptr), cells_(study.conditions.size()) {
  const PoseStudy& of_target = *study.pose_study();
  for (const int index : of_target.features) {
    const TargetFeature& feature = of_target.target->features[static_cast<size_t>(index)];
    names_.push_back(feature.name);
    kinds_.push_back(feature.kind);
  }
  over_all_ = features_of_study(kAllConditions);
  for (size_t i = 0; i < cells_.size(); ++i) {
    cells_[i].features = features_of_study(static_cast<int>(i));
  }
}

FeatureStatistics::Features FeatureStatistics::features_of_study(int condition) const {
  Features features(names_.size());
  for (size_t i = 0; i < names_.size(); ++i) {
    features[i].summary.condition = condition;
    features[i].summary.feature = names_[i];
  }
  return features;
}

// Every trial that was imaged has an observation of every feature, in the study's order.
size_t FeatureStatistics::index_of(Features& features, const std::string& name, size_t guess,
                                   int condition) {
  const auto is_it = [&](const Feature& feature) { return feature.summary.feature == name; };
  if (guess < features.size() && is_it(features[guess])) return guess;
  const auto found = std::find_if(features.begin(), features.end(), is_it);
  const auto index = static_cast<size_t>(found - features.begin());
  if (found == features.end()) {
    FeatureSummary& summary = features.emplace_back().summary;
    summary.condition = condition;
    summary.feature = name;
  }
  return index;
}

void FeatureStatistics::add(const TrialRecord& trial) {
  Cell& cell = cells_.at(static_cast<size_t>(trial.condition));
  for (size_t i = 0; i < trial.observations().size(); ++i) {
    const ObservationRecord& observation = trial.observations()[i];
    const size_t here = index_of(cell.features, observation.feature, i, trial.condition);
    cell.features[here].add(observation);
    over_all_[index_of(over_all_, observation.feature, i, kAllConditions)].add(observation);
    if (!has_images_) continue;
    cell.all.add(observation);
    if (here >= names_.size()) continue;  // not one of the study's
    cell.features[here].localisation.add(observation);
    over_all_[here].localisation.add(observation);
    cell.kinds[static_cast<size_t>(kinds_[here])].add(observation);
  }
  cell.lines.add(trial);
  if (!has_images_) return;
  end_trial(cell);
  cell.counts.add(trial);
}

void FeatureStatistics::end_trial(Cell& cell) {
  cell.all.end_trial();
  for (size_t i = 0; i < names_.size(); ++i) {
    cell.features[i].localisation.end_trial();
    over_all_[i].localisation.end_trial();
  }
  for (LocalisationStatistics& of_kind : cell.kinds) of_kind.end_trial();
}

std::vector<FeatureSummary> FeatureStatistics::summaries() const {
  std::vector<FeatureSummary> all;
  for (const Cell& cell : cells_) {
    for (const Feature& feature : cell.features) {
      if (feature.summary.trials > 0) all.push_back(feature.finished());
    }
  }
  return all;
}

FeatureSummary FeatureStatistics::over_all_trials(const std::string& feature) const {
  for (const Feature& f : over_all_) {
    if (f.summary.feature == feature) return f.finished();
  }
  FeatureSummary nothing;
  nothing.condition = kAllConditions;
  nothing.feature = feature;
  return nothing;
}

std::map<std::string, double> FeatureStatistics::inlier_rms_px(int condition) const {
  std::map<std::string, double> rms_px;
  for (const Feature& feature : cell(condition).features) {
    rms_px[feature.summary.feature] = feature.inlier_error_px.root();
  }
  return rms_px;
}

Localisation FeatureStatistics::of_cell(int condition) const {
  return cell(condition).all.summary();
}

Localisation FeatureStatistics::of_feature(const std::string& feature) const {
  const auto found = std::find(names_.begin(), names_.end(), feature);
  if (found == names_.end()) return {};
  return over_all_[static_cast<size_t>(found - names_.begin())].localisation.summary();
}

Localisation FeatureStatistics::of(int condition, const std::string& feature) const {
  const auto found = std::find(names_.begin(), names_.end(), feature);
  if (found == names_.end()) return {};
  return cell(condition)
      .features[static_cast<size_t>(found - names_.begin())]
      .localisation.summary();
}

Localisation FeatureStatistics::of_kind(int condition, FeatureKind kind) const {
  return cell(condition).kinds[static_cast<size_t>(kind)].summary();
}

}  // namespace sightline
