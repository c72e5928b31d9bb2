// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/kernels/removal_kernel.h"

#include <cmath>
#include <initializer_list>

#include "pose/kernels/factor.h"
#include "pose/kernels/lanes.h"
#include "pose/multiversion.h"

namespace sightline::kernel {
namespace {

inline Lanes square_root(const Lanes& x) {
  Lanes root;
  for (std::size_t i = 0; i < kLanes; ++i) root[i] = sqrt(x[i]);
  return root;
}

inline double sum(const Lanes& x) {
  return (x[0] + x[1]) + (x[2] + x[3]);
}

/// Whitened rows of the Jacobian, the twelve arrays of J^T, and residuals. With W = L L^T a row
/// pair (a, b) becomes L^T (a, b).
inline void whitened_rows(const PointLanes* points, std::size_t count, const RigidPose& pose,
                          double* rows, double* residuals) {
  const std::size_t stride = count * kLanes;
  const Lanes zero = {};
  for (std::size_t i = 0; i < count; ++i) {
    const PointLanes& p = points[i];
    const ReprojectedLanes e = reproject(p, pose);
    const Lanes w_uu = lanes_of(p.w_uu);
    const Lanes l00 = square_root(w_uu);
    const Lanes l10 = w_uu > zero ? lanes_of(p.w_uv) / l00 : zero;
    const Lanes l11 = square_root(lanes_of(p.w_vv) - l10 * l10);
    const Lanes row_u[6] = {e.u0, e.u1, e.u2, e.s, zero, -e.su};
    const Lanes row_v[6] = {e.v0, e.v1, e.v2, zero, e.s, -e.sv};
    for (std::size_t k = 0; k < 6; ++k) {
      store(l00 * row_u[k] + l10 * row_v[k], rows + k * stride + i * kLanes);
      store(l11 * row_v[k], rows + (6 + k) * stride + i * kLanes);
    }
    store(l00 * e.ru + l10 * e.rv, residuals + i * kLanes);
    store(l11 * e.rv, residuals + stride + i * kLanes);
  }
}

/// rows <- D^-1/2 U^-T rows, for u and v alike.
inline void orthonormalise(const LinearModel& model, std::size_t stride, double* rows) {
  for (double* half : {rows, rows + 6 * stride}) {
    for (std::size_t i = 0; i < stride; i += kLanes) {
      Lanes y[6];
#pragma GCC unroll 6
      for (int k = 0; k < 6; ++k) {
        y[k] = load(half + k * stride + i);
#pragma GCC unroll 6
        for (int b = 0; b < k; ++b) y[k] -= model.u[at(b, k)] * y[b];
      }
#pragma GCC unroll 6
      for (int k = 0; k < 6; ++k) store(y[k] * sqrt(model.inverse_d[k]), half + k * stride + i);
    }
  }
}

/// residuals <- (I - basis^T basis) residuals.
inline double project_residuals(std::size_t stride, const double* basis, double* residuals) {
  double c[6];
  for (std::size_t k = 0; k < 6; ++k) {
    Lanes along = {};
    for (std::size_t i = 0; i < stride; i += kLanes) {
      along += load(basis + k * stride + i) * load(residuals + i) +
               load(basis + (6 + k) * stride + i) * load(residuals + stride + i);
    }
    c[k] = sum(along);
  }
  Lanes rss = {};
  for (std::size_t half = 0; half < 2; ++half) {
    for (std::size_t i = 0; i < stride; i += kLanes) {
      Lanes r = load(residuals + half * stride + i);
      for (std::size_t k = 0; k < 6; ++k) r -= c[k] * load(basis + (6 * half + k) * stride + i);
      store(r, residuals + half * stride + i);
      rss += r * r;
    }
  }
  return sum(rss);
}

/// What is left of M + gamma I, and of the residuals, for the points after a set. The diagonal
/// blocks stand apart, inverted beside themselves; blocks (i, j), j > i, stand in four planes of
/// `stride` numbers a row, each used from column i + 1 on.
struct Level {
  double* d_uu;
  double* d_uv;
  double* d_vv;
  double* r_u;
  double* r_v;
  // Of each point's block: the inverse, the inverse times the residual, and what the point gives.
  double* p00;
  double* p01;
  double* p11;
  double* y0;
  double* y1;
  double* q;
  double* det;
  double* uu;
  double* uv;
  double* vu;
  double* vv;
};

constexpr std::size_t kLevelArrays = 12;
constexpr std::size_t kLevelPlanes = 4;

/// Lanes are loaded from any column on, so that a row ends with room for the rest of the last.
inline std::size_t row_length(std::size_t n) {
  return padded(n) + kLanes;
}

inline Level level_in(double* workspace, std::size_t stride, std::size_t rows) {
  Level level;
  double* next = workspace;
  for (double** array : {&level.d_uu, &level.d_uv, &level.d_vv, &level.r_u, &level.r_v, &level.p00,
                         &level.p01, &level.p11, &level.y0, &level.y1, &level.q, &level.det}) {
    *array = next;
    next += stride;
  }
  for (double** plane : {&level.uu, &level.uv, &level.vu, &level.vv}) {
    *plane = next;
    next += rows * stride;
  }
  return level;
}

inline std::size_t level_size(std::size_t n, std::size_t stride, int remaining) {
  return kLevelArrays * stride + (remaining > 1 ? kLevelPlanes * n * stride : 0);
}

/// ln x, x > 0, from below and no more than kRoughLog off: between powers of two it is linear. Of
/// other numbers it says nothing.
inline Lanes rough_log(const Lanes& x) {
  typedef unsigned long long Bits __attribute__((vector_size(kLanes * sizeof(long long))));
  constexpr double kLn2 = 0.693147180559945309;
  // The upper 52 bits, made the mantissa of a number between 2^52 and 2^53.
  const Bits bits = ((Bits)x >> 12) | 0x4330000000000000u;
  const Lanes exponent_and_mantissa = ((Lanes)bits - 0x1p52) * 0x1p-40;
  return (exponent_and_mantissa - 1023.0) * kLn2;
}

/// Of the set so far.
struct Sums {
  double q = 0;
  double det = 1;
  double odds = 0;  ///< twice their logarithm
};

/// Writes sets side by side, of which `count` count: what is beyond is written over later.
inline void put(const Lanes& q, const Lanes& det, const Lanes& odds, std::size_t count,
                SweptSets& out) {
  store(q, out.q);
  store(det, out.det);
  store(q + odds - rough_log(det), out.weight);
  out.q += count;
  out.det += count;
  out.weight += count;
}

inline Lanes everywhere(double x) {
  return Lanes{} + x;
}

/// The inverse blocks of the points from `first` on.
inline void invert_diagonal(const Level& level, std::size_t first, std::size_t n) {
  for (std::size_t j = first; j < n; j += kLanes) {
    const Lanes a = load(level.d_uu + j), b = load(level.d_uv + j), d = load(level.d_vv + j);
    const Lanes ru = load(level.r_u + j), rv = load(level.r_v + j);
    const Lanes det = a * d - b * b;
    const Lanes inverse = 1.0 / det;
    const Lanes p00 = d * inverse, p01 = -b * inverse, p11 = a * inverse;
    const Lanes y0 = p00 * ru + p01 * rv, y1 = p01 * ru + p11 * rv;
    store(p00, level.p00 + j);
    store(p01, level.p01 + j);
    store(p11, level.p11 + j);
    store(y0, level.y0 + j);
    store(y1, level.y1 + j);
    store(ru * y0 + rv * y1, level.q + j);
    store(det, level.det + j);
  }
}

/// The sets {so far, i} for all i.
inline void put_singles(const Level& level, const double* odds, std::size_t n, SweptSets& out) {
  for (std::size_t i = 0; i < n; i += kLanes) {
    const std::size_t count = n - i < kLanes ? n - i : kLanes;
    put(load(level.q + i), load(level.det + i), load(odds + i), count, out);
  }
}

/// What is left of the diagonal block and the residual of points j, j + 1, ... when i is taken, and
/// the inverse block of i times block (i, j).
struct Rest {
  Lanes uu, uv, vv, ru, rv;
  Lanes t0, t1, t2, t3;
};

inline Rest rest_of(const Level& level, std::size_t row, std::size_t i, std::size_t j) {
  const Lanes a = load(level.uu + row + j), b = load(level.uv + row + j);
  const Lanes c = load(level.vu + row + j), d = load(level.vv + row + j);
  const double p00 = level.p00[i], p01 = level.p01[i], p11 = level.p11[i];
  const double y0 = level.y0[i], y1 = level.y1[i];
  Rest rest;
  rest.t0 = p00 * a + p01 * c;
  rest.t1 = p01 * a + p11 * c;
  rest.t2 = p00 * b + p01 * d;
  rest.t3 = p01 * b + p11 * d;
  rest.uu = load(level.d_uu + j) - (a * rest.t0 + c * rest.t1);
  rest.uv = load(level.d_uv + j) - (a * rest.t2 + c * rest.t3);
  rest.vv = load(level.d_vv + j) - (b * rest.t2 + d * rest.t3);
  rest.ru = load(level.r_u + j) - (a * y0 + c * y1);
  rest.rv = load(level.r_v + j) - (b * y0 + d * y1);
  return rest;
}

/// The sets {so far, i, j} for all j > i at once; `sums` are those with i.
inline void sweep_last(const Level& level, std::size_t stride, std::size_t n, std::size_t i,
                       const double* odds, const Sums& sums, SweptSets& out) {
  for (std::size_t j = i + 1; j < n; j += kLanes) {
    const Rest r = rest_of(level, i * stride, i, j);
    const Lanes det = r.uu * r.vv - r.uv * r.uv;
    const Lanes q =
        (r.vv * r.ru * r.ru - 2.0 * r.uv * r.ru * r.rv + r.uu * r.rv * r.rv) / det + sums.q;
    const std::size_t count = n - j < kLanes ? n - j : kLanes;
    put(q, sums.det * det, load(odds + j) + sums.odds, count, out);
  }
}

/// The level of the points after i, given that i is in the set.
inline void descend(const Level& level, std::size_t stride, std::size_t n, std::size_t i,
                    const Level& next) {
  // Inverse block times block (i, j), kept where the next level has no use for it: in row i.
  const std::size_t row_i = i * stride;
  for (std::size_t j = i + 1; j < n; j += kLanes) {
    const Rest r = rest_of(level, row_i, i, j);
    store(r.t0, next.uu + row_i + j);
    store(r.t1, next.uv + row_i + j);
    store(r.t2, next.vu + row_i + j);
    store(r.t3, next.vv + row_i + j);
    store(r.uu, next.d_uu + j);
    store(r.uv, next.d_uv + j);
    store(r.vv, next.d_vv + j);
    store(r.ru, next.r_u + j);
    store(r.rv, next.r_v + j);
  }
  for (std::size_t j = i + 1; j + 1 < n; ++j) {
    const double a = level.uu[row_i + j], b = level.uv[row_i + j];
    const double c = level.vu[row_i + j], d = level.vv[row_i + j];
    const std::size_t row = j * stride;
    for (std::size_t k = j + 1; k < n; k += kLanes) {
      const Lanes t0 = load(next.uu + row_i + k), t1 = load(next.uv + row_i + k);
      const Lanes t2 = load(next.vu + row_i + k), t3 = load(next.vv + row_i + k);
      store(load(level.uu + row + k) - (a * t0 + c * t1), next.uu + row + k);
      store(load(level.uv + row + k) - (a * t2 + c * t3), next.uv + row + k);
      store(load(level.vu + row + k) - (b * t0 + d * t1), next.vu + row + k);
      store(load(level.vv + row + k) - (b * t2 + d * t3), next.vv + row + k);
    }
  }
  invert_diagonal(next, i + 1, n);
}

/// M + gamma I from the basis.
inline void fill_diagonal(const Level& level, const SweepProblem& problem) {
  const std::size_t n = problem.points, stride = padded(n);
  const double* const basis_v = problem.basis + 6 * stride;
  for (std::size_t i = 0; i < n; i += kLanes) {
    Lanes gamma = {};
    for (std::size_t lane = 0; lane < kLanes && i + lane < n; ++lane) {
      gamma[lane] = problem.gamma[i + lane];
    }
    Lanes uu = 1.0 + gamma, uv = {}, vv = uu;
#pragma GCC unroll 6
    for (std::size_t k = 0; k < 6; ++k) {
      const Lanes u = load(problem.basis + k * stride + i), v = load(basis_v + k * stride + i);
      uu -= u * u;
      uv -= u * v;
      vv -= v * v;
    }
    store(uu, level.d_uu + i);
    store(uv, level.d_uv + i);
    store(vv, level.d_vv + i);
    store(load(problem.residuals + i), level.r_u + i);
    store(load(problem.residuals + stride + i), level.r_v + i);
  }
  invert_diagonal(level, 0, n);
}

inline void fill_planes(const Level& level, std::size_t row_stride, const SweepProblem& problem) {
  const std::size_t n = problem.points, stride = padded(n);
  const double* const basis_u = problem.basis;
  const double* const basis_v = basis_u + 6 * stride;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const std::size_t row = i * row_stride;
    for (std::size_t j = (i + 1) / kLanes * kLanes; j < stride; j += kLanes) {
      Lanes uu = {}, uv = {}, vu = {}, vv = {};
#pragma GCC unroll 6
      for (std::size_t k = 0; k < 6; ++k) {
        const Lanes u = load(basis_u + k * stride + j), v = load(basis_v + k * stride + j);
        const double ui = basis_u[k * stride + i], vi = basis_v[k * stride + i];
        uu -= ui * u;
        uv -= ui * v;
        vu -= vi * u;
        vv -= vi * v;
      }
      store(uu, level.uu + row + j);
      store(uv, level.uv + row + j);
      store(vu, level.vu + row + j);
      store(vv, level.vv + row + j);
    }
    for (double* plane : {level.uu, level.uv, level.vu, level.vv}) {
      store(Lanes{}, plane + row + stride);
    }
  }
}

/// Depth-first over the sets; one entry of the stack for each point of the set so far.
inline void sweep(std::size_t n, int max_size, const Level& first, const double* odds,
                  double* workspace, SweptSets out) {
  struct Entry {
    Level level;
    std::size_t next = 0;  ///< the point to take
    Sums sums;             ///< of the set so far
  };
  const std::size_t stride = row_length(n);
  Entry stack[kMaxRemoved];
  stack[0].level = first;
  for (int depth = 1; depth < max_size; ++depth) {
    stack[depth].level = level_in(workspace, stride, n);
    workspace += level_size(n, stride, max_size - depth);
  }
  int depth = 0;
  while (depth >= 0) {
    Entry& entry = stack[depth];
    if (entry.next == n) {
      --depth;
      continue;
    }
    const std::size_t i = entry.next++;
    const Sums sums = {entry.sums.q + entry.level.q[i], entry.sums.det * entry.level.det[i],
                       entry.sums.odds + odds[i]};
    put(everywhere(sums.q), everywhere(sums.det), everywhere(sums.odds), 1, out);
    const int remaining = max_size - depth - 1;
    if (remaining == 0 || i + 1 == n) continue;
    if (remaining == 1) {
      sweep_last(entry.level, stride, n, i, odds, sums, out);
      continue;
    }
    descend(entry.level, stride, n, i, stack[depth + 1].level);
    ++depth;
    stack[depth].next = i + 1;
    stack[depth].sums = sums;
  }
}

}  // namespace

SIGHTLINE_MULTIVERSION
bool linearise(const PointLanes* lanes, std::size_t count, const RigidPose& pose, double* basis,
               double* residuals, LinearModel& model) {
  NormalEquations equations;
  if (!normal_equations(lanes, count, pose, equations)) return false;
  Factor factor;
  if (!factorise(equations.hessian, 0, factor)) return false;
  solve(factor, equations.gradient, model.step);
  __builtin_memcpy(model.u, factor.u, sizeof factor.u);
  __builtin_memcpy(model.inverse_d, factor.inverse_d, sizeof factor.inverse_d);
  model.log_det = log_determinant(factor);
  const std::size_t stride = count * kLanes;
  whitened_rows(lanes, count, pose, basis, residuals);
  orthonormalise(model, stride, basis);
  model.rss = project_residuals(stride, basis, residuals);
  return true;
}

void step_along(const LinearModel& model, const double (&z)[6], double (&delta)[6]) {
  for (int i = 5; i >= 0; --i) {
    delta[i] = z[i] * sqrt(model.inverse_d[i]);
    for (int k = i + 1; k < 6; ++k) delta[i] -= model.u[at(i, k)] * delta[k];
  }
}

std::size_t set_count(std::size_t n, int max_size) {
  std::size_t count = 0, of_size = 1;
  for (std::size_t k = 1; k <= static_cast<std::size_t>(max_size) && k <= n; ++k) {
    of_size = of_size * (n - k + 1) / k;
    count += of_size;
  }
  return count;
}

std::size_t swept_room(std::size_t n, int max_size) {
  return set_count(n, max_size) + kLanes;
}

std::size_t sweep_workspace(std::size_t n, int max_size) {
  const std::size_t stride = row_length(n);
  std::size_t size = stride;  // for the odds
  for (int remaining = max_size; remaining > 0; --remaining) {
    size += level_size(n, stride, remaining);
  }
  return size;
}

SIGHTLINE_MULTIVERSION
void sweep_sets(const SweepProblem& problem, int max_size, int before, double* workspace,
                const SweptSets& out) {
  const std::size_t n = problem.points, stride = row_length(n);
  double* const odds = workspace;
  workspace += stride;
  const Level first = level_in(workspace, stride, n);
  workspace += level_size(n, stride, max_size);
  if (before == 0) {
    for (std::size_t i = 0; i < n; ++i) odds[i] = 2 * problem.log_odds[i];
    for (std::size_t i = n; i < stride; ++i) odds[i] = 0;
    fill_diagonal(first, problem);
  }
  if (max_size == 1) {
    SweptSets next = out;
    put_singles(first, odds, n, next);
    return;
  }
  if (before < 2) fill_planes(first, stride, problem);
  sweep(n, max_size, first, odds, workspace, out);
}

SIGHTLINE_MULTIVERSION
std::size_t largest_of(const double* values, std::size_t count) {
  Lanes largest = everywhere(values[0]);
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    const Lanes x = load(values + i);
    largest = x > largest ? x : largest;
  }
  double most = largest[0];
  for (std::size_t lane = 1; lane < kLanes; ++lane) {
    if (largest[lane] > most) most = largest[lane];
  }
  for (; i < count; ++i) {
    if (values[i] > most) most = values[i];
  }
  for (i = 0; i + 1 < count; ++i) {
    if (values[i] == most) return i;
  }
  return values[i] == most ? i : 0;
}

}  // namespace sightline::kernel
