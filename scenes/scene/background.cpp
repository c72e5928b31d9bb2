// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/background.h"

#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

Choice kind_choice(BackgroundKind& kind) {
  std::vector<std::pair<std::string, BackgroundKind>> worded;
  for (int i = 0; i <= static_cast<int>(BackgroundKind::kImage); ++i) {
    const auto listed = static_cast<BackgroundKind>(i);
    worded.emplace_back(to_string(listed), listed);
  }
  return choice(kind, std::move(worded));
}

// As grey on a linear scale: files are taken for sRGB.
void read_picture(const TomlTable& table, BackgroundLaw& law) {
  const std::filesystem::path given = table.text("file");
  const std::filesystem::path beside = table.file().parent_path() / given;
  const std::filesystem::path file = std::filesystem::exists(beside) ? beside : given;
  const auto [grey, problem] = read_picture_file(file, PictureChannels::kGrey);
  if (!problem.empty())
    table.fail("file", fmt::format("is \"{}\", which {}", given.string(), problem));
  auto pixels = std::make_shared<std::vector<float>>();
  pixels->reserve(grey.total());
  for (int v = 0; v < grey.rows; ++v) {
    for (int u = 0; u < grey.cols; ++u) {
      const double encoded = grey.at<uint8_t>(v, u) / 255.0;
      pixels->push_back(static_cast<float>(
          encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4)));
    }
  }
  law.picture = std::move(pixels);
  law.picture_width = grey.cols;
}

}  // namespace

std::string_view to_string(BackgroundKind kind) {
  constexpr std::string_view kNames[] = {"uniform", "sky", "clouds", "stars", "image"};
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
       "picture of kind = \"image\", beside this file, scaled to cover the image",
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
  background.picture_width = law.picture_width;
  background.seed = draws.stream("background").bits();
  return background;
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
