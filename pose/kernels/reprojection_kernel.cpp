// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Four points go side by side (lanes.h), and the lanes are added at the very end, four sums at a
// time.

#include "pose/kernels/reprojection_kernel.h"

#include <cmath>

#include "pose/kernels/edge_lanes.h"
#include "pose/kernels/factor.h"
#include "pose/kernels/lanes.h"
#include "pose/kernels/marquardt.h"
#include "pose/multiversion.h"

namespace sightline::kernel {
namespace {

inline bool evaluate(const Observed& observed, const RigidPose& pose, NormalEquations& model) {
  const Lanes zero = {};
  Lanes cost = zero;
  Lanes g0 = zero, g1 = zero, g2 = zero, g3 = zero, g4 = zero, g5 = zero;
  Lanes h00 = zero, h01 = zero, h02 = zero, h03 = zero, h04 = zero, h05 = zero;
  Lanes h11 = zero, h12 = zero, h13 = zero, h14 = zero, h15 = zero;
  Lanes h22 = zero, h23 = zero, h24 = zero, h25 = zero;
  Lanes h33 = zero, h34 = zero, h35 = zero, h44 = zero, h45 = zero, h55 = zero;
  Mask is_behind = {};
  for (std::size_t i = 0; i < observed.point_count; ++i) {
    const PointLanes& p = observed.points[i];
    const Lanes w_uu = lanes_of(p.w_uu), w_uv = lanes_of(p.w_uv), w_vv = lanes_of(p.w_vv);
    const ReprojectedLanes e = reproject(p, pose);
    is_behind |= e.is_behind;
    const Lanes ru = e.ru, rv = e.rv, s = e.s, su = e.su, sv = e.sv;
    const Lanes u0 = e.u0, u1 = e.u1, u2 = e.u2, v0 = e.v0, v1 = e.v1, v2 = e.v2;

    // Rows of W J: the pair (a, b) of column k.
    const Lanes a0 = w_uu * u0 + w_uv * v0, b0 = w_uv * u0 + w_vv * v0;
    const Lanes a1 = w_uu * u1 + w_uv * v1, b1 = w_uv * u1 + w_vv * v1;
    const Lanes a2 = w_uu * u2 + w_uv * v2, b2 = w_uv * u2 + w_vv * v2;
    const Lanes a3 = w_uu * s, b3 = w_uv * s, b4 = w_vv * s;
    const Lanes a5 = -(w_uu * su + w_uv * sv), b5 = -(w_uv * su + w_vv * sv);
    h00 += a0 * u0 + b0 * v0;
    h01 += a0 * u1 + b0 * v1;
    h02 += a0 * u2 + b0 * v2;
    h03 += a0 * s;
    h04 += b0 * s;
    h05 -= a0 * su + b0 * sv;
    h11 += a1 * u1 + b1 * v1;
    h12 += a1 * u2 + b1 * v2;
    h13 += a1 * s;
    h14 += b1 * s;
    h15 -= a1 * su + b1 * sv;
    h22 += a2 * u2 + b2 * v2;
    h23 += a2 * s;
    h24 += b2 * s;
    h25 -= a2 * su + b2 * sv;
    h33 += a3 * s;
    h34 += b3 * s;
    h35 += a5 * s;
    h44 += b4 * s;
    h45 += b5 * s;
    h55 -= a5 * su + b5 * sv;
    g0 += a0 * ru + b0 * rv;
    g1 += a1 * ru + b1 * rv;
    g2 += a2 * ru + b2 * rv;
    g3 += a3 * ru + b3 * rv;
    g4 += b3 * ru + b4 * rv;
    g5 += a5 * ru + b5 * rv;
    cost += ru * (w_uu * ru + w_uv * rv) + rv * (w_uv * ru + w_vv * rv);
  }
  if (is_any(is_behind)) return false;
  Lanes sums[28] = {0.5 * cost, g0,  g1,  g2,  g3,  g4,  g5,  h00, h01, h02, h03, h04, h05, h11,
                    h12,        h13, h14, h15, h22, h23, h24, h25, h33, h34, h35, h44, h45, h55};
  if (observed.edge_count > 0 && !add_edges(observed.edges, observed.edge_count, pose, sums)) {
    return false;
  }
  static_assert(sizeof model == 28 * sizeof(double));
  double* const out = &model.cost;
#pragma GCC unroll 7
  for (int i = 0; i < 28; i += 4) {
    store(lane_sums(sums[i], sums[i + 1], sums[i + 2], sums[i + 3]), out + i);
  }
  return true;
}

/// What the model says that a step gains: -g.delta - 1/2 delta.H delta, with (H + damping diag H)
/// delta = -g.
inline double promised_decrease(const NormalEquations& model, const double (&delta)[6],
                                double damping) {
  double along = 0, damped = 0;
#pragma GCC unroll 6
  for (int i = 0; i < 6; ++i) {
    along += model.gradient[i] * delta[i];
    damped += model.hessian[at(i, i)] * delta[i] * delta[i];
  }
  return 0.5 * (damping * damped - along);
}

/// Cayley's turn, by 2 atan(|w| / 2) instead of |w|: equal to second order, and a rotation for
/// every w.
inline RigidPose moved(const RigidPose& pose, const double (&delta)[6]) {
  const double x = 0.5 * delta[0], y = 0.5 * delta[1], z = 0.5 * delta[2];
  const double k = 2 / (1 + x * x + y * y + z * z);
  const double turn[9] = {
      1 - k * (y * y + z * z), k * (x * y - z),         k * (x * z + y),
      k * (x * y + z),         1 - k * (x * x + z * z), k * (y * z - x),
      k * (x * z - y),         k * (y * z + x),         1 - k * (x * x + y * y)};
  RigidPose next;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      next.rotation[3 * i + j] = turn[3 * i] * pose.rotation[j] +
                                 turn[3 * i + 1] * pose.rotation[3 + j] +
                                 turn[3 * i + 2] * pose.rotation[6 + j];
    }
    next.translation[i] = pose.translation[i] + delta[3 + i];
  }
  return next;
}

inline double squared_norm(const double* v) {
  return v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
}

inline bool is_short(const double (&delta)[6], const RigidPose& pose, double tolerance) {
  const double tolerance2 = tolerance * tolerance;
  return squared_norm(delta) < tolerance2 &&
         squared_norm(delta + 3) < tolerance2 * squared_norm(pose.translation);
}

inline bool is_in_front(const PointLanes* points, std::size_t count, const RigidPose& pose) {
  const double* const r = pose.rotation;
  const Lanes zero = {};
  Mask is_behind = {};
  for (std::size_t i = 0; i < count; ++i) {
    const PointLanes& p = points[i];
    const Lanes depth =
        r[6] * lanes_of(p.x) + r[7] * lanes_of(p.y) + r[8] * lanes_of(p.z) + pose.translation[2];
    is_behind |= ~(depth > zero) & (lanes_of(p.w_uu) + lanes_of(p.w_vv) > zero);
  }
  return !is_any(is_behind);
}

inline bool is_in_front(const Observed& observed, const RigidPose& pose) {
  if (!is_in_front(observed.points, observed.point_count, pose)) return false;
  Mask is_undefined = {};
  for (std::size_t i = 0; i < observed.edge_count; ++i) {
    is_undefined |= edge_residual(observed.edges[i], pose).is_undefined;
  }
  return !is_any(is_undefined);
}

/// The fit of a pose to packed points and edges, as the iteration of marquardt.h asks for it.
class LanesFit {
 public:
  LanesFit(const Observed& observed, const RigidPose& start, double tolerance)
      : observed_(observed), tolerance_(tolerance) {
    best().pose = start;
  }

  bool evaluate_start() { return evaluate(observed_, best().pose, best().model); }
  bool propose(double damping) {
    return solve_by_blocks(best().model.hessian, damping, best().model.gradient, delta_);
  }
  bool is_short_step() const { return is_short(delta_, best().pose, tolerance_); }
  double promise(double damping) const { return promised_decrease(best().model, delta_, damping); }
  double cost() const { return best().model.cost; }
  bool evaluate_candidate() {
    candidate().pose = moved(best().pose, delta_);
    return evaluate(observed_, candidate().pose, candidate().model);
  }
  double candidate_cost() const { return candidate().model.cost; }
  void accept() { best_ = 1 - best_; }
  /// Shorter than the tolerance, the step is not worth another evaluation: the model stays that of
  /// the pose before it.
  void take_last_step() {
    const RigidPose last = moved(best().pose, delta_);
    if (is_in_front(observed_, last)) best().pose = last;
  }

  const RigidPose& pose() const { return best().pose; }
  const NormalEquations& model() const { return best().model; }

 private:
  struct Place {
    RigidPose pose;
    NormalEquations model;
  };
  Place& best() { return places_[best_]; }
  const Place& best() const { return places_[best_]; }
  Place& candidate() { return places_[1 - best_]; }
  const Place& candidate() const { return places_[1 - best_]; }

  Observed observed_;
  double tolerance_;
  double delta_[6];
  /// One is the best so far and the other the candidate. When a candidate is accepted they change
  /// parts: to copy one takes as long as a third of an evaluation.
  Place places_[2];
  int best_ = 0;
};

}  // namespace

SIGHTLINE_MULTIVERSION
bool normal_equations(const PointLanes* lanes, std::size_t count, const RigidPose& pose,
                      NormalEquations& model) {
  return evaluate({.points = lanes, .point_count = count}, pose, model);
}

SIGHTLINE_MULTIVERSION
bool normal_equations(const Observed& observed, const RigidPose& pose, NormalEquations& model) {
  return evaluate(observed, pose, model);
}

SIGHTLINE_MULTIVERSION
Fit fit(const Observed& observed, const RigidPose& start, int max_iterations,
        double step_tolerance) {
  LanesFit problem(observed, start, usable_tolerance(step_tolerance));
  Fit result;
  result.status = marquardt(problem, max_iterations, result.iterations);
  result.pose = problem.pose();
  if (result.status != FitStatus::kStartBehindCamera) result.model = problem.model();
  return result;
}

SIGHTLINE_MULTIVERSION
bool invert(const double (&hessian)[21], double (&inverse)[21]) {
  double scale[6];
  for (int i = 0; i < 6; ++i) {
    const double d = hessian[at(i, i)];
    if (!(d > 0) || !(d < INFINITY)) return false;
    scale[i] = 1 / sqrt(d);
  }
  double correlation[21];
#pragma GCC unroll 6
  for (int i = 0; i < 6; ++i) {
#pragma GCC unroll 6
    for (int j = i; j < 6; ++j) correlation[at(i, j)] = hessian[at(i, j)] * scale[i] * scale[j];
  }
  Factor f;
  if (!factorise(correlation, 0, f)) return false;
  // V = U^-1, then the inverse is V D^-1 V^T.
  double v[21];
#pragma GCC unroll 6
  for (int j = 0; j < 6; ++j) {
    v[at(j, j)] = 1;
#pragma GCC unroll 6
    for (int i = j - 1; i >= 0; --i) {
      double sum = -f.u[at(i, j)];
#pragma GCC unroll 6
      for (int k = i + 1; k < j; ++k) sum -= f.u[at(i, k)] * v[at(k, j)];
      v[at(i, j)] = sum;
    }
  }
#pragma GCC unroll 6
  for (int i = 0; i < 6; ++i) {
#pragma GCC unroll 6
    for (int j = i; j < 6; ++j) {
      double sum = 0;
#pragma GCC unroll 6
      for (int k = j; k < 6; ++k) sum += v[at(i, k)] * f.inverse_d[k] * v[at(j, k)];
      if (i == j && !(sum < kLargestInflation)) return false;
      inverse[at(i, j)] = sum * scale[i] * scale[j];
    }
  }
  return true;
}

double log_determinant(const double (&hessian)[21]) {
  Factor f;
  if (!factorise(hessian, 0, f)) return NAN;
  return log_determinant(f);
}

}  // namespace sightline::kernel
