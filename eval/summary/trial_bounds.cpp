// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/trial_bounds.h"

#include <algorithm>
#include <utility>

#include "eval/records/caps.h"
#include "eval/records/line_records.h"
#include "pose/angles.h"
#include "pose/bounds.h"

namespace sightline {
namespace {

// Stands for the noise of a feature that showed none, so that its information is finite.
constexpr double kLeastNoisePx = 1e-3;

}  // namespace

TrialBounds::TrialBounds(const Study& study) : study_(study), noise_px_(study.conditions.size()) {
  for (const TargetFeature& feature : study.pose_study()->target->features) {
    positions_m_.emplace(feature.name, feature.position_m);
  }
}

void TrialBounds::set_noise_px(int condition, std::map<std::string, double> noise_px) {
  noise_px_.at(static_cast<size_t>(condition)) = std::move(noise_px);
}

bool TrialBounds::is_noiseless(int condition) const {
  const NumericStudy* const numeric = study_.numeric();
  return numeric != nullptr && numeric->cells[condition].noise_px == 0;
}

double TrialBounds::noise_px(int condition, const std::string& feature) const {
  const NumericStudy* const numeric = study_.numeric();
  if (numeric != nullptr) return numeric->cells[condition].noise_px;
  return noise_px_[static_cast<size_t>(condition)].at(feature);
}

Eigen::Matrix2d TrialBounds::covariance_px2(const TrialRecord& trial,
                                            const std::string& feature) const {
  const double sd_px = std::max(noise_px(trial.condition, feature), kLeastNoisePx);
  const NumericStudy* const numeric = study_.numeric();
  if (numeric != nullptr &&
      numeric->setup_of(trial.condition).edges.observed != SeenEdges::Observed::kNothing) {
    const NumericSetup& setup = numeric->setup_of(trial.condition);
    const auto of_target =
        std::ranges::find(numeric->target->features, feature, &TargetFeature::name);
    const auto covariance = corner_covariance_px2(setup.edges, *of_target, setup.camera,
                                                  trial.true_cam_from_target, sd_px);
    if (covariance) return *covariance;
  }
  return sd_px * sd_px * Eigen::Matrix2d::Identity();
}

std::optional<TrialBound> TrialBounds::of(const TrialRecord& trial) const {
  if (is_noiseless(trial.condition)) return std::nullopt;
  std::vector<Eigen::Vector3d> points_m;
  std::vector<Eigen::Matrix2d> covariances_px2;
  for (const ObservationRecord& o : trial.observations()) {
    const auto position = positions_m_.find(o.feature);
    if (!o.is_found() || o.is_outlier || position == positions_m_.end()) continue;
    points_m.push_back(position->second);
    covariances_px2.push_back(covariance_px2(trial, o.feature));
  }
  std::vector<LineObservation> lines;
  for (const LineRecord& line : trial.lines()) {
    const auto seen = line_of(line, *study_.pose_study()->target);
    if (seen && line.is_right()) lines.push_back(*seen);
  }
  const auto bound = cramer_rao_bound(study_.camera_of(trial.trial), points_m,
                                      trial.true_cam_from_target, covariances_px2, lines);
  if (!bound) return std::nullopt;
  return TrialBound{bound->covariance, std::min(bound->attitude_rms_rad / kDegree, kAngleCapDeg),
                    std::min(100 * bound->translation_rms, kTranslationCapPercent),
                    std::min(bound->geodesic_rms_rad / kDegree, kAngleCapDeg)};
}

}  // namespace sightline
