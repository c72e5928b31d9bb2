// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/sensor.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace sightline {
namespace {

constexpr int kSidePx = 256;
constexpr double kPixels = kSidePx * kSidePx;

Sensor clean(int bits = 8) {
  Sensor sensor;
  sensor.psf_sigma_px = 0;
  sensor.read_noise_grey = 0;
  sensor.bits = bits;
  return sensor;
}

RandomStream stream() {
  return RandomStream(1, "sensor", 0);
}

TEST(Sensor, QuantisesToItsBits) {
  for (const int bits : {1, 4, 8, 10, 12, 16}) {
    const double white = std::exp2(bits) - 1;
    const cv::Mat image = expose(cv::Mat(4, 4, CV_32F, cv::Scalar(0.7)), clean(bits), stream());
    EXPECT_EQ(image.type(), bits <= 8 ? CV_8U : CV_16U);
    const double value = bits <= 8 ? image.at<uint8_t>(1, 1) : image.at<uint16_t>(1, 1);
    EXPECT_EQ(value, std::round(0.7f * white)) << bits;
  }
}

TEST(Sensor, ClipsAtBlackAndWhite) {
  EXPECT_EQ(expose(cv::Mat(1, 1, CV_32F, cv::Scalar(1.5)), clean(), stream()).at<uint8_t>(0, 0),
            255);
  EXPECT_EQ(expose(cv::Mat(1, 1, CV_32F, cv::Scalar(-1)), clean(), stream()).at<uint8_t>(0, 0), 0);
}

TEST(Sensor, ReadNoiseHasItsStandardDeviation) {
  Sensor sensor = clean(16);
  sensor.read_noise_grey = 3;
  const cv::Mat image =
      expose(cv::Mat(kSidePx, kSidePx, CV_32F, cv::Scalar(0.5)), sensor, stream());
  cv::Scalar mean, sd;
  cv::meanStdDev(image, mean, sd);
  const double grey = 65535.0 / 255;
  EXPECT_NEAR(mean[0] / grey, 127.5, 5 * 3 / std::sqrt(kPixels));
  EXPECT_NEAR(sd[0] / grey, 3, 5 * 3 / std::sqrt(2 * kPixels));
}

TEST(Sensor, PhotonNoiseGrowsAsTheRootOfTheLight) {
  Sensor sensor = clean(16);
  sensor.full_well_electrons = 10000;
  for (const double light : {0.1, 0.4}) {
    const cv::Mat image =
        expose(cv::Mat(kSidePx, kSidePx, CV_32F, cv::Scalar(light)), sensor, stream());
    cv::Scalar mean, sd;
    cv::meanStdDev(image, mean, sd);
    const double expected = std::sqrt(light / 10000);
    EXPECT_NEAR(sd[0] / 65535, expected, 5 * expected / std::sqrt(2 * kPixels));
  }
}

TEST(Sensor, ThePointSpreadKeepsTheLightAndHasItsWidth) {
  cv::Mat point = cv::Mat::zeros(41, 41, CV_32F);
  point.at<float>(20, 20) = 1;
  Sensor sensor = clean(16);
  sensor.psf_sigma_px = 1.2;
  cv::Mat image;
  expose(point, sensor, stream()).convertTo(image, CV_64F, 1 / 65535.0);
  EXPECT_NEAR(cv::sum(image)[0], 1, 1e-3);
  double variance = 0;
  for (int u = 0; u < 41; ++u) variance += cv::sum(image.col(u))[0] * (u - 20) * (u - 20);
  EXPECT_NEAR(variance, 1.2 * 1.2, 0.02);
}

TEST(Sensor, GainMultipliesSignalAndNoise) {
  Sensor sensor = clean(16);
  sensor.read_noise_grey = 2;
  sensor.gain = 2.5;
  const cv::Mat image =
      expose(cv::Mat(kSidePx, kSidePx, CV_32F, cv::Scalar(0.2)), sensor, stream());
  cv::Scalar mean, sd;
  cv::meanStdDev(image, mean, sd);
  const double grey = 65535.0 / 255;
  EXPECT_NEAR(mean[0] / grey, 2.5 * 0.2 * 255, 5 * 5 / std::sqrt(kPixels));
  EXPECT_NEAR(sd[0] / grey, 5, 5 * 5 / std::sqrt(2 * kPixels));
}

TEST(Sensor, NoiseIsThatOfItsStream) {
  const cv::Mat light(64, 100, CV_32F, cv::Scalar(0.5));
  Sensor sensor = clean();
  sensor.read_noise_grey = 3;
  const cv::Mat image = expose(light, sensor, stream());
  EXPECT_EQ(cv::countNonZero(image != expose(light, sensor, stream())), 0);
  const cv::Mat other = expose(light, sensor, RandomStream(1, "sensor", 1));
  EXPECT_GT(cv::countNonZero(image != other), 64 * 100 / 2);
  EXPECT_GT(cv::countNonZero(image.row(0) != image.row(1)), 100 / 2);
}

TEST(Sensor, DeadAndHotPixelsAreTheSameInAllFrames) {
  Sensor sensor = clean(10);
  sensor.dead_fraction = 0.01;
  sensor.hot_fraction = 0.002;
  const auto frame = [&sensor](double light) {
    return expose(cv::Mat(kSidePx, kSidePx, CV_32F, cv::Scalar(light)), sensor, stream());
  };
  const cv::Mat image = frame(0.5);
  EXPECT_EQ(cv::countNonZero(image == 0), std::lround(0.01 * kPixels));
  EXPECT_EQ(cv::countNonZero(image == 1023), std::lround(0.002 * kPixels));
  const cv::Mat brighter = frame(0.7);
  EXPECT_EQ(cv::countNonZero((brighter == 0) != (image == 0)), 0);
  EXPECT_EQ(cv::countNonZero((brighter == 1023) != (image == 1023)), 0);
  sensor.dead_fraction = 0.02;  // what was dead stays so
  EXPECT_EQ(cv::countNonZero((frame(0.5) != 0) & (image == 0)), 0);
  sensor.defect_seed = 1;
  EXPECT_GT(cv::countNonZero((frame(0.5) != 0) & (image == 0)), 0);
}

TEST(Sensor, AllPixelsMayBeDead) {
  Sensor sensor = clean();
  sensor.dead_fraction = 1;
  sensor.hot_fraction = 1;
  const cv::Mat image = expose(cv::Mat(9, 7, CV_32F, cv::Scalar(0.5)), sensor, stream());
  EXPECT_EQ(cv::countNonZero(image), 0);
}

TEST(Sensor, VignettingTakesItsShareInTheCorners) {
  Sensor sensor = clean(16);
  sensor.vignetting = 0.4;
  const cv::Mat image = expose(cv::Mat(101, 201, CV_32F, cv::Scalar(0.5)), sensor, stream());
  EXPECT_EQ(image.at<uint16_t>(50, 100), std::round(0.5 * 65535));
  EXPECT_NEAR(image.at<uint16_t>(0, 200), 0.5 * 0.6 * 65535, 1);
  EXPECT_NEAR(image.at<uint16_t>(50, 0), 0.5 * (1 - 0.4 * 0.8) * 65535,
              1);  // 100^2 of 100^2 + 50^2
}

TEST(Sensor, AMosaicKeepsFlatColoursAndBlursOthers) {
  Sensor sensor = clean();
  sensor.white_balance = {2, 1, 0.5};
  cv::Mat light(64, 64, CV_32FC3, cv::Scalar(0.8, 0.4, 0.2));  // blue, green, red
  const cv::Mat flat = expose_mosaic(light, sensor, stream());
  EXPECT_EQ(flat.type(), CV_8UC3);
  EXPECT_EQ(cv::norm(flat, cv::Mat(64, 64, CV_8UC3, cv::Scalar(102, 102, 102)), cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(flat, expose(light, sensor, stream()), cv::NORM_INF), 0);
  // One bright pixel of a red photosite: its red is whole, its neighbours have half and quarter.
  sensor.white_balance.setOnes();
  light.setTo(0);
  light.at<cv::Vec3f>(20, 30) = {1, 1, 1};
  const cv::Mat spot = expose_mosaic(light, sensor, stream());
  EXPECT_EQ(spot.at<cv::Vec3b>(20, 30), cv::Vec3b(0, 0, 255));
  EXPECT_NEAR(spot.at<cv::Vec3b>(20, 31)[2], 127.5, 1);
  EXPECT_NEAR(spot.at<cv::Vec3b>(21, 31)[2], 63.75, 1);
  EXPECT_EQ(spot.at<cv::Vec3b>(20, 33)[2], 0);
}

// Rows are what red, green and blue channels read of red, green and blue light.
TEST(Sensor, TheResponseMixesLightBeforeAllElse) {
  Sensor sensor = clean(16);
  const cv::Mat light(4, 4, CV_32FC3, cv::Scalar(0.1, 0.2, 0.4));  // blue, green, red
  const cv::Mat plain = expose(light, sensor, stream());
  sensor.response << 0.5, 0.25, 0.5,  //
      1, -1, 0,                       //
      0, 0, 3;
  sensor.white_balance = {1, 2, 1};
  const double red = 0.5 * 0.4 + 0.25 * 0.2 + 0.5 * 0.1, green = 2 * (0.4 - 0.2), blue = 3 * 0.1;
  for (const cv::Mat& image :
       {expose(light, sensor, stream()), expose_mosaic(light, sensor, stream())}) {
    const cv::Vec3w at = image.at<cv::Vec3w>(2, 2);
    EXPECT_NEAR(at[0], 65535 * blue, 1);
    EXPECT_NEAR(at[1], 65535 * green, 1);
    EXPECT_NEAR(at[2], 65535 * red, 1);
  }
  // The identity changes nothing, to the last bit.
  sensor.response.setIdentity();
  sensor.white_balance.setOnes();
  EXPECT_EQ(cv::norm(plain, expose(light, sensor, stream()), cv::NORM_INF), 0);
  // Noise is that of what the photosites read: none where they read nothing.
  sensor.response.setZero();
  sensor.full_well_electrons = 100;
  EXPECT_EQ(cv::norm(expose(light, sensor, stream()), cv::NORM_INF), 0);
}

TEST(Sensor, NoNoiseMeansNoNoise) {
  const cv::Mat light(8, 8, CV_32F, cv::Scalar(0.3));
  const cv::Mat image = expose(light, clean(), stream());
  EXPECT_EQ(cv::countNonZero(image != static_cast<int>(std::round(0.3f * 255))), 0);
}

// Values of IEC 61966-2-1: linear 0.5 is 187.5 of 255, 0.002 lies on the straight piece.
TEST(Sensor, EncodesSrgbWhereAskedFor) {
  cv::Mat light(1, 4, CV_32F);
  light.at<float>(0, 0) = 0.5F;
  light.at<float>(0, 1) = 0.002F;
  light.at<float>(0, 2) = 1.5F;
  light.at<float>(0, 3) = 0.25F;
  Sensor sensor{.psf_sigma_px = 0, .read_noise_grey = 0};
  sensor.is_srgb = true;
  const cv::Mat encoded = expose(light, sensor, RandomStream(1, "sensor", 0));
  EXPECT_EQ(encoded.at<uint8_t>(0, 0), 188);
  EXPECT_EQ(encoded.at<uint8_t>(0, 1), 7);  // 255 x 12.92 x 0.002 = 6.6
  EXPECT_EQ(encoded.at<uint8_t>(0, 2), 255);
  sensor.gain = 2;  // before the encoding
  EXPECT_EQ(expose(light, sensor, RandomStream(1, "sensor", 0)).at<uint8_t>(0, 3), 188);
  sensor.is_srgb = false;
  EXPECT_EQ(expose(light, sensor, RandomStream(1, "sensor", 0)).at<uint8_t>(0, 3), 128);
}

}  // namespace
}  // namespace sightline
