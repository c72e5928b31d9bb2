// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The camera and the samples of its pixels: the keys of [camera], and samples_per_pixel of [image].
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "pose/camera.h"
#include "scenes/scene/keys.h"

namespace sightline {

/// The numbers of samples that a pixel may have.
inline constexpr std::array kSampleCounts = {1, 4, 8, 16, 32, 64, 256};

/// Samples of a pixel where nothing else is said.
inline constexpr int kSamplesPerPixel = 16;

/// What a file says of the camera, which is the same in all scenes: its numbers, or a calibration
/// file that has them. Where it gives no principal point, that is the image's centre.
struct CameraLaw {
  int width_px = Camera{}.width_px;
  int height_px = Camera{}.height_px;
  double f_px = 0;
  std::vector<double> principal_point_px = {0, 0};
  double skew_px = 0;
  std::string lens = "brown_conrady";  ///< by the name of its model
  std::filesystem::path file;          ///< of a calibration; none of the others stands beside it
};

std::vector<Key> keys_of(CameraLaw& law);

/// The key samples_per_pixel, which is the same in all scenes.
std::vector<Key> keys_of_sampling(int& law, int& samples_per_pixel);

/// The camera that [camera] is. Throws InputError.
Camera read_camera(const TomlTable& table);

/// The lens of a [camera] by its keys `lens` and `distortion`. Throws InputError.
Lens read_lens(const TomlTable& table);

/// One of kSampleCounts. Throws InputError.
int read_samples_per_pixel(const TomlTable& file);

/// What the truth states of a camera.
std::vector<Fact> facts_of(const Camera& camera);

}  // namespace sightline
