// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
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

/// A line that was found along one of a feature's edges, as solvers are given it
/// (LineObservation in pose/line_observation.h).
struct LineRecord {
  std::string feature;  ///< at which the edge begins
  int edge = 0;         ///< index into the feature's edges
  LineLabel label = LineLabel::kRight;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();
  double offset_variance_px2 = 0;
  double offset_slope_covariance = 0;  ///< px rad
  double slope_variance = 0;           ///< rad^2; infinite where the slope is not known
  /// Of the edge's true image from the line, along its normal, amid the edge pixels it was found
  /// by.
  double offset_px = 0;
  double error_sigmas = std::numeric_limits<double>::quiet_NaN();  ///< of offset and slope together

  bool is_right() const { return label == LineLabel::kRight; }
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
  /// Lines judged outliers, each as its feature, a slash and its edge.
  std::vector<std::string> removed_lines;
  int false_removals = 0;   ///< removed, but inliers
  int missed_outliers = 0;  ///< kept, but outliers
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
  std::vector<LineRecord> lines;          ///< where the study uses lines
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
  std::span<const LineRecord> lines() const;
  std::span<const EstimateRecord> estimates() const;
  std::span<const OrientationRecord> orientations() const;
};

inline std::span<const ObservationRecord> TrialRecord::observations() const {
  const auto* pose_trial = std::get_if<PoseTrial>(&kind);
  if (pose_trial == nullptr) return {};
  return pose_trial->observations;
}

inline std::span<const LineRecord> TrialRecord::lines() const {
  const auto* pose_trial = std::get_if<PoseTrial>(&kind);
  if (pose_trial == nullptr) return {};
  return pose_trial->lines;
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

/// The same as they are asked for, none after the last: for who goes through two runs side by side.
using NextTrial = std::function<std::optional<TrialRecord>()>;

/// What a solver made of a trial, failed or not; null where the trial has nothing of it.
inline const EstimateRecord* find_estimate(const TrialRecord& trial, std::string_view solver) {
  for (const EstimateRecord& estimate : trial.estimates()) {
    if (estimate.solver == solver) return &estimate;
  }
  return nullptr;
}

// ---- columns
//
// Which members of the records are kept, once for all: results.sqlite (its schema, what is written
// and read), results.csv, timings.csv and the page docs/columns.md are made from the arrays below.
// To keep one more number, add it to its record and give it a line here: stores without it are
// still read, with nothing in its place. In results.csv a new member stands at CsvPlace::kEnd, so
// that no column moves.

/// Which part of a row of results.csv or timings.csv a member stands in. Between the parts stand
/// columns that no record holds (eval/results/results_csv.cpp).
enum class CsvPlace { kNowhere, kSolver, kStatus, kResult, kPose, kEnd, kTiming };

/// A member of any of the types that can be kept.
template <typename Record>
using Member =
    std::variant<int Record::*, bool Record::*, double Record::*, std::string Record::*,
                 ObservationOutcome Record::*, EstimateOutcome Record::*,
                 ObservationLabel Record::*, LineLabel Record::*, Eigen::Vector2d Record::*,
                 Pose Record::*, std::optional<bool> Record::*, std::optional<double> Record::*,
                 std::optional<Eigen::Matrix<double, 6, 6>> Record::*,
                 std::vector<std::string> Record::*>;

/// A member of a record that is kept. A vector of pixels or a pose takes several columns, whose
/// names begin with the field's name: see component_names().
template <typename Record>
struct Field {
  std::string_view name;
  std::string_view unit;  ///< empty of what has none
  std::string_view meaning;
  Member<Record> member;
  CsvPlace csv = CsvPlace::kNowhere;
  std::string_view csv_name = name;  ///< where results.csv calls it otherwise
};

inline constexpr std::array kTrialFields = {
    Field<TrialRecord>{"condition", "",
                       "index into the study's conditions: the trial's number modulo their count",
                       &TrialRecord::condition},
    Field<TrialRecord>{"redraws", "", "poses drawn before one had all features in the image",
                       &TrialRecord::redraws},
    Field<TrialRecord>{"true_", "m", "the true pose: cam_from_target, or b_from_a of point pairs",
                       &TrialRecord::true_cam_from_target, CsvPlace::kPose},
};

/// These stand in the trial's own row; NULL in a trial of point pairs.
inline constexpr std::array kPoseTrialFields = {
    Field<PoseTrial>{"prior_", "m", "the prior pose, where solvers or extractors are given one",
                     &PoseTrial::prior_cam_from_target},
};

inline constexpr std::array kObservationFields = {
    Field<ObservationRecord>{"feature", "", "its name", &ObservationRecord::feature},
    Field<ObservationRecord>{"status", "", "found, or why not", &ObservationRecord::status},
    Field<ObservationRecord>{"is_visible", "", "truly on the image, and hidden by nothing",
                             &ObservationRecord::is_visible},
    Field<ObservationRecord>{"pixel_", "px", "where it was found", &ObservationRecord::pixel},
    Field<ObservationRecord>{"true_pixel_", "px", "where it is", &ObservationRecord::true_pixel},
    Field<ObservationRecord>{"error_px", "px", "the distance of the two",
                             &ObservationRecord::error_px},
    Field<ObservationRecord>{"error_sigmas", "sigma",
                             "the same in units of the observation's own covariance; NULL where it "
                             "states none",
                             &ObservationRecord::error_sigmas},
    Field<ObservationRecord>{"is_outlier", "",
                             "found, and farther from the truth than the study's limits; in a "
                             "numeric study: planted",
                             &ObservationRecord::is_outlier},
    Field<ObservationRecord>{"label", "", "what it is against the truth",
                             &ObservationRecord::label},
};

inline constexpr std::array kLineFields = {
    Field<LineRecord>{"feature", "", "at which the edge begins", &LineRecord::feature},
    Field<LineRecord>{"edge", "", "which of the feature's edges, from 0", &LineRecord::edge},
    Field<LineRecord>{"label", "", "what it is against the truth", &LineRecord::label},
    Field<LineRecord>{"pixel_", "px", "a pixel on the line", &LineRecord::pixel},
    Field<LineRecord>{"direction_", "", "a vector along it", &LineRecord::direction},
    Field<LineRecord>{"offset_variance_px2", "px^2", "of the line across itself, at the pixel",
                      &LineRecord::offset_variance_px2},
    Field<LineRecord>{"offset_slope_covariance", "px rad", "of that offset and the slope there",
                      &LineRecord::offset_slope_covariance},
    Field<LineRecord>{"slope_variance", "rad^2", "infinite where the slope is not known",
                      &LineRecord::slope_variance},
    Field<LineRecord>{"offset_px", "px",
                      "of the edge's true image from the line, amid its edge pixels",
                      &LineRecord::offset_px},
    Field<LineRecord>{"error_sigmas", "sigma", "of offset and slope together",
                      &LineRecord::error_sigmas},
};

inline constexpr std::array kEstimateFields = {
    Field<EstimateRecord>{"solver", "",
                          "the solver's name, after / what it was given if not the "
                          "observations as they are",
                          &EstimateRecord::solver, CsvPlace::kSolver},
    Field<EstimateRecord>{"status", "", "ok, or why there is no pose: numbers then mean nothing",
                          &EstimateRecord::status, CsvPlace::kStatus},
    Field<EstimateRecord>{"theta_error_deg", "deg", "RMS of the three attitude angles' errors",
                          &EstimateRecord::theta_error_deg, CsvPlace::kResult},
    Field<EstimateRecord>{"t_error_percent", "%",
                          "RMS of the translation error's components over the distance",
                          &EstimateRecord::t_error_percent, CsvPlace::kResult},
    Field<EstimateRecord>{"geodesic_deg", "deg", "angle of the rotation between pose and truth",
                          &EstimateRecord::geodesic_deg, CsvPlace::kResult},
    Field<EstimateRecord>{"reprojection_rms_px", "px", "of the kept observations",
                          &EstimateRecord::reprojection_rms_px, CsvPlace::kResult},
    Field<EstimateRecord>{"add_m", "m", "mean distance of the vertices in both poses",
                          &EstimateRecord::add_m, CsvPlace::kResult},
    Field<EstimateRecord>{"mssd_m", "m", "greatest distance of a vertex", &EstimateRecord::mssd_m,
                          CsvPlace::kResult},
    Field<EstimateRecord>{"mspd_px", "px", "greatest distance of a projected vertex",
                          &EstimateRecord::mspd_px, CsvPlace::kResult},
    Field<EstimateRecord>{"nees", "",
                          "the pose error squared in units of the covariance that the solver "
                          "reports: chi-squared with 6 degrees of freedom where that is true",
                          &EstimateRecord::nees, CsvPlace::kResult},
    Field<EstimateRecord>{"removed", "", "features judged outliers (in the store a JSON array)",
                          &EstimateRecord::removed, CsvPlace::kResult},
    Field<EstimateRecord>{"false_removals", "", "how many of them are inliers",
                          &EstimateRecord::false_removals, CsvPlace::kResult},
    Field<EstimateRecord>{"missed_outliers", "", "how many outliers were kept",
                          &EstimateRecord::missed_outliers, CsvPlace::kResult},
    Field<EstimateRecord>{"", "m", "the estimated pose cam_from_target",
                          &EstimateRecord::cam_from_target, CsvPlace::kPose},
    Field<EstimateRecord>{"covariance", "rad, m",
                          "what the solver reports for (w, dt), cam_from_target = (Exp(w) R, t + "
                          "dt): the upper triangle by rows as 21 little-endian doubles; NULL where "
                          "it reports none",
                          &EstimateRecord::covariance},
    Field<EstimateRecord>{"ambiguous", "",
                          "the solver says: another pose explains the pixels nearly as well",
                          &EstimateRecord::is_ambiguous, CsvPlace::kEnd},
    Field<EstimateRecord>{"removed_probability", "",
                          "the solver says: how probable it is that exactly the removed features "
                          "are the outliers",
                          &EstimateRecord::removed_probability, CsvPlace::kEnd},
    Field<EstimateRecord>{"removal_limit_reached", "",
                          "the solver says: it could remove no more, and outliers may be left",
                          &EstimateRecord::is_removal_limit_reached, CsvPlace::kEnd},
    Field<EstimateRecord>{"test_failed", "",
                          "the solver says: what is kept does not look like noise",
                          &EstimateRecord::is_test_failed, CsvPlace::kEnd},
    Field<EstimateRecord>{"removed_lines", "",
                          "lines judged outliers: a JSON array of feature/edge",
                          &EstimateRecord::removed_lines},
};

inline constexpr std::array kOrientationFields = {
    Field<OrientationRecord>{"method", "", "the method's name", &OrientationRecord::method,
                             CsvPlace::kSolver, "solver"},
    Field<OrientationRecord>{"status", "", "ok, or why the first copy that failed has no rotation",
                             &OrientationRecord::status, CsvPlace::kStatus},
    Field<OrientationRecord>{"failures", "", "copies without a rotation",
                             &OrientationRecord::failures, CsvPlace::kResult},
    Field<OrientationRecord>{"angle_error_deg", "deg",
                             "mean over the copies of the three attitude angles' absolute errors",
                             &OrientationRecord::angle_error_deg, CsvPlace::kResult},
    Field<OrientationRecord>{"theta_error_deg", "deg",
                             "mean of the RMS of the three angles' errors",
                             &OrientationRecord::theta_error_deg, CsvPlace::kResult},
    Field<OrientationRecord>{"geodesic_deg", "deg",
                             "mean angle of the rotation between estimate and truth",
                             &OrientationRecord::geodesic_deg, CsvPlace::kResult},
    Field<OrientationRecord>{"t_error_percent", "%",
                             "mean RMS of the translation error's components over the distance",
                             &OrientationRecord::t_error_percent, CsvPlace::kResult},
    Field<OrientationRecord>{"time_ns", "ns", "wall time of a solve; NULL where not timed",
                             &OrientationRecord::time_ns, CsvPlace::kTiming},
};

/// What the names of a field's columns end with. Poses stand in the store as matrices, since a
/// quaternion would lose bits, and in CSV files as quaternions, scalar first.
enum class PoseAs { kMatrix, kQuaternion };

template <typename Record>
std::vector<std::string_view> component_names(const Field<Record>& field, PoseAs pose_as) {
  if (std::holds_alternative<Eigen::Vector2d Record::*>(field.member)) return {"u", "v"};
  if (!std::holds_alternative<Pose Record::*>(field.member)) return {""};
  if (pose_as == PoseAs::kQuaternion) return {"qw", "qx", "qy", "qz", "tx_m", "ty_m", "tz_m"};
  return {"r00", "r01", "r02", "r10", "r11", "r12", "r20", "r21", "r22", "tx_m", "ty_m", "tz_m"};
}

}  // namespace sightline
