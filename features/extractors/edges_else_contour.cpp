// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// model_edges where a feature has two edges to be seen; else contour, where its outline stands
// against the background. Seen along its plane a wing is a bar two pixels wide: its leading and its
// trailing edge blur into one and no line can be laid on either, but the bar and its end still hold
// the tip.
#include <algorithm>

#include "features/extractors/extractors.h"
#include "features/outline.h"

namespace sightline {
namespace {

constexpr double kBarPx = 0.6;  // more sigma: the two sides of a bar repel each other's edges

// In front of other parts of the target their edges are taken for those of a bar.
bool stands_out(const ExtractionInput& input) {
  const std::vector<OutlineSample> outline =
      predict_outline(input.view, input.prediction, input.options.search.outline_reach_px);
  const auto bordering = std::count_if(outline.begin(), outline.end(),
                                       [](const OutlineSample& s) { return s.borders_target; });
  return 4 * bordering <= static_cast<std::ptrdiff_t>(outline.size());
}

}  // namespace

void extract_edges_else_contour(const ExtractionInput& input, Observation& observation) {
  if (input.prediction.kind != FeatureKind::kLineIntersection) {
    extract_contour(input, observation);
    return;
  }
  const Observation untouched = observation;
  extract_model_edges(input, observation);
  const bool has_edges = observation.status != ObservationStatus::kNoOutline &&
                         observation.status != ObservationStatus::kParallelLines;
  if (has_edges || !stands_out(input)) return;
  observation = untouched;
  extract_contour(input, observation);
  observation.covariance_px2 += kBarPx * kBarPx * Eigen::Matrix2d::Identity();
}

}  // namespace sightline
