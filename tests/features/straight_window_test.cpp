// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Features through a lens that bends the plate's sides by two or three pixels.
#include "features/straight_window.h"

#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/features/plate.h"

namespace sightline {
namespace {

// The plate's corners are at 0.07 of the image plane, where this is a quarter of the way to the
// fold.
Camera bending_camera() {
  Camera camera = plate_camera();
  camera.lens = BrownConrady{.k1 = -15, .p1 = 0.05};
  return camera;
}

// A lens bends the sides outwards: with many vertices it is a convex polygon still.
cv::Mat bent_plate(const Pose& pose, const Camera& camera) {
  constexpr int kPieces = 12;
  const Target target = plate_target();
  std::vector<Eigen::Vector2d> polygon;
  for (int side = 0; side < 4; ++side) {
    const Eigen::Vector3d& a = target.features[side].position_m;
    const Eigen::Vector3d& b = target.features[(side + 1) % 4].position_m;
    for (int i = 0; i < kPieces; ++i) {
      polygon.push_back(*project(camera, pose * Eigen::Vector3d(a + (b - a) * i / kPieces)));
    }
  }
  return coverage(polygon, kPlateImagePx);
}

struct Seen {
  int found = 0;
  double squares_px2 = 0;
  double normalised = 0;

  double rms_px() const { return std::sqrt(squares_px2 / (2.0 * found)); }
  double normalised_sd() const { return std::sqrt(normalised / (2.0 * found)); }
};

class ThroughALens : public testing::TestWithParam<const char*> {};

TEST_P(ThroughALens, CornersAreFoundAsWellAsWithout) {
  constexpr int kDraws = 12;
  const Target target = plate_target();
  const Camera camera = bending_camera();
  const FeatureExtractor* extractor = find_feature_extractor(GetParam());
  Seen sums;
  for (int i = 0; i < kDraws; ++i) {
    RandomStream stream(8, "lens", i);
    const Pose truth =
        plate_pose(stream.uniform(0, 360), {stream.uniform(-0.3, 0.3), stream.uniform(-0.3, 0.3)});
    const cv::Mat image = exposed(bent_plate(truth, camera), {.index = static_cast<uint64_t>(i)});
    PriorError error;
    error.attitude_deg = 1;
    error.lateral_px = 2;
    const PosePrior prior = prior_of(draw_prior(truth, camera, error, stream), camera, error);
    const PredictedView view = predict_features(target, std::array{0, 1, 2, 3}, camera, prior);
    for (const Observation& seen :
         extract_features(image, 255, view, {extractor, extractor, extractor}, {})) {
      if (seen.status != ObservationStatus::kFound) continue;
      const Eigen::Vector2d off =
          seen.pixel - *project(camera, truth * target.features[seen.feature].position_m);
      ASSERT_LT(off.norm(), 1) << i;
      ++sums.found;
      sums.squares_px2 += off.squaredNorm();
      sums.normalised += off.dot(seen.covariance_px2.llt().solve(off));
    }
  }
  EXPECT_GE(sums.found, 0.95 * 4 * kDraws);
  // As promised without a lens (subpixel_test.cpp). Taken for straight, the sides would put the
  // corners half a pixel off, eight of the sigmas that are told.
  EXPECT_LE(sums.rms_px(), 0.15);
  EXPECT_LE(sums.normalised_sd(), 1.35);
}

INSTANTIATE_TEST_SUITE_P(Extractors, ThroughALens,
                         testing::Values("hough_subpixel", "model_edges", "contour"));

TEST(StraightWindow, GivesBackWhatWasFoundInIt) {
  const Camera camera = bending_camera();
  const Target target = plate_target();
  const Pose pose = plate_pose(20, {0.1, 0.2});
  PriorError error;
  error.attitude_deg = 2;
  error.lateral_px = 3;
  const PosePrior prior = prior_of(pose, camera, error);
  const PredictedView view = predict_features(target, std::array{0}, camera, prior);
  const FeaturePrediction& prediction = view.features.front();
  const cv::Mat image(kPlateImagePx, kPlateImagePx, CV_8U, cv::Scalar(0));
  const auto window = StraightWindow::about(prediction.pixel, camera, image, 104);
  ASSERT_TRUE(window);
  const PredictedView straight = window->view_of(view, prediction);
  // What is predicted here is what the pinhole's own prediction would be.
  const FeaturePrediction own =
      predict_features(target, std::array{0}, straight.camera, prior).features.front();
  const FeaturePrediction& given = straight.features.front();
  EXPECT_LT((given.covariance_px2 - own.covariance_px2).norm(), 1e-9 * own.covariance_px2.norm());
  EXPECT_LT((given.edge_direction[0] - own.edge_direction[0]).norm(), 1e-9);
  const auto here = [&](const Eigen::Vector3d& point) {
    return *project(straight.camera, pose * point);
  };
  EXPECT_LT((here(target.features[0].position_m) - straight.features[0].pixel).norm(), 1e-9);

  // A point of an edge, found at its place in the window with the line of that edge.
  const Edge& edge = target.features[0].edges[0];
  const Eigen::Vector3d point = edge.begin_m + 0.4 * (edge.end_m - edge.begin_m);
  Observation found;
  found.status = ObservationStatus::kFound;
  found.pixel = here(point);
  found.covariance_px2 << 0.04, 0.01, 0.01, 0.02;
  ImageLine line;
  line.point = found.pixel;
  line.direction = (here(edge.end_m) - here(edge.begin_m)).normalized();
  line.edge_pixels = {here(edge.begin_m), here(edge.end_m)};
  line.covariance << 0.01, 1e-5, 1e-5, 1e-6;
  found.lines = {line};
  ImageLine beyond_fold = line;
  beyond_fold.point -= 400 * line.direction;
  found.edge_lines = {{0, line}, {1, beyond_fold}};
  const Observation seen = window->in_image(found);
  ASSERT_EQ(seen.edge_lines.size(), 1U);  // the other's point is nowhere in the image
  const auto there = [&](const Eigen::Vector3d& x) { return *project(camera, pose * x); };
  EXPECT_LT((seen.pixel - there(point)).norm(), 1e-9);
  EXPECT_LT((seen.lines[0].edge_pixels[1] - there(edge.end_m)).norm(), 1e-9);
  const Eigen::Vector3d step = 1e-5 * (edge.end_m - edge.begin_m);
  const Eigen::Vector2d along = (there(point + step) - there(point - step)).normalized();
  EXPECT_LT((seen.lines[0].direction - along).norm(), 1e-8);

  // The derivative of the image's pixel by the window's, by the two ways to see a moved point.
  Eigen::Matrix2d by_window, by_image;
  for (const int axis : {0, 1}) {
    constexpr double kStepM = 1e-4;
    const Eigen::Vector3d way = pose.rotation.transpose() * Eigen::Vector3d::Unit(axis) * kStepM;
    by_window.col(axis) = here(point + way) - here(point - way);
    by_image.col(axis) = there(point + way) - there(point - way);
  }
  const Eigen::Matrix2d change = by_image * by_window.inverse();
  const Eigen::Matrix2d expected = change * found.covariance_px2 * change.transpose();
  EXPECT_LT((seen.covariance_px2 - expected).norm(), 1e-6);
  const double across = change.determinant() / (change * line.direction).norm();
  EXPECT_NEAR(seen.edge_lines[0].line.covariance(0, 0), across * across * 0.01, 1e-7);
}

// Here a pixel's surroundings are turned alone: what is white noise stays so.
TEST(StraightWindow, TurnsTheSurroundingsOfItsPixel) {
  const Camera camera = bending_camera();
  const Target target = plate_target();
  const PredictedView view = predict_features(target, std::array{0, 1, 2, 3}, camera,
                                              prior_of(plate_pose(20), camera, {}));
  const cv::Mat image(kPlateImagePx, kPlateImagePx, CV_8U, cv::Scalar(0));
  for (const FeaturePrediction& prediction : view.features) {
    const auto window = StraightWindow::about(prediction.pixel, camera, image, 104);
    ASSERT_TRUE(window);
    const Pose pose = view.cam_from_target;
    const Camera straight = window->view_of(view, prediction).camera;
    const Eigen::Vector3d x = pose * target.features[prediction.feature].position_m;
    Eigen::Matrix2d by_window, by_image;
    for (const int axis : {0, 1}) {
      const Eigen::Vector3d step = 1e-4 * Eigen::Vector3d::Unit(axis);
      by_window.col(axis) = *project(straight, x + step) - *project(straight, x - step);
      by_image.col(axis) = *project(camera, x + step) - *project(camera, x - step);
    }
    const Eigen::Matrix2d turn = by_image * by_window.inverse();
    EXPECT_LT((turn.transpose() * turn - Eigen::Matrix2d::Identity()).norm(), 1e-6);
    EXPECT_GT(turn.determinant(), 0);
  }
}

TEST(StraightWindow, IsNoneWhereNothingIsBent) {
  const cv::Mat image(kPlateImagePx, kPlateImagePx, CV_8U, cv::Scalar(0));
  const Eigen::Vector2d pixel(40, 50);
  EXPECT_TRUE(StraightWindow::about(pixel, bending_camera(), image, 104));
  EXPECT_FALSE(StraightWindow::about(pixel, plate_camera(), image, 104));
  Camera camera = plate_camera();
  camera.lens = BrownConrady{.k1 = -0.01};
  EXPECT_FALSE(StraightWindow::about(pixel, camera, image, 104));
  EXPECT_FALSE(StraightWindow::about({-500, 50}, bending_camera(), image, 104));
}

// It is cut where the image ends, so that extractors never see what is not there, and its feature
// is always well within it: also of a fisheye, whose images of the corners are turned.
TEST(StraightWindow, EndsWithTheImageAndKeepsItsFeature) {
  Camera camera = centred_camera(640, 480, 300);
  camera.lens = KannalaBrandt{};
  const cv::Mat image(camera.height_px, camera.width_px, CV_8U, cv::Scalar(90));
  const Target target = plate_target();
  PredictedView view{&target, camera, plate_pose(0), {}};
  int windows = 0, asked = 0;
  for (int u = 5; u < camera.width_px; u += 30) {
    for (int v = 5; v < camera.height_px; v += 30) {
      FeaturePrediction prediction;
      prediction.pixel = {u + 0.3, v + 0.6};
      const bool is_off_border = is_inside(camera, prediction.pixel, 40);
      asked += is_off_border;
      const auto window = StraightWindow::about(prediction.pixel, camera, image, 104);
      if (!window) continue;
      windows += is_off_border;
      const PredictedView straight = window->view_of(view, prediction);
      EXPECT_EQ(straight.camera.width_px, window->image().cols);
      EXPECT_EQ(straight.camera.height_px, window->image().rows);
      EXPECT_TRUE(
          is_inside(straight.camera, straight.features[0].pixel, StraightWindow::kLeastHalfPx))
          << u << ' ' << v;
      for (const double x : {0, straight.camera.width_px - 1}) {
        for (const double y : {0, straight.camera.height_px - 1}) {
          const auto ray = normalised_from_pixel(straight.camera, {x, y});
          EXPECT_TRUE(is_inside(camera, pixel_from_normalised(camera, *ray), 0)) << u << ' ' << v;
        }
      }
    }
  }
  EXPECT_GT(windows, 0.97 * asked);
}

}  // namespace
}  // namespace sightline
