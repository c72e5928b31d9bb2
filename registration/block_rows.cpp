// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/block_rows.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

namespace sightline {
namespace {

constexpr int kRimPx = 4;  // of the image, where blur and differences lack neighbours

// What a pixel of the model needs, row by row.
struct ModelRow {
  std::array<const float*, 5> basis;
  const float *grey, *by_x, *by_y, *half_laplacian, *image;
  const cv::Vec3f* front_m;
};

ModelRow row_of(const GreyImage& image, const ModelView& view, const ModelPicture& picture, int y) {
  const int v = y - view.box.y;
  ModelRow row{};
  for (size_t k = 0; k < row.basis.size(); ++k) row.basis[k] = view.basis[k].ptr<float>(v);
  row.grey = picture.grey.ptr<float>(v);
  row.by_x = picture.by_x.ptr<float>(v);
  row.by_y = picture.by_y.ptr<float>(v);
  row.half_laplacian = picture.half_laplacian.ptr<float>(v);
  row.front_m = view.front_m.ptr<cv::Vec3f>(v);
  row.image = image.grey.ptr<float>(y) + view.box.x;
  return row;
}

// Writes the columns of one pixel.
class ColumnWriter {
 public:
  ColumnWriter(const Camera& camera, const Pose& cam_from_target, const LightVector& light,
               bool has_blur)
      : camera_(camera),
        origin_(cam_from_target.translation),
        light_(light.segment<3>(1)),
        has_blur_(has_blur) {}

  // `x` is the column within the model's box; `slope` the pixel's place in its block, from -1 to 1.
  void write(const ModelRow& row, int x, const Eigen::Vector2d& slope, int stride,
             double* to) const {
    const cv::Vec3f& front = row.front_m[x];
    const Eigen::Vector3d point(front[0], front[1], front[2]);
    const Eigen::Vector3d g = by_point(point, {row.by_x[x], row.by_y[x]});
    const Eigen::Vector3d shade(row.basis[1][x], row.basis[2][x], row.basis[3][x]);
    // What the surface shows goes with it: by -g . velocity the model changes at a fixed pixel, the
    // velocity being w x q + dt. And the surface turns in the light.
    const Eigen::Vector3d turn = -(point - origin_).cross(g) + shade.cross(light_);
    const double outside = row.basis[4][x];
    const double values[kColumns] = {turn.x(),
                                     turn.y(),
                                     turn.z(),
                                     -g.x(),
                                     -g.y(),
                                     -g.z(),
                                     row.basis[0][x],
                                     shade.x(),
                                     shade.y(),
                                     shade.z(),
                                     outside,
                                     has_blur_ ? row.half_laplacian[x] : 0,
                                     static_cast<double>(row.image[x]) - row.grey[x],
                                     outside * slope.x(),
                                     outside * slope.y()};
    for (int i = 0; i < kColumns; ++i) to[static_cast<ptrdiff_t>(i) * stride] = values[i];
  }

 private:
  // The derivative of the model's grey by the place of the surface in the camera.
  Eigen::Vector3d by_point(const Eigen::Vector3d& point, const Eigen::Vector2d& by_pixel) const {
    const double u = point.x() / point.z(), v = point.y() / point.z();
    Eigen::Vector2d by_ray(by_pixel.x(), by_pixel.y());
    if (!is_straight(camera_)) {
      by_ray = lens_jacobian(camera_, {u, v}).transpose() * by_ray;
    }
    const double gx = by_ray.x() * camera_.fx_px / point.z();
    const double gy = by_ray.y() * camera_.fy_px / point.z();
    return {gx, gy, -gx * u - gy * v};
  }

  const Camera& camera_;
  Eigen::Vector3d origin_;
  Eigen::Vector3d light_;
  bool has_blur_;
};

// The pixels of a block that can be compared. `clipped` counts those that saturation takes.
std::vector<int> usable_pixels(const GreyImage& image, const ModelView& view, const cv::Rect& block,
                               int& clipped) {
  std::vector<int> pixels;
  for (int y = block.y; y < block.y + block.height; ++y) {
    const uchar* const is_used = view.is_used.ptr<uchar>(y - view.box.y);
    const cv::Vec3f* const front = view.front_m.ptr<cv::Vec3f>(y - view.box.y);
    const uchar* const is_clipped = image.is_clipped.ptr<uchar>(y);
    for (int x = block.x; x < block.x + block.width; ++x) {
      const int u = x - view.box.x;
      if (is_used[u] == 0 || front[u][2] == 0) continue;
      if (is_clipped[x] != 0) {
        ++clipped;
        continue;
      }
      pixels.push_back(y * image.grey.cols + x);
    }
  }
  return pixels;
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

BlockRows block_rows(const GreyImage& image, const ModelView& view, const Pose& cam_from_target,
                     const LightVector& light, bool has_blur) {
  constexpr int kFewest = 4;  // pixels that a block is worth its own deviations for
  BlockRows rows;
  rows.blocks_across = blocks_across(image.grey.size());
  const ModelPicture picture = model_picture(view, light);
  const ColumnWriter writer(image.camera, cam_from_target, light, has_blur);
  const cv::Rect inner = view.box & cv::Rect(kRimPx, kRimPx, image.grey.cols - 2 * kRimPx,
                                             image.grey.rows - 2 * kRimPx);
  if (inner.empty()) return rows;
  const auto most = static_cast<size_t>(cv::countNonZero(view.is_used));
  rows.pixels.reserve(most);
  rows.columns.reserve(most * kColumns * 5 / 4);  // padded
  for (int by = inner.y / kBlockPx; by * kBlockPx < inner.y + inner.height; ++by) {
    for (int bx = inner.x / kBlockPx; bx * kBlockPx < inner.x + inner.width; ++bx) {
      const cv::Rect square(bx * kBlockPx, by * kBlockPx, kBlockPx, kBlockPx);
      const std::vector<int> pixels = usable_pixels(image, view, square & inner, rows.clipped);
      if (static_cast<int>(pixels.size()) < kFewest) continue;
      Block block;
      block.id = by * rows.blocks_across + bx;
      block.count = static_cast<int>(pixels.size());
      block.stride = (block.count + kLanes - 1) / kLanes * kLanes;
      block.first_column = rows.columns.size();
      block.first_pixel = rows.pixels.size();
      rows.outline_px += outline_in(view.outline, view.box, pixels, image.grey.cols);
      rows.pixels.insert(rows.pixels.end(), pixels.begin(), pixels.end());
      rows.columns.resize(rows.columns.size() + static_cast<size_t>(kColumns) * block.stride, 0.0);
      double* const columns = rows.columns.data() + block.first_column;
      for (int i = 0; i < block.count; ++i) {
        const int y = pixels[static_cast<size_t>(i)] / image.grey.cols;
        const int x = pixels[static_cast<size_t>(i)] % image.grey.cols;
        const Eigen::Vector2d slope((x + 0.5 - square.x) * 2 / kBlockPx - 1,
                                    (y + 0.5 - square.y) * 2 / kBlockPx - 1);
        writer.write(row_of(image, view, picture, y), x - view.box.x, slope, block.stride,
                     columns + i);
      }
      rows.blocks.push_back(block);
    }
  }
  return rows;
}

}  // namespace sightline
