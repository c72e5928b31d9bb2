// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/trial/line_labels.h"

#include <cmath>
#include <limits>

#include "features/image_line.h"
#include "pose/edge_points.h"

namespace sightline {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The errors of a line at its edge points, in units of its noise: the root of a sum that is
// chi-squared with as many degrees of freedom as there are edge points.
double error_sigmas(const LineObservation& line, const Camera& camera, const Pose& truth) {
  const auto points = edge_points_of(line, camera);
  if (!points) return kInfinity;
  double squares = 0;
  for (const EdgePoint& point : *points) {
    const auto residual = edge_residual(point, truth);
    if (!residual) return kInfinity;
    squares += residual->residual_px * residual->residual_px / point.variance_px2;
  }
  return std::sqrt(squares);
}

// How far the true image of the edge passes the line amid its edge pixels.
double offset_px(const ImageLine& found, const LineObservation& line, const Camera& camera,
                 const Pose& truth) {
  const double along_px = found.direction.dot(seen_middle(found) - found.point);
  const auto point = edge_point_at(line, camera, along_px);
  const auto residual = point ? edge_residual(*point, truth) : std::nullopt;
  return residual ? residual->residual_px : kInfinity;
}

}  // namespace

std::vector<LineRecord> compare_lines(std::span<const Observation> observations,
                                      const Target& target, const Camera& camera,
                                      const Pose& true_cam_from_target, const LabelLimits& limits) {
  std::vector<LineRecord> records;
  for (const Observation& observation : observations) {
    for (const EdgeLine& found : observation.edge_lines) {
      LineRecord record;
      record.feature = target.features[observation.feature].name;
      record.edge = found.edge;
      record.pixel = found.line.point;
      record.direction = found.line.direction;
      record.offset_variance_px2 = found.line.covariance(0, 0);
      record.offset_slope_covariance = found.line.covariance(0, 1);
      record.slope_variance = found.line.covariance(1, 1);
      const LineObservation line = line_observation(found, target.features[observation.feature]);
      record.offset_px = offset_px(found.line, line, camera, true_cam_from_target);
      record.error_sigmas = error_sigmas(line, camera, true_cam_from_target);
      const bool is_wrong = std::abs(record.offset_px) > limits.line_px ||
                            record.error_sigmas > limits.outlier_sigmas ||
                            !std::isfinite(record.error_sigmas);
      if (is_wrong) record.label = LineLabel::kWrong;
      records.push_back(std::move(record));
    }
  }
  return records;
}

}  // namespace sightline
