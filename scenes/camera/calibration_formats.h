// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The formats of calibration files, a file each. Their functions throw InputError, whose text lacks
// the file's name.
#pragma once

#include <span>
#include <string>

#include "pose/camera.h"

namespace sightline::calibration {

/// The camera of OpenCV's text. YAML may lack the line by which OpenCV knows it.
Camera opencv_camera(std::string text, bool is_yaml);

/// True of a text with cameras as Kalibr has them: maps with a camera_model.
bool is_kalibr(const std::string& text);

/// The camera of Kalibr's text; `name` may be empty where there is one.
Camera kalibr_camera(const std::string& text, const std::string& name);

/// The camera of COLMAP's text; `name`, an id, may be empty where there is one.
Camera colmap_camera(const std::string& text, const std::string& name);

/// Which of the file's cameras is meant, by its place. Throws InputError where the name is none of
/// theirs, or is empty and there are several.
size_t chosen_camera(const std::string& name, std::span<const std::string> all);

/// Throws InputError where the lens folds the image within its border; `key` states the lens.
void require_unfolded(const Camera& camera, const std::string& key);

}  // namespace sightline::calibration
