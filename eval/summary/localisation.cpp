// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/localisation.h"

#include <algorithm>
#include <cmath>

#include "eval/statistics/statistics.h"

namespace sightline {
namespace {

constexpr double kZ95 = 1.959963984540054;  // the normal law's 97.5 % quantile

// The ends of an interval of squares, as roots.
Measured root_of(const Measured& squares) {
  const auto root = [](double x) { return std::sqrt(std::max(0.0, x)); };
  if (std::isnan(squares.value)) return {};
  Measured out{root(squares.value), squares.ci95};
  if (!std::isnan(squares.ci95[0])) out.ci95 = {root(squares.ci95[0]), root(squares.ci95[1])};
  return out;
}

}  // namespace

void ClusteredRatio::add(double numerator, double denominator) {
  ++trials_;
  numerator_ += numerator;
  denominator_ += denominator;
  numerator2_ += numerator * numerator;
  denominator2_ += denominator * denominator;
  product_ += numerator * denominator;
}

double ClusteredRatio::value() const {
  return denominator_ > 0 ? numerator_ / denominator_ : std::numeric_limits<double>::quiet_NaN();
}

// Sum of (y - R x)^2 over the trials, over (sum of x)^2, times n / (n - 1).
double ClusteredRatio::variance() const {
  const double ratio = value();
  const double squares = numerator2_ - 2 * ratio * product_ + ratio * ratio * denominator2_;
  const auto n = static_cast<double>(trials_);
  return std::max(0.0, squares) / (denominator_ * denominator_) * n / (n - 1);
}

Measured ClusteredRatio::measured() const {
  Measured out{value(), {}};
  out.ci95.fill(std::numeric_limits<double>::quiet_NaN());
  if (trials_ < 2 || !(denominator_ > 0)) return out;
  const double half = kZ95 * std::sqrt(variance());
  out.ci95 = {out.value - half, out.value + half};
  return out;
}

Measured ClusteredRatio::rate() const {
  Measured out = measured();
  if (std::isnan(out.ci95[0])) return out;
  const double p = out.value;
  const double spread = variance();
  // Never more than the observations there are: clusters may seem to differ less than chance.
  const double n = spread > 0 ? std::min(denominator_, p * (1 - p) / spread)
                              : std::min(denominator_, double(trials_));
  const double z2 = kZ95 * kZ95;
  const double centre = (p + z2 / (2 * n)) / (1 + z2 / n);
  const double half = kZ95 / (1 + z2 / n) * std::sqrt(p * (1 - p) / n + z2 / (4 * n * n));
  out.ci95 = {std::max(0.0, centre - half), std::min(1.0, centre + half)};
  return out;
}

void LocalisationStatistics::add(const TrialRecord& trial, std::span<const std::string> features) {
  double visible = 0, seen = 0, seen_outliers = 0, near = 0;
  double found = 0, outliers = 0, inliers = 0, with_sigma = 0;
  double squares_px2 = 0, du_px = 0, dv_px = 0, squares_sigmas = 0;
  for (const ObservationRecord& o : trial.observations()) {
    const bool is_asked_for = features.empty() || std::find(features.begin(), features.end(),
                                                            o.feature) != features.end();
    if (!is_asked_for) continue;
    ++labels_[o.label];
    visible += o.is_visible;
    seen += o.is_visible && o.is_found();
    if (!o.is_found()) continue;
    ++found;
    seen_outliers += o.is_visible && o.is_outlier;
    if (o.is_visible && o.error_px <= kNearPx) {
      ++near;
      if (near_px_.size() < kMostKept) near_px_.push_back(o.error_px);
    }
    const Eigen::Vector2d error = o.pixel - o.true_pixel;
    if (o.is_outlier) {
      ++outliers;
      side_u_ += error.x() / o.error_px;
      side_v_ += error.y() / o.error_px;
      if (outlier_px_.size() < kMostKept) outlier_px_.push_back(o.error_px);
      continue;
    }
    ++inliers;
    squares_px2 += error.squaredNorm() / 2;
    du_px += error.x();
    dv_px += error.y();
    if (std::isnan(o.error_sigmas)) continue;
    ++with_sigma;
    squares_sigmas += o.error_sigmas * o.error_sigmas / 2;
  }
  visible_ += static_cast<int64_t>(visible);
  found_count_ += static_cast<int64_t>(found);
  outlier_count_ += static_cast<int64_t>(outliers);
  found_.add(seen, visible);
  outliers_.add(outliers, found);
  near_.add(near, visible);
  seen_outliers_.add(seen_outliers, seen);
  squares_px2_.add(squares_px2, inliers);
  bias_u_px_.add(du_px, inliers);
  bias_v_px_.add(dv_px, inliers);
  squares_sigmas_.add(squares_sigmas, with_sigma);
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
    double squares_px2 = 0;
    for (const double distance_px : near_px_) squares_px2 += distance_px * distance_px;
    out.near_rms_px = std::sqrt(squares_px2 / static_cast<double>(near_px_.size()));
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

ExtractionStatistics::ExtractionStatistics(const Study& study)
    : cells_(study.conditions.size()),
      of_both_(study.conditions.size()),
      of_kinds_(study.conditions.size()),
      counts_(study.conditions.size()) {
  for (const int index : study.features) {
    const TargetFeature& feature = study.target->features[static_cast<size_t>(index)];
    features_.push_back(feature.name);
    of_kind_[static_cast<size_t>(feature.kind)].push_back(feature.name);
  }
  of_features_.resize(features_.size());
  for (auto& row : of_both_) row.resize(features_.size());
}

void ExtractionStatistics::add(const TrialRecord& trial) {
  const auto condition = static_cast<size_t>(trial.condition);
  cells_[condition].add(trial);
  for (size_t i = 0; i < features_.size(); ++i) {
    const std::span<const std::string> feature(&features_[i], 1);
    of_features_[i].add(trial, feature);
    of_both_[condition][i].add(trial, feature);
  }
  for (size_t kind = 0; kind < of_kind_.size(); ++kind) {
    if (!of_kind_[kind].empty()) of_kinds_[condition][kind].add(trial, of_kind_[kind]);
  }
  counts_[condition].add(trial);
}

Localisation ExtractionStatistics::of_cell(int condition) const {
  return cells_[static_cast<size_t>(condition)].summary();
}

Localisation ExtractionStatistics::of_feature(const std::string& feature) const {
  const auto found = std::find(features_.begin(), features_.end(), feature);
  return found == features_.end()
             ? Localisation{}
             : of_features_[static_cast<size_t>(found - features_.begin())].summary();
}

Localisation ExtractionStatistics::of(int condition, const std::string& feature) const {
  const auto found = std::find(features_.begin(), features_.end(), feature);
  if (found == features_.end()) return {};
  return of_both_[static_cast<size_t>(condition)][static_cast<size_t>(found - features_.begin())]
      .summary();
}

Localisation ExtractionStatistics::of_kind(int condition, FeatureKind kind) const {
  return of_kinds_[static_cast<size_t>(condition)][static_cast<size_t>(kind)].summary();
}

}  // namespace sightline
