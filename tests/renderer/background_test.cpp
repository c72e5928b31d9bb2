// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/background.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace sightline {
namespace {

const cv::Size kSize(320, 240);

Background of_kind(BackgroundKind kind, double level, double contrast, uint32_t seed = 0) {
  Background background;
  background.kind = kind;
  background.level = level;
  background.contrast = contrast;
  background.seed = seed;
  return background;
}

struct Law {
  double mean = 0;
  double sd = 0;
};

Law law_of(const cv::Mat& image) {
  cv::Scalar mean, sd;
  cv::meanStdDev(image, mean, sd);
  return {mean[0], sd[0]};
}

double difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF);
}

// Correlation of a pixel with the one `shift` to its right.
double correlation(const cv::Mat& image, int shift) {
  const cv::Mat left = image.colRange(0, image.cols - shift);
  const cv::Mat right = image.colRange(shift, image.cols);
  const Law l = law_of(left), r = law_of(right);
  const double product = left.dot(right) / static_cast<double>(left.total());
  return (product - l.mean * r.mean) / (l.sd * r.sd);
}

TEST(Background, UniformIsItsLevel) {
  const cv::Mat image = background_image(of_kind(BackgroundKind::kUniform, 0.25, 0.9), kSize);
  EXPECT_EQ(image.type(), CV_32F);
  EXPECT_EQ(image.size(), kSize);
  EXPECT_EQ(difference(image, cv::Mat(kSize, CV_32F, cv::Scalar(0.25))), 0);
}

TEST(Background, ASkyBrightensToItsSide) {
  Background sky = of_kind(BackgroundKind::kSky, 0.5, 0.4);
  sky.angle_deg = 90;
  cv::Mat image = background_image(sky, kSize);
  EXPECT_NEAR(image.at<float>(0, 7), 0.3, 1e-6);
  EXPECT_NEAR(image.at<float>(kSize.height - 1, 100), 0.7, 1e-6);
  EXPECT_NEAR(image.at<float>(100, 0), image.at<float>(100, 319), 1e-6);
  sky.angle_deg = 180;
  image = background_image(sky, kSize);
  EXPECT_NEAR(image.at<float>(5, 0), 0.7, 1e-6);
  EXPECT_NEAR(image.at<float>(99, kSize.width - 1), 0.3, 1e-6);
  sky.angle_deg = 30;
  image = background_image(sky, kSize);
  EXPECT_NEAR(image.at<float>(kSize.height - 1, kSize.width - 1), 0.7, 1e-6);
  EXPECT_NEAR(image.at<float>(0, 0), 0.3, 1e-6);
  const double right = image.at<float>(100, 101) - image.at<float>(100, 100);
  const double down = image.at<float>(101, 100) - image.at<float>(100, 100);
  EXPECT_NEAR(down / right, std::tan(30 * CV_PI / 180), 1e-3);
  EXPECT_NEAR(law_of(image).mean, 0.5, 1e-6);
}

TEST(Background, NoBackgroundIsNegative) {
  for (const auto kind : {BackgroundKind::kSky, BackgroundKind::kClouds}) {
    const cv::Mat image = background_image(of_kind(kind, 0.1, 1), kSize);
    double least = 0;
    cv::minMaxLoc(image, &least);
    EXPECT_EQ(least, 0) << to_string(kind);
  }
}

TEST(Background, CloudsHaveTheirMeanAndDeviation) {
  for (const double cloud_px : {1.0, 7.3, 64.0, 5000.0}) {
    Background clouds = of_kind(BackgroundKind::kClouds, 0.5, 0.1, 3);
    clouds.cloud_px = cloud_px;
    const Law law = law_of(background_image(clouds, kSize));
    EXPECT_NEAR(law.mean, 0.5, 1e-5) << cloud_px;
    EXPECT_NEAR(law.sd, 0.05, 1e-5) << cloud_px;
  }
}

TEST(Background, CloudsAreAsLargeAsTheyAreSaidToBe) {
  Background clouds = of_kind(BackgroundKind::kClouds, 0.5, 0.1);
  for (const int cloud_px : {8, 32}) {
    clouds.cloud_px = cloud_px;
    double near = 0, far = 0;
    constexpr int kImages = 8;
    for (clouds.seed = 0; clouds.seed < kImages; ++clouds.seed) {
      const cv::Mat image = background_image(clouds, kSize);
      near += correlation(image, cloud_px / 4) / kImages;
      far += correlation(image, 3 * cloud_px) / kImages;
    }
    EXPECT_GT(near, 0.6) << cloud_px;
    EXPECT_LT(std::abs(far), 0.15) << cloud_px;
  }
}

TEST(Background, CloudsAndStarsAreThoseOfTheirSeed) {
  for (const auto kind : {BackgroundKind::kClouds, BackgroundKind::kStars}) {
    const cv::Mat image = background_image(of_kind(kind, 0.3, 0.1, 1), kSize);
    EXPECT_EQ(difference(image, background_image(of_kind(kind, 0.3, 0.1, 1), kSize)), 0);
    EXPECT_GT(difference(image, background_image(of_kind(kind, 0.3, 0.1, 2), kSize)), 0.005);
  }
}

TEST(Background, StarsShedTheLightOfTheirLaw) {
  Background stars = of_kind(BackgroundKind::kStars, 0.02, 0);
  stars.stars_per_megapixel = 20000;
  stars.star_level = 0.8;
  const cv::Size size(1000, 800);
  const double light = law_of(background_image(stars, size)).mean - 0.02;
  // The mean of F when 1 / F is uniform in [1, 100] / 0.8; the variance of a Poisson sum is that of
  // its number times the mean of F^2 = 0.8^2 / 100.
  const double mean_star = 0.8 * std::log(100.0) / 99;
  const double stars_there = 20000 * 0.8;
  const double sd = std::sqrt(stars_there * 0.8 * 0.8 / 100) / (1000 * 800);
  EXPECT_NEAR(light, 0.02 * mean_star, 5 * sd);
  // None at all leaves the level.
  stars.stars_per_megapixel = 0;
  EXPECT_EQ(law_of(background_image(stars, size)).sd, 0);
}

TEST(Background, AStarLiesBetweenPixelsAndNotOnThem) {
  Background stars = of_kind(BackgroundKind::kStars, 0, 0, 5);
  stars.stars_per_megapixel = 50;
  const cv::Mat image = background_image(stars, {1000, 1000});
  // About 50 stars, of four pixels each unless two meet.
  const int lit = cv::countNonZero(image);
  EXPECT_GT(lit, 4 * 20);
  EXPECT_LT(lit, 4 * 90);
  EXPECT_EQ(lit % 2, 0);
}

Background picture_of(int width, int height) {
  auto pixels = std::make_shared<std::vector<float>>();
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) pixels->push_back(static_cast<float>(u) / 1000);
  }
  Background background = of_kind(BackgroundKind::kImage, 0, 0);
  background.picture = pixels;
  background.picture_width = width;
  return background;
}

TEST(Background, APictureCoversTheImageFromItsMiddle) {
  // Twice as wide as needed: columns 80 to 239, each of them two pixels.
  const cv::Mat image = background_image(picture_of(320, 120), kSize);
  ASSERT_EQ(image.size(), kSize);
  EXPECT_NEAR(image.at<float>(10, 0), 0.080, 1e-3);
  EXPECT_NEAR(image.at<float>(200, 319), 0.239, 1e-3);
  EXPECT_NEAR(image.at<float>(120, 161) - image.at<float>(120, 159), 0.001, 1e-5);
}

TEST(Background, APictureOfTheImagesSizeIsItself) {
  const Background background = picture_of(kSize.width, kSize.height);
  const cv::Mat image = background_image(background, kSize);
  EXPECT_EQ(image.at<float>(3, 77), 0.077f);
  const cv::Mat half = background_image(background, kSize / 2);  // shrunk: means of four
  EXPECT_NEAR(half.at<float>(3, 10), 0.0205, 1e-6);
}

}  // namespace
}  // namespace sightline
