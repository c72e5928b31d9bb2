// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// ViSP's model-based tracker, as a peer to compare with. The headers of ViSP 3.5 are no C++20, so
// that this one and its .cpp keep to C++17 and include nothing else of ours.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace sightline {

/// A body as ViSP tracks it.
struct VispModel {
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<std::array<int, 3>> triangles;  ///< they hide what is behind them
  std::vector<std::array<int, 2>> lines;      ///< what is tracked
};

/// A camera without a lens.
struct VispCamera {
  double fx_px, fy_px, cx_px, cy_px;
};

/// (R, t) from the body to the camera.
using VispPose = Eigen::Matrix<double, 3, 4>;

/// The edge tracker (A. I. Comport, E. Marchand, M. Pressigout and F. Chaumette, "Real-time
/// markerless tracking for augmented reality: the virtual visual servoing framework", IEEE TVCG
/// 2006).
class VispTracker {
 public:
  /// Edges are looked for up to `reach_px` on either side of where a pose puts them.
  VispTracker(const VispModel& model, const VispCamera& camera, int reach_px);
  ~VispTracker();

  /// Tracks one image (CV_8U) from a start until the pose stands still. None where ViSP gives up,
  /// for want of edges above all.
  std::optional<VispPose> track(const cv::Mat& image, const VispPose& start);

 private:
  class Body;

  std::unique_ptr<Body> body_;
};

}  // namespace sightline
