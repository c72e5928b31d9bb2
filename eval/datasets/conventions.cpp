// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/conventions.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <fmt/format.h>

#include "scenes/files/input_error.h"

namespace sightline {
namespace {

constexpr double kRotationTolerance = 1e-2;
constexpr double kPrintedTolerance = 1e-5;
constexpr double kSkewTolerance = 1e-6;  // of the focal length

using RowWise3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// By how much a number of the transpose times the matrix differs from the identity's.
double off_rotation(const Eigen::Matrix3d& matrix) {
  return (matrix.transpose() * matrix - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
}

}  // namespace

Eigen::Matrix3d matrix_from_rows(std::span<const double> nine) {
  return Eigen::Map<const RowWise3>(nine.data());
}

std::array<double, 9> rows_of(const Eigen::Matrix3d& matrix) {
  std::array<double, 9> nine{};
  Eigen::Map<RowWise3>(nine.data()) = matrix;
  return nine;
}

bool is_near_rotation(const Eigen::Matrix3d& matrix) {
  return matrix.allFinite() && off_rotation(matrix) <= kRotationTolerance &&
         matrix.determinant() > 0;
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix) {
  if (!is_near_rotation(matrix)) throw InputError("is no rotation");
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

std::optional<Eigen::Matrix3d> usable_rotation(const Eigen::Matrix3d& matrix) {
  if (!is_near_rotation(matrix)) return std::nullopt;
  return off_rotation(matrix) <= kPrintedTolerance ? matrix : nearest_rotation(matrix);
}

std::optional<Eigen::Matrix3d> usable_rotation(const Eigen::Quaterniond& quaternion) {
  constexpr double kTolerance = 1e-2;
  if (!(std::abs(quaternion.norm() - 1) <= kTolerance)) return std::nullopt;
  return quaternion.normalized().toRotationMatrix();
}

void require_near(const Eigen::Vector3d& position_m, const std::string& key) {
  if (!position_m.allFinite() || position_m.cwiseAbs().maxCoeff() <= kFarthestM) return;
  throw InputError(fmt::format("{} is {:g} m away, must be within {:g} m", key,
                               position_m.cwiseAbs().maxCoeff(), kFarthestM));
}

Camera camera_from_matrix(const Eigen::Matrix3d& k) {
  const bool has_focus = k.allFinite() && k(0, 0) > 0 && k(1, 1) > 0;
  const bool is_bounded = k.cwiseAbs().maxCoeff() <= kGreatestPx;
  Eigen::Matrix3d rest = k - Eigen::Matrix3d::Identity();
  rest(0, 0) = rest(1, 1) = rest(0, 1) = rest(0, 2) = rest(1, 2) = 0;
  if (!has_focus || !is_bounded ||
      rest.cwiseAbs().maxCoeff() > kSkewTolerance * std::max(1.0, k(0, 0))) {
    throw InputError(
        "must be fx s cx, 0 fy cy, 0 0 1 with focal lengths above 0 and no number beyond 1e8");
  }
  Camera camera;
  camera.fx_px = k(0, 0);
  camera.fy_px = k(1, 1);
  camera.cx_px = k(0, 2);
  camera.cy_px = k(1, 2);
  // Less is rounding.
  if (std::abs(k(0, 1)) > kSkewTolerance * std::max(1.0, k(0, 0))) camera.skew_px = k(0, 1);
  return camera;
}

}  // namespace sightline
