// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The inner loops of the registration, compiled for several processors: no Eigen here.
#pragma once

namespace sightline {

/// Columns of a block of pixels: see registration/block_rows.h.
inline constexpr int kColumns = 15;
/// A block is a square of so many pixels a side.
inline constexpr int kBlockPx = 12;
inline constexpr int kBlockPixels = kBlockPx * kBlockPx;
/// The pixels of a block are padded to a multiple of this, by zeros.
inline constexpr int kLanes = 8;

/// Of each pixel of a block: the surface in the camera, and the derivatives of the model's grey by
/// the place (x/z, y/z) of what it shows.
struct PixelSlopes {
  double x_m[kBlockPixels], y_m[kBlockPixels], z_m[kBlockPixels];
  double by_u[kBlockPixels], by_v[kBlockPixels];
};

/// Writes the first six columns of a block, the derivatives by the change (w, dt) of the pose about
/// `origin`. Columns 7 to 9, which it reads, hold albedo_normal, which turns in the light.
void write_pose_columns(const PixelSlopes& slopes, const double* origin, const double* light,
                        int count, int stride, double* columns);

/// gram[15 i + j] = sum over pixels p of weights[p] c_i[p] c_j[p], both halves filled. Column i
/// begins at columns + i * stride; `stride`, a multiple of kLanes and at most kBlockPixels, is also
/// the number of pixels.
void weighted_gram(const double* columns, int stride, const double* weights, double* gram);

/// out[p] = sum over columns i of coefficients[i] c_i[p].
void combine_columns(const double* columns, int stride, const double* coefficients, double* out);

/// Student's weights of residuals with that variance and `nu` degrees of freedom, at most 1.
void student_weights(const double* residuals, int count, double variance, double nu,
                     float* weights);

/// How many of the values are smaller than that size, whatever their sign.
int count_below(const double* values, int count, double size);

}  // namespace sightline
