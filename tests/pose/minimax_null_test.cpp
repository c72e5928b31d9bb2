// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/minimax_null.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "pose/minimax.h"
#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

constexpr double kSigmaPx = 0.5;
constexpr std::array kTails = {0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001};

struct NullDraws {
  std::vector<double> minimax;  ///< over sigma^2
  std::vector<double> ratios;   ///< Lambda
};

std::vector<Eigen::Vector3d> points_in_box(int n, Draw& draw) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < n; ++i) points.push_back(draw.in_box(0.5));
  return points;
}

/// The simulation of the tables: `points_of` gives the target of each draw.
template <typename PointsOf>
NullDraws null_draws(int count, Draw& draw, const PointsOf& points_of) {
  NullDraws draws;
  for (int i = 0; i < count; ++i) {
    Synthetic s = exact_problem(centred_camera(512, 512, 15000), points_of(draw),
                                {draw.rotation(), {0, 0, 100}});
    add_noise(s.problem, kSigmaPx, draw);
    const Correspondences c = prepare(s.problem).correspondences;
    const Minimax all = minimax_from({c, {}, {}}, to_centred(s.cam_from_target, c));
    if (all.status != PoseStatus::kOk) continue;
    draws.minimax.push_back(all.largest_px2 / (kSigmaPx * kSigmaPx));
    if (c.size() <= 4) continue;
    std::vector<int> kept(c.size());
    std::iota(kept.begin(), kept.end(), 0);
    kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(all.most_binding()));
    const Minimax less = minimax_from({c, kept, {}}, all.cam_from_centred);
    if (less.status == PoseStatus::kOk && less.largest_px2 > 0) {
      draws.ratios.push_back(all.largest_px2 / less.largest_px2);
    }
  }
  return draws;
}

double part_above(const std::vector<double>& draws, double value) {
  const auto above = std::count_if(draws.begin(), draws.end(), [&](double x) { return x > value; });
  return static_cast<double>(above) / static_cast<double>(draws.size());
}

/// Five standard deviations of the part of so many draws, and what the table itself errs.
double allowance(double tail, std::size_t draws) {
  constexpr double kTableError = 0.05;
  return 5 * std::sqrt(tail / static_cast<double>(draws)) + kTableError * tail;
}

TEST(MinimaxNull, EntriesAreWhatTheSimulationGives) {
  constexpr int kDraws = 6000;
  Draw draw(1);
  for (const int n : {5, 8, 12}) {
    const NullDraws draws = null_draws(kDraws, draw, [n](Draw& d) { return points_in_box(n, d); });
    ASSERT_GT(draws.ratios.size(), 0.99 * kDraws);
    for (const double tail : {0.1, 0.03, 0.01}) {
      const double allowed = allowance(tail, draws.minimax.size());
      const auto points = static_cast<std::size_t>(n);
      EXPECT_NEAR(part_above(draws.minimax, minimax_quantile(points, tail)), tail, allowed)
          << n << " points";
      EXPECT_NEAR(part_above(draws.ratios, minimax_ratio_quantile(points, tail)), tail, allowed)
          << n << " points";
    }
  }
}

TEST(MinimaxNull, HoldsForACubeToo) {
  constexpr int kDraws = 6000;
  constexpr double kOtherTarget = 0.4;  // of the tail: a tenth of the quantile
  Draw draw(2);
  const NullDraws draws = null_draws(kDraws, draw, [](Draw&) { return cube_vertices(); });
  for (const double tail : {0.1, 0.01}) {
    const double allowed = allowance(tail, draws.minimax.size()) + kOtherTarget * tail;
    EXPECT_NEAR(part_above(draws.minimax, minimax_quantile(8, tail)), tail, allowed);
    EXPECT_NEAR(part_above(draws.ratios, minimax_ratio_quantile(8, tail)), tail, allowed);
  }
}

TEST(MinimaxNull, DoesNotHoldWithAnOutlier) {
  Draw draw(3);
  int above = 0;
  for (int i = 0; i < 100; ++i) {
    Synthetic s = cube_problem(kSigmaPx, draw);
    add_outlier(s.problem, 0, 20, draw);
    const Correspondences c = prepare(s.problem).correspondences;
    const Minimax m =
        minimax({c, {}, {}}, std::vector<Pose>{to_centred(s.cam_from_target, c)}, SolverOptions{});
    above += m.largest_px2 > kSigmaPx * kSigmaPx * minimax_quantile(8, 1e-3);
  }
  EXPECT_GE(above, 99);
}

TEST(MinimaxNull, ManyPointsAreExtrapolated) {
  constexpr int kDraws = 3000;
  constexpr double kExtrapolation = 0.5;  // of the tail
  Draw draw(4);
  const NullDraws draws = null_draws(kDraws, draw, [](Draw& d) { return points_in_box(32, d); });
  for (const double tail : {0.1, 0.02}) {
    const double allowed = allowance(tail, draws.minimax.size()) + kExtrapolation * tail;
    EXPECT_NEAR(part_above(draws.minimax, minimax_quantile(32, tail)), tail, allowed);
    EXPECT_LE(part_above(draws.ratios, minimax_ratio_quantile(32, tail)), tail + allowed);
  }
}

TEST(MinimaxNull, FallsWithTheTail) {
  for (std::size_t n = 4; n <= 40; ++n) {
    for (double tail = 1e-6; tail < 0.4; tail *= 1.1) {
      EXPECT_GT(minimax_quantile(n, tail), minimax_quantile(n, 1.1 * tail)) << n << " " << tail;
      if (n == 4) continue;
      EXPECT_GT(minimax_ratio_quantile(n, tail), minimax_ratio_quantile(n, 1.1 * tail));
      EXPECT_GE(minimax_ratio_quantile(n, tail), 1);
    }
  }
}

TEST(MinimaxNull, MorePointsHaveALargerMaximumAndSmallerRatio) {
  for (const double tail : {0.1, 0.01, 0.001}) {
    for (std::size_t n = 4; n < 20; ++n) {
      EXPECT_LT(minimax_quantile(n, tail), minimax_quantile(n + 1, tail));
      EXPECT_GE(minimax_ratio_quantile(n, tail), minimax_ratio_quantile(n + 1, tail));
    }
  }
}

TEST(MinimaxNull, FewPointsAndOddTails) {
  EXPECT_EQ(minimax_quantile(3, 0.01), 0);
  EXPECT_EQ(minimax_ratio_quantile(4, 0.01), kInfinity);
  for (const double tail : {-1.0, 0.0, kNaN}) {
    EXPECT_EQ(minimax_quantile(8, tail), minimax_quantile(8, 1e-6));
    EXPECT_EQ(minimax_ratio_quantile(8, tail), minimax_ratio_quantile(8, 1e-6));
  }
  EXPECT_EQ(minimax_quantile(8, 2), minimax_quantile(8, 0.5));
}

// Draws the tables of pose/minimax_null.cpp again; takes a minute.
TEST(MinimaxNull, DISABLED_PrintTheNullTables) {
  constexpr int kDraws = 150000;
  for (int n = 4; n <= 16; ++n) {
    Draw draw(static_cast<unsigned>(100 + n));
    NullDraws draws = null_draws(kDraws, draw, [n](Draw& d) { return points_in_box(n, d); });
    for (std::vector<double>* values : {&draws.minimax, &draws.ratios}) {
      if (values->empty()) continue;
      std::sort(values->begin(), values->end());
      std::printf("    {");
      for (const double tail : kTails) {
        const auto index =
            static_cast<std::size_t>((1 - tail) * static_cast<double>(values->size()));
        std::printf("%.4g%s", (*values)[index], tail == kTails.back() ? "" : ", ");
      }
      std::printf("},  // %d %s\n", n, values == &draws.minimax ? "minimax" : "Lambda");
    }
  }
}

}  // namespace
}  // namespace sightline
