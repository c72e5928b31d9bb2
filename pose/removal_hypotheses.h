// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Small sets of removals fitted, from one start to a mean over what is probable: the steps of
// pose/solvers/orpe_weighed.cpp, where the model stands, which consensus takes for few points too.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "pose/packed_points.h"
#include "pose/removal_sets.h"

namespace sightline {

/// One explanation of the pixels: which points are outliers, and the pose then.
struct RemovalHypothesis {
  RemovalSet set;
  Pose pose;
  kernel::NormalEquations model;  ///< whitened, removed points at the slab's weight
  double log_weight = 0;
  double rss = 0;  ///< of the kept points, whitened
};

/// What was found from one start.
struct RemovalBranch {
  PoseStatus status = PoseStatus::kDiverged;
  std::vector<RemovalHypothesis> hypotheses;
  int iterations = 0;
};

/// How far a search goes where no small set explains the points.
enum class RemovalEffort {
  kOnlySmall,  ///< it ends with what it has
  kAll,        ///< all sets of the linear model are fitted, a thousand at most
};

/// Sets of removals from a start, as cam_from_centred: weighed in the linear model, which moves to
/// the heaviest set's pose, the probable ones then fitted. `linear` is room to work in.
RemovalBranch removals_from(const RemovalModel& s, const PackedPoints& points, const Pose& start,
                            RemovalEffort effort, Linearisation& linear);

/// The heaviest one.
const RemovalHypothesis& best_of(const std::vector<RemovalHypothesis>& hypotheses);

/// Whether what a hypothesis keeps looks like noise of the size that is known.
bool is_explained(const RemovalModel& s, const RemovalHypothesis& h);

/// The mean over the hypotheses of the best one's start: between mirror poses lies no pose.
struct MeanOverRemovals {
  RemovalHypothesis best;
  const RemovalBranch* chosen = nullptr;
  Pose mean;                 ///< cam_from_centred
  Matrix6d covariance;       ///< of the mean, doubt about the set included
  Matrix6d best_covariance;  ///< of the best pose, were its set certain
  double best_probability = 1;
  bool is_ambiguous = false;
};

/// None where the best hypothesis leaves the pose undetermined. One branch at least must have a
/// hypothesis.
std::optional<MeanOverRemovals> mean_over_removals(std::span<const RemovalBranch> branches,
                                                   const RemovalModel& s);

/// Least squares on exactly the points that a hypothesis keeps.
struct FitOfKept {
  Pose pose;  ///< cam_from_centred
  Matrix6d unit_covariance;
};

std::optional<FitOfKept> fit_kept(const RemovalModel& s, const PackedPoints& points,
                                  const RemovalHypothesis& best);

/// Whether a pose has all points in front of the camera that a hypothesis keeps.
bool has_kept_in_front(const Correspondences& c, const RemovalSet& removed, const Pose& pose);

}  // namespace sightline
