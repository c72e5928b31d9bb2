// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The promise that every number of samples makes about edges and vertices, kept.
#include "renderer/edge_errors.h"

#include <cmath>

#include <gtest/gtest.h>

#include "renderer/sample_pattern.h"
#include "scenes/builders/cube.h"
#include "scenes/scene/scene.h"

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

// Errors, root mean square, of the two edges of a cube's face that run this way.
double errors_along_px(int samples, const Eigen::Vector2d& way) {
  constexpr int kPlaces = 40;
  Target cube{"cube", "", build_cube().mesh, {}, {}, Occluder({})};
  for (Part& part : cube.mesh.parts) part.albedo = 1;
  Scene scene;
  scene.target = std::make_shared<const Target>(std::move(cube));
  scene.light.ambient = 1;
  scene.light.directional = 0;
  scene.background.level = 0;
  scene.samples_per_pixel = samples;
  scene.cam_from_target.rotation = rotation_from_vector({0, 0, std::atan2(way.y(), way.x())});
  Renderer renderer;
  RandomStream stream(1, "along rows", 0);
  double squares = 0;
  int count = 0;
  for (int i = 0; i < kPlaces; ++i) {
    scene.cam_from_target.translation = {stream.uniform(-0.1, 0.1), stream.uniform(-0.1, 0.1), 60};
    for (const OutlineEdge& edge : measure_outline(scene, renderer.render_linear(scene))) {
      const Eigen::Vector2d along = (edge.end - edge.begin).normalized();
      if (std::abs(along.dot(way.normalized())) < 0.9) continue;
      squares += edge.position_error_px * edge.position_error_px;
      ++count;
    }
  }
  EXPECT_EQ(count, 2 * kPlaces);
  return std::sqrt(squares / count);
}

// There all of an edge meets the same row of samples: uniform over the rows' distance. 80 edges
// give the RMS to 8 %. The README tells it.
TEST(EdgeErrors, AlongTheClosestSamplesAnEdgeIsKnownToTheirRowsDistance) {
  for (const int samples : {16, 64, 256}) {
    const SamplePattern& pattern = sample_pattern(samples);
    const Eigen::Vector2d closest(pattern.skewed_from_pixel[3], -pattern.skewed_from_pixel[2]);
    const double rows_px = 1 / closest.norm();
    const double along_px = errors_along_px(samples, closest);
    EXPECT_NEAR(along_px, rows_px / std::sqrt(12.0), 0.25 * rows_px / std::sqrt(12.0)) << samples;
    EXPECT_LT(errors_along_px(samples, {1, 0.37}), along_px / 3);
  }
}

}  // namespace
}  // namespace sightline
