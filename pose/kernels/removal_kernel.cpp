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
/// blocks stand apart; blocks (i, j), j > i, stand in four planes of `stride` numbers a row, each
/// used from column i + 1 on.
struct Level {
  double* d_uu;
  double* d_uv;
  double* d_vv;
  double* r_u;
  double* r_v;
  double* uu;
  double* uv;
  double* vu;
  double* vv;
};

constexpr std::size_t kLevelArrays = 5;
constexpr std::size_t kLevelPlanes = 4;

inline Level level_in(double* workspace, std::size_t stride, std::size_t rows) {
  Level level;
  double* next = workspace;
  for (double** array : {&level.d_uu, &level.d_uv, &level.d_vv, &level.r_u, &level.r_v}) {
    *array = next;
    next += stride;
  }
  for (double** plane : {&level.uu, &level.uv, &level.vu, &level.vv}) {
    *plane = next;
    next += rows * stride;
  }
  return level;
}

/// A 2x2 pivot, inverted, and what it gives for its own point.
struct Pivot {
  double p00, p01, p11;
  double y0, y1;  ///< inverse times residual
  double q;
  double det;
};

inline Pivot pivot_at(const Level& level, std::size_t i) {
  Pivot p;
  const double a = level.d_uu[i], b = level.d_uv[i], d = level.d_vv[i];
  p.det = a * d - b * b;
  const double inverse = 1 / p.det;
  p.p00 = d * inverse;
  p.p01 = -b * inverse;
  p.p11 = a * inverse;
  p.y0 = p.p00 * level.r_u[i] + p.p01 * level.r_v[i];
  p.y1 = p.p01 * level.r_u[i] + p.p11 * level.r_v[i];
  p.q = level.r_u[i] * p.y0 + level.r_v[i] * p.y1;
  return p;
}

struct Output {
  double* q;
  double* det;
};

/// The sets {so far, i, j} for all j > i at once.
inline void sweep_last(const Level& level, std::size_t stride, std::size_t n, std::size_t i,
                       const Pivot& p, double q, double det, Output& out) {
  const double* const a = level.uu + i * stride;
  const double* const b = level.uv + i * stride;
  const double* const c = level.vu + i * stride;
  const double* const d = level.vv + i * stride;
  double* const out_q = out.q - (i + 1);
  double* const out_det = out.det - (i + 1);
#pragma GCC ivdep
  for (std::size_t j = i + 1; j < n; ++j) {
    const double t0 = p.p00 * a[j] + p.p01 * c[j], t1 = p.p01 * a[j] + p.p11 * c[j];
    const double t2 = p.p00 * b[j] + p.p01 * d[j], t3 = p.p01 * b[j] + p.p11 * d[j];
    const double uu = level.d_uu[j] - (a[j] * t0 + c[j] * t1);
    const double uv = level.d_uv[j] - (a[j] * t2 + c[j] * t3);
    const double vv = level.d_vv[j] - (b[j] * t2 + d[j] * t3);
    const double ru = level.r_u[j] - (a[j] * p.y0 + c[j] * p.y1);
    const double rv = level.r_v[j] - (b[j] * p.y0 + d[j] * p.y1);
    const double det_j = uu * vv - uv * uv;
    out_q[j] = q + (vv * ru * ru - 2 * uv * ru * rv + uu * rv * rv) / det_j;
    out_det[j] = det * det_j;
  }
  out.q += n - i - 1;
  out.det += n - i - 1;
}

/// The level of the points after i, given that i is in the set.
inline void descend(const Level& level, std::size_t stride, std::size_t n, std::size_t i,
                    const Pivot& p, const Level& next) {
  const double* const a = level.uu + i * stride;
  const double* const b = level.uv + i * stride;
  const double* const c = level.vu + i * stride;
  const double* const d = level.vv + i * stride;
  // Inverse pivot times block (i, j), kept where the next level has no use for it: in row i.
  double* const t0 = next.uu + i * stride;
  double* const t1 = next.uv + i * stride;
  double* const t2 = next.vu + i * stride;
  double* const t3 = next.vv + i * stride;
#pragma GCC ivdep
  for (std::size_t j = i + 1; j < n; ++j) {
    t0[j] = p.p00 * a[j] + p.p01 * c[j];
    t1[j] = p.p01 * a[j] + p.p11 * c[j];
    t2[j] = p.p00 * b[j] + p.p01 * d[j];
    t3[j] = p.p01 * b[j] + p.p11 * d[j];
    next.d_uu[j] = level.d_uu[j] - (a[j] * t0[j] + c[j] * t1[j]);
    next.d_uv[j] = level.d_uv[j] - (a[j] * t2[j] + c[j] * t3[j]);
    next.d_vv[j] = level.d_vv[j] - (b[j] * t2[j] + d[j] * t3[j]);
    next.r_u[j] = level.r_u[j] - (a[j] * p.y0 + c[j] * p.y1);
    next.r_v[j] = level.r_v[j] - (b[j] * p.y0 + d[j] * p.y1);
  }
  for (std::size_t j = i + 1; j + 1 < n; ++j) {
    const double aj = a[j], bj = b[j], cj = c[j], dj = d[j];
    const std::size_t row = j * stride;
#pragma GCC ivdep
    for (std::size_t k = j + 1; k < n; ++k) {
      next.uu[row + k] = level.uu[row + k] - (aj * t0[k] + cj * t1[k]);
      next.uv[row + k] = level.uv[row + k] - (aj * t2[k] + cj * t3[k]);
      next.vu[row + k] = level.vu[row + k] - (bj * t0[k] + dj * t1[k]);
      next.vv[row + k] = level.vv[row + k] - (bj * t2[k] + dj * t3[k]);
    }
  }
}

inline std::size_t level_size(std::size_t n, std::size_t stride, int remaining) {
  return kLevelArrays * stride + (remaining > 1 ? kLevelPlanes * n * stride : 0);
}

/// M + gamma I from the basis.
inline void fill(const Level& level, std::size_t stride, std::size_t n, const double* basis,
                 const double* residuals, const double* gamma, bool has_planes) {
  const double* const basis_u = basis;
  const double* const basis_v = basis + 6 * stride;
  for (std::size_t i = 0; i < n; ++i) {
    double uu = 1 + gamma[i], uv = 0, vv = 1 + gamma[i];
    for (std::size_t k = 0; k < 6; ++k) {
      const double u = basis_u[k * stride + i], v = basis_v[k * stride + i];
      uu -= u * u;
      uv -= u * v;
      vv -= v * v;
    }
    level.d_uu[i] = uu;
    level.d_uv[i] = uv;
    level.d_vv[i] = vv;
    level.r_u[i] = residuals[i];
    level.r_v[i] = residuals[stride + i];
  }
  if (!has_planes) return;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const std::size_t row = i * stride;
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
  }
}

/// Depth-first over the sets; one entry of the stack for each point of the set so far.
inline void sweep(std::size_t stride, std::size_t n, int max_size, double* workspace, Output out) {
  struct Entry {
    Level level;
    std::size_t next;  ///< the point to take
    double q, det;     ///< of the set so far
  };
  Entry stack[kMaxRemoved];
  for (int depth = 0; depth < max_size; ++depth) {
    stack[depth].level = level_in(workspace, stride, n);
    workspace += level_size(n, stride, max_size - depth);
  }
  stack[0].next = 0;
  stack[0].q = 0;
  stack[0].det = 1;
  int depth = 0;
  while (depth >= 0) {
    Entry& entry = stack[depth];
    if (entry.next == n) {
      --depth;
      continue;
    }
    const std::size_t i = entry.next++;
    const Pivot p = pivot_at(entry.level, i);
    const double q = entry.q + p.q;
    const double det = entry.det * p.det;
    *out.q++ = q;
    *out.det++ = det;
    const int remaining = max_size - depth - 1;
    if (remaining == 0 || i + 1 == n) continue;
    if (remaining == 1) {
      sweep_last(entry.level, stride, n, i, p, q, det, out);
      continue;
    }
    descend(entry.level, stride, n, i, p, stack[depth + 1].level);
    ++depth;
    stack[depth].next = i + 1;
    stack[depth].q = q;
    stack[depth].det = det;
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

std::size_t sweep_workspace(std::size_t n, int max_size) {
  std::size_t size = 0;
  for (int remaining = max_size; remaining > 0; --remaining) {
    size += level_size(n, padded(n), remaining);
  }
  return size;
}

SIGHTLINE_MULTIVERSION
void sweep_sets(std::size_t n, const double* basis, const double* residuals, const double* gamma,
                int max_size, double* workspace, double* q, double* det) {
  const std::size_t stride = padded(n);
  fill(level_in(workspace, stride, n), stride, n, basis, residuals, gamma, max_size > 1);
  sweep(stride, n, max_size, workspace, {q, det});
}

}  // namespace sightline::kernel
