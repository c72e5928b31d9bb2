// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Attitudes of a target seen from so far that all its points are at one range. Their image is then
// an affine map of the points, and the map is a rotation's upper rows but for its scale.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace sightline {

/// The rotation, camera from axes, nearest to the affine map `affine` from points in the frame of
/// the axes to the image: its first two rows are (A A^T)^-1/2 A. None unless the map is of full
/// rank: otherwise the points coincide, or lie on one line, in the image.
std::optional<Eigen::Matrix3d> rotation_from_affine(const Eigen::Matrix<double, 2, 3>& affine);

/// The two mirror rotations, camera from axes, of a target in the plane of its first two axes,
/// whose affine map from that plane to the image is `affine`. Empty where the map is zero.
std::vector<Eigen::Matrix3d> rotations_from_plane_affine(const Eigen::Matrix2d& affine);

}  // namespace sightline
