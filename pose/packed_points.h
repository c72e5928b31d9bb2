// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Correspondences in the form that the kernel of least squares takes
// (pose/kernels/reprojection_kernel.h), and poses and matrices to and from its plain arrays.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "pose/kernels/reprojection_kernel.h"
#include "pose/pose.h"
#include "pose/reprojection.h"
#include "pose/solver.h"

namespace sightline {

/// Correspondences as the kernel takes them, four points side by side. Up to sixteen points are
/// held without an allocation.
class PackedPoints {
 public:
  /// Packs points whose squared residuals are multiplied by `weights`; none means ones. A point of
  /// weight zero is not looked at. All are multiplied by `common` too.
  explicit PackedPoints(const Correspondences& c, std::span<const double> weights = {},
                        double common = 1);
  /// Packs points whose squared residual is r^T W r, with a symmetric matrix W for each point.
  PackedPoints(const Correspondences& c, std::span<const Eigen::Matrix2d> weights);

  /// Least squares by Marquardt's method from one start (kernel::fit).
  kernel::Fit fit(const Pose& start, int max_iterations, double step_tolerance) const;

  /// Multiplies the weight of one point.
  void scale_weight(std::size_t point, double factor);

  std::span<const kernel::PointLanes> lanes() const { return {data(), count_}; }

 private:
  static constexpr std::size_t kInline = 4;

  PackedPoints(const Correspondences& c, std::size_t lanes);
  kernel::PointLanes* data() { return heap_.empty() ? inline_.data() : heap_.data(); }
  const kernel::PointLanes* data() const { return heap_.empty() ? inline_.data() : heap_.data(); }

  std::size_t count_;
  std::array<kernel::PointLanes, kInline> inline_;
  std::vector<kernel::PointLanes> heap_;
};

/// A pose from the kernel's plain arrays, and back.
Pose pose_from(const kernel::RigidPose& pose);
kernel::RigidPose rigid_from(const Pose& pose);

/// A symmetric matrix from its upper triangle, row by row.
Matrix6d symmetric_from(const double (&upper)[21]);

/// A model's Hessian in full.
Matrix6d hessian_of(const kernel::NormalEquations& model);

/// The inverse of a fit's Hessian, which is the covariance at unit noise. None where it is not
/// positive definite to rounding, as of inverse_information.
std::optional<Matrix6d> inverse_of(const kernel::NormalEquations& model);

/// The information matrix J^T W J of the points at a pose. None when a point of weight other than
/// zero is behind the camera.
std::optional<Matrix6d> information_at(const PackedPoints& points, const Pose& cam_from_centred);

}  // namespace sightline
