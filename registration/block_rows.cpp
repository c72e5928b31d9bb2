// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/block_rows.h"

#include <algorithm>
#include <iterator>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

namespace sightline {
namespace {

constexpr int kRimPx = 4;  // of the image, where blur and differences lack neighbours

// Writes the columns of the pixels of a block.
class ColumnWriter {
 public:
  ColumnWriter(const GreyImage& image, const ModelView& view, const Pose& cam_from_target,
               const LightVector& light, bool has_blur)
      : image_(image),
        view_(view),
        picture_(model_picture(view, light)),
        origin_(cam_from_target.translation),
        light_(light.segment<3>(1)),
        has_blur_(has_blur),
        is_straight_(is_straight(image.camera)) {}

  // `square` is the whole block's place in the image.
  void write(std::span<const int> pixels, const cv::Rect& square, int stride,
             double* columns) const {
    PixelSlopes slopes;
    const int width = image_.grey.cols;
    for (size_t i = 0; i < pixels.size(); ++i) {
      const int y = pixels[i] / width, x = pixels[i] % width;
      write_pixel(y, x, square, stride, columns + i);
      write_slopes(y - view_.box.y, x - view_.box.x, i, slopes);
    }
    const auto count = static_cast<int>(pixels.size());
    write_pose_columns(slopes, origin_.data(), light_.data(), count, stride, columns);
    for (int i = 0; i < kColumns; ++i) {
      std::fill(columns + static_cast<ptrdiff_t>(i) * stride + count,
                columns + static_cast<ptrdiff_t>(i + 1) * stride, 0.0);
    }
  }

 private:
  // All columns but those of the pose.
  void write_pixel(int y, int x, const cv::Rect& square, int stride, double* to) const {
    const int v = y - view_.box.y, u = x - view_.box.x;
    const double outside = view_.basis[4].ptr<float>(v)[u];
    const double slope_x = (x + 0.5 - square.x) * 2 / kBlockPx - 1;
    const double slope_y = (y + 0.5 - square.y) * 2 / kBlockPx - 1;
    const double values[] = {
        view_.basis[0].ptr<float>(v)[u],
        view_.basis[1].ptr<float>(v)[u],
        view_.basis[2].ptr<float>(v)[u],
        view_.basis[3].ptr<float>(v)[u],
        outside,
        has_blur_ ? picture_.half_laplacian.ptr<float>(v)[u] : 0,
        static_cast<double>(image_.grey.ptr<float>(y)[x]) - picture_.grey.ptr<float>(v)[u],
        outside * slope_x,
        outside * slope_y};
    static_assert(std::size(values) == kColumns - kLightAt);
    to += static_cast<ptrdiff_t>(kLightAt) * stride;
    for (const double value : values) {
      *to = value;
      to += stride;
    }
  }

  void write_slopes(int v, int u, size_t i, PixelSlopes& slopes) const {
    const cv::Vec3f& front = view_.front_m.ptr<cv::Vec3f>(v)[u];
    Eigen::Vector2d by_ray(picture_.by_x.ptr<float>(v)[u], picture_.by_y.ptr<float>(v)[u]);
    if (!is_straight_) {
      const double z = front[2];
      by_ray = lens_jacobian(image_.camera, {front[0] / z, front[1] / z}).transpose() * by_ray;
    }
    slopes.x_m[i] = front[0];
    slopes.y_m[i] = front[1];
    slopes.z_m[i] = front[2];
    slopes.by_u[i] = by_ray.x() * image_.camera.fx_px;
    slopes.by_v[i] = by_ray.y() * image_.camera.fy_px;
  }

  const GreyImage& image_;
  const ModelView& view_;
  ModelPicture picture_;
  Eigen::Vector3d origin_;
  Eigen::Vector3d light_;
  bool has_blur_;
  bool is_straight_;
};

// Appends the pixels of a block that can be compared to those of `rows`.
void append_usable(const GreyImage& image, const ModelView& view, const cv::Rect& block,
                   BlockRows& rows) {
  for (int y = block.y; y < block.y + block.height; ++y) {
    const uchar* const is_used = view.is_used.ptr<uchar>(y - view.box.y);
    const cv::Vec3f* const front = view.front_m.ptr<cv::Vec3f>(y - view.box.y);
    const uchar* const is_clipped = image.is_clipped.ptr<uchar>(y);
    for (int x = block.x; x < block.x + block.width; ++x) {
      const int u = x - view.box.x;
      if (is_used[u] == 0 || front[u][2] == 0) continue;
      if (is_clipped[x] != 0) {
        ++rows.clipped;
        continue;
      }
      rows.pixels.push_back(y * image.grey.cols + x);
    }
  }
}

double outline_in(const cv::Mat& outline, const cv::Rect& box, std::span<const int> pixels,
                  int width) {
  double sum = 0;
  for (const int pixel : pixels)
    sum += outline.at<float>(pixel / width - box.y, pixel % width - box.x);
  return sum;
}

}  // namespace

int blocks_across(const cv::Size& image) {
  return (image.width + kBlockPx - 1) / kBlockPx;
}

int block_count(const cv::Size& image) {
  return blocks_across(image) * ((image.height + kBlockPx - 1) / kBlockPx);
}

void linearise_rows(const GreyImage& image, const ModelView& view, const Pose& cam_from_target,
                    const LightVector& light, bool has_blur, BlockRows& rows) {
  constexpr int kFewest = 4;  // pixels that a block is worth its own deviations for
  rows.blocks.clear();
  rows.pixels.clear();
  rows.clipped = 0;
  rows.outline_px = 0;
  rows.blocks_across = blocks_across(image.grey.size());
  const cv::Rect inner = view.box & cv::Rect(kRimPx, kRimPx, image.grey.cols - 2 * kRimPx,
                                             image.grey.rows - 2 * kRimPx);
  if (inner.empty()) return;
  const ColumnWriter writer(image, view, cam_from_target, light, has_blur);
  size_t columns = 0;
  for (int by = inner.y / kBlockPx; by * kBlockPx < inner.y + inner.height; ++by) {
    for (int bx = inner.x / kBlockPx; bx * kBlockPx < inner.x + inner.width; ++bx) {
      const cv::Rect square(bx * kBlockPx, by * kBlockPx, kBlockPx, kBlockPx);
      Block block;
      block.id = by * rows.blocks_across + bx;
      block.first_pixel = rows.pixels.size();
      append_usable(image, view, square & inner, rows);
      block.count = static_cast<int>(rows.pixels.size() - block.first_pixel);
      if (block.count < kFewest) {
        rows.pixels.resize(block.first_pixel);
        continue;
      }
      block.stride = (block.count + kLanes - 1) / kLanes * kLanes;
      block.first_column = columns;
      columns += static_cast<size_t>(kColumns) * block.stride;
      if (rows.columns.size() < columns) rows.columns.resize(columns);
      const std::span<const int> pixels = rows.pixels_of(block);
      rows.outline_px += outline_in(view.outline, view.box, pixels, image.grey.cols);
      writer.write(pixels, square, block.stride, rows.columns.data() + block.first_column);
      rows.blocks.push_back(block);
    }
  }
}

}  // namespace sightline
