// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/kernels/orientation_kernels.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "tests/pose/matchers.h"
#include "tests/pose/orientation/clouds.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

void expect_sums_near(const PairSums& actual, const PairSums& expected, double n) {
  // Terms of up to 20^2, and the plain sum rounds once a point.
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      EXPECT_NEAR(actual.rows[i][j], expected.rows[i][j], 400 * n * std::sqrt(n) * kEpsilon) << n;
    }
  }
}

template <typename Scalar>
PairArrays<Scalar> arrays_of(const std::vector<Eigen::Matrix<Scalar, 3, 1>>& a,
                             const std::vector<Eigen::Matrix<Scalar, 3, 1>>& b,
                             const double* weights) {
  return {a[0].data(), b[0].data(), weights, a.size(), {1, -2, 3}, {-3, 2, 1}};
}

TEST(PairSums, EqualPlainLoops) {
  Draw draw(20);
  for (const int n : {1, 2, 3, 4, 5, 6, 7, 8, 9, 17, 100, 8191, 8192, 8193, 8194, 20001}) {
    const Cloud cloud = draw_cloud(n, {10, 9, 8}, 0, {draw.rotation(), {1, 2, 3}}, draw);
    Weights weights;
    for (int i = 0; i < n; ++i) weights.push_back(draw.uniform(0, 2));
    const double* const none = nullptr;
    for (const double* w : {none, static_cast<const double*>(weights.data())}) {
      const FloatPoints float_a = in_float(cloud.in_a);
      const FloatPoints float_b = in_float(cloud.in_b);
      const PairArrays<double> doubles = arrays_of<double>(cloud.in_a, cloud.in_b, w);
      const PairArrays<float> floats = arrays_of<float>(float_a, float_b, w);
      for (std::size_t rank = 0; orientation_kernels(rank); ++rank) {
        const OrientationKernels& kernels = *orientation_kernels(rank);
        expect_sums_near(kernels.sum_double(doubles), sum_pairs_plainly(doubles), n);
        expect_sums_near(kernels.sum_float(floats), sum_pairs_plainly(floats), n);
      }
    }
  }
}

}  // namespace
}  // namespace sightline
