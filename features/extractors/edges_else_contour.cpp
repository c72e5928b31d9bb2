// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// model_edges where a feature has two edges to be seen; else contour, where its outline stands
// against the background. Seen along its plane a wing is a bar two pixels wide: its leading and its
// trailing edge blur into one and no line can be laid on either, but the bar and its end still hold
// the tip.
#include <algorithm>
#include <utility>

#include "features/extractors/extractors.h"
#include "features/outline.h"

namespace sightline {
namespace {

// The two sides of a bar two pixels wide blur into each other, and each is seen farther from the
// other than it is. So much more is the standard deviation of a feature found by its outline: an
// upper estimate, of tips that are seen near the plane of their wing.
constexpr double kBarPx = 0.6;

// In front of other parts of the target their edges are taken for those of a bar.
bool stands_out(const ExtractionInput& input) {
  const std::vector<OutlineSample> outline =
      predict_outline(input.view, input.prediction, input.options.search.outline_reach_px);
  const auto bordering = std::count_if(outline.begin(), outline.end(),
                                       [](const OutlineSample& s) { return s.borders_target; });
  return 4 * bordering <= static_cast<std::ptrdiff_t>(outline.size());
}

}  // namespace

Observation extract_edges_else_contour(const ExtractionInput& input) {
  if (input.prediction.kind != FeatureKind::kLineIntersection) {
    return extract_contour(input);
  }
  Observation by_edges = extract_model_edges(input);
  const bool has_edges = by_edges.status != ObservationStatus::kNoOutline &&
                         by_edges.status != ObservationStatus::kParallelLines;
  if (has_edges || !stands_out(input)) return by_edges;
  Observation by_outline = extract_contour(input);
  // What holds the feature by its outline is laid on the same edges.
  if (by_outline.status != ObservationStatus::kFound) {
    by_outline.edge_lines = std::move(by_edges.edge_lines);
  }
  by_outline.covariance_px2 += kBarPx * kBarPx * Eigen::Matrix2d::Identity();
  return by_outline;
}

}  // namespace sightline
