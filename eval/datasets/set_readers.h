// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// How each format of data sets is read, for read_sightings alone.
#pragma once

#include <Eigen/Geometry>

#include "eval/datasets/sightings.h"

namespace sightline {

/// Metres of a millimetre, the unit of BOP and of SPEED's model file.
inline constexpr double kMetresPerMillimetre = 1e-3;

/// How far what few printed digits leave a matrix from orthonormal.
inline constexpr double kRotationTolerance = 1e-2;

/// What a set says of the target: poses in metres, of the set's own frame of the model; cameras
/// without a size.
struct SetReading {
  std::vector<Sighting> sightings;
  int obj_id = 1;
  std::filesystem::path model_file;                ///< that says what the next is
  std::optional<Eigen::AlignedBox3d> model_box_m;  ///< of the model in its own frame, if known
};

SetReading read_bop_sightings(const SightingSource& source);

/// Whether the folder has a list as SPEED+ has them.
bool is_speed_set(const SightingSource& source);
SetReading read_speed_sightings(const SightingSource& source);

/// A camera without size from the rows of its matrix, pixel centres at integers. Throws InputError
/// for what is no such matrix, and for skew, which ours has not.
Camera camera_from_matrix(const Eigen::Matrix3d& k);

/// The rotation nearest to a matrix that was printed with few digits. Throws InputError for one
/// that is farther from a rotation than that leaves.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix);

}  // namespace sightline
