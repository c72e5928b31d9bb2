// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Noise that is the same all over an image is not before a wide lens: a fisheye shows the last
// degrees to its edge small, so that a pixel is many there. Solvers see pixels without lens, and
// are told by covariances.
#pragma once

#include "pose/solver.h"

namespace sightline::entry {

/// True where a known noise is to be told so: covariances are not given, sigma is, and the lens
/// shows a point far from its axis; one of Brown and Conrady's model, which bends little for most
/// cameras, only where it stretches or shrinks what is seen there by a seventh.
bool is_noise_bent(const PoseProblem& problem);

/// The same problem with the noise as covariances, one a pixel.
PoseProblem with_bent_noise(PoseProblem problem);

/// The estimate, made with bent noise, as one of the problem: in pixels. The unit covariance of a
/// solver that states none for covariances is that which noise of a pixel in the image leaves to
/// the points that are kept.
PoseEstimate in_pixels(PoseEstimate estimate, const PoseSolver& solver, const PoseProblem& problem);

}  // namespace sightline::entry
