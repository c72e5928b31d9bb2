// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/peak_fit.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

// All peaks are expected at one offset, which is their mean.
class OneOffset : public PeakModel {
 public:
  explicit OneOffset(double start_px) : offset_px(start_px) {}

  double expected_px(size_t) const override { return offset_px; }

  bool move_to(const std::vector<ChosenPeak>& peaks) override {
    offset_px = 0;
    for (const ChosenPeak& chosen : peaks) {
      offset_px += chosen.peak.offset_px / static_cast<double>(peaks.size());
    }
    return is_held;
  }

  double offset_px;
  bool is_held = true;
};

// Samples with an edge at 3 px and clutter elsewhere; of the last few nothing but clutter.
std::vector<EdgePeaks> samples(size_t count, size_t without_edge) {
  std::vector<EdgePeaks> all(count);
  for (size_t i = 0; i < count; ++i) {
    all[i].add({-4 + 0.1 * static_cast<double>(i), 9});
    if (i + without_edge < count) all[i].add({i % 2 == 0 ? 2.9 : 3.1, i % 2 == 0 ? 16.0 : -48.0});
    all[i].add({9, 5});
  }
  return all;
}

TEST(PeakFit, TheNearestPeaksMoveTheModelOntoTheEdge) {
  OneOffset model(2);
  const auto chosen = fit_to_peaks(samples(20, 0), 4, model);
  ASSERT_TRUE(chosen.has_value());
  EXPECT_EQ(chosen->size(), 20u);
  EXPECT_NEAR(model.offset_px, 3, 1e-12);
  for (const ChosenPeak& peak : *chosen) EXPECT_NEAR(peak.peak.offset_px, 3, 0.11);
  // Peaks of either sign count by their height.
  EXPECT_NEAR(mean_contrast_grey(*chosen), 32 / kGradientOfUnitEdge, 1e-9);
}

TEST(PeakFit, SamplesWithoutAPeakNearAreLeftOut) {
  OneOffset model(3.5);
  const auto chosen = fit_to_peaks(samples(20, 10), 4, model);
  ASSERT_TRUE(chosen.has_value());
  ASSERT_EQ(chosen->size(), 10u);
  for (size_t i = 0; i < 10; ++i) EXPECT_EQ((*chosen)[i].sample, i);
}

TEST(PeakFit, TooFewPeaksAreNone) {
  OneOffset model(3);
  EXPECT_FALSE(fit_to_peaks(samples(20, 13), 4, model).has_value());  // 35 %
  EXPECT_TRUE(fit_to_peaks(samples(20, 12), 4, model).has_value());   // 40 %
  EXPECT_FALSE(fit_to_peaks(samples(20, 12), 9, model).has_value());
  OneOffset far(6);
  EXPECT_FALSE(fit_to_peaks(samples(20, 0), 4, far).has_value());
}

TEST(PeakFit, WhatPeaksDoNotHoldIsNone) {
  OneOffset model(3);
  model.is_held = false;
  EXPECT_FALSE(fit_to_peaks(samples(20, 0), 4, model).has_value());
}

// 0.2 px is what a measurement is taken for, and three samples make one.
TEST(PeakFit, WhatIsKnownBeforehandWeighsAsItsSigmaSays) {
  EXPECT_NEAR(known_beforehand(0.2), kSamplesOfOne, 1e-12);
  EXPECT_NEAR(known_beforehand(0.4), kSamplesOfOne / 4, 1e-12);
}

}  // namespace
}  // namespace sightline
