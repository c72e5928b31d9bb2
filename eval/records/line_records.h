// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <string>

#include "eval/records/records.h"
#include "pose/line_observation.h"
#include "scenes/target/target.h"

namespace sightline {

/// The line as solvers are given it, of an edge of the target, whose feature it must name.
inline LineObservation line_of(const LineRecord& record, const Target& target) {
  const auto feature = std::ranges::find(target.features, record.feature, &TargetFeature::name);
  const Edge& edge = feature->edges.at(static_cast<size_t>(record.edge));
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
