// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the formats of SPEED+ (Park et al., IEEE Aerospace Conference 2022) and of SPEED before it
// (Kisantal et al., IEEE TAES 56(5), 2020) are, for the reader and the writer alike: a list of
// images of one target with x_cam = R(q) x_target + r, q scalar first and r in metres, and one
// camera.
#pragma once

#include <array>
#include <string_view>

namespace sightline::speed {

/// The format's image begins at (0, 0), so that its first pixel's centre is at (0.5, 0.5): its
/// principal points are by this greater than ours.
inline constexpr double kHalfPixel = 0.5;

inline constexpr std::string_view kCameraFile = "camera.json";
inline constexpr std::string_view kImagesFolder = "images";
/// The lists of images that a set may have, but for the ending .json; ours has the first.
inline constexpr std::array<std::string_view, 3> kLists = {"train", "validation", "test"};
/// The target's mesh in millimetres, in our sets alone.
inline constexpr std::string_view kModelFile = "model/target.ply";

// Keys of an image's element in the list.
inline constexpr const char* kFisheye = "fisheye_model";  // in camera.json, as OpenCV says it
inline constexpr const char* kPicture = "filename";
inline constexpr const char* kAttitude = "q_vbs2tango_true";
inline constexpr const char* kAttitudeOfSpeed = "q_vbs2tango";  ///< in SPEED instead
inline constexpr const char* kPosition = "r_Vo2To_vbs_true";
/// What an attitude and a position may be called, ours first.
inline constexpr std::array kAttitudes = {kAttitude, kAttitudeOfSpeed};
inline constexpr std::array kPositions = {kPosition, "r_Vo2To_vbs"};

}  // namespace sightline::speed
