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
