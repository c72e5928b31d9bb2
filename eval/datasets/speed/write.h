// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The files of SPEED+'s format, as text (layout.h says where they lie).
#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Core>

#include "eval/output/json.h"
#include "pose/camera.h"

namespace sightline::speed {

/// The format wants a size of the pixels, and ours have none: metres.
inline constexpr double kPixelPitchM = 1e-5;

/// "img000017.png", the picture of an image of our sets.
std::string picture_name(int64_t index);

/// An image's element in the list.
Json list_element(const std::string& picture, const Eigen::Vector4d& q_wxyz,
                  const Eigen::Vector3d& translation_m);

/// The camera that all images share.
std::string camera_file(const Camera& camera);

}  // namespace sightline::speed
