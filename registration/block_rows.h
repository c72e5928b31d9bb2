// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "pose/pose.h"
#include "registration/columns_kernel.h"
#include "registration/grey_image.h"
#include "registration/model_view.h"

namespace sightline {

/// The unknowns of a registration: the change (w, dt) of the pose, the light and background, and
/// the variance of the blur.
inline constexpr int kUnknowns = 12;
inline constexpr int kLightAt = 6;  ///< the first of LightVector among the unknowns
inline constexpr int kBlurAt = 11;
/// A block's own deviations: a light of its own (4), and a background with two slopes (3).
inline constexpr int kInsideLocals = 4;
inline constexpr int kOutsideLocals = 3;
inline constexpr int kLocals = kInsideLocals + kOutsideLocals;

using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;

/// The pixels of one square of the image that are compared, linearised about a model. Its columns
/// are the derivatives of the model by the unknowns, then the residual image - model, then the two
/// slopes of the background; they hold the columns of the local deviations too.
struct Block {
  int id = 0;               ///< the same at every linearisation
  int count = 0;            ///< pixels in use
  int stride = 0;           ///< the same, padded
  size_t first_column = 0;  ///< in BlockRows::columns
  size_t first_pixel = 0;   ///< in BlockRows::pixels
};

/// All blocks of a linearisation.
struct BlockRows {
  std::vector<Block> blocks;
  std::vector<double> columns;
  std::vector<int> pixels;  ///< y * width + x in the image, of each block's pixels
  int blocks_across = 0;    ///< of the image: a block's id is row * blocks_across + column
  int clipped = 0;          ///< pixels near the target that are left out since they are saturated
  double outline_px = 0;    ///< length of outline among the pixels in use

  const double* columns_of(const Block& block) const { return columns.data() + block.first_column; }
  std::span<const int> pixels_of(const Block& block) const {
    return {pixels.data() + block.first_pixel, static_cast<size_t>(block.count)};
  }
};

/// The blocks of an image of that size, and how many stand side by side.
int blocks_across(const cv::Size& image);
int block_count(const cv::Size& image);

/// Linearises the model about a pose and a light. `has_blur`: the blur's variance is an unknown.
/// `rows` keeps its memory, which is megabytes, from one linearisation to the next.
void linearise_rows(const GreyImage& image, const ModelView& view, const Pose& cam_from_target,
                    const LightVector& light, bool has_blur, BlockRows& rows);

}  // namespace sightline
