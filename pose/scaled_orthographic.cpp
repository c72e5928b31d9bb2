// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/scaled_orthographic.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace sightline {

std::optional<Eigen::Matrix3d> rotation_from_affine(const Eigen::Matrix<double, 2, 3>& affine) {
  const Eigen::Matrix2d gram = affine * affine.transpose();
  const double det_root = std::sqrt(std::max(gram.determinant(), 0.0));
  if (!(det_root > 1e-9 * gram.trace())) return std::nullopt;
  const Eigen::Matrix2d root =
      (gram + det_root * Eigen::Matrix2d::Identity()) / std::sqrt(gram.trace() + 2 * det_root);
  const Eigen::Matrix<double, 2, 3> rows = root.inverse() * affine;
  Eigen::Matrix3d rotation;
  rotation << rows, rows.row(0).cross(rows.row(1));
  return rotation;
}

std::vector<Eigen::Matrix3d> rotations_from_plane_affine(const Eigen::Matrix2d& affine) {
  // The map is the scale times the upper 2x2 block of the rotation's first two columns; the third
  // row completes them to unit length, and its sign is not known.
  const Eigen::Matrix2d gram = affine.transpose() * affine;
  const double half_trace = 0.5 * gram.trace();
  const double scale2 =  // the larger eigenvalue of gram
      half_trace + std::hypot(0.5 * (gram(0, 0) - gram(1, 1)), gram(0, 1));
  if (!(scale2 > 0)) return {};
  const double c0_2 = std::max(0.0, 1 - gram(0, 0) / scale2);
  const double c1_2 = std::max(0.0, 1 - gram(1, 1) / scale2);
  const double product = -gram(0, 1) / scale2;
  const Eigen::RowVector2d third_row(std::sqrt(c0_2), std::copysign(std::sqrt(c1_2), product));

  std::vector<Eigen::Matrix3d> rotations;
  for (const double sign : {1.0, -1.0}) {
    Eigen::Matrix<double, 3, 2> columns;
    columns << affine / std::sqrt(scale2), sign * third_row;
    Eigen::Matrix3d rotation;
    rotation << columns, columns.col(0).cross(columns.col(1));
    rotations.push_back(rotation);
  }
  return rotations;
}

}  // namespace sightline
