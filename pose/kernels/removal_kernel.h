// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The inner loops of pose/solvers/orpe_weighed.cpp on plain arrays (see pose/multiversion.h): the
// problem linearised at a pose, and what the removal of every small set of points would change.
#pragma once

#include <cstddef>

#include "pose/kernels/reprojection_kernel.h"

namespace sightline::kernel {

/// The largest set.
inline constexpr int kMaxRemoved = 8;

/// The length of an array that holds one number a point.
constexpr std::size_t padded(std::size_t points) {
  return (points + kLanes - 1) / kLanes * kLanes;
}

/// H = J^T J = U^T D U of whitened rows, linearised at a pose. The arrays of `basis`, 12 of length
/// padded(n), are D^-1/2 U^-T J^T: six for the rows of u, six for those of v; orthonormal, so that
/// M = I - basis^T basis. `residuals`, 2 of that length, are what least squares leaves.
struct LinearModel {
  double u[21];
  double inverse_d[6];
  double step[6];  ///< (w, dt) to least squares
  double rss;      ///< |residuals|^2
  double log_det;  ///< ln det H
};

/// False when a point is behind the camera or H is not positive definite.
bool linearise(const PointLanes* lanes, std::size_t count, const RigidPose& pose, double* basis,
               double* residuals, LinearModel& model);

/// H delta = J^T y for y = basis^T z, that is delta = U^-1 D^-1/2 z.
void step_along(const LinearModel& model, const double (&z)[6], double (&delta)[6]);

/// The number of sets of 1 to max_size of n points.
std::size_t set_count(std::size_t n, int max_size);

/// A problem as sweep_sets takes it: the arrays of a linear model, and of each point gamma and the
/// log odds of being an outlier.
struct SweepProblem {
  std::size_t points;
  const double* basis;
  const double* residuals;
  const double* gamma;
  const double* log_odds;
};

/// How far a weight of SweptSets may be above the true one.
inline constexpr double kRoughLog = 0.06;

/// Of every set S of 1 to max_size points, in lexicographic order ({0}, {0, 1}, {0, 1, 2}, ...,
/// {0, 2}, ..., {1}, ...): q = r_S^T (M_SS + gamma I)^-1 r_S, det = det(M_SS + gamma I), and about
/// q + 2 sum_S log odds - ln det, kRoughLog too much at most.
struct SweptSets {
  double* q;
  double* det;
  double* weight;
};

/// How many doubles each array of SweptSets must have room for: more than set_count.
std::size_t swept_room(std::size_t n, int max_size);

/// How many doubles sweep_sets needs to work in.
std::size_t sweep_workspace(std::size_t n, int max_size);

/// Sweeps all sets of 1 to max_size points, by Schur complements with 2x2 pivots. `before` is the
/// max_size of the sweep of the same problem that was the last in this workspace, 0 if none was;
/// the workspace must be large enough for both.
void sweep_sets(const SweepProblem& problem, int max_size, int before, double* workspace,
                const SweptSets& out);

/// The place of the largest of one value or more, of which the first must be a number; other NaNs
/// are none.
std::size_t largest_of(const double* values, std::size_t count);

}  // namespace sightline::kernel
