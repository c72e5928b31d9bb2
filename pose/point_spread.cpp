// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/point_spread.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace sightline {

Eigen::Vector3d mean_of(std::span<const Eigen::Vector3d> points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

Eigen::Matrix3d Moments::matrix() const {
  Eigen::Matrix3d m;
  m << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  return m;
}

Eigen::Matrix3d moments_of(std::span<const Eigen::Vector3d> points) {
  Moments moments;
  for (const Eigen::Vector3d& p : points) moments.add(p);
  return moments.matrix();
}

double second_invariant(const Eigen::Matrix3d& m) {
  return m(0, 0) * m(1, 1) - m(0, 1) * m(0, 1) + m(0, 0) * m(2, 2) - m(0, 2) * m(0, 2) +
         m(1, 1) * m(2, 2) - m(1, 2) * m(1, 2);
}

PointSpread spread_of(std::span<const Eigen::Vector3d> points) {
  PointSpread spread;
  spread.mean = mean_of(points);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d d = p - spread.mean;
    scatter += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);  // ascending
  spread.axes.col(0) = eigen.eigenvectors().col(2);
  spread.axes.col(1) = eigen.eigenvectors().col(1);
  spread.axes.col(2) = spread.axes.col(0).cross(spread.axes.col(1));
  spread.sd = eigen.eigenvalues().reverse().cwiseMax(0.0).cwiseSqrt();
  return spread;
}

}  // namespace sightline
