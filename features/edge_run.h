// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Along which part of an edge can it be fitted to the grey levels? Away from both its ends, where
// other edges bend it, and where the same other edges of the mesh run beside it all the way, so
// that these can be fitted together with it (features/blurred_edge.h).
#pragma once

#include <vector>

#include "features/blurred_edge.h"
#include "features/outline.h"

namespace sightline {

/// Kept off the ends of an edge, where the edges that begin there bend it.
inline constexpr double kOffCornerPx = 4;

/// Edges farther apart than this do not matter to each other's fits.
inline constexpr double kApartPx = 6;

/// A part of an edge along which it can be fitted.
struct EdgeRun {
  double from_px = 0;  ///< along the edge, from the feature
  double to_px = 0;
  std::vector<EdgeBeside> beside;  ///< within kApartPx of it, one a side at most

  double length_px() const { return to_px - from_px; }
};

/// The longest such part of one of the feature's edges, an index into its own, of which `predicted`
/// is what should be seen and `length_px` how far that is from the feature. Of length zero where
/// there is none.
EdgeRun longest_even_run(const PredictedView& view, const FeaturePrediction& prediction, int edge,
                         const PredictedEdge& predicted, double length_px);

/// The longest part of an edge whose samples follow one another a pixel apart, whatever runs
/// beside it. Of length zero where there is none.
EdgeRun longest_unbroken_run(const PredictedEdge& predicted);

}  // namespace sightline
