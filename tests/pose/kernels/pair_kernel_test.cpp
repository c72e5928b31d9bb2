// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/kernels/pair_kernel.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

kernel::PairRows draw_rows(std::size_t n, Draw& draw) {
  kernel::PairRows rows;
  kernel::resize(rows, n);
  for (std::size_t k = 0; k < n; ++k) {
    for (std::vector<float>* row : {&rows.ax, &rows.ay, &rows.az, &rows.bx, &rows.by, &rows.bz}) {
      (*row)[k] = static_cast<float>(draw.uniform(-1, 1));
    }
    rows.v[k] = static_cast<float>(draw.uniform(0.5, 2));
  }
  return rows;
}

Eigen::Vector3d a_of(const kernel::PairRows& rows, std::size_t k) {
  return {rows.ax[k], rows.ay[k], rows.az[k]};
}

Eigen::Vector3d b_of(const kernel::PairRows& rows, std::size_t k) {
  return {rows.bx[k], rows.by[k], rows.bz[k]};
}

TEST(PairKernel, TestsEveryPairOfTheWindowAndNothingElse) {
  Draw draw(110);
  for (const std::size_t n : {1u, 15u, 16u, 17u, 100u, 1000u}) {
    const kernel::PairRows rows = draw_rows(n, draw);
    const kernel::PairTest test = {
        .scale = 1.2f, .tolerance2 = 0.05f, .spread = 0.3f, .least_length2 = 0.2f};
    const kernel::PairWindow window = n < 40 ? kernel::all_of(rows) : kernel::PairWindow{16, 48};
    std::vector<int> flags, found;
    kernel::compatible_pairs(rows, window, kernel::pivot_at(rows, 0), test, flags, found);
    std::vector<int> expected;
    for (std::size_t k = window.begin; k < std::min(n, window.begin + window.size); ++k) {
      const double length_a = (a_of(rows, k) - a_of(rows, 0)).norm();
      const double length_b = (b_of(rows, k) - b_of(rows, 0)).norm();
      const double allowed = 0.05 * (rows.v[k] + rows.v[0] + 0.3 * length_a * length_a);
      const double difference = length_b - 1.2 * length_a;
      if (length_a * length_a >= 0.2 && difference * difference <= allowed) {
        expected.push_back(static_cast<int>(k));
      }
    }
    EXPECT_EQ(found, expected) << n;
    if (n >= 40) continue;
    EXPECT_EQ(kernel::count_compatible(rows, kernel::pivot_at(rows, 0), test),
              static_cast<int>(expected.size()));
  }
}

TEST(PairKernel, ScoresWhatAMapBringsTogether) {
  Draw draw(111);
  for (const std::size_t n : {1u, 16u, 33u, 1000u}) {
    const kernel::PairRows rows = draw_rows(n, draw);
    const kernel::PairMap map = {{0, -1, 0, 0.1f, 1, 0, 0, 0.2f, 0, 0, 1, 0.3f}};
    double expected = 0;
    for (std::size_t k = 0; k < n; ++k) {
      const Eigen::Vector3d a = a_of(rows, k);
      const Eigen::Vector3d mapped(-a.y() + 0.1f, a.x() + 0.2f, a.z() + 0.3f);
      const double r2 = (mapped - b_of(rows, k)).squaredNorm();
      expected += std::max(0.0, 1 - r2 / (0.5 * rows.v[k]));
    }
    EXPECT_NEAR(kernel::consensus_score(rows, kernel::all_of(rows), map, 0.5f), expected,
                1e-5 * (1 + expected));
  }
}

TEST(PairKernel, GathersWithFillingThatNothingAdmits) {
  Draw draw(112);
  const kernel::PairRows rows = draw_rows(50, draw);
  kernel::PairRows some;
  kernel::gather(rows, {3, 40, 7}, some);
  EXPECT_EQ(some.n, 3u);
  EXPECT_EQ(some.padded_size(), kernel::kPairLanes);
  EXPECT_EQ(a_of(some, 1), a_of(rows, 40));
  const kernel::PairTest everything = {.tolerance2 = 1e6f};
  EXPECT_EQ(kernel::count_compatible(some, kernel::pivot_at(some, 0), everything), 3);
}

}  // namespace
}  // namespace sightline
