// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/benchmarks/visp_tracker.h"

#include <algorithm>

#include <opencv2/core.hpp>
#include <visp3/core/vpException.h>
#include <visp3/mbt/vpMbEdgeTracker.h>

namespace sightline {
namespace {

vpHomogeneousMatrix vp_pose(const VispPose& pose) {
  vpHomogeneousMatrix matrix;
  for (unsigned i = 0; i < 3; ++i) {
    for (unsigned j = 0; j < 4; ++j) matrix[i][j] = pose(i, j);
  }
  return matrix;
}

VispPose visp_pose(const vpHomogeneousMatrix& matrix) {
  VispPose pose;
  for (unsigned i = 0; i < 3; ++i) {
    for (unsigned j = 0; j < 4; ++j) pose(i, j) = matrix[i][j];
  }
  return pose;
}

// As ViSP's examples have it, but for the reach.
vpMe moving_edges(int reach_px) {
  vpMe edges;
  edges.setMaskSize(5);
  edges.setMaskNumber(180);
  edges.setRange(static_cast<unsigned>(reach_px));
  edges.setThreshold(5000);
  edges.setMu1(0.5);
  edges.setMu2(0.5);
  edges.setSampleStep(2);
  return edges;
}

vpImage<unsigned char> vp_image(const cv::Mat& image) {
  vpImage<unsigned char> grey(static_cast<unsigned>(image.rows), static_cast<unsigned>(image.cols));
  for (int y = 0; y < image.rows; ++y) {
    std::copy_n(image.ptr<uchar>(y), image.cols, grey[static_cast<unsigned>(y)]);
  }
  return grey;
}

}  // namespace

// The model in ViSP's terms. Its files (.cao) would track every side of every triangle.
class VispTracker::Body : public vpMbEdgeTracker {
 public:
  Body(const VispModel& model, const VispCamera& camera, int reach_px) {
    vpCameraParameters parameters;
    parameters.initPersProjWithoutDistortion(camera.fx_px, camera.fy_px, camera.cx_px,
                                             camera.cy_px);
    setCameraParameters(parameters);
    setMovingEdge(moving_edges(reach_px));
    setAngleAppear(vpMath::rad(89));
    setAngleDisappear(vpMath::rad(89.5));
    setScanLineVisibilityTest(true);
    setDisplayFeatures(false);
    for (const auto& triangle : model.triangles) add_face(model, triangle);
    // A polygon of two corners is a line that is seen wherever nothing hides it.
    for (const auto& line : model.lines) {
      add_face(model, line);
      initFaceFromCorners(*faces.getPolygon().back());
    }
    modelInitialised = true;
  }

 private:
  template <size_t N>
  void add_face(const VispModel& model, const std::array<int, N>& vertices) {
    std::vector<vpPoint> corners;
    for (const int v : vertices) {
      const Eigen::Vector3d& x_m = model.vertices_m[static_cast<size_t>(v)];
      corners.emplace_back(x_m.x(), x_m.y(), x_m.z());
    }
    vpMbTracker::addPolygon(corners, static_cast<int>(faces.size()));
  }
};

VispTracker::VispTracker(const VispModel& model, const VispCamera& camera, int reach_px)
    : body_(std::make_unique<Body>(model, camera, reach_px)) {}

VispTracker::~VispTracker() = default;

std::optional<VispPose> VispTracker::track(const cv::Mat& image, const VispPose& start) {
  constexpr int kMostRounds = 20;
  constexpr double kStill = 1e-4;  // of a rotation matrix's numbers
  const vpImage<unsigned char> grey = vp_image(image);
  try {
    body_->initFromPose(grey, vp_pose(start));
    VispPose pose = start;
    for (int round = 0; round < kMostRounds; ++round) {
      body_->track(grey);
      const VispPose before = pose;
      vpHomogeneousMatrix matrix;
      body_->getPose(matrix);
      pose = visp_pose(matrix);
      if ((pose - before).leftCols<3>().cwiseAbs().maxCoeff() < kStill) break;
    }
    return pose;
  } catch (const vpException&) {
    return std::nullopt;
  }
}

}  // namespace sightline
