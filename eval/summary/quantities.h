// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "eval/records/records.h"
#include "eval/statistics/error_statistics.h"
#include "eval/study/study.h"

namespace sightline {

struct CellObservations;

/// Statistics of every error of one cell. What a kind of study does not measure has no trials.
struct CellErrors {
  ErrorSummary theta_error_deg;  ///< RMS of the three attitude angles' errors
  ErrorSummary t_error_percent;  ///< RMS of the translation error's components over the distance
  ErrorSummary geodesic_deg;     ///< the angle of the one rotation between estimate and truth
  // Of an orientation study, whose trials are draws with noisy copies:
  ErrorSummary angle_error_deg;  ///< mean of the three attitude angles' absolute errors
  ErrorSummary time_ns;          ///< a solve; not in summary.json, as times do not repeat
};

/// Where tables and charts of one kind of study show a quantity.
struct QuantityView {
  const char* heading = nullptr;  ///< of its table, with the unit and the statistic; null: no table
  bool is_detail = false;         ///< its table stands in the report alone, among the details
  bool is_charted = false;        ///< charts show how the trials' errors spread
};

/// An error by which solvers or methods are judged: what is stored of each trial, its statistics in
/// a cell, and how it is shown. To add one: a member of the record that stores it (eval/records),
/// its computation (eval/trial), a member of CellErrors and an entry in quantities().
struct Quantity {
  const char* name;                     ///< in summary.json: "theta_error_deg"
  const char* id;                       ///< in names of charts' files: "theta"
  const char* label;                    ///< in the report, with its unit: "θ error, °"
  double cap;                           ///< in means and RMS; a failed trial counts as this much
  double EstimateRecord::*of_estimate;  ///< null: poses have no such error
  double OrientationRecord::*of_orientation;  ///< null: orientations have no such error
  ErrorSummary CellErrors::*summary;
  QuantityView in_pose_studies{};
  QuantityView in_orientation_studies{};
  double PaperFigure::*paper = nullptr;       ///< what the paper prints of it; null: nothing
  double CellObservations::*bound = nullptr;  ///< the Cramér-Rao bound; null where it has none
  int paper_decimals = 0;                     ///< as the paper prints it
  bool is_rms = false;   ///< tables of numeric studies state the RMS, as the bound is of an RMS
  bool is_time = false;  ///< only there where the study takes times
};

/// Every quantity, in the order in which tables show them.
std::span<const Quantity> quantities();

/// The quantity of that name in summary.json. Throws std::out_of_range where there is none.
const Quantity& quantity(std::string_view name);

/// The errors of one cell, gathered trial by trial in the order of the trials.
class CellErrorStatistics {
 public:
  CellErrorStatistics();

  void add(const EstimateRecord& estimate);
  void add(const OrientationRecord& orientation);
  /// A trial without a pose: every error of poses is infinite.
  void add_failure();

  /// The statistics, whose bootstrap draws from random streams of the cell's own.
  CellErrors summary(const Study& study, int condition, std::string_view solver) const;

 private:
  std::vector<ErrorStatistics> errors_;  // one a quantity
};

/// Whether the three angles of an attitude say little: its yaw is beyond 60 degrees, where an error
/// of the rotation moves pitch and roll by more than twice as much, at 90 degrees without bound.
bool is_near_gimbal_lock(const Eigen::Matrix3d& rotation);

/// Takes from a cell, whose trials come near gimbal lock, the intervals of means of errors of
/// angles. Their squares have no mean there but for the cap, and a 95 % interval of theta_error's
/// mean holds 88 % of the time; the median's holds, and so does that of the geodesic angle.
void drop_intervals_of_angles(CellErrors& errors);

/// The name of the random stream of a number's bootstrap.
std::string bootstrap_stream(const Study& study, int condition, std::string_view solver,
                             std::string_view number);

}  // namespace sightline
