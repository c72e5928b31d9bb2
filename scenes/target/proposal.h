// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "scenes/mesh/mesh.h"
#include "scenes/mesh/occluder.h"
#include "scenes/target/target.h"

namespace sightline {

/// What `propose_features` asks of a feature. Lengths are fractions of the target's size, the
/// diagonal of its box.
struct ProposalOptions {
  int max_features = 16;
  int enough_corners = 10;             ///< with fewer, rounded tips fill up to that
  double sharp_angle_deg = 20;         ///< the faces at a crease turn by this at least
  double straightness = 0.0015;        ///< an edge's vertices lie this close to its line
  double min_length = 0.012;           ///< of each of the two edges: a tip's chord
  double max_gap = 0.015;              ///< from the end of an edge to where the lines meet
  double min_angle_deg = 20;           ///< between the edges, and from being one line
  double min_distance = 0.02;          ///< between features
  double min_visible_fraction = 0.15;  ///< of the views
  double min_outline_fraction = 0.3;   ///< of each edge: flush panels have edges nobody sees
  int views = 200;                     ///< spread evenly over the sphere
};

/// True of a part whose name says that it turns or is drawn as a blur (propeller, rotor, fan,
/// disc): nothing on it stays where it is.
bool is_moving_part(const std::string& name);

/// A feature that the mesh itself suggests.
struct FeatureProposal {
  TargetFeature feature;        ///< a line intersection or a contour, named <part>_<n>
  double visible_fraction = 0;  ///< of the views: its point and most of both edges near it
  double outline_fraction = 0;  ///< of the lesser edge, or the outline: against the background
};

/// Points where two long straight sharp edges of a mesh meet, best first. The mesh may be an open,
/// non-manifold soup of any winding. Sharp edges are chained while they hardly bend and cut into
/// straight ones (Douglas and Peucker 1973); a candidate is where two of their lines meet. Each
/// view gives each candidate a worth from what an extractor would have there: both edges in sight,
/// their projected lengths, the angle between them, and how much of them is outline, since against
/// other surfaces an edge may have no contrast. The features are chosen one by one for the greatest
/// sum of worths over the views, each divided by what the chosen ones give that view already, so
/// that they spread over the target and its sides. Where the mesh has few of them, rounded tips
/// are added in the same way (rounded_tips.h), as contours. Fewer than asked for, or none, where
/// the mesh has no more.
std::vector<FeatureProposal> propose_features(const Mesh& mesh, const Occluder& occluder,
                                              const ProposalOptions& options = {});

}  // namespace sightline
