// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What lies behind all bodies: the keys of [background].
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/scene/file_draw.h"
#include "scenes/scene/keys.h"

namespace sightline {

enum class BackgroundKind {
  kUniform,      ///< `level` everywhere
  kSky,          ///< from level - contrast / 2 at one side to level + contrast / 2 at the other
  kClouds,       ///< fractal noise about `level`
  kStars,        ///< point sources on `level`
  kImage,        ///< a picture, scaled to cover the image
  kEnvironment,  ///< the panorama that lights the scene, as the camera sees it
};

std::string_view to_string(BackgroundKind kind);

/// What lies behind all bodies; linear, 1 is white, at the resolution of the image.
struct Background {
  BackgroundKind kind = BackgroundKind::kUniform;
  double level = 0.15;
  double contrast = 0.2;  ///< of a sky, from side to side; of clouds, twice their sd
  double angle_deg = 90;  ///< of a sky: where it brightens to; 0 is image right, 90 is down
  double cloud_px = 120;  ///< of clouds: the size of the largest
  double stars_per_megapixel = 200;
  double star_level = 1;  ///< the light of the brightest star, in white pixels
  std::string file;       ///< of an image: the name of the picture's file, as it was given
  std::shared_ptr<const std::vector<float>> picture;  ///< of an image: rows of grey, 1 is white
  /// The same in colour: rows of blue, green, red; of a scene in colour alone.
  std::shared_ptr<const std::vector<float>> colours;
  int picture_width = 0;
  uint32_t seed = 0;  ///< of clouds and stars
};

/// What a file says of the background. The defaults are those of a frame.
struct BackgroundLaw {
  BackgroundKind kind = Background{}.kind;
  Range level = Background{}.level;
  Range contrast = Background{}.contrast;
  Range angle_deg = Background{}.angle_deg;
  Range cloud_px = Background{}.cloud_px;
  Range stars_per_megapixel = Background{}.stars_per_megapixel;
  std::string file;
  bool has_colour = false;
  /// Of an image whose file is a folder: the pictures in it, one of which is drawn for a frame.
  FileDraw folder = {};
  std::shared_ptr<const std::vector<float>> picture;
  std::shared_ptr<const std::vector<float>> colours;
  int picture_width = 0;
};

std::vector<Key> keys_of(BackgroundLaw& law, Background& background);

/// Reads the picture too; of a folder it only sees to it that there are pictures. Throws
/// InputError.
BackgroundLaw read_background(const TomlTable& file);

/// Throws InputError for a picture of a folder that cannot be read.
Background draw_background(BackgroundLaw law, const Draws& draws);

/// Reads the picture of a folder that one scene draws, unless `checked` has it already. Throws
/// InputError.
void check_drawn_file(const BackgroundLaw& law, const Draws& draws, CheckedFiles& checked);

/// What the truth states of a background.
std::vector<Fact> facts_of(Background background);

}  // namespace sightline
