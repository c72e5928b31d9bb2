// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "pose/camera.h"

namespace sightline {

/// The camera of a calibration file (OpenCV's, Kalibr's or COLMAP's:
/// scenes/camera/calibration_file.h says what may stand in them), or of a .toml with the table
/// [camera] of a scene. Throws InputError for a file that is none of these, and for a lens that is
/// no model of ours.
Camera read_camera_file(const std::filesystem::path& file);

}  // namespace sightline
