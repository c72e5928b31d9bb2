// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/background.h"

#include <array>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "scenes/picture/picture_file.h"
#include "scenes/scene/colouring.h"

namespace sightline {
namespace {

Choice kind_choice(BackgroundKind& kind) {
  std::vector<std::pair<std::string, BackgroundKind>> worded;
  for (int i = 0; i <= static_cast<int>(BackgroundKind::kEnvironment); ++i) {
    const auto listed = static_cast<BackgroundKind>(i);
    worded.emplace_back(to_string(listed), listed);
  }
  return choice(kind, std::move(worded));
}

float linear(uint8_t code) {
  const double encoded = code / 255.0;
  return static_cast<float>(encoded <= 0.04045 ? encoded / 12.92
                                               : std::pow((encoded + 0.055) / 1.055, 2.4));
}

std::shared_ptr<const std::vector<float>> linear_light(const cv::Mat& picture) {
  std::array<float, 256> table{};
  for (size_t code = 0; code < table.size(); ++code)
    table[code] = linear(static_cast<uint8_t>(code));
  auto pixels = std::make_shared<std::vector<float>>();
  const int row_bytes = picture.cols * picture.channels();
  pixels->reserve(picture.total() * static_cast<size_t>(picture.channels()));
  for (int v = 0; v < picture.rows; ++v) {
    const uint8_t* row = picture.ptr<uint8_t>(v);
    for (int i = 0; i < row_bytes; ++i) pixels->push_back(table[row[i]]);
  }
  return pixels;
}

struct Pictures {
  cv::Mat grey, colours;
};

struct PictureOfBackground {
  Pictures pictures;
  std::string problem;  // to stand after the file's name; empty where there is none
};

PictureOfBackground pictures_in(const std::filesystem::path& file, bool has_colour) {
  PictureReading grey = read_picture_file(file, PictureChannels::kGrey);
  if (!grey.problem.empty() || !has_colour) return {{grey.pixels, {}}, grey.problem};
  PictureReading colours = read_picture_file(file, PictureChannels::kColour);
  return {{grey.pixels, colours.pixels}, colours.problem};
}

// On a linear scale: files are taken for sRGB.
template <typename Holder>
void set_picture(const Pictures& pictures, Holder& to) {
  to.picture = linear_light(pictures.grey);
  if (!pictures.colours.empty()) to.colours = linear_light(pictures.colours);
  to.picture_width = pictures.grey.cols;
}

void read_picture(const TomlTable& table, BackgroundLaw& law) {
  const std::string given = table.text("file");
  const std::filesystem::path file = named_path(table, given);
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) {
    const auto is_picture = [](const std::filesystem::path& one) {
      return picture_size(one).has_value();
    };
    law.folder = files_of(table, "background", "file", file, given, is_picture, "pictures");
    return;
  }
  const auto [pictures, problem] = pictures_in(file, law.has_colour);
  if (!problem.empty()) {
    table.fail("file", fmt::format("is \"{}\", which {}", given, problem));
  }
  set_picture(pictures, law);
}

std::filesystem::path drawn_picture(const BackgroundLaw& law, const Draws& draws) {
  RandomStream stream = draws.stream("background.file");
  return law.folder.draw(stream);
}

// Those of one of a folder's files.
Pictures pictures_of(const BackgroundLaw& law, const std::filesystem::path& file) {
  PictureOfBackground read = pictures_in(file, law.has_colour);
  if (!read.problem.empty()) law.folder.fail(file, read.problem);
  return read.pictures;
}

}  // namespace

std::string_view to_string(BackgroundKind kind) {
  constexpr std::string_view kNames[] = {"uniform", "sky",   "clouds",
                                         "stars",   "image", "environment"};
  return kNames[static_cast<int>(kind)];
}

std::vector<Key> keys_of(BackgroundLaw& law, Background& background) {
  return {
      {"background",
       "kind",
       kind_choice(law.kind),
       {},
       "",
       "what lies behind all bodies",
       kind_choice(background.kind)},
      {"background",
       "level",
       &law.level,
       {0, 1},
       "",
       "grey, 1 is white: everywhere, in the middle of a sky, on the average of clouds, between "
       "stars",
       &background.level},
      {"background",
       "contrast",
       &law.contrast,
       {0, 2},
       "",
       "of a sky, from side to side; of clouds, twice their standard deviation",
       &background.contrast},
      {"background",
       "angle_deg",
       &law.angle_deg,
       {-360, 360},
       "deg",
       "where a sky brightens to; 0 is image right, 90 is down",
       &background.angle_deg},
      {"background",
       "cloud_px",
       &law.cloud_px,
       {2, 100000},
       "px",
       "size of the largest clouds",
       &background.cloud_px},
      {"background",
       "stars_per_megapixel",
       &law.stars_per_megapixel,
       {0, 1e5},
       "",
       "number of stars",
       &background.stars_per_megapixel},
      {"background",
       "file",
       &law.file,
       {},
       "",
       "picture of kind = \"image\", beside this file, scaled to cover the image; or a folder, of "
       "whose pictures one is drawn for each frame",
       {},
       "file",
       false,
       "required by kind = \"image\""},
  };
}

BackgroundLaw read_background(const TomlTable& file) {
  BackgroundLaw law;
  Background background;
  read_keys(file, keys_of(law, background));
  const TomlTable table = file.table("background");
  if (law.kind == BackgroundKind::kImage) {
    law.has_colour = read_colouring(file).mode != ColourMode::kGrey;
    read_picture(table, law);
  } else if (table.has("file")) {
    table.fail("file", "belongs to kind = \"image\"");
  }
  return law;
}

Background draw_background(BackgroundLaw law, const Draws& draws) {
  Background background;
  draw_keys(keys_of(law, background), draws);
  background.file = law.file;
  background.picture = law.picture;
  background.colours = law.colours;
  background.picture_width = law.picture_width;
  if (law.folder.is_there()) {
    const std::filesystem::path file = drawn_picture(law, draws);
    set_picture(pictures_of(law, file), background);
    background.file = law.folder.stated(file);
  }
  background.seed = draws.stream("background").bits();
  return background;
}

void check_drawn_file(const BackgroundLaw& law, const Draws& draws, CheckedFiles& checked) {
  if (!law.folder.is_there()) return;
  const std::filesystem::path file = drawn_picture(law, draws);
  if (checked.insert(file).second) pictures_of(law, file);
}

std::vector<Fact> facts_of(Background background) {
  BackgroundLaw law;
  std::vector<Fact> facts = facts_of(keys_of(law, background));
  facts.push_back({"seed", int64_t{background.seed}});
  facts.push_back({"star_level", background.star_level});
  facts.push_back({"file", background.file});
  return facts;
}

}  // namespace sightline
