// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The promise that every number of samples makes about edges and vertices, kept.
#include "renderer/edge_errors.h"

#include <cmath>

#include <gtest/gtest.h>

#include "renderer/sample_pattern.h"
#include "scenes/scene.h"

namespace sightline {
namespace {

class EdgeErrorsOf : public testing::TestWithParam<int> {};

TEST_P(EdgeErrorsOf, StayWithinThePromise) {
  const int samples = GetParam();
  Renderer renderer;
  const EdgeErrors measured = measure_edge_errors(renderer, samples, samples < 256 ? 25 : 5);
  const EdgeErrors promised = promised_edge_errors(samples);
  EXPECT_GT(measured.general_count, samples < 256 ? 100 : 15);
  EXPECT_LT(measured.general_px, promised.general_px);
  EXPECT_LT(measured.axis_px, promised.axis_px);
  EXPECT_LT(measured.vertex_px, promised.vertex_px);
  // The measurement can see errors of this size.
  EXPECT_GT(measured.general_px, promised.general_px / 10);
  EXPECT_GT(measured.axis_px, promised.axis_px / 3);
}

INSTANTIATE_TEST_SUITE_P(EverySampleCount, EdgeErrorsOf,
                         testing::ValuesIn(kSampleCounts.begin(), kSampleCounts.end()));

TEST(EdgeErrors, ThePromisesAreThoseAskedFor) {
  EXPECT_LE(promised_edge_errors(16).general_px, 0.005);
  EXPECT_LE(promised_edge_errors(64).general_px, 0.001);
  EXPECT_LE(promised_edge_errors(64).axis_px, 0.022);
}

TEST(EdgeErrors, AnAxisAlignedEdgeIsKnownToOneSampleInEach) {
  // No two samples share a column: uniform over 1 / count. 120 edges give the RMS to 10 %.
  Renderer renderer;
  const EdgeErrors measured = measure_edge_errors(renderer, 16, 30);
  EXPECT_EQ(measured.axis_count, 120);
  EXPECT_NEAR(measured.axis_px, 1 / (16 * std::sqrt(12.0)), 0.2 / (16 * std::sqrt(12.0)));
}

}  // namespace
}  // namespace sightline
