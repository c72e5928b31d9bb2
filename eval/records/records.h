// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "pose/pose.h"

namespace sightline {

/// What became of one feature in one trial.
struct ObservationRecord {
  std::string feature;
  std::string status;                               ///< "found", or why it is missing
  bool is_visible = false;                          ///< truly: see LabelledObservation
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< with status "found"
  Eigen::Vector2d true_pixel = Eigen::Vector2d::Zero();
  double error_px = 0;  ///< with status "found"
  /// The error in units of the observation's own covariance; NaN where it states none.
  double error_sigmas = std::numeric_limits<double>::quiet_NaN();
  bool is_outlier = false;  ///< found, and farther from the truth than the study's limits
  std::string label;        ///< what it is against the truth: see ObservationLabel

  bool is_found() const { return status == "found"; }
};

/// What one solver made of one trial. Errors as the ORPE paper defines them; in a failed trial
/// (status other than "ok") they are not meaningful, and statistics count the failure.
struct EstimateRecord {
  std::string solver;
  std::string status = "ok";  ///< or why there is no pose
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
  /// covariance it is chi-squared with 6 degrees of freedom. NaN without a covariance.
  double nees = std::numeric_limits<double>::quiet_NaN();

  bool is_ok() const { return status == "ok"; }
};

/// What one method made of the noisy copies of one draw of an orientation study. Errors are means
/// over the copies, each capped as in statistics, a copy without a rotation counting as the cap.
struct OrientationRecord {
  std::string method;
  std::string status = "ok";   ///< of the first copy that failed, if one did
  int failures = 0;            ///< copies without a rotation
  double angle_error_deg = 0;  ///< mean of the three attitude angles' absolute errors
  double theta_error_deg = 0;  ///< the rest as in EstimateRecord
  double t_error_percent = 0;
  double geodesic_deg = 0;
  double time_ns = std::numeric_limits<double>::quiet_NaN();  ///< a solve; NaN where not timed
};

/// One trial: the truth, what was seen, and what each solver said.
struct TrialRecord {
  int64_t trial = 0;
  int condition = 0;
  int redraws = 0;
  Pose true_cam_from_target;
  Pose prior_cam_from_target;
  std::vector<ObservationRecord> observations;
  std::vector<EstimateRecord> estimates;  ///< in the study's order of solvers
  /// In the study's order of methods; only in an orientation study, whose true pose is b_from_a.
  std::vector<OrientationRecord> orientations;
};

/// Trials that are gone through one by one, by their numbers, so that no more than one need be in
/// memory; as often as asked.
using TrialVisitor = std::function<void(const TrialRecord&)>;
using TrialSource = std::function<void(const TrialVisitor&)>;

/// What a solver made of a trial, failed or not; null where the trial has nothing of it.
inline const EstimateRecord* find_estimate(const TrialRecord& trial, std::string_view solver) {
  for (const EstimateRecord& estimate : trial.estimates) {
    if (estimate.solver == solver) return &estimate;
  }
  return nullptr;
}

}  // namespace sightline
