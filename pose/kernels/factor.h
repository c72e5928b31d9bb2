// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Symmetric 6x6 matrices, of which kernels hold the upper triangle row by row.
#pragma once

#include <cmath>

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

/// A symmetric 3x3 matrix's inverse by its adjugate: one division where a factorisation has three
/// in a row. False unless positive definite.
struct Symmetric3 {
  double xx, xy, xz, yy, yz, zz;
};

inline bool invert(const Symmetric3& m, Symmetric3& inverse) {
  const double xx = m.yy * m.zz - m.yz * m.yz;
  const double xy = m.xz * m.yz - m.xy * m.zz;
  const double xz = m.xy * m.yz - m.xz * m.yy;
  const double minor = m.xx * m.yy - m.xy * m.xy;
  const double det = m.xx * xx + m.xy * xy + m.xz * xz;
  if (!(m.xx > 0 && minor > 0 && det > 0)) return false;
  const double k = 1 / det;
  inverse = {
      k * xx,   k * xy, k * xz, k * (m.xx * m.zz - m.xz * m.xz), k * (m.xy * m.xz - m.xx * m.yz),
      k * minor};
  return true;
}

/// Solves (H + damping diag H) delta = -gradient by blocks: the translation is eliminated. False
/// unless positive definite. The shortest chain of dependent steps we know; factorise and solve are
/// the plain version.
inline bool solve_by_blocks(const double (&h)[21], double damping, const double (&g)[6],
                            double (&delta)[6]) {
  const double f = 1 + damping;
  const Symmetric3 tt = {f * h[at(3, 3)], h[at(3, 4)], h[at(3, 5)],
                         f * h[at(4, 4)], h[at(4, 5)], f * h[at(5, 5)]};
  Symmetric3 v;  // inverse of the translation's block
  if (!invert(tt, v)) return false;
  double k[3][3];  // block (rotation, translation) times v
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    const double a = h[at(i, 3)], b = h[at(i, 4)], c = h[at(i, 5)];
    k[i][0] = a * v.xx + b * v.xy + c * v.xz;
    k[i][1] = a * v.xy + b * v.yy + c * v.yz;
    k[i][2] = a * v.xz + b * v.yz + c * v.zz;
  }
  const auto schur = [&](int i, int j, double scale) {
    return scale * h[at(i, j)] -
           (k[i][0] * h[at(j, 3)] + k[i][1] * h[at(j, 4)] + k[i][2] * h[at(j, 5)]);
  };
  const Symmetric3 ww = {schur(0, 0, f), schur(0, 1, 1), schur(0, 2, 1),
                         schur(1, 1, f), schur(1, 2, 1), schur(2, 2, f)};
  Symmetric3 s;
  if (!invert(ww, s)) return false;
  double r[3];
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) r[i] = k[i][0] * g[3] + k[i][1] * g[4] + k[i][2] * g[5] - g[i];
  delta[0] = s.xx * r[0] + s.xy * r[1] + s.xz * r[2];
  delta[1] = s.xy * r[0] + s.yy * r[1] + s.yz * r[2];
  delta[2] = s.xz * r[0] + s.yz * r[1] + s.zz * r[2];
  const double q[3] = {v.xx * g[3] + v.xy * g[4] + v.xz * g[5],
                       v.xy * g[3] + v.yy * g[4] + v.yz * g[5],
                       v.xz * g[3] + v.yz * g[4] + v.zz * g[5]};
#pragma GCC unroll 3
  for (int j = 0; j < 3; ++j) {
    delta[3 + j] = -q[j] - (k[0][j] * delta[0] + k[1][j] * delta[1] + k[2][j] * delta[2]);
  }
  return true;
}

}  // namespace sightline::kernel
