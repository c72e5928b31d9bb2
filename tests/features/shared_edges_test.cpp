// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What lines along edges say beyond the features that they made, and once each.
#include "features/shared_edges.h"

#include <array>
#include <cmath>
#include <utility>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "features/image_line.h"

namespace sightline {
namespace {

ImageLine line_with(double offset_sd, double slope_sd, double correlation) {
  ImageLine line;
  line.point = {100, 50};
  line.direction = Eigen::Vector2d(3, 4).normalized();
  const double mixed = correlation * offset_sd * slope_sd;
  line.covariance << offset_sd * offset_sd, mixed, mixed, slope_sd * slope_sd;
  return line;
}

// The information on offset and slope at the line's own point that an offset of that variance
// holds.
Eigen::Matrix2d information_of_offset(double along_px, double variance_px2) {
  const Eigen::Vector2d row(1, along_px);
  return row * row.transpose() / variance_px2;
}

TEST(BeyondOffset, WithTheOffsetItIsTheLine) {
  for (const double correlation : {-0.6, 0.0, 0.4}) {
    const ImageLine line = line_with(0.2, 0.01, correlation);
    const Eigen::Vector2d vertex = line.point + 40 * line.direction;
    const auto beyond = beyond_offset_at(line, vertex, 1000);
    ASSERT_TRUE(beyond);
    EXPECT_TRUE(std::isinf(beyond->covariance(1, 1)));
    const double place = line.direction.dot(beyond->point - line.point);
    const Eigen::Matrix2d both = information_of_offset(40, offset_variance_px2(line, vertex)) +
                                 information_of_offset(place, beyond->covariance(0, 0));
    EXPECT_LT((both * line.covariance - Eigen::Matrix2d::Identity()).norm(), 1e-9) << correlation;
  }
}

TEST(BeyondOffset, OfASlopeThatIsHardlyKnownIsNothing) {
  const ImageLine line = line_with(0.5, 0.001, 0);
  EXPECT_FALSE(beyond_offset_at(line, line.point + 10 * line.direction, 400));
}

// Two features at the ends of one edge, and a third beside them with an edge of its own.
Target target_of_one_edge() {
  Target target{.name = "edge",
                .description = "",
                .mesh = {},
                .cleaning = {},
                .features = {},
                .occluder = Occluder(Mesh{})};
  const Eigen::Vector3d a(0, 0, 0), b(1, 0, 0), c(0, 1, 0), far(0, 2, 0);
  for (const auto& [begin, end] : {std::pair(a, b), {b, a}, {c, far}}) {
    TargetFeature& feature = target.features.emplace_back();
    feature.position_m = begin;
    feature.edges = {{begin, end}};
  }
  return target;
}

// What the three features have: one line each, of these edge pixels.
std::vector<Observation> seen(ObservationStatus of_a, ObservationStatus of_b, double b_from_px) {
  std::vector<Observation> observations(3);
  const std::array begins = {0.0, b_from_px, 0.0};
  const std::array statuses = {of_a, of_b, ObservationStatus::kFound};
  for (size_t i = 0; i < 3; ++i) {
    observations[i].feature = static_cast<int>(i);
    observations[i].status = statuses[i];
    ImageLine line;
    line.point = {begins[i] + 15, 0};
    line.covariance(1, 1) = i == 0 ? 1e-6 : 2e-6;
    for (int k = 0; k <= 30; ++k) line.edge_pixels.emplace_back(begins[i] + k, 0);
    observations[i].edge_lines.push_back({0, line});
  }
  return observations;
}

std::array<size_t, 3> left_of(std::vector<Observation> observations) {
  drop_shared_lines(target_of_one_edge(), observations);
  return {observations[0].edge_lines.size(), observations[1].edge_lines.size(),
          observations[2].edge_lines.size()};
}

TEST(SharedEdges, CountOnce) {
  constexpr auto kFound = ObservationStatus::kFound;
  constexpr auto kNot = ObservationStatus::kParallelLines;
  using Left = std::array<size_t, 3>;
  EXPECT_EQ(left_of(seen(kFound, kFound, 20)), (Left{0, 0, 1}));
  EXPECT_EQ(left_of(seen(kFound, kNot, 20)), (Left{0, 1, 1}));
  EXPECT_EQ(left_of(seen(kNot, kFound, 20)), (Left{1, 0, 1}));
  EXPECT_EQ(left_of(seen(kNot, kNot, 20)), (Left{1, 0, 1})) << "the better of two that overlap";
  EXPECT_EQ(left_of(seen(kNot, kNot, 80)), (Left{1, 1, 1})) << "of other pixels";
}

// Its edge pixels lie more densely on one side, so that the line's point is not their middle.
TEST(ImageLineNoise, AtTheEndsOfALineIsWhatIsAddedThere) {
  ImageLine line;
  line.point = {30, 40};
  line.direction = Eigen::Vector2d(0.6, 0.8);
  for (const double along_px : {-20.0, -15.0, -10.0, 40.0}) {
    line.edge_pixels.push_back(line.point + along_px * line.direction);
  }
  line.covariance << 0.01, 1e-4, 1e-4, 1e-5;
  ImageLine noisy = line;
  add_noise_at_ends(0.3, noisy);
  for (const double along_px : {-20.0, 40.0}) {
    const Eigen::Vector2d end = line.point + along_px * line.direction;
    EXPECT_NEAR(offset_variance_px2(noisy, end) - offset_variance_px2(line, end), 0.09, 1e-12);
  }
  const Eigen::Vector2d middle = line.point + 10 * line.direction;
  EXPECT_NEAR(offset_variance_px2(noisy, middle) - offset_variance_px2(line, middle), 0.045, 1e-12);
}

}  // namespace
}  // namespace sightline
