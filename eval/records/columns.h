// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which members of the records are kept, once for all: results.sqlite (its schema, what is written
// and read), results.csv, timings.csv and the page docs/columns.md are made from the arrays of this
// file. To keep one more number, add it to its record and give it a line here: stores without it
// are still read, with nothing in its place. In results.csv a new member stands at CsvPlace::kEnd,
// so that no column moves.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "eval/records/records.h"

namespace sightline {

/// Which part of a row of results.csv or timings.csv a member stands in. Between the parts stand
/// columns that no record holds (eval/results/results_csv.cpp).
enum class CsvPlace { kNowhere, kSolver, kStatus, kResult, kPose, kEnd, kTiming };

/// A member of any of the types that can be kept.
template <typename Record>
using Member = std::variant<int Record::*, bool Record::*, double Record::*, std::string Record::*,
                            ObservationOutcome Record::*, EstimateOutcome Record::*,
                            ObservationLabel Record::*, Eigen::Vector2d Record::*, Pose Record::*,
                            std::optional<bool> Record::*, std::optional<double> Record::*,
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
