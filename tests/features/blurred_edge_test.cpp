// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/blurred_edge.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "scenes/random/random.h"

namespace sightline {
namespace {

constexpr int kSize = 64;
constexpr double kNoiseGrey = 3;
constexpr double kApartPx = 2;
constexpr Stretch kStretch{-20, 20};

// Where the first edge truly is.
ImageLine true_line() {
  ImageLine line;
  line.point = {32.3, 30.8};
  line.direction = Eigen::Vector2d(0.8, 0.6);
  return line;
}

// A step of 60 grey levels along the line and one of `beside_grey` 2 px beside it, blurred by 0.76
// px, with noise.
cv::Mat image_of_steps(double beside_grey, uint64_t index) {
  constexpr double kBlurPx = 0.76;
  const ImageLine line = true_line();
  const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
  const auto step = [&](double across_px) {
    return 0.5 * std::erfc(-across_px / kBlurPx / std::numbers::sqrt2);
  };
  RandomStream stream(5, "steps", index);
  cv::Mat image(kSize, kSize, CV_8U);
  for (int v = 0; v < kSize; ++v) {
    for (int u = 0; u < kSize; ++u) {
      const double across_px = normal.dot(Eigen::Vector2d(u, v) - line.point);
      const double grey = 40 + 60 * step(across_px) + beside_grey * step(across_px - kApartPx);
      image.at<uint8_t>(v, u) =
          cv::saturate_cast<uint8_t>(std::lround(grey + kNoiseGrey * stream.normal()));
    }
  }
  return image;
}

// Of the fitted line's offset over many images, in px and in its own sigmas.
struct Scatter {
  int fitted = 0;
  double mean_px = 0;
  double rms_px = 0;
  double rms_sigmas = 0;
};

Scatter scatter_of(double beside_grey, std::span<const EdgeBeside> beside) {
  constexpr int kImages = 100;
  const ImageLine line = true_line();
  const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
  ImageLine start = line;
  start.point += 0.3 * normal;
  Scatter scatter;
  for (int i = 0; i < kImages; ++i) {
    const auto fit =
        fit_blurred_edge(image_of_steps(beside_grey, i), start, kStretch, kNoiseGrey, beside);
    if (!fit) continue;
    ++scatter.fitted;
    const double off_px = normal.dot(fit->point - line.point);
    scatter.mean_px += off_px;
    scatter.rms_px += off_px * off_px;
    scatter.rms_sigmas += off_px * off_px / fit->covariance(0, 0);
  }
  scatter.mean_px /= scatter.fitted;
  scatter.rms_px = std::sqrt(scatter.rms_px / scatter.fitted);
  scatter.rms_sigmas = std::sqrt(scatter.rms_sigmas / scatter.fitted);
  return scatter;
}

// Expected a fifth of a pixel off where it is.
EdgeBeside edge_beside() {
  return {std::vector<double>(42, kApartPx + 0.2), 0.3};
}

TEST(BlurredEdge, AloneIsFoundToAFiftiethOfAPixel) {
  const Scatter scatter = scatter_of(0, {});
  EXPECT_EQ(scatter.fitted, 100);
  EXPECT_LT(scatter.rms_px, 0.02);
  EXPECT_NEAR(scatter.rms_sigmas, 1, 0.25);
}

TEST(BlurredEdge, WithAnotherBesideItIsFoundWhereThatIsKnown) {
  const std::vector<EdgeBeside> beside = {edge_beside()};
  const Scatter scatter = scatter_of(80, beside);
  EXPECT_EQ(scatter.fitted, 100);
  EXPECT_LT(scatter.rms_px, 0.06);
  EXPECT_LT(std::abs(scatter.mean_px), 0.03);
  EXPECT_NEAR(scatter.rms_sigmas, 1, 0.25);
}

TEST(BlurredEdge, AnotherBesideItThatIsNotKnownDrawsItAway) {
  EXPECT_GT(scatter_of(80, {}).mean_px, 0.3);
}

TEST(BlurredEdge, AnotherBesideItThatIsNotThereDoesNoHarm) {
  const std::vector<EdgeBeside> beside = {edge_beside()};
  const Scatter scatter = scatter_of(0, beside);
  EXPECT_EQ(scatter.fitted, 100);
  EXPECT_LT(scatter.rms_px, 0.06);
  EXPECT_LT(scatter.rms_sigmas, 1.25);
}

TEST(BlurredEdge, TheEdgeMayBeOnTheOtherSide) {
  ImageLine turned = true_line();
  turned.direction = -turned.direction;
  EdgeBeside beside = edge_beside();
  for (double& offset_px : beside.offset_px) offset_px = -offset_px;
  const std::vector<EdgeBeside> other_side = {beside};
  const cv::Mat image = image_of_steps(80, 0);
  const auto fit = fit_blurred_edge(image, turned, kStretch, kNoiseGrey, other_side);
  const std::vector<EdgeBeside> same_side = {edge_beside()};
  const auto same = fit_blurred_edge(image, true_line(), kStretch, kNoiseGrey, same_side);
  ASSERT_TRUE(fit && same);
  EXPECT_LT((fit->point - same->point).norm(), 1e-3);
}

TEST(BlurredEdge, NoneIsFoundFarFromTheLine) {
  ImageLine line = true_line();
  line.point += 5 * Eigen::Vector2d(-0.6, 0.8);
  EXPECT_FALSE(fit_blurred_edge(image_of_steps(0, 0), line, kStretch, kNoiseGrey));
  line = true_line();
  line.point += Eigen::Vector2d(-0.6, 0.8);
  EXPECT_TRUE(fit_blurred_edge(image_of_steps(0, 0), line, kStretch, kNoiseGrey));
}

}  // namespace
}  // namespace sightline
