// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenes/camera/calibration_formats.h"
#include "scenes/camera/lens_numbers.h"
#include "scenes/files/input_error.h"

namespace sightline::calibration {
namespace {

// COLMAP has (0.5, 0.5) at the centre of the top-left pixel.
constexpr double kColmapHalfPixel = 0.5;

// A model by COLMAP's word: ours, and its parameters in the order of the file.
struct ColmapModel {
  std::string word;
  const char* lens;
  std::vector<std::string> parameters;
};

const std::vector<ColmapModel>& colmap_models() {
  static const std::vector<ColmapModel> models = {
      {"SIMPLE_PINHOLE", "brown_conrady", {"f", "cx", "cy"}},
      {"PINHOLE", "brown_conrady", {"fx", "fy", "cx", "cy"}},
      {"SIMPLE_RADIAL", "brown_conrady", {"f", "cx", "cy", "k1"}},
      {"RADIAL", "brown_conrady", {"f", "cx", "cy", "k1", "k2"}},
      {"OPENCV", "brown_conrady", {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"}},
      {"FULL_OPENCV",
       "rational",
       {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}},
      {"OPENCV_FISHEYE", "fisheye", {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"}},
      {"SIMPLE_RADIAL_FISHEYE", "fisheye", {"f", "cx", "cy", "k1"}},
      {"RADIAL_FISHEYE", "fisheye", {"f", "cx", "cy", "k1", "k2"}}};
  return models;
}

// A line of the file: an id, a model, a size and the parameters.
struct ColmapLine {
  int number = 0;
  std::string id, model;
  double width = 0, height = 0;
  std::vector<double> parameters;
};

std::vector<ColmapLine> lines_of(const std::string& text) {
  std::vector<ColmapLine> lines;
  std::istringstream stream(text);
  int number = 0;
  for (std::string row; std::getline(stream, row);) {
    ++number;
    const size_t begin = row.find_first_not_of(" \t\r");
    if (begin == std::string::npos || row[begin] == '#') continue;
    ColmapLine line;
    line.number = number;
    std::istringstream words(row);
    bool is_whole = static_cast<bool>(words >> line.id >> line.model >> line.width >> line.height);
    is_whole =
        is_whole && line.width >= 1 && line.height >= 1 && line.width <= 1e6 && line.height <= 1e6;
    for (double value = 0; is_whole && words >> value;) line.parameters.push_back(value);
    if (!is_whole || !words.eof()) {
      throw InputError(fmt::format(
          "line {} is \"{}\", must be CAMERA_ID MODEL WIDTH HEIGHT PARAMS as in COLMAP's "
          "cameras.txt",
          number, row));
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

const ColmapModel& model_in(const ColmapLine& line) {
  std::vector<std::string> words;
  for (const ColmapModel& model : colmap_models()) {
    if (model.word == line.model) return model;
    words.push_back(model.word);
  }
  throw InputError(fmt::format("line {}: MODEL is {}, must be one of {}", line.number, line.model,
                               fmt::join(words, ", ")));
}

Camera camera_of_line(const ColmapLine& line) {
  const ColmapModel& model = model_in(line);
  if (line.parameters.size() != model.parameters.size()) {
    throw InputError(fmt::format("line {}: {} has {} parameters, must have {} ({})", line.number,
                                 line.model, line.parameters.size(), model.parameters.size(),
                                 fmt::join(model.parameters, ", ")));
  }
  const auto value_of = [&](const std::string& name) {
    const auto found = std::find(model.parameters.begin(), model.parameters.end(), name);
    return found == model.parameters.end()
               ? 0
               : line.parameters[static_cast<size_t>(found - model.parameters.begin())];
  };
  const bool has_one_focus = model.parameters.front() == "f";
  Camera camera;
  camera.width_px = static_cast<int>(line.width);
  camera.height_px = static_cast<int>(line.height);
  camera.fx_px = value_of(has_one_focus ? "f" : "fx");
  camera.fy_px = value_of(has_one_focus ? "f" : "fy");
  camera.cx_px = value_of("cx") - kColmapHalfPixel;
  camera.cy_px = value_of("cy") - kColmapHalfPixel;
  if (!(camera.fx_px > 0) || !(camera.fy_px > 0)) {
    throw InputError(fmt::format("line {}: a focal length is not above 0", line.number));
  }
  const LensModel& lens = *find_lens_model(model.lens);
  std::vector<double> coefficients;
  for (const std::string& name : lens.coefficients) coefficients.push_back(value_of(name));
  camera.lens = lens_of(lens, coefficients);
  require_unfolded(camera, fmt::format("line {}: {}", line.number, line.model));
  return camera;
}

}  // namespace

Camera colmap_camera(const std::string& text, const std::string& name) {
  const std::vector<ColmapLine> lines = lines_of(text);
  std::vector<std::string> ids;
  for (const ColmapLine& line : lines) ids.push_back(line.id);
  return camera_of_line(lines[chosen_camera(name, ids)]);
}

}  // namespace sightline::calibration
