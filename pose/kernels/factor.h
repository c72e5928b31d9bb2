// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Symmetric 6x6 matrices, of which kernels hold the upper triangle row by row.
#pragma once

#include <math.h>

namespace sightline::kernel {

/// The place of (row, column), row <= column, in an upper triangle stored row by row.
constexpr int at(int row, int column) {
  return row * 6 - row * (row - 1) / 2 + column - row;
}

/// H (1 + damping on the diagonal) = U^T D U with unit upper triangular U. False unless positive
/// definite.
struct Factor {
  double u[21];
  double inverse_d[6];
};

inline bool factorise(const double (&hessian)[21], double damping, Factor& f) {
  double inverse_d[6], u[21];
#pragma GCC unroll 6
  for (int i = 0; i < 6; ++i) {
    double d = hessian[at(i, i)] * (1 + damping);
#pragma GCC unroll 6
    for (int k = 0; k < i; ++k) {
      const double undivided = u[at(k, i)];
      u[at(k, i)] *= inverse_d[k];
      d -= undivided * u[at(k, i)];
    }
    if (!(d > 0)) return false;
    inverse_d[i] = 1 / d;
#pragma GCC unroll 6
    for (int j = i + 1; j < 6; ++j) {
      double sum = hessian[at(i, j)];
      // Row k of column j is still d_k u_kj: it is divided when its own turn comes.
#pragma GCC unroll 6
      for (int k = 0; k < i; ++k) sum -= u[at(k, i)] * u[at(k, j)];
      u[at(i, j)] = sum;
    }
  }
  __builtin_memcpy(f.u, u, sizeof u);
  __builtin_memcpy(f.inverse_d, inverse_d, sizeof inverse_d);
  return true;
}

inline double log_determinant(const Factor& f) {
  const double* const d = f.inverse_d;
  return -log(d[0] * d[1] * d[2]) - log(d[3] * d[4] * d[5]);
}

/// Solves H delta = -gradient.
inline void solve(const Factor& f, const double (&gradient)[6], double (&delta)[6]) {
#pragma GCC unroll 6
  for (int i = 0; i < 6; ++i) {
    delta[i] = -gradient[i];
#pragma GCC unroll 6
    for (int k = 0; k < i; ++k) delta[i] -= f.u[at(k, i)] * delta[k];
  }
#pragma GCC unroll 6
  for (int i = 0; i < 6; ++i) delta[i] *= f.inverse_d[i];
#pragma GCC unroll 6
  for (int i = 4; i >= 0; --i) {
#pragma GCC unroll 6
    for (int k = i + 1; k < 6; ++k) delta[i] -= f.u[at(i, k)] * delta[k];
  }
}

}  // namespace sightline::kernel
