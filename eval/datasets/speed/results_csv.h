// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "eval/datasets/picture_names.h"
#include "pose/pose.h"

namespace sightline {

/// What a method says of the target in one picture.
struct SpeedEstimate {
  std::string picture;    ///< its file, as it is named there
  Pose cam_from_model;    ///< metres
  int line = 0;           ///< of the file, from 1
  std::string problem{};  ///< why the row is no pose; empty where it is one
};

/// Gives an estimate its pose, or its problem.
void set_pose(const Eigen::Quaterniond& attitude, const Eigen::Vector3d& translation_m,
              SpeedEstimate& estimate);

/// Poses as ESA's challenges take them: a line a picture of its file's name, a quaternion, scalar
/// first, and a translation in metres, with commas between them. A first line of names, which
/// begins with "filename", does not count. A row whose numbers are
/// not finite, or whose quaternion is not of length 1 (1e-2), is kept with its problem. Throws
/// InputError, with file and line, for whatever else is not so, for a picture that stands there
/// twice, and where there is none.
std::vector<SpeedEstimate> read_speed_results(const std::filesystem::path& file);

/// What the picture of each estimate of a file stands for; none where the set does not have it.
/// Throws InputError where two are of one picture, by whatever names.
std::vector<std::optional<int>> pictures_of(std::span<const SpeedEstimate> estimates,
                                            const PictureNames& names,
                                            const std::filesystem::path& file);

}  // namespace sightline
