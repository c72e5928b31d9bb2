// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Light from all sides, as a panorama has it: the keys of [environment].
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "scenes/scene/file_draw.h"
#include "scenes/scene/keys.h"

namespace cv {
class Mat;
}

namespace sightline {

/// Light by direction, infinitely far away. The picture is equirectangular, twice as wide as it is
/// high: its columns go once around, its rows from straight up to straight down. In its own axes,
/// which are a camera's (x right, y down, z forward), the middle of the picture lies along z, and
/// what is right of the middle along x.
struct Environment {
  std::string file;                      ///< as it was given; of a folder, the picture drawn
  std::shared_ptr<const cv::Mat> light;  ///< CV_32FC3, blue, green, red; none: there is none
  double strength = 1;  ///< on the picture's numbers; all of them 1, it is a glow of this level
  double yaw_deg = 0;
  double pitch_deg = 0;
  double roll_deg = 0;

  bool is_there() const { return light != nullptr; }
};

/// How the panorama is turned: about its vertical first, then about the camera's x, then its z.
/// Seen by the camera, what was in the middle moves right (yaw), up (pitch), and clockwise about
/// the middle (roll).
Eigen::Matrix3d cam_from_environment(const Environment& environment);

/// What a file says of it.
struct EnvironmentLaw {
  std::string file;
  Range strength = Environment{}.strength;
  Range yaw_deg = Environment{}.yaw_deg;
  Range pitch_deg = Environment{}.pitch_deg;
  Range roll_deg = Environment{}.roll_deg;
  /// Of a folder: the panoramas in it, one of which is drawn for a frame.
  FileDraw folder = {};
  std::shared_ptr<const cv::Mat> light;

  bool is_there() const { return !file.empty(); }
};

std::vector<Key> keys_of(EnvironmentLaw& law, Environment& environment);

/// Reads the panorama too; of a folder it only sees to it that there are some. Throws InputError.
EnvironmentLaw read_environment(const TomlTable& file);

/// Throws InputError for a panorama of a folder that cannot be read.
Environment draw_environment(EnvironmentLaw law, const Draws& draws);

/// Reads the panorama of a folder that one scene draws, unless `checked` has it already. Throws
/// InputError.
void check_drawn_file(const EnvironmentLaw& law, const Draws& draws, CheckedFiles& checked);

/// What the truth states of it: nothing where there is none.
std::vector<Fact> facts_of(Environment environment);

}  // namespace sightline
