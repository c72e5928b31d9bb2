// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// A plate seen edge-on, and a plate before another one.
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "pose/angles.h"
#include "tests/features/plate.h"

namespace sightline {
namespace {

PosePrior good_prior(const Pose& pose) {
  return prior_of(pose, plate_camera(),
                  {.attitude_deg = 0.05, .range_fraction = 0.001, .lateral_px = 1});
}

// The plate, and one of these corners, wound to face the camera, behind it.
Target with_plate_behind(const std::vector<Eigen::Vector3d>& corners) {
  Target plate = plate_target();
  const int first = static_cast<int>(plate.mesh.vertices.size());
  for (const Eigen::Vector3d& corner : corners) plate.mesh.vertices.push_back(corner);
  const auto normals = plate.mesh.triangles.front().normal;
  plate.mesh.triangles.push_back({{first, first + 3, first + 2}, 1, normals});
  plate.mesh.triangles.push_back({{first, first + 2, first + 1}, 1, normals});
  plate.mesh.parts.push_back({"behind", 0.8});
  plate.occluder = Occluder(plate.mesh);
  plate.shapes = feature_shapes(plate.mesh, plate.features);
  return plate;
}

cv::Mat coverage_of(const Pose& pose, const std::vector<Eigen::Vector3d>& corners) {
  std::vector<Eigen::Vector2d> polygon;
  for (const Eigen::Vector3d& corner : corners) {
    polygon.push_back(*project(plate_camera(), pose * corner));
  }
  return coverage(polygon, kPlateImagePx);
}

// Turned about its middle, so that it is a bar 100 px long and 2.6 px wide.
Pose edge_on_pose() {
  const Eigen::Matrix3d tilt = rotation_from_vector({88.5 * kDegree, 0, 0});
  return {rotation_from_vector({0, 0, 20 * kDegree}) * tilt, {0.02, -0.03, 100}};
}

TEST(EdgesElseContour, ABarsEndsAreFoundByItsOutline) {
  const Target target = plate_target();
  const Pose truth = edge_on_pose();
  const cv::Mat image = exposed(plate_coverage(truth), {});
  const PosePrior prior = good_prior(truth);
  for (const Observation& seen : extract_plate("model_edges", image, target, prior)) {
    EXPECT_EQ(seen.status, ObservationStatus::kNoOutline);
  }
  for (const Observation& seen : extract_plate("edges_else_contour", image, target, prior)) {
    ASSERT_EQ(seen.status, ObservationStatus::kFound);
    EXPECT_FALSE(seen.contour.empty());
    EXPECT_TRUE(seen.lines.empty());
    const Eigen::Vector2d pixel =
        *project(plate_camera(), truth * target.features[seen.feature].position_m);
    const Eigen::Vector2d error = seen.pixel - pixel;
    EXPECT_LT(error.norm(), 2);  // less than the bar is wide
    EXPECT_LT(error.dot(seen.covariance_px2.inverse() * error), 3 * 3);
  }
}

TEST(EdgesElseContour, ABarBeforeAnotherPartIsLeftAlone) {
  const Pose truth = edge_on_pose();
  // In the plate's frame the camera looks along its edges: what is behind lies across them.
  const std::vector<Eigen::Vector3d> behind = {{-8, 8, 8}, {8, 8, 8}, {8, 8, -8}, {-8, 8, -8}};
  const Eigen::Vector3d away = inverse(truth).rotation * Eigen::Vector3d::UnitZ();
  const std::vector<Eigen::Vector3d> farther = {behind[0] + 4 * away, behind[1] + 4 * away,
                                                behind[2] + 4 * away, behind[3] + 4 * away};
  const Target target = with_plate_behind(farther);
  const cv::Mat light = 0.5 * coverage_of(truth, farther) + 0.5 * plate_coverage(truth);
  const cv::Mat image = exposed(light, {});
  for (const Observation& seen :
       extract_plate("edges_else_contour", image, target, good_prior(truth))) {
    EXPECT_NE(seen.status, ObservationStatus::kFound);
  }
}

TEST(EdgesElseContour, WhereEdgesAreToBeSeenItIsModelEdges) {
  const Target target = plate_target();
  const Pose truth = plate_pose(20, {0.1, 0.2});
  const cv::Mat image = exposed(plate_coverage(truth), {});
  const PosePrior prior = prior_of(plate_pose(21), plate_camera(), {});
  const auto by_edges = extract_plate("model_edges", image, target, prior);
  const auto seen = extract_plate("edges_else_contour", image, target, prior);
  for (size_t i = 0; i < seen.size(); ++i) {
    ASSERT_EQ(seen[i].status, ObservationStatus::kFound);
    EXPECT_EQ(seen[i].pixel, by_edges[i].pixel);
    EXPECT_EQ(seen[i].covariance_px2, by_edges[i].covariance_px2);
  }
}

// Of a grey plate one edge lies before a bright part and the other mostly before the dark
// background, to whose polarity the bright part must not contribute.
TEST(ModelEdges, ACornerBetweenABrightPartAndADarkBackgroundIsFound) {
  const Pose truth = plate_pose(0);
  const std::vector<Eigen::Vector3d> behind = {
      {-7.8, -7.8, 2}, {-3.8, -7.8, 2}, {-3.8, 7.8, 2}, {-7.8, 7.8, 2}};
  const Target target = with_plate_behind(behind);
  const cv::Mat plate = plate_coverage(truth);
  const cv::Mat beyond = coverage_of(truth, behind);
  const cv::Mat light = 0.5 * plate + beyond.mul(1 - plate);
  const auto seen = extract_plate("model_edges", exposed(light, {}), target, good_prior(truth));
  const Eigen::Vector2d corner = *project(plate_camera(), truth * target.features[0].position_m);
  ASSERT_EQ(seen[0].status, ObservationStatus::kFound);
  EXPECT_LT((seen[0].pixel - corner).norm(), 0.5);
}

}  // namespace
}  // namespace sightline
