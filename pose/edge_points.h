// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// What an observed line comes to. An offset o and a slope m of covariance C about a pixel are, at
// two places along the line, two offsets that err independently: at the distances s1 and s2 from
// where o and m are uncorrelated, with s1 s2 = -var(o) / var(m). Each says that the image of the
// edge passes one pixel, up to an error along one normal. That has a simple residual, and a lens
// bends it as it bends a pixel.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "pose/camera.h"
#include "pose/kernels/reprojection_kernel.h"
#include "pose/line_observation.h"
#include "pose/pose.h"

namespace sightline {

/// A pixel that the image of a straight edge passes, up to noise along a normal.
struct EdgePoint {
  Eigen::Vector3d begin_in_target = Eigen::Vector3d::Zero();
  Eigen::Vector3d end_in_target = Eigen::Vector3d::UnitX();
  Eigen::Vector2d ray = Eigen::Vector2d::Zero();  ///< (x/z, y/z) of the pixel, without lens
  /// A pixel's way across the line, in the coordinates of `ray`.
  Eigen::Vector2d normal_per_px = Eigen::Vector2d::UnitY();
  double variance_px2 = 1;  ///< of the image of the edge along the normal
};

/// The one or two edge points of a line: one where its slope is not known.
class EdgePoints {
 public:
  void add(const EdgePoint& point) { points_[count_++] = point; }
  std::size_t size() const { return count_; }
  const EdgePoint* begin() const { return points_.data(); }
  const EdgePoint* end() const { return points_.data() + count_; }
  const EdgePoint& operator[](std::size_t i) const { return points_[i]; }

 private:
  std::array<EdgePoint, 2> points_;
  std::size_t count_ = 0;
};

/// The edge points of a line; none where it cannot be used (is_usable) or the lens cannot be undone
/// at its pixel. To first order in the noise nothing is lost or gained. Their places are along the
/// line without the lens, where what touches the image of a straight edge is straight.
std::optional<EdgePoints> edge_points_of(const LineObservation& line, const Camera& camera);

/// The edge point of the line so many of its pixels from its own pixel, along its direction, with a
/// variance of one; none as above.
std::optional<EdgePoint> edge_point_at(const LineObservation& line, const Camera& camera,
                                       double along_px);

/// How far along the normal, from the pixel, the image of the edge passes (predicted - observed,
/// px), and the derivative by (w, dt) in (Exp(w) R, t + dt).
struct EdgeResidual {
  double residual_px = 0;
  Eigen::Matrix<double, 1, 6> jacobian;
};

/// None where the edge is seen nearly along the normal (kernel::kLeastCrossing2), or meets it
/// behind the camera.
std::optional<EdgeResidual> edge_residual(const EdgePoint& point, const Pose& cam_from_target);

/// Edge points as the kernel takes them, four side by side, about another origin of the target.
class PackedEdges {
 public:
  PackedEdges() = default;
  PackedEdges(std::span<const EdgePoint> points, const Eigen::Vector3d& origin_in_target);

  /// Sets the weight of one edge point, 1 / px^2. One of weight zero is not looked at.
  void set_weight(std::size_t point, double weight);

  std::span<const kernel::EdgeLanes> lanes() const { return {data(), count_}; }

 private:
  static constexpr std::size_t kInline = 4;

  kernel::EdgeLanes* data() { return heap_.empty() ? inline_.data() : heap_.data(); }
  const kernel::EdgeLanes* data() const { return heap_.empty() ? inline_.data() : heap_.data(); }

  std::size_t count_ = 0;
  std::array<kernel::EdgeLanes, kInline> inline_;
  std::vector<kernel::EdgeLanes> heap_;
};

}  // namespace sightline
