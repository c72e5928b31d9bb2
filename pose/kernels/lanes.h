// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Four points side by side in one vector: two registers of 128 bits, one of 256, or half of 512.
// Only for the .cpp files of this folder, into which all of it is inlined.
#pragma once

#include "pose/kernels/reprojection_kernel.h"

// No vector crosses a file's border, so that the ABI it would have there does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace sightline::kernel {

typedef double Lanes __attribute__((vector_size(kLanes * sizeof(double))));
typedef long long Mask __attribute__((vector_size(kLanes * sizeof(long long))));

inline const Lanes& lanes_of(const double (&values)[kLanes]) {
  return reinterpret_cast<const Lanes&>(values);
}

inline void store(const Lanes& values, double* to) {
  __builtin_memcpy(to, &values, sizeof values);
}

inline Lanes load(const double* from) {
  Lanes values;
  __builtin_memcpy(&values, from, sizeof values);
  return values;
}

/// (sum a, sum b, sum c, sum d).
inline Lanes lane_sums(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d) {
  const Lanes ab =
      __builtin_shufflevector(a, b, 0, 4, 2, 6) + __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Lanes cd =
      __builtin_shufflevector(c, d, 0, 4, 2, 6) + __builtin_shufflevector(c, d, 1, 5, 3, 7);
  return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}

inline bool is_any(const Mask& m) {
  return (m[0] | m[1] | m[2] | m[3]) != 0;
}

/// Residuals and rows of the Jacobian by (w, dt). With q = R x, (a, b, z) = q + t, s = 1 / z and
/// (u, v) = s (a, b) they are
///
///   J_u = (-su q_y,           s q_z + su q_x,  -s q_y,  s, 0, -su),   su = s u,
///   J_v = (-s q_z - sv q_y,   sv q_x,           s q_x,  0, s, -sv),   sv = s v.
struct ReprojectedLanes {
  Lanes ru, rv;
  Lanes u0, u1, u2, v0, v1, v2;
  Lanes s, su, sv;
  Mask is_behind;  ///< of points that count
};

inline ReprojectedLanes reproject(const PointLanes& p, const RigidPose& pose) {
  const double* const r = pose.rotation;
  const double* const t = pose.translation;
  const Lanes zero = {};
  const Lanes x = lanes_of(p.x), y = lanes_of(p.y), z = lanes_of(p.z);
  const Lanes qx = r[0] * x + r[1] * y + r[2] * z;
  const Lanes qy = r[3] * x + r[4] * y + r[5] * z;
  const Lanes qz = r[6] * x + r[7] * y + r[8] * z;
  const Lanes depth = lanes_of(p.w_uu) + lanes_of(p.w_vv) > zero ? qz + t[2] : zero + 1.0;
  ReprojectedLanes e;
  e.is_behind = ~(depth > zero);  // a NaN counts as behind
  e.s = 1.0 / depth;
  const Lanes u = (qx + t[0]) * e.s;
  const Lanes v = (qy + t[1]) * e.s;
  e.ru = u - lanes_of(p.u);
  e.rv = v - lanes_of(p.v);
  e.su = e.s * u;
  e.sv = e.s * v;
  e.u0 = -e.su * qy;
  e.u1 = e.s * qz + e.su * qx;
  e.u2 = -e.s * qy;
  e.v0 = -e.s * qz - e.sv * qy;
  e.v1 = e.sv * qx;
  e.v2 = e.s * qx;
  return e;
}

}  // namespace sightline::kernel
