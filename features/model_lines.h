// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The feature's edges as the prior pose shows them on the mesh: where they are to be seen, every
// pixel along them, the peaks of the image's gradient along the normal, of the polarity that target
// and background give. The peaks vote for an offset and a slope of a line; robust least squares
// fits it. Each edge may have several such lines, of which those agree that meet in one point.
// Offsets are against the outline of the mesh itself, so that a rounded edge does no harm.
#pragma once

#include <optional>
#include <vector>

#include "features/agreement.h"
#include "features/extractor.h"

namespace sightline {

/// A line that may be the image of one of the feature's edges.
struct FoundLine {
  int edge;        ///< index into the feature's edges
  double support;  ///< the share of the edge's samples that have a peak on it
  bool is_soft;    ///< the edge is rounded or bevelled (PredictedEdge)
  /// The unit vector across the edge to where the background should be; none where it should not.
  std::optional<Eigen::Vector2d> outward;
  ImageLine line;
};

/// What is found along the edges that were looked for, which may be fewer than the feature has.
struct ModelLines {
  std::vector<std::vector<FoundLine>> of_edge;  ///< of each edge looked for, best first
  std::vector<Agreement> agreements;            ///< of these lines, in the window, best first, few
  int polarity = 0;                             ///< of the outline (features/outline_search.h)
};

/// The lines along a feature's edges, of many edges the longest. None where the target shows none
/// of them.
std::optional<ModelLines> find_model_lines(const ExtractionInput& input, const cv::Rect& window);

/// The line of a sharp edge fitted to the grey levels (features/blurred_edge.h) along all of it
/// that nothing else comes near, `vertex` being where the edge begins. None where there is too
/// little of that.
std::optional<ImageLine> refitted(const ExtractionInput& input, const FoundLine& found,
                                  const Eigen::Vector2d& vertex, int polarity);

}  // namespace sightline
