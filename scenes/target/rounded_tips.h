// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <set>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "scenes/mesh/mesh.h"
#include "scenes/mesh/occluder.h"
#include "scenes/target/candidate.h"

namespace sightline {

/// Of the target's size: extreme points this near to each other are one tip, to whose outline parts
/// as near belong; and how far from the tip its outline reaches.
inline constexpr double kTipRadius = 0.03;
inline constexpr double kTipReach = 0.05;

/// The parts that have a vertex within reach of a place: their outlines make the one there.
std::set<std::string> parts_about(const Mesh& mesh, const Eigen::Vector3d& position_m,
                                  double reach_m);

/// Where a rounded target sticks out, as contour features: noses, the tips of elliptical wings,
/// tails. `directions` are those towards the eyes; lengths in the options are fractions of the
/// target's size. A target without such places (a ball) has none.
///
/// A place sticks out where many directions have their extreme point: the vertex v that maximises
/// d . v is the same, or one near it, for all directions d of a wide cone. The share of such
/// directions is the area of the surface's image under the Gauss map, which by Gauss and Bonnet is
/// the place's integral curvature over 4 pi: a sharp point has much of it, a ball has it spread
/// evenly. Directions are looked at for the whole mesh and for each of its parts, whose ends need
/// not lie on the hull of all.
///
/// From one side, the outline near the place consists of edges between a face turned to the eye and
/// one turned away. Laid on an image, a piece of outline of length l and unit normal n holds a
/// shift of the whole only across itself, so that all of them hold it with sum(l n n^T), a length,
/// whose lesser eigenvalue says how well the worst direction is held: nothing of a straight wing's
/// edge along itself, half the arc's length of a semicircle. That eigenvalue, of the outline in
/// sight, is what a view is worth.
std::vector<Candidate> rounded_tips(const Mesh& mesh, const Occluder& occluder,
                                    const std::vector<Eigen::Vector3d>& directions);

}  // namespace sightline
