// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "pose/reprojection.h"
#include "pose/solver.h"

namespace sightline::entry {

/// The other minimum that the image of a plane has, roughly: (I - 2 v v^T) R (I - 2 n n^T), n the
/// normal of the plane in which the points nearly lie, v the ray to their centroid, which stays.
Pose mirror_of(const Correspondences& c, const Pose& cam_from_centred);

/// The pose other than the estimate's that explains its kept points nearly as well (at least one
/// twentieth as probable, and far away for the covariance): of least squares from the mirror pose,
/// or of p3p where three points are kept. The most probable one; none where there is none.
std::optional<Pose> rival_of(const PoseProblem& problem, const PoseEstimate& estimate);

}  // namespace sightline::entry
