// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "eval/records/records.h"
#include "pose/line_observation.h"
#include "scenes/target/target.h"

namespace sightline {

/// The line as solvers are given it; none where the target has no such edge (any more: records
/// outlive the target's file).
inline std::optional<LineObservation> line_of(const LineRecord& record, const Target& target) {
  const auto feature = std::ranges::find(target.features, record.feature, &TargetFeature::name);
  if (feature == target.features.end()) return std::nullopt;
  const auto index = static_cast<size_t>(record.edge);
  if (index >= feature->edges.size()) return std::nullopt;
  const Edge& edge = feature->edges[index];
  LineObservation line;
  line.begin_in_target = edge.begin_m;
  line.end_in_target = edge.end_m;
  line.pixel = record.pixel;
  line.direction = record.direction;
  line.covariance << record.offset_variance_px2, record.offset_slope_covariance,
      record.offset_slope_covariance, record.slope_variance;
  return line;
}

/// The name of a line: its feature, a slash and its edge.
inline std::string name_of(const LineRecord& record) {
  return record.feature + "/" + std::to_string(record.edge);
}

}  // namespace sightline
