// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include <Eigen/Core>

#include "pose/pose.h"

namespace sightline {

/// A line that an object may be turned about by any angle, and looks alike.
struct SymmetryAxis {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< of length 1
  Eigen::Vector3d point = Eigen::Vector3d::Zero();       ///< on it
};

/// How an object may be moved and looks alike, in its own frame.
struct Symmetries {
  /// The poses of it that look alike, the identity first; of an axis in equal steps, as errors of
  /// vertices take them (bop/models.h).
  std::vector<Pose> poses{Pose{}};
  /// The axes, for errors of the pose itself, which steps are too coarse for.
  std::vector<SymmetryAxis> axes{};

  bool has_any() const { return poses.size() > 1; }
};

}  // namespace sightline
