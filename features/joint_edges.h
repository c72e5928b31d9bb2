// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which lines along the target's edges belong together. Beside an edge of a printed target run the
// borders of the print, which look like it, so that no edge can be told by itself. But all edges
// move with one pose: the right lines are those that one pose near the prior explains.
//
// Each stretch of an edge is one measurement, of which one line at most is right. Ways of taking a
// line or none for every stretch are followed side by side, the most probable of them. Each is a
// Kalman filter over small changes of the pose, begun at the prior; its probability is that of the
// offsets it takes, against lines that lie anywhere in the search (multiple hypotheses: Reid, IEEE
// Trans. Automatic Control 24(6), 1979; the associations are jointly compatible: Neira and Tardos,
// IEEE Trans. Robotics and Automation 17(6), 2001).
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "features/extractor.h"
#include "features/prediction.h"
#include "pose/edge_points.h"

namespace sightline {

/// A line that may be the image of an edge.
struct LineCandidate {
  std::array<EdgePoint, 2> ends;  ///< places that it passes, with the variance of each
  /// How well the image speaks for it, over how densely lines that are no edge's would lie there:
  /// per square px of offsets at both ends.
  double weight_px2 = 1;
};

/// The lines found where one stretch of an edge should be seen.
using StretchCandidates = std::vector<LineCandidate>;

/// The lines along the edges of the feature that is asked for, edge by edge.
std::vector<StretchCandidates> line_candidates(const ExtractionInput& input);

/// The pose near the prior that best explains one line or none of each stretch, and how well it is
/// known from them. None where fewer than three stretches have a line that it explains.
std::optional<PosePrior> jointly_explained(std::span<const StretchCandidates> stretches,
                                           const PosePrior& prior);

}  // namespace sightline
