// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/block_rows.h"

#include <algorithm>

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
    for (size_t i = 0; i < pixels.size();) {
      const size_t length = run_length(pixels.subspan(i));
      write_run(pixels[i], static_cast<int>(length), square, stride, columns + i);
      write_slopes(pixels[i], static_cast<int>(length), i, slopes);
      i += length;
    }
    const auto count = static_cast<int>(pixels.size());
    write_pose_columns(slopes, origin_.data(), light_.data(), count, stride, columns);
    for (int i = 0; i < kColumns; ++i) {
      std::fill(columns + static_cast<ptrdiff_t>(i) * stride + count,
                columns + static_cast<ptrdiff_t>(i + 1) * stride, 0.0);
    }
  }

 private:
  // How many pixels follow the first in its row, itself included.
  size_t run_length(std::span<const int> pixels) const {
    const int width = image_.grey.cols;
    const int row_end = pixels[0] - pixels[0] % width + width;
    size_t length = 1;
    while (length < pixels.size() && pixels[length] == pixels[0] + static_cast<int>(length) &&
           pixels[length] < row_end) {
      ++length;
    }
    return length;
  }

  // All columns but those of the pose, of pixels side by side.
  void write_run(int first, int count, const cv::Rect& square, int stride, double* to) const {
    const int y = first / image_.grey.cols, x = first % image_.grey.cols;
    const int v = y - view_.box.y, u = x - view_.box.x;
    to += static_cast<ptrdiff_t>(kLightAt) * stride;
    for (const cv::Mat& basis : view_.basis) {
      std::copy_n(basis.ptr<float>(v) + u, count, to);
      to += stride;
    }
    if (has_blur_) {
      std::copy_n(picture_.half_laplacian.ptr<float>(v) + u, count, to);
    } else {
      std::fill_n(to, count, 0.0);
    }
    double* const residual = to + stride;
    double* const along_x = residual + stride;
    double* const along_y = along_x + stride;
    const float* const outside = view_.basis[4].ptr<float>(v) + u;
    const float* const grey = image_.grey.ptr<float>(y) + x;
    const float* const model = picture_.grey.ptr<float>(v) + u;
    const double slope_y = (y + 0.5 - square.y) * 2 / kBlockPx - 1;
    for (int i = 0; i < count; ++i) {
      const double slope_x = (x + i + 0.5 - square.x) * 2 / kBlockPx - 1;
      residual[i] = static_cast<double>(grey[i]) - model[i];
      along_x[i] = outside[i] * slope_x;
      along_y[i] = outside[i] * slope_y;
    }
  }

  // Of pixels side by side, into the places from `at` on.
  void write_slopes(int first, int count, size_t at, PixelSlopes& slopes) const {
    const int v = first / image_.grey.cols - view_.box.y,
              u = first % image_.grey.cols - view_.box.x;
    const cv::Vec3f* const front = view_.front_m.ptr<cv::Vec3f>(v) + u;
    const float* const by_x = picture_.by_x.ptr<float>(v) + u;
    const float* const by_y = picture_.by_y.ptr<float>(v) + u;
    for (int i = 0; i < count; ++i, ++at) {
      Eigen::Vector2d by_ray(by_x[i], by_y[i]);
      if (!is_straight_) {
        const double z = front[i][2];
        by_ray =
            lens_jacobian(image_.camera, {front[i][0] / z, front[i][1] / z}).transpose() * by_ray;
      }
      slopes.x_m[at] = front[i][0];
      slopes.y_m[at] = front[i][1];
      slopes.z_m[at] = front[i][2];
      slopes.by_u[at] = by_ray.x() * image_.camera.fx_px;
      slopes.by_v[at] = by_ray.y() * image_.camera.fy_px;
    }
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
  int row = -1, row_begin = 0;
  const float* of_row = nullptr;
  for (const int pixel : pixels) {
    if (row < 0 || pixel >= row_begin + width) {
      row = pixel / width;
      row_begin = row * width;
      of_row = outline.ptr<float>(row - box.y);
    }
    sum += of_row[pixel - row_begin - box.x];
  }
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
