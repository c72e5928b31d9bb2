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
