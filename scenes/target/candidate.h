// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include <Eigen/Core>

#include "scenes/target/feature_shape.h"

namespace sightline {

/// A feature that may be proposed, and what it is worth from every side.
struct Candidate {
  int part = 0;
  TargetFeature feature;
  double worth = 0;                   ///< by its shape alone
  std::vector<double> worth_in_view;  ///< 0, where it is not to be had, to 1
  double visible_fraction = 0;        ///< of the views
  double outline_fraction = 0;        ///< of what is in sight: against the background
};

/// Directions towards an eye, evenly over the sphere (a Fibonacci spiral).
std::vector<Eigen::Vector3d> directions_all_round(int count);

/// Adds candidates to those that are chosen, until there are `most`: one by one the one with the
/// greatest sum of worths over the views, each divided by what the chosen ones give that view
/// already, so that they spread over the target and its sides. None nearer than that to another.
void choose(std::vector<Candidate> candidates, int most, double min_distance_m,
            std::vector<Candidate>& chosen);

}  // namespace sightline
