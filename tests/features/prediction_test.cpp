// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/prediction.h"

#include <numeric>

#include <gtest/gtest.h>

#include "scenes/target/target.h"

namespace sightline {
namespace {

TEST(Prediction, IsTheProjectionOfThePriorPose) {
  const auto cube = load_target("cube");
  const Camera camera = centred_camera(512, 512, 5000);
  const Pose prior = {rotation_from_vector({0.3, -0.4, 0.2}), {0.5, -0.3, 50}};
  std::vector<int> features(cube->features.size());
  std::iota(features.begin(), features.end(), 0);
  const auto predictions = predict_features(*cube, features, camera, {prior}).features;
  ASSERT_EQ(predictions.size(), features.size());
  int hidden = 0;
  for (const FeaturePrediction& prediction : predictions) {
    const TargetFeature& feature = cube->features[prediction.feature];
    EXPECT_TRUE(prediction.is_in_front);
    EXPECT_LT((prediction.pixel - *project(camera, prior * feature.position_m)).norm(), 1e-12);
    for (int i = 0; i < 2; ++i) {
      // Far along a straight edge the direction is still that of its projection.
      const Eigen::Vector2d end = *project(camera, prior * feature.edges[prediction.edge[i]].end_m);
      const Eigen::Vector2d along = (end - prediction.pixel).normalized();
      EXPECT_GT(along.dot(prediction.edge_direction[i]), 1 - 1e-9);
    }
    hidden += prediction.is_hidden;
  }
  EXPECT_EQ(hidden, 1);  // a cube seen in general position hides one vertex
}

TEST(Prediction, KnowsHowAFisheyeTurnsEdgesAndShrinksErrors) {
  const auto cube = load_target("cube");
  Camera camera = centred_camera(512, 512, 300);
  const Pose pose = {rotation_from_vector({0.4, 0.3, 0.2}), {6, 3, 5}};
  const PosePrior prior = prior_of(pose, camera, {});
  const auto straight = predict_features(*cube, std::vector<int>{0}, camera, prior).features[0];
  camera.lens = KannalaBrandt{};
  const auto bent = predict_features(*cube, std::vector<int>{0}, camera, prior).features[0];
  const TargetFeature& feature = cube->features[0];
  for (int i = 0; i < 2; ++i) {
    const Edge& edge = feature.edges[bent.edge[i]];
    const Eigen::Vector3d near = edge.begin_m + 1e-5 * (edge.end_m - edge.begin_m);
    const Eigen::Vector2d along = (*project(camera, pose * near) - bent.pixel).normalized();
    EXPECT_GT(along.dot(bent.edge_direction[i]), 1 - 1e-6);
  }
  EXPECT_LT(predicted_sd_px(bent), 0.8 * predicted_sd_px(straight));
}

TEST(Prediction, BehindTheCameraThereIsNothingToPredict) {
  const auto cube = load_target("cube");
  const Pose behind = {Eigen::Matrix3d::Identity(), {0, 0, -50}};
  const auto predictions =
      predict_features(*cube, std::vector<int>{0}, centred_camera(512, 512, 5000), {behind})
          .features;
  EXPECT_FALSE(predictions[0].is_in_front);
}

TEST(WindowAround, IsCutByTheBorderAndEmptyBeyondHalf) {
  const cv::Size image(100, 80);
  EXPECT_EQ(window_around({50.4, 40.6}, 10, image), cv::Rect(40, 31, 21, 21));
  EXPECT_EQ(window_around({2, 40}, 10, image), cv::Rect(0, 30, 13, 21));
  EXPECT_TRUE(window_around({-8, 40}, 10, image).empty());
  EXPECT_TRUE(window_around({std::nan(""), 40}, 10, image).empty());
}

}  // namespace
}  // namespace sightline
