// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "python/module/arrays.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include <pybind11/stl.h>

#include "pose/lenses/catalogue.h"

namespace sightline {
namespace {

namespace py = pybind11;

template <int kSize>
std::vector<Eigen::Vector<double, kSize>> vectors_from(const Doubles& rows) {
  std::vector<Eigen::Vector<double, kSize>> vectors;
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    vectors.emplace_back(Eigen::Map<const Eigen::Vector<double, kSize>>(rows.data(i, 0)));
  }
  return vectors;
}

template <int kSize>
Doubles array_from(const std::vector<Eigen::Vector<double, kSize>>& vectors) {
  Doubles rows({static_cast<py::ssize_t>(vectors.size()), py::ssize_t{kSize}});
  double* out = rows.mutable_data();
  for (const auto& vector : vectors) out = std::copy(vector.begin(), vector.end(), out);
  return rows;
}

template <int kRows, int kColumns>
using ByRows = Eigen::Matrix<double, kRows, kColumns, Eigen::RowMajor>;

py::dtype dtype_of(const cv::Mat& image) {
  switch (image.depth()) {
    case CV_8U:
      return py::dtype::of<uint8_t>();
    case CV_16U:
      return py::dtype::of<uint16_t>();
    case CV_64F:
      return py::dtype::of<double>();
    default:
      throw std::logic_error("an image of a depth that frames do not have");
  }
}

py::array read_only(const cv::Mat& image, const std::vector<py::ssize_t>& shape,
                    const std::vector<py::ssize_t>& strides, const uint8_t* first) {
  // Another header of the same pixels, which counts as one more that uses them.
  const py::capsule owner(new cv::Mat(image), [](void* mat) { delete static_cast<cv::Mat*>(mat); });
  py::array array(dtype_of(image), shape, strides, first, owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

}  // namespace

Camera camera_from(const py::tuple& numbers) {
  Camera camera;
  camera.width_px = numbers[0].cast<int>();
  camera.height_px = numbers[1].cast<int>();
  camera.fx_px = numbers[2].cast<double>();
  camera.fy_px = numbers[3].cast<double>();
  camera.cx_px = numbers[4].cast<double>();
  camera.cy_px = numbers[5].cast<double>();
  camera.skew_px = numbers[6].cast<double>();
  const LensModel& model = *find_lens_model(numbers[7].cast<std::string>());
  std::vector<double> coefficients;
  for (size_t i = 8; i < numbers.size(); ++i) coefficients.push_back(numbers[i].cast<double>());
  camera.lens = *make_lens(model, coefficients);
  return camera;
}

py::tuple numbers_of(const Camera& camera) {
  py::tuple numbers =
      py::make_tuple(camera.width_px, camera.height_px, camera.fx_px, camera.fy_px, camera.cx_px,
                     camera.cy_px, camera.skew_px, model_of(camera.lens).name);
  return numbers + py::tuple(py::cast(coefficients_of(camera.lens)));
}

Pose pose_from(const Doubles& matrix) {
  const Eigen::Map<const ByRows<4, 4>> m(matrix.data());
  return {m.topLeftCorner<3, 3>(), m.topRightCorner<3, 1>()};
}

Doubles matrix_of(const Pose& b_from_a) {
  Doubles matrix({4, 4});
  Eigen::Map<ByRows<4, 4>> m(matrix.mutable_data());
  m.setIdentity();
  m.topLeftCorner<3, 3>() = b_from_a.rotation;
  m.topRightCorner<3, 1>() = b_from_a.translation;
  return matrix;
}

std::vector<Eigen::Vector3d> points_from(const Doubles& rows) {
  return vectors_from<3>(rows);
}
std::vector<Eigen::Vector2d> pixels_from(const Doubles& rows) {
  return vectors_from<2>(rows);
}
Doubles rows_of(const std::vector<Eigen::Vector3d>& points) {
  return array_from(points);
}
Doubles rows_of(const std::vector<Eigen::Vector2d>& pixels) {
  return array_from(pixels);
}

std::vector<Eigen::Matrix2d> covariances_from(const Doubles& matrices) {
  std::vector<Eigen::Matrix2d> covariances;
  for (py::ssize_t i = 0; i < matrices.shape(0); ++i) {
    covariances.emplace_back(Eigen::Map<const ByRows<2, 2>>(matrices.data(i, 0, 0)));
  }
  return covariances;
}

Doubles array_of(const std::vector<Eigen::Matrix2d>& matrices) {
  Doubles out({static_cast<py::ssize_t>(matrices.size()), py::ssize_t{2}, py::ssize_t{2}});
  for (size_t i = 0; i < matrices.size(); ++i) {
    Eigen::Map<ByRows<2, 2>>(out.mutable_data(static_cast<py::ssize_t>(i), 0, 0)) = matrices[i];
  }
  return out;
}

Matrix6d matrix6_from(const Doubles& matrix) {
  return Eigen::Map<const ByRows<6, 6>>(matrix.data());
}

Doubles array_of(const Matrix6d& matrix) {
  Doubles out({6, 6});
  Eigen::Map<ByRows<6, 6>>(out.mutable_data()) = matrix;
  return out;
}

py::array view_of(const cv::Mat& image) {
  const auto size = static_cast<py::ssize_t>(image.elemSize());
  const auto row = static_cast<py::ssize_t>(image.step[0]);
  return read_only(image, {py::ssize_t{image.rows}, py::ssize_t{image.cols}}, {row, size},
                   image.data);
}

py::array colours_of(const cv::Mat& image) {
  const auto number = static_cast<py::ssize_t>(image.elemSize1());
  const auto row = static_cast<py::ssize_t>(image.step[0]);
  // From red, the last of three, backwards.
  return read_only(image, {py::ssize_t{image.rows}, py::ssize_t{image.cols}, py::ssize_t{3}},
                   {row, 3 * number, -number}, image.data + 2 * number);
}

}  // namespace sightline
