// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Straight edges beside points: how far from a pixel, along a given direction, an edge of the
// target passes it. Only for the .cpp files of this folder, into which all of it is inlined. The
// plain version is edge_residual() of pose/edge_points.h.
#pragma once

#include "pose/kernels/lanes.h"
#include "pose/kernels/reprojection_kernel.h"

namespace sightline::kernel {

struct Lanes3 {
  Lanes x, y, z;
};

inline Lanes3 cross(const Lanes3& a, const Lanes3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

inline Lanes dot(const Lanes3& a, const Lanes3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

inline Lanes3 turned(const double (&r)[9], const Lanes& x, const Lanes& y, const Lanes& z) {
  return {r[0] * x + r[1] * y + r[2] * z, r[3] * x + r[4] * y + r[5] * z,
          r[6] * x + r[7] * y + r[8] * z};
}

/// The residual e and its derivative by (w, dt). With p = R begin, A = p + t and D = R along, the
/// edge meets q + e n where A . (D x (q + e n)) = 0; at that place q',
///
///   de = -(w . (p x c + D x (q' x A)) + dt . c) / M,   c = D x q',  M = A . (D x n).
struct EdgeResidualLanes {
  Lanes residual;
  Lanes j[6];
  Mask is_undefined;  ///< of edges that count
};

inline EdgeResidualLanes edge_residual(const EdgeLanes& e, const RigidPose& pose) {
  const Lanes zero = {};
  const double* const t = pose.translation;
  const Lanes3 p = turned(pose.rotation, lanes_of(e.x), lanes_of(e.y), lanes_of(e.z));
  const Lanes3 d = turned(pose.rotation, lanes_of(e.dx), lanes_of(e.dy), lanes_of(e.dz));
  const Lanes3 a = {p.x + t[0], p.y + t[1], p.z + t[2]};
  const Lanes3 q = {lanes_of(e.u), lanes_of(e.v), zero + 1.0};
  const Lanes3 n = {lanes_of(e.nu), lanes_of(e.nv), zero};
  const Lanes3 dq = cross(d, q);
  const Lanes3 dn = cross(d, n);
  const Lanes3 moment = cross(a, d);
  const Mask counts = lanes_of(e.weight) > zero;
  const Lanes m = counts ? dot(a, dn) : zero + 1.0;
  const Lanes tilt2 = (moment.x * moment.x + moment.y * moment.y) * (n.x * n.x + n.y * n.y);
  const Lanes inverse_m = 1.0 / m;

  EdgeResidualLanes out;
  out.residual = -dot(a, dq) * inverse_m;
  const Lanes3 place = {q.x + out.residual * n.x, q.y + out.residual * n.y, q.z};
  const Lanes3 c = {dq.x + out.residual * dn.x, dq.y + out.residual * dn.y,
                    dq.z + out.residual * dn.z};
  // What the moved edge means at its own depth: 1 / depth, which must be positive.
  const Lanes inverse_depth = -dot(dq, n) * inverse_m;
  const Mask is_defined =
      (m * m > kLeastCrossing2 * tilt2) & (inverse_depth > zero);  // false of a NaN
  out.is_undefined = ~is_defined & counts;
  const Lanes3 pc = cross(p, c);
  const Lanes3 dg = cross(d, cross(place, a));
  out.j[0] = -(pc.x + dg.x) * inverse_m;
  out.j[1] = -(pc.y + dg.y) * inverse_m;
  out.j[2] = -(pc.z + dg.z) * inverse_m;
  out.j[3] = -c.x * inverse_m;
  out.j[4] = -c.y * inverse_m;
  out.j[5] = -c.z * inverse_m;
  return out;
}

/// Adds the edges to the sums of a model of the points: its numbers in their order, lane by lane.
/// False where one that counts has no residual.
inline bool add_edges(const EdgeLanes* edges, std::size_t count, const RigidPose& pose,
                      Lanes (&sums)[28]) {
  Mask is_undefined = {};
  for (std::size_t i = 0; i < count; ++i) {
    const EdgeResidualLanes e = edge_residual(edges[i], pose);
    is_undefined |= e.is_undefined;
    const Lanes w = lanes_of(edges[i].weight);
    const Lanes weighted = w * e.residual;
    sums[0] += 0.5 * weighted * e.residual;
    int next = 7;
#pragma GCC unroll 6
    for (int row = 0; row < 6; ++row) {
      sums[1 + row] += weighted * e.j[row];
      const Lanes wj = w * e.j[row];
#pragma GCC unroll 6
      for (int column = row; column < 6; ++column) sums[next++] += wj * e.j[column];
    }
  }
  return !is_any(is_undefined);
}

}  // namespace sightline::kernel
