// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <opencv2/core.hpp>

#include "scenes/camera/calibration_formats.h"
#include "scenes/camera/lens_numbers.h"
#include "scenes/files/input_error.h"

namespace sightline::calibration {
namespace {

constexpr double kNoSkew = 1e-6;  // of the focal length: rounding

cv::FileStorage storage_of(const std::string& text) {
  cv::FileStorage storage;
  try {
    storage.open(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
  } catch (const cv::Exception&) {
    storage.release();
  }
  if (storage.isOpened()) return storage;
  throw InputError(
      "is no calibration file of OpenCV or Kalibr (.yaml, .json, .xml), nor COLMAP's cameras.txt, "
      "nor a .toml with [camera]");
}

cv::Mat matrix_in(const cv::FileStorage& storage, const char* key) {
  cv::Mat matrix;
  if (storage[key].isMap() || storage[key].isSeq()) storage[key] >> matrix;
  matrix.convertTo(matrix, CV_64F);
  return matrix;
}

// The focal lengths, the principal point and the skew of fx s cx, 0 fy cy, 0 0 1.
Camera matrix_camera(const cv::FileStorage& storage) {
  const cv::Mat k = matrix_in(storage, "camera_matrix");
  if (k.total() != 9) throw InputError("camera_matrix is missing, must be 3 x 3");
  const auto at = [&k](int i) { return k.at<double>(i); };
  bool is_finite = true;
  for (int i = 0; i < 9; ++i) is_finite = is_finite && std::isfinite(at(i));
  const bool has_rest = at(3) == 0 && at(6) == 0 && at(7) == 0 && at(8) == 1;
  if (!is_finite || !has_rest || !(at(0) > 0) || !(at(4) > 0)) {
    throw InputError("camera_matrix must be fx s cx, 0 fy cy, 0 0 1 with focal lengths above 0");
  }
  Camera camera;
  camera.fx_px = at(0);
  camera.fy_px = at(4);
  camera.cx_px = at(2);
  camera.cy_px = at(5);
  if (std::abs(at(1)) > kNoSkew * at(0)) camera.skew_px = at(1);
  return camera;
}

// A side in pixels; as far to each side of the principal point where none is stated.
int side_in(const cv::FileStorage& storage, const char* key, double centre_px) {
  const cv::FileNode node = storage[key];
  if (node.isInt()) {
    const int side = static_cast<int>(node);
    if (side < 1) throw InputError(fmt::format("{} is {}, must be positive", key, side));
    return side;
  }
  constexpr double kMostPixels = 1e6;
  return static_cast<int>(std::clamp(2 * centre_px + 1, 1.0, kMostPixels));
}

// Whether the coefficients are those of OpenCV's fisheye module, as its samples and ROS say it.
bool is_stated_fisheye(const cv::FileStorage& storage) {
  const cv::FileNode flag = storage["fisheye_model"];
  if (flag.isInt() && static_cast<int>(flag) != 0) return true;
  const cv::FileNode model = storage["distortion_model"];
  if (!model.isString()) return false;
  const std::vector<std::string> fisheyes = {"fisheye", "equidistant"};
  const std::vector<std::string> others = {"plumb_bob", "brown_conrady", "rational_polynomial",
                                           "rational"};
  const std::string word = static_cast<std::string>(model);
  if (std::find(fisheyes.begin(), fisheyes.end(), word) != fisheyes.end()) return true;
  if (std::find(others.begin(), others.end(), word) != others.end()) return false;
  throw InputError(fmt::format("distortion_model is \"{}\", must be one of {}, {}", word,
                               fmt::join(fisheyes, ", "), fmt::join(others, ", ")));
}

Lens lens_in(const cv::FileStorage& storage) {
  const cv::Mat d = matrix_in(storage, "distortion_coefficients");
  std::vector<double> coefficients;
  for (size_t i = 0; i < d.total(); ++i) coefficients.push_back(d.at<double>(static_cast<int>(i)));
  try {
    return is_stated_fisheye(storage) ? lens_of(*find_lens_model("fisheye"), coefficients)
                                      : lens_of_opencv(coefficients);
  } catch (const InputError& error) {
    const std::string reason = error.what();
    const bool is_of_list = reason.starts_with("has");
    throw InputError(is_of_list ? "distortion_coefficients " + reason : reason);
  }
}

Camera stored_camera(const cv::FileStorage& storage) {
  Camera camera = matrix_camera(storage);
  camera.width_px = side_in(storage, "image_width", camera.cx_px);
  camera.height_px = side_in(storage, "image_height", camera.cy_px);
  camera.lens = lens_in(storage);
  // A size that is not stated is only what a pixel may be said to lie outside of.
  if (storage["image_width"].isInt() && storage["image_height"].isInt()) {
    require_unfolded(camera, "distortion_coefficients");
  }
  return camera;
}

}  // namespace

Camera opencv_camera(std::string text, bool is_yaml) {
  if (is_yaml && !text.starts_with("%YAML")) text = "%YAML:1.0\n---\n" + text;
  const cv::FileStorage storage = storage_of(text);
  try {
    return stored_camera(storage);
  } catch (const cv::Exception&) {
    throw InputError("has a value of a type that cannot be used");
  }
}

}  // namespace sightline::calibration
