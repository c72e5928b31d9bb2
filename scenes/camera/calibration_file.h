// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "pose/camera.h"

namespace sightline {

/// The camera of a calibration file, in our convention (pixel centres at integers), whichever it
/// is:
///
/// - OpenCV's (.yaml, .yml, .json, .xml): camera_matrix, distortion_coefficients of 0, 4, 5, 8 or
/// 12
///   numbers (14 where the sensor is not tilted), or of 4 with fisheye_model: 1 or
///   distortion_model: fisheye (or equidistant), image_width, image_height. Without a size the
///   image reaches as far to each side of the principal point.
/// - Kalibr's camchain (.yaml): camera_model pinhole; distortion_model radtan, equidistant or none.
/// - COLMAP's cameras.txt (.txt), whose pixel centres lie at halves: SIMPLE_PINHOLE, PINHOLE,
///   SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV, OPENCV_FISHEYE, SIMPLE_RADIAL_FISHEYE,
///   RADIAL_FISHEYE.
///
/// Of several cameras in one file, FILE#NAME is the one of that name (Kalibr's cam1, COLMAP's id).
/// Throws InputError with the file, the key, what is given and what is allowed: for a file that is
/// none of these, a model that is not ours, a wrong number of coefficients, a lens that folds the
/// image within its stated border.
Camera read_calibration_file(const std::filesystem::path& file);

}  // namespace sightline
