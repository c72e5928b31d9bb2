// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Least squares with few unknowns by Levenberg and Marquardt's method: the sums over all residuals
// and the step that they give. What is fitted sums them up (features/blurred_edge.cpp,
// features/facet_fit.cpp). Eigen's solvers are slow to compile: they are named in
// normal_equations.cpp alone.
#pragma once

#include <Eigen/Core>

namespace sightline {

inline constexpr int kMostUnknowns = 14;

/// Of as many rows as there are unknowns, kMostUnknowns at most.
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostUnknowns, 1>;
using SmallMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostUnknowns, kMostUnknowns>;

/// Sums over residuals r and their derivatives J by the unknowns.
struct NormalEquations {
  SmallMatrix information;  ///< J^T J
  SmallVector gradient;     ///< J^T r
  double squares = 0;       ///< r^T r
};

/// How triangular systems are solved. Unrolled is the faster way, for 5 or 8 unknowns (others are
/// looped over); the results differ by rounding.
enum class Substitution { kLooped, kUnrolled };

/// x of `matrix` x = `vector`, the matrix being symmetric and positive definite. Where it is not,
/// x may be anything, not finite as well.
SmallVector solved(const SmallMatrix& matrix, const SmallVector& vector);

/// The step towards less squares: the solution of the normal equations with their diagonal greater
/// by a fraction, `damping`, of itself.
SmallVector damped_step(const NormalEquations& sums, double damping,
                        Substitution substitution = Substitution::kLooped);

/// The inverse of a symmetric, positive definite matrix: of the information, the covariance of the
/// unknowns for residuals of variance 1. Where it is not definite the result is not meaningful, and
/// may not be finite.
SmallMatrix inverse_of(const SmallMatrix& matrix);

}  // namespace sightline
