// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/columns_kernel.h"

#include "pose/multiversion.h"

namespace sightline {
namespace {

// Numbers of so many pixels side by side: their number is the same on every processor, so that
// results are.
using Lanes [[gnu::vector_size(kLanes * sizeof(double))]] = double;

inline void load(const double* from, Lanes& to) {
  __builtin_memcpy(&to, from, sizeof to);
}

// The sums of a[p] b[p] for N columns b. Several at once: one alone would wait for its own last
// addition.
template <int N>
inline void dots(const double* a, const double* b, int stride, double* sums) {
  Lanes total[N] = {};
  for (int p = 0; p < stride; p += kLanes) {
    Lanes left, right;
    load(a + p, left);
    for (int j = 0; j < N; ++j) {
      load(b + j * stride + p, right);
      total[j] += left * right;
    }
  }
  for (int j = 0; j < N; ++j) {
    const Lanes& l = total[j];
    sums[j] = ((l[0] + l[4]) + (l[2] + l[6])) + ((l[1] + l[5]) + (l[3] + l[7]));
  }
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
    double* const row = gram + kColumns * i;
    int j = i;
    for (; j + 4 <= kColumns; j += 4) dots<4>(weighted, columns + j * stride, stride, row + j);
    for (; j < kColumns; ++j) dots<1>(weighted, columns + j * stride, stride, row + j);
    for (j = i; j < kColumns; ++j) gram[kColumns * j + i] = row[j];
  }
}

SIGHTLINE_MULTIVERSION
void combine_columns(const double* columns, int stride, const double* coefficients, double* out) {
  for (int p = 0; p < stride; p += kLanes) {
    Lanes sum = {}, column;
    for (int i = 0; i < kColumns; ++i) {
      load(columns + i * stride + p, column);
      sum += coefficients[i] * column;
    }
    __builtin_memcpy(out + p, &sum, sizeof sum);
  }
}

SIGHTLINE_MULTIVERSION
void student_weights(const double* residuals, int count, double variance, double nu,
                     float* weights) {
  const double information = 1 / variance;
  for (int p = 0; p < count; ++p) {
    const double weight = (nu + 1) / (nu + residuals[p] * residuals[p] * information);
    weights[p] = static_cast<float>(weight < 1 ? weight : 1.0);
  }
}

SIGHTLINE_MULTIVERSION
int count_below(const double* values, int count, double size) {
  int below = 0;
  for (int p = 0; p < count; ++p) below += (values[p] < size) & (values[p] > -size);
  return below;
}

}  // namespace sightline
