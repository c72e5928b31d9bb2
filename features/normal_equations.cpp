// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/normal_equations.h"

#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

namespace sightline {
namespace {

using Factor = Eigen::LDLT<SmallMatrix>;

// x of P^T L D L^T P x = vector, of a size that the compiler knows.
template <int kSize>
SmallVector substituted(const Factor& factor, const SmallVector& vector) {
  const Eigen::Matrix<double, kSize, kSize> lower = factor.matrixLDLT();
  Eigen::Matrix<double, kSize, 1> x = factor.transpositionsP() * vector;
  lower.template triangularView<Eigen::UnitLower>().solveInPlace(x);
  for (int i = 0; i < kSize; ++i) {
    const bool is_zero = !(std::abs(lower(i, i)) > std::numeric_limits<double>::min());
    x[i] = is_zero ? 0 : x[i] / lower(i, i);
  }
  lower.transpose().template triangularView<Eigen::UnitUpper>().solveInPlace(x);
  return factor.transpositionsP().transpose() * x;
}

}  // namespace

SmallVector solved(const SmallMatrix& matrix, const SmallVector& vector) {
  return Factor(matrix).solve(vector);
}

SmallVector damped_step(const NormalEquations& sums, double damping, Substitution substitution) {
  constexpr double kLeastDamping = 1e-9;  // for an unknown on which nothing depends
  SmallMatrix damped = sums.information;
  damped.diagonal() *= 1 + damping;
  damped.diagonal().array() += kLeastDamping;
  const Factor factor(damped);
  if (substitution == Substitution::kUnrolled) {
    if (damped.rows() == 5) return substituted<5>(factor, sums.gradient);
    if (damped.rows() == 8) return substituted<8>(factor, sums.gradient);
  }
  return factor.solve(sums.gradient);
}

SmallMatrix inverse_of(const SmallMatrix& matrix) {
  return Factor(matrix).solve(SmallMatrix::Identity(matrix.rows(), matrix.rows()));
}

}  // namespace sightline
