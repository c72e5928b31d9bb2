// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/kernels/consensus_kernel.h"

#include "pose/multiversion.h"

// No vector crosses a file's border, so that the ABI it would have there does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace sightline::kernel {
namespace {

typedef float Floats __attribute__((vector_size(kScreenLanes * sizeof(float))));
typedef int Flags __attribute__((vector_size(kScreenLanes * sizeof(int))));

inline Floats load_floats(const float* from) {
  Floats values;
  __builtin_memcpy(&values, from, sizeof values);
  return values;
}

/// A residual times the depth, which saves the division, and the depth.
struct ScaledMiss {
  Floats squared;
  Floats depth;
};

inline ScaledMiss scaled_miss(const ScreenPoints& points, const ScreenPose& pose, std::size_t i) {
  const float* const r = pose.row;
  const Floats x = load_floats(points.x.data() + i);
  const Floats y = load_floats(points.y.data() + i);
  const Floats z = load_floats(points.z.data() + i);
  const Floats depth = r[8] * x + r[9] * y + r[10] * z + r[11];
  const Floats a = r[0] * x + r[1] * y + r[2] * z + r[3] - load_floats(points.u.data() + i) * depth;
  const Floats b = r[4] * x + r[5] * y + r[6] * z + r[7] - load_floats(points.v.data() + i) * depth;
  return {a * a + b * b, depth};
}

}  // namespace

SIGHTLINE_MULTIVERSION
int count_within(const ScreenPoints& points, const ScreenPose& pose, std::size_t begin,
                 std::size_t end, float radius2) {
  Flags minus_count = {};
  for (std::size_t i = begin; i < end; i += kScreenLanes) {
    const ScaledMiss miss = scaled_miss(points, pose, i);
    const Floats limit = load_floats(points.reach.data() + i) * radius2;
    minus_count += (miss.squared <= limit * (miss.depth * miss.depth)) & (miss.depth > 0.F);
  }
  int count = 0;
  for (std::size_t lane = 0; lane < kScreenLanes; ++lane) count -= minus_count[lane];
  return count;
}

SIGHTLINE_MULTIVERSION
void squared_distances(const ScreenPoints& points, const ScreenPose& pose, std::size_t end,
                       float* distances2) {
  const Floats not_seen = Floats{} + kNotSeen;
  for (std::size_t i = 0; i < end; i += kScreenLanes) {
    const ScaledMiss miss = scaled_miss(points, pose, i);
    const Floats distance2 = miss.squared / (miss.depth * miss.depth);
    const Floats seen = miss.depth > 0.F ? distance2 : not_seen;
    __builtin_memcpy(distances2 + i, &seen, sizeof seen);
  }
}

}  // namespace sightline::kernel
