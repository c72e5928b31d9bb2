// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// What the consensus search does for every pose that it tries: reproject all points or some, in
// floats, eight side by side. Plain arrays, so that it may be compiled for several kinds of
// processor (pose/multiversion.h).
#pragma once

#include <cstddef>
#include <vector>

namespace sightline::kernel {

inline constexpr std::size_t kScreenLanes = 8;

/// Points and where they are seen, padded to a multiple of kScreenLanes with points that no pose
/// meets. `reach` multiplies a squared radius about each point: its noise against the others'.
struct ScreenPoints {
  std::vector<float> x, y, z, u, v, reach;

  std::size_t padded() const { return x.size(); }
};

/// Rows of the rotation, each followed by the translation; the first two times the focal lengths.
struct ScreenPose {
  float row[12];
};

/// How many of the points [begin, end) lie in front of the camera and within the root of
/// reach * radius2 of where they are seen. Both bounds are multiples of kScreenLanes.
int count_within(const ScreenPoints& points, const ScreenPose& pose, std::size_t begin,
                 std::size_t end, float radius2);

/// The squared distances of the points [0, end) from where they are seen; kNotSeen for a point at
/// or behind the camera's plane. `end` is a multiple of kScreenLanes.
inline constexpr float kNotSeen = 1e30F;
void squared_distances(const ScreenPoints& points, const ScreenPose& pose, std::size_t end,
                       float* distances2);

}  // namespace sightline::kernel
