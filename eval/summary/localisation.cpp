// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/localisation.h"

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

// The ends of an interval of squares, as roots.
Measured root_of(const Measured& squares) {
  const auto root = [](double x) { return std::sqrt(std::max(0.0, x)); };
  if (std::isnan(squares.value)) return {};
  Measured out{root(squares.value), squares.ci95};
  if (!std::isnan(squares.ci95[0])) out.ci95 = {root(squares.ci95[0]), root(squares.ci95[1])};
  return out;
}

double root_mean_square(const std::vector<double>& values) {
  double squares = 0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares / static_cast<double>(values.size()));
}

}  // namespace

void LocalisationStatistics::add(const ObservationRecord& observation) {
  ++labels_[observation.label];
  trial_.visible += observation.is_visible;
  trial_.seen += observation.is_visible && observation.is_found();
  if (!observation.is_found()) return;
  ++trial_.found;
  trial_.seen_outliers += observation.is_visible && observation.is_outlier;
  if (observation.is_visible && observation.error_px <= kNearPx) {
    ++trial_.near;
    if (near_px_.size() < kMostKept) near_px_.push_back(observation.error_px);
  }
  const Eigen::Vector2d error = observation.pixel - observation.true_pixel;
  observation.is_outlier ? add_outlier(observation, error) : add_inlier(observation, error);
}

void LocalisationStatistics::add_outlier(const ObservationRecord& observation,
                                         const Eigen::Vector2d& error) {
  ++trial_.outliers;
  side_u_ += error.x() / observation.error_px;
  side_v_ += error.y() / observation.error_px;
  if (outlier_px_.size() < kMostKept) outlier_px_.push_back(observation.error_px);
}

void LocalisationStatistics::add_inlier(const ObservationRecord& observation,
                                        const Eigen::Vector2d& error) {
  ++trial_.inliers;
  trial_.squares_px2 += error.squaredNorm() / 2;
  trial_.du_px += error.x();
  trial_.dv_px += error.y();
  if (std::isnan(observation.error_sigmas)) return;
  ++trial_.with_sigma;
  trial_.squares_sigmas += observation.error_sigmas * observation.error_sigmas / 2;
}

void LocalisationStatistics::end_trial() {
  visible_ += static_cast<int64_t>(trial_.visible);
  found_count_ += static_cast<int64_t>(trial_.found);
  outlier_count_ += static_cast<int64_t>(trial_.outliers);
  found_.add(trial_.seen, trial_.visible);
  outliers_.add(trial_.outliers, trial_.found);
  near_.add(trial_.near, trial_.visible);
  seen_outliers_.add(trial_.seen_outliers, trial_.seen);
  squares_px2_.add(trial_.squares_px2, trial_.inliers);
  bias_u_px_.add(trial_.du_px, trial_.inliers);
  bias_v_px_.add(trial_.dv_px, trial_.inliers);
  squares_sigmas_.add(trial_.squares_sigmas, trial_.with_sigma);
  trial_ = {};
}

void LocalisationStatistics::add(const TrialRecord& trial) {
  for (const ObservationRecord& observation : trial.observations()) add(observation);
  end_trial();
}

Localisation LocalisationStatistics::summary() const {
  Localisation out;
  out.visible = visible_;
  out.found = found_count_;
  out.found_rate = found_.rate();
  out.outlier_rate = outliers_.rate();
  out.near_rate = near_.rate();
  out.seen_outlier_rate = seen_outliers_.rate();
  if (!near_px_.empty()) {
    out.near_median_px = percentile(near_px_, 0.5);
    out.near_rms_px = root_mean_square(near_px_);
  }
  out.rms_px = root_of(squares_px2_.measured());
  out.bias_u_px = bias_u_px_.measured();
  out.bias_v_px = bias_v_px_.measured();
  out.rms_sigmas = root_of(squares_sigmas_.measured());
  out.labels = labels_;
  const auto count = static_cast<double>(outlier_count_);
  out.outlier_side = {side_u_ / count, side_v_ / count};
  const std::array<double, 3> kPercentiles = {0.1, 0.5, 0.9};
  for (size_t i = 0; i < kPercentiles.size(); ++i) {
    out.outlier_px[i] = percentile(outlier_px_, kPercentiles[i]);
  }
  return out;
}

}  // namespace sightline
