// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/columns_kernel.h"

#include "pose/multiversion.h"

namespace sightline {
namespace {

// The sum of a[p] b[p], in lanes whose number no processor changes, so that no result does.
inline double dot(const double* a, const double* b, int count) {
  double lanes[kLanes] = {};
  for (int p = 0; p < count; p += kLanes) {
    for (int k = 0; k < kLanes; ++k) lanes[k] += a[p + k] * b[p + k];
  }
  return ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) +
         ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]));
}

}  // namespace

// What the surface shows goes with it: by -g . velocity the model changes at a fixed pixel, the
// velocity being w x q + dt, where q is the surface's place about the origin. And it turns in the
// light.
SIGHTLINE_MULTIVERSION
void write_pose_columns(const PixelSlopes& slopes, const double* origin, const double* light,
                        int count, int stride, double* columns) {
  double* const to[6] = {columns,
                         columns + stride,
                         columns + 2 * stride,
                         columns + 3 * stride,
                         columns + 4 * stride,
                         columns + 5 * stride};
  const double* const shade_x = columns + 7 * stride;
  const double* const shade_y = columns + 8 * stride;
  const double* const shade_z = columns + 9 * stride;
#pragma GCC ivdep
  for (int p = 0; p < count; ++p) {
    const double x = slopes.x_m[p], y = slopes.y_m[p], z = slopes.z_m[p];
    const double gx = slopes.by_u[p] / z;
    const double gy = slopes.by_v[p] / z;
    const double gz = -gx * (x / z) - gy * (y / z);
    const double qx = x - origin[0], qy = y - origin[1], qz = z - origin[2];
    to[0][p] = -(qy * gz - qz * gy) + (shade_y[p] * light[2] - shade_z[p] * light[1]);
    to[1][p] = -(qz * gx - qx * gz) + (shade_z[p] * light[0] - shade_x[p] * light[2]);
    to[2][p] = -(qx * gy - qy * gx) + (shade_x[p] * light[1] - shade_y[p] * light[0]);
    to[3][p] = -gx;
    to[4][p] = -gy;
    to[5][p] = -gz;
  }
}

SIGHTLINE_MULTIVERSION
void weighted_gram(const double* columns, int stride, const double* weights, double* gram) {
  double weighted[kBlockPixels];
  for (int i = 0; i < kColumns; ++i) {
    const double* const column = columns + i * stride;
    for (int p = 0; p < stride; ++p) weighted[p] = column[p] * weights[p];
    for (int j = i; j < kColumns; ++j) {
      const double sum = dot(weighted, columns + j * stride, stride);
      gram[kColumns * i + j] = sum;
      gram[kColumns * j + i] = sum;
    }
  }
}

SIGHTLINE_MULTIVERSION
void combine_columns(const double* columns, int stride, const double* coefficients, double* out) {
  for (int p = 0; p < stride; ++p) out[p] = 0;
  for (int i = 0; i < kColumns; ++i) {
    const double* const column = columns + i * stride;
    const double c = coefficients[i];
    for (int p = 0; p < stride; ++p) out[p] += c * column[p];
  }
}

}  // namespace sightline
