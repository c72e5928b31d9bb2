// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/background.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "pose/angles.h"
#include "scenes/random/random.h"

namespace sightline {
namespace {

constexpr double kFaintestStar = 0.01;  // of the brightest: five magnitudes
constexpr double kOctaveRatio = 0.6;
constexpr int kLatticeBorder = 5;  // points that a lattice has beyond those that span the image

cv::Mat uniform(double level, cv::Size size) {
  return {size, CV_32F, cv::Scalar(level)};
}

cv::Mat sky(const Background& background, cv::Size size) {
  const double angle = background.angle_deg * kDegree;
  const double right = std::cos(angle);
  const double down = std::sin(angle);
  // From the middle to the farthest pixel centre along the direction.
  const double reach =
      (std::abs(right) * (size.width - 1) + std::abs(down) * (size.height - 1)) / 2;
  const double slope = reach > 0 ? background.contrast / 2 / reach : 0;
  cv::Mat image(size, CV_32F);
  for (int v = 0; v < size.height; ++v) {
    float* row = image.ptr<float>(v);
    const double at_left = background.level + slope * (down * (v - (size.height - 1) / 2.0) -
                                                       right * (size.width - 1) / 2.0);
    for (int u = 0; u < size.width; ++u) row[u] = static_cast<float>(at_left + slope * right * u);
  }
  return image;
}

// Twice as large by cubic B-splines (subdivision with the binomial kernel), less the border where
// pyrUp would have to invent neighbours.
cv::Mat subdivided(const cv::Mat& coarse) {
  cv::Mat fine;
  cv::pyrUp(coarse, fine);
  constexpr int kBorder = 2;
  return fine(cv::Rect(kBorder, kBorder, fine.cols - 2 * kBorder, fine.rows - 2 * kBorder));
}

void add_normals(cv::Mat& image, double sd, RandomStream& stream) {
  std::vector<float> row(image.cols);
  for (int v = 0; v < image.rows; ++v) {
    stream.normals(row);
    float* to = image.ptr<float>(v);
    for (int u = 0; u < image.cols; ++u) to[u] += static_cast<float>(sd) * row[u];
  }
}

// Noise whose coarsest structures are `cloud_px` pixels large: lattices of random numbers, each
// twice as fine as the one before, down to a step of one to two pixels.
cv::Mat fractal_noise(double cloud_px, cv::Size size, RandomStream& stream) {
  const int octaves = std::max(0, static_cast<int>(std::floor(std::log2(std::max(1.0, cloud_px)))));
  const double step_px = std::max(1.0, cloud_px) / std::exp2(octaves);
  // Of n points subdivision makes 2 n - 4; what the finest lattice does not need is cut off.
  const auto lattice_size = [&](int octave) {
    const double cells = std::exp2(octaves - octave) * step_px;
    return cv::Size(static_cast<int>(std::ceil(size.width / cells)) + kLatticeBorder,
                    static_cast<int>(std::ceil(size.height / cells)) + kLatticeBorder);
  };
  cv::Mat noise = cv::Mat::zeros(lattice_size(0), CV_32F);
  double sd = 1;
  add_normals(noise, sd, stream);
  for (int octave = 1; octave <= octaves; ++octave) {
    noise = subdivided(noise)(cv::Rect({0, 0}, lattice_size(octave))).clone();
    sd *= kOctaveRatio;
    add_normals(noise, sd, stream);
  }
  // The last step, from the finest lattice to pixels, is between one and two.
  cv::Mat image;
  const cv::Matx23d lattice_from_pixel(1 / step_px, 0, 1, 0, 1 / step_px, 1);
  cv::warpAffine(noise, image, lattice_from_pixel, size, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                 cv::BORDER_REPLICATE);
  return image;
}

cv::Mat clouds(const Background& background, cv::Size size) {
  RandomStream stream(background.seed, "clouds", 0);
  const cv::Mat noise = fractal_noise(background.cloud_px, size, stream);
  cv::Scalar mean, sd;
  cv::meanStdDev(noise, mean, sd);
  const double scale = sd[0] > 0 ? background.contrast / 2 / sd[0] : 0;
  cv::Mat image;
  noise.convertTo(image, CV_32F, scale, background.level - scale * mean[0]);
  return image;
}

// Shares light among the four pixel centres about (u, v), as far as they are in the image.
void deposit(cv::Mat& image, double u, double v, double light) {
  const int left = static_cast<int>(std::floor(u));
  const int top = static_cast<int>(std::floor(v));
  for (int row = top; row <= top + 1; ++row) {
    for (int column = left; column <= left + 1; ++column) {
      if (row < 0 || row >= image.rows || column < 0 || column >= image.cols) continue;
      const double share = (1 - std::abs(u - column)) * (1 - std::abs(v - row));
      image.at<float>(row, column) += static_cast<float>(light * share);
    }
  }
}

cv::Mat stars(const Background& background, cv::Size size) {
  cv::Mat image = uniform(background.level, size);
  RandomStream stream(background.seed, "stars", 0);
  // Within one pixel around the image as well: their light reaches in.
  const double width = size.width + 1;
  const double height = size.height + 1;
  const double expected = background.stars_per_megapixel * 1e-6 * width * height;
  // A Poisson number of stars: arrivals of unit rate before `expected`.
  for (double time = -std::log(stream.uniform()); time < expected;
       time -= std::log(stream.uniform())) {
    const double u = stream.uniform(-1, size.width);
    const double v = stream.uniform(-1, size.height);
    // 1 / F uniform between its ends makes the number above F go as 1 / F.
    const double light = background.star_level / stream.uniform(1, 1 / kFaintestStar);
    deposit(image, u, v, light);
  }
  return image;
}

// `type` is CV_32F or CV_32FC3.
cv::Mat picture(const std::vector<float>& pixels, int columns, int type, cv::Size size) {
  const int rows = static_cast<int>(pixels.size()) / columns / CV_MAT_CN(type);
  const cv::Mat whole(rows, columns, type, const_cast<float*>(pixels.data()));
  const double scale = std::max(static_cast<double>(size.width) / whole.cols,
                                static_cast<double>(size.height) / whole.rows);
  const auto part = [scale](int needed, int given) {
    return std::clamp(static_cast<int>(std::lround(needed / scale)), 1, given);
  };
  const int width = part(size.width, whole.cols);
  const int height = part(size.height, whole.rows);
  const cv::Rect middle((whole.cols - width) / 2, (whole.rows - height) / 2, width, height);
  cv::Mat image;
  cv::resize(whole(middle), image, size, 0, 0, scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  return image;
}

cv::Mat unclipped(const Background& background, cv::Size size) {
  switch (background.kind) {
    case BackgroundKind::kUniform:
    case BackgroundKind::kEnvironment:  // environment_image() has it
      break;
    case BackgroundKind::kSky:
      return sky(background, size);
    case BackgroundKind::kClouds:
      return clouds(background, size);
    case BackgroundKind::kStars:
      return stars(background, size);
    case BackgroundKind::kImage:
      return picture(*background.picture, background.picture_width, CV_32F, size);
  }
  return uniform(background.level, size);
}

}  // namespace

cv::Mat colour_background_image(const Background& background, cv::Size size) {
  if (background.kind == BackgroundKind::kImage && background.colours) {
    return picture(*background.colours, background.picture_width, CV_32FC3, size);
  }
  cv::Mat colours;
  cv::cvtColor(background_image(background, size), colours, cv::COLOR_GRAY2BGR);
  return colours;
}

cv::Mat background_image(const Background& background, cv::Size size) {
  cv::Mat image = unclipped(background, size);
  cv::threshold(image, image, 0, 0, cv::THRESH_TOZERO);
  return image;
}

}  // namespace sightline
