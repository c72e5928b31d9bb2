// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "pose/pose.h"
#include "pose/reprojection.h"
#include "pose/solver.h"

namespace sightline {

/// When orthogonal iteration stops.
struct OrthogonalIterationOptions {
  int max_iterations = 200;
  /// Stops when the object-space error falls by less than this fraction in one iteration.
  double relative_tolerance = 1e-7;
};

/// Starts for the image-space solvers that need neither truth nor a guess: orthogonal iteration
/// (Lu, Hager, Mjolsness, IEEE PAMI 22(6), 2000) whose inner step is the fast absolute orientation,
/// begun from the scaled-orthographic (affine) pose. A planar or nearly planar target has two
/// mirror starts that fit alike at weak perspective; both are then iterated and returned, better
/// one first. Empty when there are fewer than four points or they are collinear (or, under weak
/// perspective, coincide in the image). Every returned pose has all points in front of the camera.
std::vector<Pose> orthogonal_iteration_starts(const PoseProblem& problem,
                                              const OrthogonalIterationOptions& options = {});

/// The same for a prepared problem; the poses are cam_from_centred.
std::vector<Pose> centred_starts(const Correspondences& c,
                                 const OrthogonalIterationOptions& options);

}  // namespace sightline
