// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/run_numbers.h"

#include <limits>

#include "eval/summary/localisation.h"
#include "eval/summary/quantities.h"

namespace sightline {
namespace {

constexpr double kOfAFailure = std::numeric_limits<double>::infinity();

// No error is greater than its cap, and one that is no number is as great.
Share error_share(double error, double cap) {
  return {error < cap ? error : cap};
}

RunNumber error_number(const Quantity& quantity) {
  RunNumber number;
  number.name = quantity.name;
  number.meaning = "error, capped; a failed trial counts as the cap";
  number.kind = NumberKind::kError;
  number.cap = quantity.cap;
  if (const auto error = quantity.of_estimate; error != nullptr) {
    number.of_estimate = [error, cap = quantity.cap](const TrialRecord&, const EstimateRecord& e) {
      return error_share(e.is_ok() ? e.*error : cap, cap);
    };
  }
  if (const auto error = quantity.of_orientation; error != nullptr) {
    number.of_orientation = [error, cap = quantity.cap](const OrientationRecord& o) {
      return error_share(o.*error, cap);
    };
  }
  return number;
}

RunNumber open_error(const char* name, const char* meaning, double EstimateRecord::*error) {
  RunNumber number;
  number.name = name;
  number.meaning = meaning;
  number.kind = NumberKind::kOpenError;
  number.of_estimate = [error](const TrialRecord&, const EstimateRecord& e) {
    return error_share(e.is_ok() ? e.*error : kOfAFailure, kOfAFailure);
  };
  return number;
}

RunNumber failure_rate() {
  RunNumber number;
  number.name = "failure_rate";
  number.meaning = "trials without a pose";
  number.kind = NumberKind::kFlag;
  number.of_estimate = [](const TrialRecord&, const EstimateRecord& e) {
    return Share{e.is_ok() ? 0.0 : 1.0};
  };
  number.of_orientation = [](const OrientationRecord& o) {
    return Share{o.failures > 0 ? 1.0 : 0.0};
  };
  return number;
}

RunNumber exact_set_rate() {
  RunNumber number;
  number.name = "exact_set_rate";
  number.meaning = "trials in which exactly the outliers were removed";
  number.kind = NumberKind::kFlag;
  number.is_more_better = true;
  number.of_estimate = [](const TrialRecord&, const EstimateRecord& e) {
    return Share{e.is_ok() && e.is_set_exact() ? 1.0 : 0.0};
  };
  return number;
}

RunNumber false_removals() {
  RunNumber number;
  number.name = "false_removals";
  number.meaning = "inliers removed, a trial";
  number.kind = NumberKind::kCount;
  number.of_estimate = [](const TrialRecord&, const EstimateRecord& e) {
    return Share{e.is_ok() ? static_cast<double>(e.false_removals) : 0.0};
  };
  return number;
}

RunNumber missed_outliers() {
  RunNumber number;
  number.name = "missed_outliers";
  number.meaning = "outliers kept, a trial; a failed one keeps all";
  number.kind = NumberKind::kCount;
  number.of_estimate = [](const TrialRecord& trial, const EstimateRecord& e) {
    double missed = e.missed_outliers;
    if (e.is_ok()) return Share{missed};
    missed = 0;
    for (const ObservationRecord& observation : trial.observations()) {
      missed += observation.is_found() && observation.is_outlier;
    }
    return Share{missed};
  };
  return number;
}

// A sum over a trial's observations: `add` enters what one of them adds.
RunNumber feature_number(const char* name, const char* meaning, NumberKind kind,
                         bool is_more_better, void (*add)(const ObservationRecord&, Share&)) {
  RunNumber number;
  number.name = name;
  number.meaning = meaning;
  number.kind = kind;
  number.is_more_better = is_more_better;
  number.is_of_features = true;
  number.of_features = [add](const TrialRecord& trial) {
    Share share{0, 0};
    for (const ObservationRecord& observation : trial.observations()) add(observation, share);
    return share;
  };
  return number;
}

void add_found(const ObservationRecord& o, Share& share) {
  share.whole += o.is_visible;
  share.part += o.is_visible && o.is_found();
}

void add_near(const ObservationRecord& o, Share& share) {
  share.whole += o.is_visible;
  share.part += o.is_visible && o.is_found() && o.error_px <= kNearPx;
}

void add_outlier(const ObservationRecord& o, Share& share) {
  share.whole += o.is_found();
  share.part += o.is_found() && o.is_outlier;
}

void add_inlier(const ObservationRecord& o, Share& share) {
  if (!o.is_found() || o.is_outlier) return;
  share.whole += 1;
  share.part += (o.pixel - o.true_pixel).squaredNorm() / 2;  // of one coordinate
}

std::vector<RunNumber> all_run_numbers() {
  std::vector<RunNumber> numbers;
  for (const Quantity& quantity : quantities()) {
    if (!quantity.is_time) numbers.push_back(error_number(quantity));
  }
  numbers.push_back(open_error("reprojection_rms_px", "of the kept observations",
                               &EstimateRecord::reprojection_rms_px));
  numbers.push_back(
      open_error("add_m", "mean distance of the vertices in both poses", &EstimateRecord::add_m));
  numbers.push_back(open_error("mssd_m", "greatest distance of a vertex", &EstimateRecord::mssd_m));
  numbers.push_back(
      open_error("mspd_px", "greatest distance of a projected vertex", &EstimateRecord::mspd_px));
  numbers.push_back(failure_rate());
  numbers.push_back(exact_set_rate());
  numbers.push_back(false_removals());
  numbers.push_back(missed_outliers());
  numbers.push_back(feature_number("found_rate", "features found, of those to be seen",
                                   NumberKind::kRate, true, add_found));
  numbers.push_back(feature_number("near_rate", "features found within 3 px, of those to be seen",
                                   NumberKind::kRate, true, add_near));
  numbers.push_back(feature_number("outlier_rate", "outliers, of the features found",
                                   NumberKind::kRate, false, add_outlier));
  numbers.push_back(feature_number("inlier_rms_px", "error of the inliers, RMS of a coordinate",
                                   NumberKind::kRms, false, add_inlier));
  return numbers;
}

}  // namespace

const std::vector<RunNumber>& run_numbers() {
  static const std::vector<RunNumber> numbers = all_run_numbers();
  return numbers;
}

}  // namespace sightline
