// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/camera/calibration_file.h"

#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenes/camera/calibration_formats.h"
#include "scenes/camera/lens_numbers.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"

namespace sightline {
namespace calibration {

size_t chosen_camera(const std::string& name, std::span<const std::string> all) {
  if (all.empty()) throw InputError("has no camera");
  if (name.empty() && all.size() == 1) return 0;
  for (size_t i = 0; i < all.size(); ++i) {
    if (!name.empty() && all[i] == name) return i;
  }
  if (name.empty()) {
    throw InputError(
        fmt::format("has the cameras {}: say which by FILE#{}", fmt::join(all, ", "), all.front()));
  }
  throw InputError(fmt::format("has no camera {}{}", name, suggestion(name, all)));
}

void require_unfolded(const Camera& camera, const std::string& key) {
  const std::string reason = why_folded(camera);
  if (!reason.empty()) throw InputError(key + " " + reason);
}

}  // namespace calibration

namespace {

namespace fs = std::filesystem;

// FILE or FILE#NAME.
struct GivenFile {
  fs::path file;
  std::string camera;
};

GivenFile given_file(const fs::path& given) {
  const std::string text = given.string();
  const size_t hash = text.rfind('#');
  if (hash == std::string::npos || fs::is_regular_file(given)) return {given, {}};
  return {text.substr(0, hash), text.substr(hash + 1)};
}

bool is_yaml(const fs::path& file) {
  return file.extension() == ".yaml" || file.extension() == ".yml";
}

Camera camera_in(const GivenFile& given, const std::string& text) {
  if (given.file.extension() == ".txt") return calibration::colmap_camera(text, given.camera);
  if (calibration::is_kalibr(text)) return calibration::kalibr_camera(text, given.camera);
  if (!given.camera.empty()) {
    throw InputError(fmt::format("has one camera without a name, not {}", given.camera));
  }
  return calibration::opencv_camera(text, is_yaml(given.file));
}

}  // namespace

Camera read_calibration_file(const fs::path& file) {
  const GivenFile given = given_file(file);
  const std::string text = read_input_file(given.file, kMostTextBytes);
  try {
    return camera_in(given, text);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", given.file.string(), error.what()));
  }
}

}  // namespace sightline
