// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/statistics/signed_rank.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "eval/statistics/bootstrap.h"
#include "eval/statistics/significance.h"
#include "scenes/random/random.h"

namespace sightline {
namespace {

constexpr double kRounding = 1e-12;

// Of 64 choices of signs one, and two, have so great a sum of ranks.
TEST(SignedRank, OfSixIsCountedByHand) {
  const std::vector<double> all_positive{0.1, 3, 2, 50, 0.4, 7};
  EXPECT_NEAR(p_middle_above_zero(all_positive), 1.0 / 64, kRounding);
  const std::vector<double> least_negative{-0.1, 3, 2, 50, 0.4, 7};
  EXPECT_NEAR(p_middle_above_zero(least_negative), 2.0 / 64, kRounding);
  const std::vector<double> all_negative{-1, -2, -3, -4, -5, -6};
  EXPECT_NEAR(p_middle_above_zero(all_negative), 1, kRounding);
}

TEST(SignedRank, LeavesZerosOutAndSharesTheRanksOfTies) {
  // Three of rank 2 each, of which two are positive: at least two of three, 4 of 8.
  const std::vector<double> ties{1, 0, 1, -1, 0, 0};
  EXPECT_NEAR(p_middle_above_zero(ties), 0.5, kRounding);
  EXPECT_EQ(p_middle_above_zero(std::vector<double>(9, 0.0)), 1);
  EXPECT_EQ(p_middle_above_zero({}), 1);
}

TEST(SignedRank, AnOutlierHasARankAndNoMore) {
  std::vector<double> differences;
  for (int i = 0; i < 40; ++i) differences.push_back(0.01 + 0.001 * i);
  differences.push_back(-1e6);
  EXPECT_LT(p_middle_above_zero(differences), 1e-6);
  EXPECT_GT(p_mean_above_zero(differences), 0.5) << "which the mean does not notice";
  differences.back() = -std::numeric_limits<double>::infinity();
  EXPECT_LT(p_middle_above_zero(differences), 1e-6);
}

// The sum's law by drawing signs, for as many differences as the normal law is taken of.
TEST(SignedRank, OfManyIsAsOftenExceededAsItSays) {
  constexpr int kCount = 60;
  constexpr int kDraws = 20'000;
  RandomStream random(1, "signed rank", 0);
  std::vector<double> differences;
  double observed = 0;
  for (int i = 1; i <= kCount; ++i) {
    const bool is_positive = random.uniform() < 0.62;
    differences.push_back(is_positive ? i : -i);
    observed += is_positive ? i : 0;
  }
  int as_great = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    double sum = 0;
    for (int i = 1; i <= kCount; ++i) sum += random.uniform() < 0.5 ? i : 0;
    as_great += sum >= observed;
  }
  const double share = static_cast<double>(as_great) / kDraws;
  const double chance = 4 * std::sqrt(share * (1 - share) / kDraws);
  EXPECT_GT(share, 0.001) << "or there is nothing to compare";
  EXPECT_NEAR(p_middle_above_zero(differences), share, chance + 0.001);
}

// Without a change one in twenty is below 5 %: of 2000 at most 4 standard deviations more.
TEST(SignedRank, KeepsItsLevel) {
  constexpr int kTests = 2000;
  RandomStream random(2, "level", 0);
  int rejected = 0;
  for (int test = 0; test < kTests; ++test) {
    std::vector<double> differences;
    for (int i = 0; i < 30; ++i) differences.push_back(std::pow(random.normal(), 3));
    rejected += p_middle_above_zero(differences) < 0.05;
  }
  EXPECT_LT(rejected, 0.05 * kTests + 4 * std::sqrt(0.05 * 0.95 * kTests));
  EXPECT_GT(rejected, 0.02 * kTests) << "and it does reject";
}

TEST(Middle, IsTheMedianOfTheMeansOfPairs) {
  // 1, 1.5, 2, 2.5, 3, 4.
  EXPECT_DOUBLE_EQ(middle_of(std::vector<double>{4, 1, 2}).value, 2.25);
  EXPECT_TRUE(std::isnan(middle_of(std::vector<double>{4, 1, 2}).ci95[0]));
  EXPECT_TRUE(std::isnan(middle_of({}).value));
  EXPECT_EQ(middle_of(std::vector<double>(8, 0.3)).ci95[0], 0.3);
}

// All means listed and sorted; of twenty the ranks are 53 and 158 of 210 (Hollander, Wolfe and
// Chicken 2014, table A.4: T+ at most 52 has a chance of 0.024).
TEST(Middle, HasTheEndsOfTheListedMeans) {
  RandomStream random(3, "middle", 0);
  std::vector<double> values;
  for (int i = 0; i < 20; ++i) values.push_back(random.normal());
  std::vector<double> means;
  for (size_t i = 0; i < values.size(); ++i) {
    for (size_t j = i; j < values.size(); ++j) means.push_back((values[i] + values[j]) / 2);
  }
  std::sort(means.begin(), means.end());
  const Measured middle = middle_of(values);
  EXPECT_NEAR(middle.value, (means[104] + means[105]) / 2, kRounding);
  EXPECT_NEAR(middle.ci95[0], means[52], kRounding);
  EXPECT_NEAR(middle.ci95[1], means[157], kRounding);
}

TEST(McNemarOfMore, CountsOneTail) {
  EXPECT_NEAR(mcnemar_p_of_more(1, 3), 5.0 / 16, kRounding);
  EXPECT_NEAR(mcnemar_p_of_more(3, 1), 15.0 / 16, kRounding);
  EXPECT_EQ(mcnemar_p_of_more(0, 0), 1);
}

// Of a mean the interval is the normal law's: for 400 values within 10 % of its width.
TEST(BootstrapInterval, OfAMeanIsThatOfTheNormalLaw) {
  RandomStream random(4, "bootstrap", 0);
  std::vector<double> values;
  double sum = 0;
  double squares = 0;
  for (int i = 0; i < 400; ++i) {
    values.push_back(random.normal());
    sum += values.back();
    squares += values.back() * values.back();
  }
  const double mean = sum / 400;
  const double half = 1.96 * std::sqrt((squares / 400 - mean * mean) / 400);
  const auto mean_of_drawn = [&](std::span<const uint32_t> drawn) {
    double total = 0;
    for (const uint32_t index : drawn) total += values[index];
    return total / static_cast<double>(drawn.size());
  };
  const Interval95 interval = bootstrap_interval(values.size(), 1, "mean", mean_of_drawn);
  EXPECT_NEAR(interval[0], mean - half, 0.2 * half);
  EXPECT_NEAR(interval[1], mean + half, 0.2 * half);
  EXPECT_EQ(interval, bootstrap_interval(values.size(), 1, "mean", mean_of_drawn));
  EXPECT_TRUE(std::isnan(bootstrap_interval(1, 1, "one", mean_of_drawn)[0]));
  const auto nothing = [](std::span<const uint32_t>) { return kNoNumber; };
  EXPECT_TRUE(std::isnan(bootstrap_interval(9, 1, "none", nothing)[0]));
}

}  // namespace
}  // namespace sightline
