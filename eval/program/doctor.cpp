// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/program/doctor.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <limits>

#include <Eigen/Core>
#include <SQLiteCpp/Database.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <opencv2/core.hpp>

#include "eval/work/shard.h"
#include "renderer/edge_errors.h"
#include "renderer/renderer.h"
#include "renderer/sample_pattern.h"
#include "scenes/files/assets.h"
#include "scenes/files/input_error.h"
#include "scenes/scene/scene.h"

namespace sightline {
namespace {

std::string line(const std::string& name, const std::string& value) {
  return fmt::format("  {:<16}{}\n", name, value);
}

std::string libraries() {
  return "libraries\n" + line("OpenCV", cv::getVersionString()) +
         line("Eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION,
                                   EIGEN_MINOR_VERSION)) +
         line("SQLite", SQLite::getLibVersion()) +
         line("fmt", fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100,
                                 FMT_VERSION % 100));
}

std::string folders() {
  std::string assets;
  try {
    assets = fmt::format("{} ({} targets, {} studies)", assets_folder().string(),
                         target_names().size(), study_names().size());
  } catch (const std::exception& error) {
    assets = error.what();
  }
  return "folders\n" + line("assets", assets);
}

std::string context_of(GlChoice choice) {
  try {
    return Renderer({.gl = choice}).description();
  } catch (const GraphicsError& error) {
    return fmt::format("not to be had: {}", error.what());
  }
}

std::string drawing() {
  return "drawing\n" + line("used by default", Renderer().description()) +
         line("--gl auto", context_of(GlChoice::kAuto)) +
         line("--gl osmesa", context_of(GlChoice::kOsMesa)) +
         line("--gl egl", context_of(GlChoice::kEgl));
}

std::string shard() {
  std::string text;
  try {
    const ShardChoice choice =
        read_shard("auto", [](const char* name) { return std::getenv(name); });
    text = fmt::format("{}/{} ({})", choice.shard.index, choice.shard.count, choice.source);
  } catch (const InputError& error) {
    text = error.what();
  }
  return "shards\n" + line("--shard auto", text);
}

// Milliseconds of the fastest of a few frames of a Boeing 707 across half the image, truth and all
// but the sensor.
double frame_ms(Renderer& renderer, int samples_per_pixel) {
  constexpr int kFrames = 5;
  Scene scene;
  scene.target = load_target("boeing707");
  scene.cam_from_target = {rotation_from_vector({-0.35, 0.5, 0.7}), {0, 0, 1150}};
  scene.sensor.psf_sigma_px = 0;
  scene.sensor.read_noise_grey = 0;
  scene.samples_per_pixel = samples_per_pixel;
  double best_ms = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kFrames; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    renderer.render(scene, RandomStream(1, "doctor", i));
    const auto end = std::chrono::steady_clock::now();
    best_ms = std::min(best_ms, std::chrono::duration<double, std::milli>(end - begin).count());
  }
  return best_ms;
}

std::string edge_table() {
  constexpr int kPoses = 30;
  std::string text =
      "edges and vertices of a cube, px rms from their places (promised), and a frame of 512 x "
      "512\n"
      "  samples   general edges       edges along an axis   vertices            ms a frame\n";
  Renderer renderer;
  for (const int samples : kSampleCounts) {
    const EdgeErrors measured = measure_edge_errors(renderer, samples, kPoses);
    const EdgeErrors promised = promised_edge_errors(samples);
    const auto cell = [](double value, double limit) {
      return fmt::format("{:.4f} ({:.4f}){}", value, limit, value <= limit ? "   " : " ! ");
    };
    text += fmt::format("  {:>7}   {:<20}{:<22}{:<20}{:.1f}\n", samples,
                        cell(measured.general_px, promised.general_px),
                        cell(measured.axis_px, promised.axis_px),
                        cell(measured.vertex_px, promised.vertex_px), frame_ms(renderer, samples));
  }
  return text;
}

}  // namespace

std::string library_licences() {
  struct Library {
    const char* name;
    const char* package;
    const char* licence;
  };
  constexpr Library kLibraries[] = {
      {"Assimp", "libassimp-dev", "BSD-3-Clause"},
      {"Boost", "libboost-dev", "BSL-1.0"},
      {"CGAL", "libcgal-dev", "GPL-3.0-or-later"},
      {"Chart.js", "libjs-chart.js", "MIT"},
      {"CLI11", "libcli11-dev", "BSD-3-Clause"},
      {"Draco", "libdraco-dev", "Apache-2.0"},
      {"Eigen", "libeigen3-dev", "MPL-2.0"},
      {"fmt", "libfmt-dev", "MIT"},
      {"JSON for Modern C++", "nlohmann-json3-dev", "MIT"},
      {"libjpeg-turbo", "libturbojpeg0-dev", "IJG AND BSD-3-Clause"},
      {"libpng", "libpng-dev", "libpng-2.0"},
      {"libtiff", "libtiff-dev", "libtiff"},
      {"libwebp", "libwebp-dev", "BSD-3-Clause"},
      {"Mesa (loaded for --gl)", "libosmesa6-dev", "MIT"},
      {"meshoptimizer", "libmeshoptimizer-dev", "MIT"},
      {"Mustache", "libkainjow-mustache-dev", "BSL-1.0"},
      {"OpenCV", "libopencv-dev", "Apache-2.0"},
      {"OpenEXR", "libopenexr-dev", "BSD-3-Clause"},
      {"pugixml", "libpugixml-dev", "MIT"},
      {"pybind11", "pybind11-dev", "BSD-3-Clause"},
      {"Random123", "librandom123-dev", "BSD-3-Clause"},
      {"SQLite", "libsqlite3-dev", "blessing"},
      {"SQLiteCpp", "libsqlitecpp-dev", "MIT"},
      {"stb_image", "libstb-dev", "MIT"},
      {"tinygltf", "libtinygltf-dev", "MIT"},
      {"toml++", "libtomlplusplus-dev", "MIT"},
      {"yaml-cpp", "libyaml-cpp-dev", "MIT"},
      {"zlib", "zlib1g-dev", "Zlib"},
  };
  std::string text = fmt::format(
      "sightline {}: GPL-3.0-or-later; pose/ alone: Apache-2.0\n"
      "Made of these, each from Debian's package of that name:\n",
      SIGHTLINE_VERSION);
  for (const Library& library : kLibraries) {
    text += fmt::format("  {:<24}{:<26}{}\n", library.name, library.package, library.licence);
  }
  return text;
}

std::string doctor(bool measures_renderer) {
  std::string text = fmt::format("sightline {}, built by {}\n", SIGHTLINE_VERSION, __VERSION__) +
                     libraries() + folders() + drawing() + shard();
  if (measures_renderer) text += edge_table();
  return text;
}

}  // namespace sightline
