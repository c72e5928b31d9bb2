// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/quantities.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

#include "eval/records/caps.h"
#include "eval/summary/cells.h"
#include "pose/attitude.h"

namespace sightline {
namespace {

constexpr double kNoCap = std::numeric_limits<double>::infinity();

constexpr Quantity kQuantities[] = {
    {.name = "time_ns",
     .id = "time",
     .label = "Time of a solve, ns",
     .cap = kNoCap,
     .of_estimate = nullptr,
     .of_orientation = &OrientationRecord::time_ns,
     .summary = &CellErrors::time_ns,
     .in_orientation_studies = {.heading = "Time of a solve / ns, mean of the draws"},
     .is_time = true},
    {.name = "angle_error_deg",
     .id = "angle",
     .label = "Error of an Euler angle, °",
     .cap = kAngleCapDeg,
     .of_estimate = nullptr,
     .of_orientation = &OrientationRecord::angle_error_deg,
     .summary = &CellErrors::angle_error_deg,
     .in_orientation_studies = {.heading =
                                    "Error of an Euler angle / °, absolute, mean of the three",
                                .is_charted = true}},
    {.name = "theta_error_deg",
     .id = "theta",
     .label = "θ error, °",
     .cap = kAngleCapDeg,
     .of_estimate = &EstimateRecord::theta_error_deg,
     .of_orientation = &OrientationRecord::theta_error_deg,
     .summary = &CellErrors::theta_error_deg,
     .in_pose_studies = {.heading = "theta_error / °, mean of the trials", .is_charted = true},
     .in_orientation_studies = {.heading = "theta_error / °, mean", .is_detail = true},
     .paper = &PaperFigure::theta_error_deg,
     .bound = &CellObservations::bound_theta_deg,
     .paper_decimals = 2},
    {.name = "t_error_percent",
     .id = "t",
     .label = "T error, %",
     .cap = kTranslationCapPercent,
     .of_estimate = &EstimateRecord::t_error_percent,
     .of_orientation = &OrientationRecord::t_error_percent,
     .summary = &CellErrors::t_error_percent,
     .in_pose_studies = {.heading = "T_error / % of the distance, mean of the trials",
                         .is_charted = true},
     .in_orientation_studies = {.heading = "T_error / % of the distance, mean",
                                .is_detail = true,
                                .is_charted = true},
     .paper = &PaperFigure::t_error_percent,
     .bound = &CellObservations::bound_t_percent,
     .paper_decimals = 1},
    {.name = "geodesic_deg",
     .id = "geodesic",
     .label = "Geodesic error, °",
     .cap = kAngleCapDeg,
     .of_estimate = &EstimateRecord::geodesic_deg,
     .of_orientation = &OrientationRecord::geodesic_deg,
     .summary = &CellErrors::geodesic_deg,
     .in_pose_studies = {.heading = "Geodesic error / °, RMS of the trials"},
     .in_orientation_studies = {.heading = "Geodesic error / °, mean"},
     .bound = &CellObservations::bound_geodesic_deg,
     .is_rms = true},
};

}  // namespace

std::span<const Quantity> quantities() {
  return kQuantities;
}

const Quantity& quantity(std::string_view name) {
  for (const Quantity& quantity : kQuantities) {
    if (quantity.name == name) return quantity;
  }
  throw std::out_of_range(fmt::format("no quantity is named {}", name));
}

CellErrorStatistics::CellErrorStatistics() {
  for (const Quantity& quantity : kQuantities) errors_.emplace_back(quantity.cap);
}

void CellErrorStatistics::add(const EstimateRecord& estimate) {
  for (size_t i = 0; i < errors_.size(); ++i) {
    const auto error = kQuantities[i].of_estimate;
    if (error != nullptr) errors_[i].add(estimate.*error);
  }
}

void CellErrorStatistics::add(const OrientationRecord& orientation) {
  for (size_t i = 0; i < errors_.size(); ++i) {
    const auto error = kQuantities[i].of_orientation;
    if (error != nullptr) errors_[i].add(orientation.*error);
  }
}

void CellErrorStatistics::add_failure() {
  for (size_t i = 0; i < errors_.size(); ++i) {
    const bool is_of_poses = kQuantities[i].of_estimate != nullptr;
    if (is_of_poses) errors_[i].add(std::numeric_limits<double>::infinity());
  }
}

CellErrors CellErrorStatistics::summary(const Study& study, int condition,
                                        std::string_view solver) const {
  CellErrors errors;
  for (size_t i = 0; i < errors_.size(); ++i) {
    const Quantity& quantity = kQuantities[i];
    if (quantity.is_time && !study.takes_times()) continue;
    errors.*quantity.summary =
        errors_[i].summary(study.seed, bootstrap_stream(study, condition, solver, quantity.name));
  }
  return errors;
}

bool is_near_gimbal_lock(const Eigen::Matrix3d& rotation) {
  constexpr double kMostYawRad = std::numbers::pi / 3;
  return std::abs(attitude_from_rotation(rotation).yaw_rad) > kMostYawRad;
}

void drop_intervals_of_angles(CellErrors& errors) {
  errors.theta_error_deg.mean_ci95 = kNoInterval;
  errors.angle_error_deg.mean_ci95 = kNoInterval;
}

std::string bootstrap_stream(const Study& study, int condition, std::string_view solver,
                             std::string_view number) {
  return fmt::format("bootstrap/{}/{}/{}", study.conditions[static_cast<size_t>(condition)].label,
                     solver, number);
}

}  // namespace sightline
