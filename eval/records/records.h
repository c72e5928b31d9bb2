// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "eval/records/names.h"
#include "pose/pose.h"

namespace sightline {

/// What became of one feature in one trial.
struct ObservationRecord {
  std::string feature;
  ObservationOutcome status = ObservationOutcome::kFound;
  bool is_visible = false;                          ///< truly: see LabelledObservation
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< zero where nothing was found
  Eigen::Vector2d true_pixel = Eigen::Vector2d::Zero();
  double error_px = 0;  ///< zero where nothing was found
  /// The error in units of the observation's own covariance; NaN where it states none.
  double error_sigmas = std::numeric_limits<double>::quiet_NaN();
  bool is_outlier = false;  ///< found, and farther from the truth than the study's limits
  ObservationLabel label = ObservationLabel::kInlier;

  bool is_found() const { return status == ObservationOutcome::kFound; }
};

/// What one solver made of one trial. Errors as the ORPE paper defines them; in a failed trial
/// (status other than kOk) they are not meaningful, and statistics count the failure.
struct EstimateRecord {
  std::string solver;
  EstimateOutcome status = EstimateOutcome::kOk;
  Pose cam_from_target;
  double theta_error_deg = 0;  ///< RMS of the three attitude angles' errors
  double t_error_percent = 0;  ///< RMS of the translation error's components over the distance
  double geodesic_deg = 0;
  double reprojection_rms_px = 0;    ///< of the kept observations
  double add_m = 0;                  ///< mean distance of the vertices
  double mssd_m = 0;                 ///< greatest distance of a vertex
  double mspd_px = 0;                ///< greatest distance of a projected vertex
  std::vector<std::string> removed;  ///< features judged outliers
  int false_removals = 0;            ///< removed, but inliers
  int missed_outliers = 0;           ///< kept, but outliers
  /// As the solver reports it, of (w, dt): cam_from_target = (Exp(w) R, t + dt), radians and
  /// metres; none where it reports none.
  std::optional<Eigen::Matrix<double, 6, 6>> covariance;
  /// Normalised estimation error squared: e^T covariance^-1 e of the error e = (w, dt). Of a true
  /// covariance it is chi-squared with 6 degrees of freedom. None without a covariance.
  std::optional<double> nees;
  // What the solver itself says of its pose (Diagnosis in pose/solver.h); none where it says
  // nothing of that question.
  std::optional<bool> is_ambiguous;
  std::optional<double> removed_probability;
  std::optional<bool> is_removal_limit_reached;
  std::optional<bool> is_test_failed;

  bool is_ok() const { return status == EstimateOutcome::kOk; }
  /// Whether exactly the outliers were removed; of an estimate that is ok.
  bool is_set_exact() const { return false_removals == 0 && missed_outliers == 0; }
};

/// What one method made of the noisy copies of one draw of an orientation study. Errors are means
/// over the copies, each capped as in statistics, a copy without a rotation counting as the cap.
struct OrientationRecord {
  std::string method;
  EstimateOutcome status = EstimateOutcome::kOk;  ///< of the first copy that failed, if one did
  int failures = 0;                               ///< copies without a rotation
  double angle_error_deg = 0;  ///< mean of the three attitude angles' absolute errors
  double theta_error_deg = 0;  ///< the rest as in EstimateRecord
  double t_error_percent = 0;
  double geodesic_deg = 0;
  double time_ns = std::numeric_limits<double>::quiet_NaN();  ///< a solve; NaN where not timed
};

/// What images, or points projected in their place, gave, and what each solver made of it.
struct PoseTrial {
  Pose prior_cam_from_target;
  std::vector<ObservationRecord> observations;
  std::vector<EstimateRecord> estimates;  ///< in the study's order of solvers
};

/// What each method made of pairs of points.
struct OrientationTrial {
  std::vector<OrientationRecord> orientations;  ///< in the study's order of methods
};

/// One trial: which it is, the true pose that was to be found, and what became of it.
struct TrialRecord {
  int64_t trial = 0;
  int condition = 0;
  int redraws = 0;            ///< poses drawn before the one that is kept
  Pose true_cam_from_target;  ///< of pairs of points a and b: b_from_a
  std::variant<PoseTrial, OrientationTrial> kind;

  /// Of a trial that is known to be of that kind. Throws std::bad_variant_access for any other.
  PoseTrial& pose_trial() { return std::get<PoseTrial>(kind); }
  const PoseTrial& pose_trial() const { return std::get<PoseTrial>(kind); }
  OrientationTrial& orientation_trial() { return std::get<OrientationTrial>(kind); }

  /// What a trial of either kind has of these: nothing, where it is of the other kind.
  std::span<const ObservationRecord> observations() const;
  std::span<const EstimateRecord> estimates() const;
  std::span<const OrientationRecord> orientations() const;
};

inline std::span<const ObservationRecord> TrialRecord::observations() const {
  const auto* pose_trial = std::get_if<PoseTrial>(&kind);
  if (pose_trial == nullptr) return {};
  return pose_trial->observations;
}

inline std::span<const EstimateRecord> TrialRecord::estimates() const {
  const auto* pose_trial = std::get_if<PoseTrial>(&kind);
  if (pose_trial == nullptr) return {};
  return pose_trial->estimates;
}

inline std::span<const OrientationRecord> TrialRecord::orientations() const {
  const auto* orientation_trial = std::get_if<OrientationTrial>(&kind);
  if (orientation_trial == nullptr) return {};
  return orientation_trial->orientations;
}

/// Trials that are gone through one by one, by their numbers, so that no more than one need be in
/// memory; as often as asked.
using TrialVisitor = std::function<void(const TrialRecord&)>;
using TrialSource = std::function<void(const TrialVisitor&)>;

/// What a solver made of a trial, failed or not; null where the trial has nothing of it.
inline const EstimateRecord* find_estimate(const TrialRecord& trial, std::string_view solver) {
  for (const EstimateRecord& estimate : trial.estimates()) {
    if (estimate.solver == solver) return &estimate;
  }
  return nullptr;
}

}  // namespace sightline
