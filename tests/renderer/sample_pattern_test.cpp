// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/sample_pattern.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "scenes/files/input_error.h"
#include "scenes/scene/scene.h"

namespace sightline {
namespace {

TEST(SamplePattern, NoTwoSamplesShareAColumnOrARow) {
  for (const int count : kSampleCounts) {
    const SamplePattern& pattern = sample_pattern(count);
    ASSERT_EQ(pattern.count, count);
    ASSERT_EQ(pattern.x.size(), static_cast<size_t>(count));
    for (const auto* offsets : {&pattern.x, &pattern.y}) {
      std::vector<float> sorted = *offsets;
      std::sort(sorted.begin(), sorted.end());
      for (int i = 0; i < count; ++i) {
        EXPECT_NEAR(sorted[i], (i + 0.5) / count - 0.5, 1e-7);
      }
    }
  }
}

TEST(SamplePattern, BeginsAtThePixelsCentre) {
  for (const int count : kSampleCounts) {
    const SamplePattern& pattern = sample_pattern(count);
    for (int k = 1; k < count; ++k) {
      EXPECT_GE(std::hypot(pattern.x[k], pattern.y[k]) + 1e-6,
                std::hypot(pattern.x[k - 1], pattern.y[k - 1]));
    }
  }
}

TEST(SamplePattern, TheSkewedImageHasEverySampleOnce) {
  for (const int count : kSampleCounts) {
    const SamplePattern& pattern = sample_pattern(count);
    const auto& m = pattern.skewed_from_pixel;
    EXPECT_EQ(m[0] * m[3] - m[1] * m[2], count);
    std::set<std::pair<int, int>> cells;
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 3; ++x) {
        for (int k = 0; k < count; ++k) {
          const double u = x + pattern.x[k] - pattern.first[0];
          const double v = y + pattern.y[k] - pattern.first[1];
          const double column = m[0] * u + m[1] * v;
          const double row = m[2] * u + m[3] * v;
          EXPECT_NEAR(column, std::round(column), 1e-4);
          EXPECT_NEAR(row, std::round(row), 1e-4);
          cells.emplace(std::lround(column), std::lround(row));
        }
      }
    }
    EXPECT_EQ(cells.size(), 9u * count);
  }
}

TEST(SamplePattern, OtherNumbersAreInputErrors) {
  for (const int count : {-1, 0, 2, 17, 512}) EXPECT_THROW(sample_pattern(count), InputError);
}

}  // namespace
}  // namespace sightline
