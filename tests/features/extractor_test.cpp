// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/extractor.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <set>

#include <Eigen/LU>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "pose/angles.h"
#include "scenes/random/random.h"

namespace sightline {
namespace {

constexpr int kImageSize = 120;

// A wedge with its tip at `tip`, opening between two directions (degrees, u right, v down), bright
// on dark, blurred and noisy as a frame is.
cv::Mat wedge_image(const Eigen::Vector2d& tip, double from_deg, double to_deg,
                    double noise_grey = 3, double background = 40, double foreground = 180) {
  constexpr int kShift = 4;
  constexpr int kOversample = 8;
  cv::Mat large(kImageSize * kOversample, kImageSize * kOversample, CV_32F, cv::Scalar(background));
  const auto to_large = [](const Eigen::Vector2d& p) {
    const double scale = kOversample * (1 << kShift);
    return cv::Point(static_cast<int>(std::lround((p.x() + 0.5) * scale - 0.5 * (1 << kShift))),
                     static_cast<int>(std::lround((p.y() + 0.5) * scale - 0.5 * (1 << kShift))));
  };
  std::vector<cv::Point> polygon = {to_large(tip)};
  for (int i = 0; i <= 4; ++i) {
    const double angle = (from_deg + (to_deg - from_deg) * i / 4) * kDegree;
    polygon.push_back(to_large(tip + 300 * Eigen::Vector2d(std::cos(angle), std::sin(angle))));
  }
  cv::fillPoly(large, std::vector<std::vector<cv::Point>>{polygon}, cv::Scalar(foreground),
               cv::LINE_8, kShift);
  cv::Mat image;
  cv::resize(large, image, {kImageSize, kImageSize}, 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(image, image, {}, 0.7);
  RandomStream stream(1, "noise", 0);
  for (int v = 0; v < kImageSize; ++v) {
    for (int u = 0; u < kImageSize; ++u) {
      image.at<float>(v, u) += static_cast<float>(noise_grey * stream.normal());
    }
  }
  image.convertTo(image, CV_8U);
  return image;
}

FeaturePrediction line_prediction(const Eigen::Vector2d& pixel, double a_deg, double b_deg) {
  FeaturePrediction prediction;
  prediction.kind = FeatureKind::kLineIntersection;
  prediction.is_in_front = true;
  prediction.pixel = pixel;
  prediction.edge_direction = {
      Eigen::Vector2d(std::cos(a_deg * kDegree), std::sin(a_deg * kDegree)),
      Eigen::Vector2d(std::cos(b_deg * kDegree), std::sin(b_deg * kDegree))};
  return prediction;
}

FeaturePrediction corner_prediction(const Eigen::Vector2d& pixel) {
  FeaturePrediction prediction = line_prediction(pixel, 0, 90);
  prediction.kind = FeatureKind::kCorner;
  return prediction;
}

Observation extract(const cv::Mat& image, const FeaturePrediction& prediction, double white = 255) {
  const ExtractorChoice choice = {find_feature_extractor("hough_intersection"),
                                  find_feature_extractor("shi_tomasi_nearest")};
  PredictedView view;
  view.features = {prediction};
  return extract_features(image, white, view, choice, {}).front();
}

TEST(HoughIntersection, FindsTheTipOfAWedge) {
  for (const double turn_deg : {0.0, 17.0, 45.0, 100.0, 200.0}) {
    const Eigen::Vector2d tip(61.3, 58.8);
    const Observation found =
        extract(wedge_image(tip, turn_deg, turn_deg + 70),
                line_prediction(tip + Eigen::Vector2d(3, -4), turn_deg + 3, turn_deg + 66));
    ASSERT_EQ(found.status, ObservationStatus::kFound) << turn_deg;
    // Canny's whole pixels on 20 px of edge leave a few tenths.
    EXPECT_LT((found.pixel - tip).norm(), 0.8) << turn_deg;
    EXPECT_EQ(found.lines.size(), 2u);
    EXPECT_GT(found.covariance_px2.determinant(), 0);
  }
}

// A blue wing before a sky of the same grey: its red differs most.
cv::Mat blue_wedge_image(const Eigen::Vector2d& tip) {
  std::vector<cv::Mat> channels;
  for (const auto& [sky, wing] : {std::pair{160.0, 250.0}, {150.0, 178.0}, {150.0, 60.0}}) {
    channels.push_back(wedge_image(tip, 10, 80, 1, sky, wing));
  }
  cv::Mat image;
  cv::merge(channels, image);
  return image;
}

TEST(Channels, OfAPictureInColourTheOneWithTheMostContrastIsLookedAt) {
  const Eigen::Vector2d tip(61.3, 58.8);
  const cv::Mat image = blue_wedge_image(tip);
  const Observation found = extract(image, line_prediction(tip, 10, 80));
  ASSERT_EQ(found.status, ObservationStatus::kFound);
  EXPECT_LT((found.pixel - tip).norm(), 0.8);
  cv::Mat grey, wide;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  EXPECT_NE(extract(grey, line_prediction(tip, 10, 80)).status, ObservationStatus::kFound);
  image.convertTo(wide, CV_16U, 4095 / 255.0);
  EXPECT_EQ(extract(wide, line_prediction(tip, 10, 80), 4095).status, ObservationStatus::kFound);
}

TEST(Channels, WhatHasNoColourIsLookedAtInItsGrey) {
  const Eigen::Vector2d tip(61.3, 58.8);
  const cv::Mat grey = wedge_image(tip, 10, 80);
  cv::Mat image;
  cv::merge(std::vector<cv::Mat>{grey, grey, grey}, image);
  EXPECT_EQ(extract(image, line_prediction(tip, 10, 80)).pixel,
            extract(grey, line_prediction(tip, 10, 80)).pixel);
}

TEST(HoughIntersection, WorksOnSixteenBits) {
  const Eigen::Vector2d tip(61.3, 58.8);
  cv::Mat image;
  wedge_image(tip, 10, 80).convertTo(image, CV_16U, 4095 / 255.0);
  const Observation found = extract(image, line_prediction(tip, 10, 80), 4095);
  ASSERT_EQ(found.status, ObservationStatus::kFound);
  EXPECT_LT((found.pixel - tip).norm(), 0.8);
}

TEST(HoughIntersection, AnEmptyWindowHasTooFewEdgePixels) {
  const cv::Mat image = wedge_image({500, 500}, 0, 10);
  const Observation found = extract(image, line_prediction({60, 60}, 0, 90));
  EXPECT_EQ(found.status, ObservationStatus::kTooFewEdgePixels);
}

TEST(HoughIntersection, ALineAlongNeitherPredictionDoesNotCount) {
  const Eigen::Vector2d tip(60, 60);
  const Observation found = extract(wedge_image(tip, 0, 70), line_prediction(tip, 30, 110));
  EXPECT_EQ(found.status, ObservationStatus::kTooFewEdgePixels);
}

TEST(HoughIntersection, LinesThatNeverMeetAreParallel) {
  // A long thin wedge whose edges are 6 degrees apart.
  const Eigen::Vector2d tip(10, 60);
  const Observation found = extract(wedge_image(tip, -3, 3), line_prediction({60, 60}, -8, 8));
  EXPECT_EQ(found.status, ObservationStatus::kParallelLines);
}

TEST(HoughIntersection, LinesThatMeetElsewhereAreNotTheFeature) {
  const Eigen::Vector2d tip(20, 60);  // 40 px left of the window's centre
  const Observation found = extract(wedge_image(tip, -12, 12), line_prediction({60, 60}, -12, 12));
  EXPECT_EQ(found.status, ObservationStatus::kOutsideWindow);
}

TEST(ShiTomasiNearest, FindsTheCornerNearestTheWindowsCentre) {
  const Eigen::Vector2d tip(61, 59);
  const Observation found = extract(wedge_image(tip, 20, 110), corner_prediction({65, 55}));
  ASSERT_EQ(found.status, ObservationStatus::kFound);
  EXPECT_LT((found.pixel - tip).norm(), 3);
  for (const Eigen::Vector2d& corner : found.corners) {
    EXPECT_GE((corner - Eigen::Vector2d(65, 55)).norm(),
              (found.pixel - Eigen::Vector2d(65, 55)).norm());
  }
}

TEST(ShiTomasiNearest, AnEdgeThatLeavesTheWindowIsNoCorner) {
  // One oblique edge across the whole image: mirrored at the window's rim it would be a corner.
  const cv::Mat edge = wedge_image({-100, 30}, 20, 110, 0, 40, 100);
  EXPECT_EQ(extract(edge, corner_prediction({60, 90})).status, ObservationStatus::kNoCorner);
}

TEST(ShiTomasiNearest, NoiseIsNoCorner) {
  const Observation noisy = extract(wedge_image({500, 500}, 0, 10), corner_prediction({60, 60}));
  EXPECT_EQ(noisy.status, ObservationStatus::kNoCorner);
  const Observation flat =
      extract(cv::Mat(kImageSize, kImageSize, CV_8U, cv::Scalar(40)), corner_prediction({60, 60}));
  EXPECT_EQ(flat.status, ObservationStatus::kEmptyWindow);
}

TEST(ShiTomasiNearest, TheContrastFloorMeansWhatItSays) {
  const Eigen::Vector2d tip(61, 59);
  const double floor = CornerOptions{}.min_contrast_grey;
  const auto corner_of_contrast = [&](double contrast) {
    return extract(wedge_image(tip, 20, 110, 0, 40, 40 + contrast), corner_prediction(tip)).status;
  };
  EXPECT_EQ(corner_of_contrast(1.5 * floor), ObservationStatus::kFound);
  EXPECT_EQ(corner_of_contrast(0.6 * floor), ObservationStatus::kNoCorner);
}

TEST(ExtractFeatures, SaysWhyItDidNotLook) {
  const cv::Mat image = wedge_image({60, 60}, 0, 70);
  FeaturePrediction hidden = line_prediction({60, 60}, 0, 70);
  hidden.is_hidden = true;
  EXPECT_EQ(extract(image, hidden).status, ObservationStatus::kHidden);
  EXPECT_EQ(extract(image, line_prediction({-20, 60}, 0, 70)).status,
            ObservationStatus::kOutsideImage);
  EXPECT_EQ(extract(image, line_prediction({1e300, 60}, 0, 70)).status,
            ObservationStatus::kOutsideImage);
  FeaturePrediction behind = line_prediction({60, 60}, 0, 70);
  behind.is_in_front = false;
  EXPECT_EQ(extract(image, behind).status, ObservationStatus::kOutsideImage);
}

TEST(ExtractFeatures, AWindowCutByTheBorderIsSearched) {
  const Eigen::Vector2d tip(5, 60);
  const Observation found = extract(wedge_image(tip, -40, 40), line_prediction(tip, -40, 40));
  ASSERT_EQ(found.status, ObservationStatus::kFound);
  EXPECT_EQ(found.window.x, 0);
  EXPECT_LT((found.pixel - tip).norm(), 1);
}

TEST(FeatureExtractors, FolderAndCatalogueAgree) {
  std::set<std::string> files, names;
  const auto folder = std::filesystem::path(SIGHTLINE_SOURCE_DIR) / "features/extractors";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".cpp") files.insert(entry.path().stem());
  }
  for (const FeatureExtractor& extractor : feature_extractors()) {
    names.emplace(extractor.name);
    EXPECT_EQ(find_feature_extractor(extractor.name), &extractor);
    EXPECT_FALSE(extractor.summary.empty());
  }
  EXPECT_EQ(files, names);
  EXPECT_EQ(find_feature_extractor("no_such"), nullptr);
}

}  // namespace
}  // namespace sightline
