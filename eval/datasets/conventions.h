// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Between the numbers in other people's files and ours: units, matrices, rotations that were
// printed with few digits.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "pose/camera.h"

namespace sightline {

/// BOP's files and every model file that we write are in millimetres.
inline constexpr double kMetresPerMillimetre = 1e-3;
inline constexpr double kMillimetresPerMetre = 1000;

/// What a file states beyond these is no camera's and no target's, and overflows where it is
/// squared: focal lengths and principal points in pixels, positions in metres (100 000 km).
inline constexpr double kGreatestPx = 1e8;
inline constexpr double kFarthestM = 1e8;

/// Throws InputError, with the key, for a position in metres that is finite and beyond kFarthestM.
void require_near(const Eigen::Vector3d& position_m, const std::string& key);

/// The matrix of nine numbers that stand row by row.
Eigen::Matrix3d matrix_from_rows(std::span<const double> nine);

/// The nine numbers of a matrix, row by row.
std::array<double, 9> rows_of(const Eigen::Matrix3d& matrix);

/// Whether a matrix is a rotation, but for what few printed digits leave (1e-2 of a number of its
/// transpose times itself): finite, no reflection, not scaled by more than half a percent.
bool is_near_rotation(const Eigen::Matrix3d& matrix);

/// The rotation nearest to a matrix that was printed with few digits. Throws InputError for one
/// that is not near a rotation.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix);

/// The matrix itself where it is a rotation to what five printed digits leave (1e-5), so that
/// errors are those of the numbers in the file; else the nearest rotation, as nearest_rotation has
/// it; none where it is not near one.
std::optional<Eigen::Matrix3d> usable_rotation(const Eigen::Matrix3d& matrix);

/// The rotation of a quaternion that was printed with few digits; none where its length is not 1
/// within what those leave (1e-2).
std::optional<Eigen::Matrix3d> usable_rotation(const Eigen::Quaterniond& quaternion);

/// A camera without size from its matrix (fx s cx, 0 fy cy, 0 0 1), pixel centres at integers.
/// Throws InputError for what is no such matrix, or has a number beyond kGreatestPx.
Camera camera_from_matrix(const Eigen::Matrix3d& k);

}  // namespace sightline
