// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Matched clouds of points for the tests of absolute orientation.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "pose/pose.h"
#include "tests/pose/synthetic.h"

namespace sightline {

using Points = std::vector<Eigen::Vector3d>;
using FloatPoints = std::vector<Eigen::Vector3f>;
using Weights = std::vector<double>;

/// Points in two frames, and the pose between them.
struct Cloud {
  Points in_a;
  Points in_b;
  Pose b_from_a;
};

/// n points drawn in a box of this half width about (offset, offset, offset), seen from both
/// frames.
inline Cloud draw_cloud(int n, const Eigen::Vector3d& half_width, double offset,
                        const Pose& b_from_a, Draw& draw) {
  Cloud cloud;
  cloud.b_from_a = b_from_a;
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector3d x_in_a =
        half_width.cwiseProduct(draw.in_box(1)) + Eigen::Vector3d::Constant(offset);
    cloud.in_a.push_back(x_in_a);
    cloud.in_b.push_back(b_from_a * x_in_a);
  }
  return cloud;
}

/// The pose by Eigen's method, to compare with.
inline Pose umeyama_pose(const Cloud& cloud) {
  const auto n = static_cast<Eigen::Index>(cloud.in_a.size());
  Eigen::Matrix3Xd a(3, n);
  Eigen::Matrix3Xd b(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    a.col(i) = cloud.in_a[static_cast<std::size_t>(i)];
    b.col(i) = cloud.in_b[static_cast<std::size_t>(i)];
  }
  const Eigen::Matrix4d transform = Eigen::umeyama(a, b, false);
  return {transform.topLeftCorner<3, 3>(), transform.topRightCorner<3, 1>()};
}

inline FloatPoints in_float(const Points& points) {
  FloatPoints result;
  for (const Eigen::Vector3d& x : points) result.push_back(x.cast<float>());
  return result;
}

inline Points in_double(const FloatPoints& points) {
  Points result;
  for (const Eigen::Vector3f& x : points) result.push_back(x.cast<double>());
  return result;
}

}  // namespace sightline
