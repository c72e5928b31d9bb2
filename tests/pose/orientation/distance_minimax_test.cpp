// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "pose/orientation/orpe_limits.h"
#include "pose/orientation/orpe_minimax.h"
#include "tests/pose/matchers.h"
#include "tests/pose/orientation/wrong_pairs.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

using pair_consensus::PairSet;
using pair_consensus::Similarity;

struct Problem {
  PairSet set;
  std::vector<int> indices;
};

Problem draw_problem(int n, bool estimates_scale, Draw& draw) {
  const WrongPairs pairs = draw_wrong_pairs({.pairs = n, .sigma_m = 0.3}, draw);
  Weights weights;
  for (int i = 0; i < n; ++i) weights.push_back(draw.uniform(0.5, 2));
  Problem problem = {pair_consensus::prepare_pairs({pairs.in_a, pairs.in_b, weights},
                                                   {.estimates_scale = estimates_scale}),
                     std::vector<int>(static_cast<std::size_t>(n))};
  std::iota(problem.indices.begin(), problem.indices.end(), 0);
  return problem;
}

double largest_square(const PairSet& set, const Similarity& map) {
  double largest = 0;
  for (std::size_t k = 0; k < set.a.size(); ++k) {
    largest =
        std::max(largest, (map * set.a[k] - set.b[k]).squaredNorm() * set.inverse_variance[k]);
  }
  return largest;
}

TEST(DistanceMinimax, IsProvenByItsMultipliers) {
  Draw draw(100);
  for (const bool estimates_scale : {false, true}) {
    for (const int n : {4, 5, 8, 20, 200, 1000}) {
      for (int i = 0; i < (n > 100 ? 5 : 40); ++i) {
        const Problem problem = draw_problem(n, estimates_scale, draw);
        const auto minimax = minimise_largest_distance(problem.set, problem.indices);
        ASSERT_TRUE(minimax.has_value());
        EXPECT_DOUBLE_EQ(minimax->largest, largest_square(problem.set, minimax->map));
        EXPECT_LE(minimax->lower_bound, minimax->largest * (1 + 1e-9));
        EXPECT_GE(minimax->lower_bound, minimax->largest * (1 - 1e-5)) << n << estimates_scale;
        double sum = 0;
        for (const double multiplier : minimax->multipliers) {
          EXPECT_GE(multiplier, 0);
          sum += multiplier;
        }
        EXPECT_NEAR(sum, 1, 1e-12);
      }
    }
  }
}

TEST(DistanceMinimax, NoMapNearbyIsLower) {
  Draw draw(101);
  for (int i = 0; i < 50; ++i) {
    const Problem problem = draw_problem(12, false, draw);
    const auto minimax = minimise_largest_distance(problem.set, problem.indices);
    ASSERT_TRUE(minimax.has_value());
    for (int k = 0; k < 50; ++k) {
      Similarity other = minimax->map;
      const double size = std::pow(10.0, draw.uniform(-6, -1));
      other.rotation = rotation_from_vector(size * draw.vector()) * other.rotation;
      other.translation += size * draw.vector();
      EXPECT_GE(largest_square(problem.set, other), minimax->largest * (1 - 1e-5));
    }
    // The negative twin: least squares is lower than nothing, and higher than the minimax.
    const auto least_squares = pair_consensus::fit_pairs(problem.set, problem.indices);
    EXPECT_GT(largest_square(problem.set, *least_squares), minimax->largest);
  }
}

TEST(DistanceMinimax, TheFarthestPairBinds) {
  Draw draw(102);
  WrongPairs pairs = draw_wrong_pairs({.pairs = 30, .sigma_m = 0.01}, draw);
  pairs.in_b[7] += Eigen::Vector3d(0, 2, 0);
  const PairSet set = pair_consensus::prepare_pairs(pairs.points(), {});
  std::vector<int> indices(30);
  std::iota(indices.begin(), indices.end(), 0);
  const auto minimax = minimise_largest_distance(set, indices);
  ASSERT_TRUE(minimax.has_value());
  EXPECT_EQ(set.given_index[minimax->most_binding()], 7);
}

TEST(DistanceLimit, IsExceededAsOftenAsItSays) {
  Draw draw(103);
  for (const int pairs : {1, 10, 100}) {
    const double limit = squared_distance_limit(0.05, pairs);
    int exceeded = 0;
    constexpr int kDraws = 4000;
    for (int i = 0; i < kDraws; ++i) {
      double largest = 0;
      for (int k = 0; k < pairs; ++k) largest = std::max(largest, draw.vector().squaredNorm());
      exceeded += largest > limit;
    }
    EXPECT_NEAR(exceeded, 0.05 * kDraws, 5 * std::sqrt(0.05 * kDraws)) << pairs;
  }
  EXPECT_NEAR(squared_distance_limit(0.01, 1), 11.345, 1e-3);  // of tables of chi-square
}

}  // namespace
}  // namespace sightline
