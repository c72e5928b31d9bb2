// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "pose/lenses/catalogue.h"
#include "scenes/camera/calibration_formats.h"
#include "scenes/camera/lens_numbers.h"
#include "scenes/files/input_error.h"

namespace sightline::calibration {
namespace {

struct KalibrCamera {
  std::string name;
  YAML::Node values;
};

// The maps of a camchain that have a camera_model; empty where the text is no YAML, or another.
std::vector<KalibrCamera> cameras_of(const std::string& text) {
  // OpenCV's first line is none of YAML's; some give it to every calibration.
  const bool has_opencv_line = text.starts_with("%YAML:");
  std::vector<KalibrCamera> cameras;
  try {
    const YAML::Node root = YAML::Load(has_opencv_line ? text.substr(text.find('\n')) : text);
    if (!root.IsMap()) return {};
    for (const auto& entry : root) {
      if (!entry.second.IsMap() || !entry.second["camera_model"]) continue;
      cameras.push_back({entry.first.as<std::string>(), entry.second});
    }
  } catch (const YAML::Exception&) {
    return {};
  }
  return cameras;
}

// Empty where there is no word of that key, or something else.
std::string word_in(const KalibrCamera& camera, const char* key) {
  const YAML::Node value = camera.values[key];
  return value && value.IsScalar() ? value.as<std::string>() : std::string();
}

// Empty where there is no list of finite numbers.
std::vector<double> numbers_in(const KalibrCamera& camera, const char* key) {
  try {
    const YAML::Node value = camera.values[key];
    if (!value) return {};
    const auto numbers = value.as<std::vector<double>>();
    const bool is_finite =
        std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
    return is_finite ? numbers : std::vector<double>();
  } catch (const YAML::Exception&) {
    return {};
  }
}

Lens kalibr_lens(const KalibrCamera& camera) {
  const std::string model = word_in(camera, "distortion_model");
  if (model == "none" || !camera.values["distortion_model"]) return {};
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
  const std::string model = word_in(stated, "camera_model");
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
