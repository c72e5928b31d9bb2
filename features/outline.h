// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a pose expects of the target's edges around a feature: which of them are to be seen, where,
// and on which side of them the target lies. The outline is that of the mesh itself: where an edge
// of the target is rounded, it lies outside the edge.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "features/prediction.h"

namespace sightline {

/// One of a feature's two straight edges as it should be seen.
struct PredictedEdge {
  struct Sample {
    double along_px;   ///< from the feature, along the edge
    double offset_px;  ///< of the outline from the edge, along its normal
    /// What lies beyond the outline is the target again: its shade is not the background's.
    bool borders_target;
  };
  Eigen::Vector2d begin = Eigen::Vector2d::Zero();       ///< the feature's pixel
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();  ///< unit vector, away from the feature
  Eigen::Vector2d normal = Eigen::Vector2d::UnitY();     ///< unit vector, out of the target
  /// Within a few pixels of it the target is shaded otherwise: it is rounded, or bevelled.
  bool is_soft = false;
  bool is_crease = false;       ///< inside the outline, between two faces that are both seen
  std::vector<Sample> samples;  ///< one a pixel, where it is to be seen
};

/// A point of the target's outline.
struct OutlineSample {
  Eigen::Vector2d pixel;
  Eigen::Vector2d normal;  ///< unit vector, out of the target
  bool borders_target;
};

/// Which stretch of an edge is looked at.
struct EdgeStretch {
  double gap_px;    ///< kept off both its ends
  double reach_px;  ///< how far from the feature
  /// Other edges seen nearer than this leave no sample beside them: where it is enough that they do
  /// not blur into one, those of the outline; else also the creases inside it.
  double apart_px = 3.5;
  bool is_apart_from_creases = false;
};

/// That edge of a line intersection, an index into its own.
PredictedEdge predict_edge(const PredictedView& view, const FeaturePrediction& prediction, int edge,
                           const EdgeStretch& stretch);

/// A straight edge of the mesh in the image.
struct EdgeSegment {
  Eigen::Vector2d begin, end;
};

/// The edges within `reach_px` of a feature other than that one of its own: those of the outline
/// and the creases inside it. What other parts of the target hide of them is not asked.
std::vector<EdgeSegment> edges_beside(const PredictedView& view,
                                      const FeaturePrediction& prediction, int edge,
                                      double reach_px);

/// The outline within `reach_px` of a feature, a sample a pixel, where it is to be seen.
std::vector<OutlineSample> predict_outline(const PredictedView& view,
                                           const FeaturePrediction& prediction, double reach_px);

}  // namespace sightline
