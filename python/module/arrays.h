// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Between numpy's arrays and our types. The package's Python side has checked all shapes.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <pybind11/numpy.h>

#include "pose/camera.h"
#include "pose/pose.h"

namespace sightline {

/// Doubles by rows; other arrays are converted.
using Doubles = pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>;

/// A camera as the package holds it: width, height, fx, fy, cx, cy, k1, k2, p1, p2, k3.
Camera camera_from(const pybind11::tuple& numbers);
pybind11::tuple numbers_of(const Camera& camera);

/// A rigid transform as a 4 x 4 matrix.
Pose pose_from(const Doubles& matrix);
Doubles matrix_of(const Pose& b_from_a);

/// The rows of an n x 3 or n x 2 array, and back.
std::vector<Eigen::Vector3d> points_from(const Doubles& rows);
std::vector<Eigen::Vector2d> pixels_from(const Doubles& rows);
Doubles rows_of(const std::vector<Eigen::Vector3d>& points);
Doubles rows_of(const std::vector<Eigen::Vector2d>& pixels);

/// n x 2 x 2 covariances, and back.
std::vector<Eigen::Matrix2d> covariances_from(const Doubles& matrices);
Doubles array_of(const std::vector<Eigen::Matrix2d>& matrices);

Matrix6d matrix6_from(const Doubles& matrix);
Doubles array_of(const Matrix6d& matrix);

/// The pixels themselves, not a copy: the array keeps them alive, and cannot write to them.
pybind11::array view_of(const cv::Mat& image);
/// The same of an image of blue, green and red: height x width x 3, red first.
pybind11::array colours_of(const cv::Mat& image);

}  // namespace sightline
