// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/environment.h"

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "pose/angles.h"
#include "scenes/picture/radiance_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr int kMostColumns = 4096;  // of what is kept; 5 minutes of arc each

struct Panorama {
  std::shared_ptr<const cv::Mat> light;
  std::string problem;  // to stand after the file's name; empty where there is none
};

Panorama read_panorama(const fs::path& file) {
  auto [pixels, problem] = read_radiance_file(file);
  if (!problem.empty()) return {nullptr, problem};
  if (pixels.cols != 2 * pixels.rows) {
    return {nullptr, fmt::format("is {} x {} pixels, must be twice as wide as high", pixels.cols,
                                 pixels.rows)};
  }
  if (pixels.cols > kMostColumns) {
    cv::Mat smaller;
    cv::resize(pixels, smaller, {kMostColumns, kMostColumns / 2}, 0, 0, cv::INTER_AREA);
    pixels = smaller;
  }
  return {std::make_shared<const cv::Mat>(pixels), {}};
}

fs::path drawn_panorama(const EnvironmentLaw& law, const Draws& draws) {
  RandomStream stream = draws.stream("environment.file");
  return law.folder.draw(stream);
}

// One of a folder's.
std::shared_ptr<const cv::Mat> panorama_of(const FileDraw& folder, const fs::path& file) {
  auto [light, problem] = read_panorama(file);
  if (!problem.empty()) folder.fail(file, problem);
  return light;
}

}  // namespace

Eigen::Matrix3d cam_from_environment(const Environment& environment) {
  using Eigen::AngleAxisd, Eigen::Vector3d;
  return (AngleAxisd(environment.roll_deg * kDegree, Vector3d::UnitZ()) *
          AngleAxisd(environment.pitch_deg * kDegree, Vector3d::UnitX()) *
          AngleAxisd(environment.yaw_deg * kDegree, Vector3d::UnitY()))
      .toRotationMatrix();
}

std::vector<Key> keys_of(EnvironmentLaw& law, Environment& environment) {
  return {
      {"environment",
       "file",
       &law.file,
       {},
       "",
       "panorama (.exr or .hdr, equirectangular) whose light falls on all bodies, beside this "
       "file; "
       "or a folder, of whose panoramas one is drawn for each frame; background.kind = "
       "\"environment\" shows it",
       {},
       "file",
       false,
       "none"},
      {"environment",
       "strength",
       &law.strength,
       {0, 1e6},
       "",
       "factor on the panorama's numbers; where all of them are 1, the grey of a white surface",
       &environment.strength},
      {"environment",
       "yaw_deg",
       &law.yaw_deg,
       {-360, 360},
       "deg",
       "turn of the panorama about its vertical: its middle, at 0 the camera's axis, moves right",
       &environment.yaw_deg},
      {"environment",
       "pitch_deg",
       &law.pitch_deg,
       {-360, 360},
       "deg",
       "after that, its turn about the camera's x: the middle moves up",
       &environment.pitch_deg},
      {"environment",
       "roll_deg",
       &law.roll_deg,
       {-360, 360},
       "deg",
       "after that, its turn about the camera's axis, clockwise",
       &environment.roll_deg},
  };
}

EnvironmentLaw read_environment(const TomlTable& file) {
  EnvironmentLaw law;
  Environment environment;
  const std::vector<Key> keys = keys_of(law, environment);
  read_keys(file, keys);
  const TomlTable table = file.table("environment");
  if (!law.is_there()) {
    for (const Key& key : keys) {
      if (table.has(key.name)) table.fail(key.name, "needs file beside it");
    }
    return law;
  }
  const fs::path found = named_path(table, law.file);
  std::error_code error;
  if (fs::is_directory(found, error)) {
    law.folder =
        files_of(table, "environment", "file", found, law.file, is_radiance_name, ".exr or .hdr");
    return law;
  }
  auto [light, problem] = read_panorama(found);
  if (!problem.empty()) {
    table.fail("file", fmt::format("is \"{}\", which {}", law.file, problem));
  }
  law.light = std::move(light);
  return law;
}

Environment draw_environment(EnvironmentLaw law, const Draws& draws) {
  Environment environment;
  if (!law.is_there()) return environment;
  draw_keys(keys_of(law, environment), draws);
  environment.file = law.file;
  environment.light = law.light;
  if (!law.folder.is_there()) return environment;
  const fs::path file = drawn_panorama(law, draws);
  environment.light = panorama_of(law.folder, file);
  environment.file = law.folder.stated(file);
  return environment;
}

void check_drawn_file(const EnvironmentLaw& law, const Draws& draws, CheckedFiles& checked) {
  if (!law.folder.is_there()) return;
  const fs::path file = drawn_panorama(law, draws);
  if (checked.insert(file).second) panorama_of(law.folder, file);
}

std::vector<Fact> facts_of(Environment environment) {
  if (!environment.is_there()) return {};
  EnvironmentLaw law;
  std::vector<Fact> facts = facts_of(keys_of(law, environment));
  facts.insert(facts.begin(), {"file", environment.file});
  return facts;
}

}  // namespace sightline
