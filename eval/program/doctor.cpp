// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/program/doctor.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <SQLiteCpp/Database.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <opencv2/core.hpp>

#include "eval/output/json.h"
#include "eval/work/shard.h"
#include "renderer/edge_errors.h"
#include "renderer/renderer.h"
#include "renderer/sample_pattern.h"
#include "scenes/files/assets.h"
#include "scenes/files/child_process.h"
#include "scenes/files/input_error.h"
#include "scenes/scene/scene.h"

namespace sightline {
namespace {

struct Section {
  std::string title;
  std::vector<std::pair<std::string, std::string>> lines;
};

Section libraries() {
  return {"libraries",
          {{"OpenCV", cv::getVersionString()},
           {"Eigen",
            fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
           {"SQLite", SQLite::getLibVersion()},
           {"fmt", fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100,
                               FMT_VERSION % 100)}}};
}

Section folders() {
  std::string assets;
  try {
    assets = fmt::format("{} ({} targets, {} studies)", assets_folder().string(),
                         target_names().size(), study_names().size());
  } catch (const std::exception& error) {
    assets = error.what();
  }
  return {"folders", {{"assets", assets}}};
}

std::string context_of(GlChoice choice) {
  try {
    return Renderer({.gl = choice}).description();
  } catch (const GraphicsError& error) {
    return fmt::format("not to be had: {}", error.what());
  }
}

Section drawing() {
  return {"drawing",
          {{"used by default", Renderer().description()},
           {"--gl auto", context_of(GlChoice::kAuto)},
           {"--gl osmesa", context_of(GlChoice::kOsMesa)},
           {"--gl egl", context_of(GlChoice::kEgl)}}};
}

Section shard() {
  std::string text;
  try {
    const ShardChoice choice =
        read_shard("auto", [](const char* name) { return std::getenv(name); });
    text = fmt::format("{}/{} ({})", choice.shard.index, choice.shard.count, choice.source);
  } catch (const InputError& error) {
    text = error.what();
  }
  return {"shards", {{"--shard auto", text}}};
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

// Of one number of samples: what is measured, what is promised, and a frame's time.
struct EdgeRow {
  int samples;
  EdgeErrors measured, promised;
  double ms;
};

std::vector<EdgeRow> edge_rows() {
  constexpr int kPoses = 30;
  std::vector<EdgeRow> rows;
  Renderer renderer;
  for (const int samples : kSampleCounts) {
    rows.push_back({samples, measure_edge_errors(renderer, samples, kPoses),
                    promised_edge_errors(samples), frame_ms(renderer, samples)});
  }
  return rows;
}

std::string edge_table() {
  std::string text =
      "edges and vertices of a cube, px rms from their places (promised), and a frame of 512 x "
      "512\n"
      "  samples   general edges       edges along an axis   vertices            ms a frame\n";
  for (const auto& [samples, measured, promised, ms] : edge_rows()) {
    const auto cell = [](double value, double limit) {
      return fmt::format("{:.4f} ({:.4f}){}", value, limit, value <= limit ? "   " : " ! ");
    };
    text += fmt::format("  {:>7}   {:<20}{:<22}{:<20}{:.1f}\n", samples,
                        cell(measured.general_px, promised.general_px),
                        cell(measured.axis_px, promised.axis_px),
                        cell(measured.vertex_px, promised.vertex_px), ms);
  }
  return text;
}

// Programs that a run asks, and what it goes without where they are missing.
Section programs() {
  const auto said = [](const std::string& program, const std::string& without) {
    const bool is_there = run_program({program, "--version"}, "/") != kProgramNotFound;
    return std::pair(program, is_there ? "found" : "missing: " + without);
  };
  return {"programs",
          {said("gnuplot", "runs have no figures/ for print (package gnuplot-nox)"),
           said("xdg-open", "report --open shows nothing (package xdg-utils)")}};
}

std::vector<Section> sections() {
  return {libraries(), folders(), programs(), drawing(), shard()};
}

Json errors_json(const EdgeErrors& errors) {
  return {{"general_px", errors.general_px},
          {"axis_px", errors.axis_px},
          {"vertex_px", errors.vertex_px}};
}

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
    {"ISA-L", "libisal-dev", "BSD-3-Clause"},
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

}  // namespace

std::string library_licences() {
  std::string text = fmt::format(
      "sightline {}: GPL-3.0-or-later; pose/ alone: Apache-2.0\n"
      "Made of these, each from Debian's package of that name:\n",
      SIGHTLINE_VERSION);
  for (const Library& library : kLibraries) {
    text += fmt::format("  {:<24}{:<26}{}\n", library.name, library.package, library.licence);
  }
  return text;
}

std::string licences_json() {
  Json json = {{"sightline", SIGHTLINE_VERSION}, {"libraries", Json::array()}};
  for (const Library& library : kLibraries) {
    json["libraries"].push_back(
        {{"name", library.name}, {"package", library.package}, {"licence", library.licence}});
  }
  return json_text(json);
}

std::string doctor(bool measures_renderer) {
  std::string text = fmt::format("sightline {}, built by {}\n", SIGHTLINE_VERSION, __VERSION__);
  for (const Section& section : sections()) {
    text += section.title + "\n";
    for (const auto& [name, value] : section.lines)
      text += fmt::format("  {:<16}{}\n", name, value);
  }
  if (measures_renderer) text += edge_table();
  return text;
}

std::string doctor_json(bool measures_renderer) {
  Json json = {{"sightline", SIGHTLINE_VERSION}, {"compiler", __VERSION__}};
  for (const Section& section : sections()) {
    for (const auto& [name, value] : section.lines) json[section.title][name] = value;
  }
  if (!measures_renderer) return json_text(json);
  for (const auto& [samples, measured, promised, ms] : edge_rows()) {
    json["renderer"].push_back({{"samples", samples},
                                {"measured", errors_json(measured)},
                                {"promised", errors_json(promised)},
                                {"frame_ms", ms}});
  }
  return json_text(json);
}

}  // namespace sightline
