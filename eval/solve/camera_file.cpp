// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/solve/camera_file.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "eval/datasets/conventions.h"
#include "scenes/files/input_error.h"
#include "scenes/files/toml_table.h"
#include "scenes/scene/imaging.h"

namespace sightline {
namespace {

Camera read_toml_camera(const std::filesystem::path& file) {
  const TomlTable table = TomlTable::read_file(file);
  if (!table.has("camera")) table.fail("camera", "is missing: the file must have such a table");
  return read_camera(table.table("camera"));
}

cv::FileStorage open_calibration(const std::filesystem::path& file) {
  cv::FileStorage storage;
  if (std::filesystem::is_regular_file(file)) {
    try {
      storage.open(file.string(), cv::FileStorage::READ);
    } catch (const cv::Exception&) {
      throw InputError(fmt::format(
          "{}: is no calibration file of OpenCV, nor a .toml with [camera]", file.string()));
    }
  }
  if (!storage.isOpened()) throw InputError(fmt::format("{}: cannot be read", file.string()));
  return storage;
}

cv::Mat matrix_in(const cv::FileStorage& storage, const char* key) {
  cv::Mat matrix;
  if (storage[key].isMap() || storage[key].isSeq()) storage[key] >> matrix;
  matrix.convertTo(matrix, CV_64F);
  return matrix;
}

int size_in(const cv::FileStorage& storage, const char* key, int fallback) {
  return storage[key].isInt() ? static_cast<int>(storage[key]) : fallback;
}

}  // namespace

Camera read_camera_file(const std::filesystem::path& file) {
  if (file.extension() == ".toml") return read_toml_camera(file);
  const cv::FileStorage storage = open_calibration(file);
  const auto fail = [&file](const char* key, const std::string& reason) {
    throw InputError(fmt::format("{}: {} {}", file.string(), key, reason));
  };
  const cv::Mat k = matrix_in(storage, "camera_matrix");
  if (k.total() != 9) fail("camera_matrix", "is missing, must be 3 x 3");
  const std::array<double, 9> rows = {k.at<double>(0), k.at<double>(1), k.at<double>(2),
                                      k.at<double>(3), k.at<double>(4), k.at<double>(5),
                                      k.at<double>(6), k.at<double>(7), k.at<double>(8)};
  Camera camera;
  try {
    camera = camera_from_matrix(matrix_from_rows(rows));
  } catch (const InputError& error) {
    fail("camera_matrix", error.what());
  }
  // Nothing is drawn here: a size is only what a pixel may be said to lie outside of.
  camera.width_px = size_in(storage, "image_width", static_cast<int>(2 * camera.cx_px + 1));
  camera.height_px = size_in(storage, "image_height", static_cast<int>(2 * camera.cy_px + 1));
  if (camera.width_px < 1 || camera.height_px < 1) fail("image_width", "must be positive");
  const cv::Mat d = matrix_in(storage, "distortion_coefficients");
  const size_t count = d.total();
  if (count != 0 && count != 4 && count != 5) {
    fail("distortion_coefficients",
         fmt::format("has {} numbers, must have none, 4 or 5 (k1, k2, p1, p2, k3)", count));
  }
  std::array<double, 5> lens{};
  for (size_t i = 0; i < count; ++i) lens[i] = d.at<double>(static_cast<int>(i));
  if (!std::all_of(lens.begin(), lens.end(), [](double c) { return std::isfinite(c); })) {
    fail("distortion_coefficients", "must be finite numbers");
  }
  camera.distortion = {.k1 = lens[0], .k2 = lens[1], .p1 = lens[2], .p2 = lens[3], .k3 = lens[4]};
  return camera;
}

}  // namespace sightline
