// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace sightline {

/// Colours of a .ply's faces, which Assimp does not read.
struct PlyFaceColours {
  bool are_there = false;
  /// Of every triangle, where a face of n corners becomes n - 2 of them in their order: red, green,
  /// blue and alpha from 0 to 1 as the file has them. Empty where they cannot be read: the file is
  /// torn, or has lists before its faces.
  std::vector<Eigen::Vector4f> of_triangles;
};

PlyFaceColours ply_face_colours(std::string_view ply);

}  // namespace sightline
