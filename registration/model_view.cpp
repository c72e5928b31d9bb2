// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/model_view.h"

#include <cmath>
#include <limits>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "registration/grey_image.h"

namespace sightline {
namespace {

constexpr double kBandPx = 3.5;      // half the width of the band along the outline
constexpr float kDepthJump = 3e-4F;  // of the depth: more than a surface falls in a pixel

// The least depth of a pixel and its eight neighbours, of those that see the target.
cv::Mat nearest_depths(const cv::Mat& front_m) {
  cv::Mat depth(front_m.size(), CV_32F);
  for (int y = 0; y < front_m.rows; ++y) {
    const cv::Vec3f* const row = front_m.ptr<cv::Vec3f>(y);
    float* const to = depth.ptr<float>(y);
    for (int x = 0; x < front_m.cols; ++x) {
      to[x] = row[x][2] == 0 ? std::numeric_limits<float>::max() : row[x][2];
    }
  }
  cv::erode(depth, depth, cv::Mat());
  return depth;
}

// Of pixels that see the target, the nearest surface of their neighbourhood where depth jumps.
cv::Mat nearest_at_jumps(const cv::Mat& front_m) {
  cv::Mat out = front_m.clone();
  const cv::Mat nearest_around = nearest_depths(front_m);
  for (int y = 1; y + 1 < front_m.rows; ++y) {
    const float* const around_m = nearest_around.ptr<float>(y);
    const cv::Vec3f* rows[3] = {front_m.ptr<cv::Vec3f>(y - 1), front_m.ptr<cv::Vec3f>(y),
                                front_m.ptr<cv::Vec3f>(y + 1)};
    cv::Vec3f* const to = out.ptr<cv::Vec3f>(y);
    for (int x = 1; x + 1 < front_m.cols; ++x) {
      const float own_m = rows[1][x][2];
      if (own_m == 0) continue;
      float nearest_m = own_m * (1 - kDepthJump);
      if (around_m[x] >= nearest_m) continue;
      for (const cv::Vec3f* row : rows) {
        for (int u = x - 1; u <= x + 1; ++u) {
          if (row[u][2] == 0 || row[u][2] >= nearest_m) continue;
          nearest_m = row[u][2];
          to[x] = row[u];
        }
      }
    }
  }
  return out;
}

// Continues the surface over its border: pixels that see none take that of the nearest which does.
// Returns the distance to it.
cv::Mat continue_outwards(int reach, cv::Mat& front_m) {
  cv::Mat is_empty(front_m.size(), CV_8U);
  for (int y = 0; y < front_m.rows; ++y) {
    const cv::Vec3f* const row = front_m.ptr<cv::Vec3f>(y);
    uchar* const to = is_empty.ptr<uchar>(y);
    for (int x = 0; x < front_m.cols; ++x) to[x] = row[x][2] > 0 ? 0 : 255;
  }
  cv::Mat distance, label;
  cv::distanceTransform(is_empty, distance, label, cv::DIST_L2, cv::DIST_MASK_3,
                        cv::DIST_LABEL_PIXEL);
  std::vector<cv::Vec3f> at(front_m.total() + 1, cv::Vec3f(0, 0, 0));
  for (int y = 0; y < front_m.rows; ++y) {
    const cv::Vec3f* const row = front_m.ptr<cv::Vec3f>(y);
    const int* const labels = label.ptr<int>(y);
    for (int x = 0; x < front_m.cols; ++x) {
      if (row[x][2] > 0) at[static_cast<size_t>(labels[x])] = row[x];
    }
  }
  for (int y = 0; y < front_m.rows; ++y) {
    cv::Vec3f* const row = front_m.ptr<cv::Vec3f>(y);
    const uchar* const empty = is_empty.ptr<uchar>(y);
    const int* const labels = label.ptr<int>(y);
    const float* const distances = distance.ptr<float>(y);
    for (int x = 0; x < front_m.cols; ++x) {
      if (empty[x] != 0 && distances[x] <= reach) row[x] = at[static_cast<size_t>(labels[x])];
    }
  }
  return distance;
}

// A field's sixth-order differences.
const cv::Mat& difference_kernel() {
  static const cv::Mat kernel =
      (cv::Mat_<float>(1, 7) << -1 / 60.F, 9 / 60.F, -45 / 60.F, 0, 45 / 60.F, -9 / 60.F, 1 / 60.F);
  return kernel;
}

const cv::Mat& second_difference_kernel() {
  static const cv::Mat kernel = (cv::Mat_<float>(1, 7) << 2 / 180.F, -27 / 180.F, 270 / 180.F,
                                 -490 / 180.F, 270 / 180.F, -27 / 180.F, 2 / 180.F);
  return kernel;
}

cv::Mat filtered(const cv::Mat& image, const cv::Mat& along_x, const cv::Mat& along_y) {
  cv::Mat out;
  cv::sepFilter2D(image, out, CV_32F, along_x, along_y, {-1, -1}, 0, cv::BORDER_REPLICATE);
  return out;
}

// The slope of the coverage: its sum is the length of the outline, px.
cv::Mat outline_of(const cv::Mat& background) {
  const cv::Mat same = cv::Mat::ones(1, 1, CV_32F);
  const cv::Mat by_x = filtered(background, difference_kernel(), same);
  const cv::Mat by_y = filtered(background, same, difference_kernel());
  cv::Mat slope;
  cv::magnitude(by_x, by_y, slope);
  return slope;
}

}  // namespace

cv::Mat outline_band(const cv::Mat& coverage) {
  const cv::Mat is_target = coverage > 0.5;
  const int side = 2 * static_cast<int>(std::lround(kBandPx)) + 1;
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side});
  cv::Mat grown, shrunken;
  cv::dilate(is_target, grown, disc);
  // The target goes on where the image ends: that is no outline.
  cv::erode(is_target, shrunken, disc);
  return grown & ~shrunken;
}

int reach_px(double blur_px) {
  return static_cast<int>(std::ceil(3 * blur_px + 1.5));
}

int margin_px(double blur_px) {
  constexpr int kDifference = 3;  // taps on either side
  return reach_px(blur_px) + kDifference + 2;
}

ModelView model_view(const BasisImages& images, double blur_px, RegistrationRegion region) {
  ModelView view;
  view.box = images.box;
  view.basis[0] = blurred(images.albedo, blur_px);
  for (size_t k = 0; k < 3; ++k) view.basis[k + 1] = blurred(images.albedo_normal[k], blur_px);
  view.basis[4] = 1 - blurred(images.coverage, blur_px);
  view.front_m = nearest_at_jumps(images.front_m);
  const int reach = reach_px(blur_px);
  const cv::Mat distance = continue_outwards(reach, view.front_m);
  view.is_used = distance <= reach;
  if (region == RegistrationRegion::kOutline) view.is_used &= outline_band(images.coverage);
  view.outline = outline_of(view.basis[4]);
  return view;
}

ModelPicture model_picture(const ModelView& view, const LightVector& light) {
  ModelPicture picture;
  picture.grey = cv::Mat::zeros(view.basis[0].size(), CV_32F);
  for (size_t k = 0; k < view.basis.size(); ++k) {
    cv::scaleAdd(view.basis[k], light[static_cast<int>(k)], picture.grey, picture.grey);
  }
  const cv::Mat same = cv::Mat::ones(1, 1, CV_32F);
  picture.by_x = filtered(picture.grey, difference_kernel(), same);
  picture.by_y = filtered(picture.grey, same, difference_kernel());
  picture.half_laplacian = filtered(picture.grey, second_difference_kernel(), same) +
                           filtered(picture.grey, same, second_difference_kernel());
  picture.half_laplacian *= 0.5;
  return picture;
}

}  // namespace sightline
