// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
// Kalibr's camchains are of the part of YAML that has a map of maps of words and lists of numbers;
// of the lists within lists nothing is needed here.
#include <algorithm>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "pose/lenses/catalogue.h"
#include "scenes/camera/calibration_formats.h"
#include "scenes/camera/lens_numbers.h"
#include "scenes/files/input_error.h"

namespace sightline::calibration {
namespace {

struct KalibrCamera {
  std::string name;
  std::map<std::string, std::string> values;  // as they stand in the file
};

std::string trimmed(const std::string& text) {
  const size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") + 1 - begin);
}

// The file's maps. A list may go on over several lines, within its brackets or an element a line.
std::vector<KalibrCamera> maps_of(const std::string& text) {
  std::vector<KalibrCamera> maps;
  std::string* value = nullptr;  // the last one
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    const std::string words = trimmed(line.substr(0, line.find('#')));
    if (words.empty() || words.starts_with("%") || words == "---") continue;
    const bool is_open = value != nullptr && value->starts_with("[") && !value->ends_with("]");
    if (is_open || words.starts_with("-")) {
      if (value != nullptr) *value += " " + (is_open ? words : words.substr(1));
      continue;
    }
    const size_t colon = words.find(':');
    if (colon == std::string::npos) continue;
    const std::string key = trimmed(words.substr(0, colon));
    if (line.front() != ' ') {
      maps.push_back({key, {}});
      value = nullptr;
    } else if (!maps.empty()) {
      value = &(maps.back().values[key] = trimmed(words.substr(colon + 1)));
    }
  }
  return maps;
}

std::vector<KalibrCamera> cameras_of(const std::string& text) {
  std::vector<KalibrCamera> cameras = maps_of(text);
  std::erase_if(cameras,
                [](const KalibrCamera& map) { return !map.values.contains("camera_model"); });
  return cameras;
}

std::string word_in(const KalibrCamera& camera, const char* key, const char* fallback) {
  const auto found = camera.values.find(key);
  return found == camera.values.end() ? fallback : found->second;
}

// Empty where there is no list of numbers.
std::vector<double> numbers_in(const KalibrCamera& camera, const char* key) {
  std::string text = word_in(camera, key, "");
  for (char& c : text) {
    if (c == ',' || c == '[' || c == ']') c = ' ';
  }
  std::istringstream words(text);
  std::vector<double> numbers;
  for (double number = 0; words >> number;) numbers.push_back(number);
  return words.eof() ? numbers : std::vector<double>();
}

Lens kalibr_lens(const KalibrCamera& camera) {
  const std::string model = word_in(camera, "distortion_model", "none");
  if (model == "none") return {};
  if (model != "radtan" && model != "equidistant") {
    throw InputError(fmt::format("{}: distortion_model is {}, must be radtan, equidistant or none",
                                 camera.name, model));
  }
  const std::vector<double> k = numbers_in(camera, "distortion_coeffs");
  if (k.size() != 4) {
    throw InputError(fmt::format("{}: distortion_coeffs has {} numbers, must have 4 ({}) of {}",
                                 camera.name, k.size(),
                                 model == "radtan" ? "k1, k2, p1, p2" : "k1, k2, k3, k4", model));
  }
  return lens_of(*find_lens_model(model == "radtan" ? "brown_conrady" : "fisheye"), k);
}

Camera camera_of(const KalibrCamera& stated) {
  const std::string model = word_in(stated, "camera_model", "");
  if (model != "pinhole") {
    throw InputError(fmt::format("{}: camera_model is {}, must be pinhole", stated.name, model));
  }
  const std::vector<double> k = numbers_in(stated, "intrinsics");
  if (k.size() != 4 || !(k[0] > 0) || !(k[1] > 0)) {
    throw InputError(fmt::format(
        "{}: intrinsics must be [fx, fy, cx, cy] with focal lengths above 0", stated.name));
  }
  const std::vector<double> size = numbers_in(stated, "resolution");
  const bool is_size = size.size() == 2 && std::all_of(size.begin(), size.end(), [](double side) {
                         return side >= 1 && side <= 1e6;
                       });
  if (!is_size) {
    throw InputError(fmt::format("{}: resolution must be [width, height] in pixels", stated.name));
  }
  Camera camera;
  camera.fx_px = k[0];
  camera.fy_px = k[1];
  camera.cx_px = k[2];
  camera.cy_px = k[3];
  camera.width_px = static_cast<int>(size[0]);
  camera.height_px = static_cast<int>(size[1]);
  camera.lens = kalibr_lens(stated);
  require_unfolded(camera, stated.name + ": distortion_coeffs");
  return camera;
}

}  // namespace

bool is_kalibr(const std::string& text) {
  return !cameras_of(text).empty();
}

Camera kalibr_camera(const std::string& text, const std::string& name) {
  const std::vector<KalibrCamera> cameras = cameras_of(text);
  std::vector<std::string> names;
  for (const KalibrCamera& camera : cameras) names.push_back(camera.name);
  return camera_of(cameras[chosen_camera(name, names)]);
}

}  // namespace sightline::calibration
