// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "pose/camera.h"

namespace sightline {

/// The camera of a calibration file: OpenCV's (.yaml, .yml, .json, .xml: camera_matrix,
/// distortion_coefficients of up to five numbers, image_width, image_height; pixel centres at
/// integers, as ours), or a .toml with the table [camera] of a scene. Throws InputError for a file
/// that is neither, and for a lens that our model has not.
Camera read_camera_file(const std::filesystem::path& file);

}  // namespace sightline
