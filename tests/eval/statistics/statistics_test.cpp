// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/statistics/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "eval/statistics/bootstrap.h"
#include "eval/statistics/error_statistics.h"
#include "eval/statistics/rms_ratio.h"
#include "eval/statistics/significance.h"
#include "scenes/random/random.h"

namespace sightline {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kCap = 20;

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

TEST(NormalCdf, HasPublishedValues) {
  EXPECT_DOUBLE_EQ(normal_cdf(0), 0.5);
  EXPECT_NEAR(normal_cdf(1), 0.8413447460685429, 1e-15);
  EXPECT_NEAR(normal_cdf(-6), 9.865876450376946e-10, 1e-23);
}

TEST(NormalQuantile, HasPublishedValues) {
  constexpr double kPromised = 1e-14;
  EXPECT_EQ(normal_quantile(0.5), 0);
  EXPECT_NEAR(normal_quantile(0.975), 1.959963984540054, kPromised);
  EXPECT_NEAR(normal_quantile(0.995), 2.5758293035489004, kPromised);
  EXPECT_NEAR(normal_quantile(0.01), -2.3263478740408408, kPromised);
  EXPECT_NEAR(normal_quantile(1e-10), -6.361340902404056, kPromised);
}

TEST(NormalQuantile, InvertsTheDistributionFunction) {
  for (double z = -8; z <= 0; z += 0.01) {
    EXPECT_NEAR(normal_quantile(normal_cdf(z)), z, 1e-13) << z;
  }
}

// Type 7 puts the p-th fraction at position (n - 1) p: R's quantile() and NumPy's default.
TEST(Percentile, IsLinearBetweenOrderStatistics) {
  const std::vector<double> values{40, 10, 30, 20};
  EXPECT_EQ(percentile(values, 0), 10);
  EXPECT_EQ(percentile(values, 0.5), 25);
  EXPECT_EQ(percentile(values, 0.25), 17.5);
  EXPECT_NEAR(percentile(values, 0.9), 37, 1e-12);
  EXPECT_EQ(percentile(values, 1), 40);
}

TEST(Percentile, OfOneValueIsThatValue) {
  const std::vector<double> values{7};
  for (const double p : {0.0, 0.3, 1.0}) EXPECT_EQ(percentile(values, p), 7);
}

TEST(Percentile, IsInfiniteBesideAnInfiniteValueAndFiniteOnTheFiniteOne) {
  const std::vector<double> values{1, 2, kInfinity, kInfinity, kInfinity};
  EXPECT_EQ(percentile(values, 0.25), 2);
  EXPECT_EQ(percentile(values, 0.3), kInfinity);
  EXPECT_EQ(percentile(values, 0.9), kInfinity);
}

TEST(Percentile, OfNothingIsNoNumber) {
  EXPECT_TRUE(std::isnan(percentile({}, 0.5)));
}

TEST(BcaMeanInterval, OfEqualValuesIsThatPoint) {
  const std::vector<double> values(10, 0.1);
  const auto interval = bca_mean_interval(values, 1, "equal");
  EXPECT_EQ(interval[0], 0.1);
  EXPECT_EQ(interval[1], 0.1);
}

TEST(BcaMeanInterval, OfNothingIsNoNumber) {
  const auto interval = bca_mean_interval({}, 1, "nothing");
  EXPECT_TRUE(std::isnan(interval[0]));
  EXPECT_TRUE(std::isnan(interval[1]));
}

TEST(BcaMeanInterval, OfOneValueIsNoNumber) {
  const std::vector<double> one = {0.3};
  EXPECT_TRUE(std::isnan(bca_mean_interval(one, 1, "one")[0]));
}

TEST(BcaMeanInterval, RepeatsWithItsStreamAndVariesWithSeedAndName) {
  const std::vector<double> values{0.2, 0.5, 0.9, 1.4, 2.2, 3.7};
  const auto interval = bca_mean_interval(values, 1, "a");
  EXPECT_EQ(interval, bca_mean_interval(values, 1, "a"));
  EXPECT_NE(interval, bca_mean_interval(values, 2, "a"));
  EXPECT_NE(interval, bca_mean_interval(values, 1, "b"));
}

// The bootstrap without chance: the means of all n^n resamples, and the jackknife by leaving out.
class ExactBca {
 public:
  explicit ExactBca(std::vector<double> values) : values_(std::move(values)) {
    add_means(0, 0);
    std::sort(means_.begin(), means_.end());
    bias_ = normal_quantile(fraction_below(mean_of(values_)));
    acceleration_ = jackknife_acceleration();
  }

  // The end of the interval where the bias correction is off by `bias_error` and the resulting
  // fraction by `fraction_error`.
  double end(double z, double bias_error, double fraction_error) const {
    const double bias = bias_ + bias_error;
    const double fraction = normal_cdf(bias + (bias + z) / (1 - acceleration_ * (bias + z)));
    return percentile(means_, std::clamp(fraction + fraction_error, 0.0, 1.0));
  }

  double fraction_below(double mean) const {
    double count = 0;
    for (const double m : means_) count += m < mean - 1e-12 ? 1 : m < mean + 1e-12 ? 0.5 : 0;
    return count / static_cast<double>(means_.size());
  }

 private:
  void add_means(size_t drawn, double sum) {
    if (drawn == values_.size()) {
      means_.push_back(sum / static_cast<double>(values_.size()));
      return;
    }
    for (const double value : values_) add_means(drawn + 1, sum + value);
  }

  double jackknife_acceleration() const {
    std::vector<double> without;
    for (size_t i = 0; i < values_.size(); ++i) {
      std::vector<double> rest = values_;
      rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
      without.push_back(mean_of(rest));
    }
    double squares = 0, cubes = 0;
    for (const double mean : without) {
      squares += std::pow(mean_of(without) - mean, 2);
      cubes += std::pow(mean_of(without) - mean, 3);
    }
    return cubes / (6 * std::pow(squares, 1.5));
  }

  std::vector<double> values_;
  std::vector<double> means_;
  double bias_ = 0;
  double acceleration_ = 0;
};

TEST(BcaMeanInterval, AgreesWithTheExactBootstrapOfAllResamples) {
  const std::vector<double> values{0.1, 0.3, 0.4, 0.9, 1.7, 6.0};
  const ExactBca exact(values);
  const auto interval = bca_mean_interval(values, 5, "skewed");
  // What 2000 resamples leave to chance, four standard deviations of it: of the bias correction,
  // and of a fraction near the ends (0.001 to 0.1).
  const double bias_error = 4 * std::sqrt(0.25 / 2000) / 0.4;
  const double fraction_error = 4 * std::sqrt(0.04 / 2000);
  EXPECT_GE(interval[0], exact.end(-1.96, -bias_error, -fraction_error));
  EXPECT_LE(interval[0], exact.end(-1.96, bias_error, fraction_error));
  EXPECT_GE(interval[1], exact.end(1.96, -bias_error, -fraction_error));
  EXPECT_LE(interval[1], exact.end(1.96, bias_error, fraction_error));
  // The long tail is to the right, so both ends lie higher than the plain percentiles.
  EXPECT_GT(exact.fraction_below(interval[0]), 0.03);
  EXPECT_GT(exact.fraction_below(interval[1]), 0.98);
}

// Errors are positive and skewed; the exponential law stands for them.
double coverage_of_exponential_mean(double claimed_mean) {
  constexpr int kSets = 400;
  constexpr int kValues = 30;
  int covered = 0;
  for (int set = 0; set < kSets; ++set) {
    RandomStream random(11, "exponential", set);
    std::vector<double> values(kValues);
    for (double& value : values) value = -std::log(random.uniform());
    const auto [low, high] = bca_mean_interval(values, set, "coverage");
    covered += low <= claimed_mean && claimed_mean <= high;
  }
  return static_cast<double>(covered) / kSets;
}

TEST(BcaMeanInterval, CoversTheTrueMeanAsOftenAsItSays) {
  // BCa undercovers a little at 30 values of a skewed law; 400 sets leave a deviation of 0.011.
  const double coverage = coverage_of_exponential_mean(1);
  EXPECT_GT(coverage, 0.90);
  EXPECT_LT(coverage, 0.98);
  EXPECT_LT(coverage_of_exponential_mean(1.6), 0.5) << "an interval that covers anything";
}

TEST(BcaMeanInterval, OfManySymmetricValuesIsTheNormalInterval) {
  // 0 and 1 in equal parts: the standard deviation is n / (n - 1) / 4, squared.
  std::vector<double> values(40000);
  for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(i % 2);
  const auto interval = bca_mean_interval(values, 1, "many");
  const double half_width = 1.959963984540054 * 0.5 / std::sqrt(39999.0);
  EXPECT_NEAR(interval[0], 0.5 - half_width, 1e-12);
  EXPECT_NEAR(interval[1], 0.5 + half_width, 1e-12);
}

// Errors as studies have them: skewed, and a few in a hundred at the cap.
std::vector<double> skewed_errors(size_t count, uint64_t set) {
  RandomStream random(12, "skewed", set);
  std::vector<double> values(count);
  for (double& value : values) {
    value = random.uniform() < 0.02 ? kCap : -std::log(random.uniform());
  }
  return values;
}

TEST(BcaMeanInterval, IsContinuousWhereTheAnalyticFormTakesOver) {
  // What 2000 resamples leave to chance, at four standard deviations: as in the exact test, a bias
  // correction off by 0.11, which counts twice, and a fraction off by 0.014, which is 0.24 standard
  // errors at the ends; 1.96 of which are half a width.
  const double tolerance = std::hypot(2 * 0.11, 0.24) / 1.96;
  for (uint64_t set = 0; set < 20; ++set) {
    std::vector<double> values = skewed_errors(500, set);
    const auto resampled = bca_mean_interval(values, set, "border");
    values.push_back(mean_of(values));
    const auto analytic = bca_mean_interval(values, set, "border");
    const double half_width = (analytic[1] - analytic[0]) / 2;
    EXPECT_NEAR(resampled[0], analytic[0], tolerance * half_width) << set;
    EXPECT_NEAR(resampled[1], analytic[1], tolerance * half_width) << set;
    // The tail is to the right, and so is more of the interval: no normal interval.
    EXPECT_GT(analytic[1] - mean_of(values), 1.1 * (mean_of(values) - analytic[0])) << set;
  }
}

TEST(BcaMeanInterval, OfManyValuesCoversTheTrueMeanAsOftenAsItSays) {
  constexpr int kSets = 400;
  const double true_mean = 0.02 * kCap + 0.98;
  int covered = 0;
  for (uint64_t set = 0; set < kSets; ++set) {
    const auto [low, high] = bca_mean_interval(skewed_errors(1000, 100 + set), set, "covered");
    covered += low <= true_mean && true_mean <= high;
  }
  // 400 sets leave a deviation of 0.011.
  EXPECT_NEAR(static_cast<double>(covered) / kSets, 0.95, 0.04);
}

TEST(Summarise, OfFiniteErrorsBelowTheCapIsThePlainStatistics) {
  const std::vector<double> errors{3, 1, 2, 4};
  const ErrorSummary summary = summarise(errors, kCap, 1, "plain");
  EXPECT_DOUBLE_EQ(summary.mean, 2.5);
  EXPECT_DOUBLE_EQ(summary.rms, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(summary.median, 2.5);
  EXPECT_DOUBLE_EQ(summary.p90, 3.7);
  EXPECT_EQ(summary.capped, 0);
  EXPECT_LT(summary.mean_ci95[0], 2.5);
  EXPECT_GT(summary.mean_ci95[1], 2.5);
}

TEST(Summarise, CountsAFailureAsTheCapInTheMeanAndInfiniteInThePercentiles) {
  const std::vector<double> errors{1, kInfinity, 3, 25};
  const ErrorSummary summary = summarise(errors, kCap, 1, "failures");
  EXPECT_DOUBLE_EQ(summary.mean, (1 + 20 + 3 + 20) / 4.0);
  EXPECT_DOUBLE_EQ(summary.rms, std::sqrt((1 + 400 + 9 + 400) / 4.0));
  EXPECT_DOUBLE_EQ(summary.median, 14) << "an error beyond the cap is what it is in percentiles";
  EXPECT_EQ(summary.p90, kInfinity);
  EXPECT_EQ(summary.capped, 2);
}

TEST(Summarise, HasAnInfiniteMedianWhereHalfFailed) {
  EXPECT_EQ(summarise(std::vector{1.0, kInfinity}, kCap, 1, "half").median, kInfinity);
  EXPECT_EQ(summarise(std::vector{1.0, 2.0, kInfinity}, kCap, 1, "third").median, 2);
}

TEST(Summarise, TakesNoNumberForAFailure) {
  const ErrorSummary summary = summarise(std::vector{1.0, 1.0, kNaN}, kCap, 1, "nan");
  EXPECT_DOUBLE_EQ(summary.mean, 22.0 / 3);
  EXPECT_EQ(summary.median, 1);
  EXPECT_EQ(summary.capped, 1);
}

TEST(Summarise, OfNothingIsNoNumber) {
  const ErrorSummary summary = summarise({}, kCap, 1, "nothing");
  for (const double number : {summary.mean, summary.median_ci95[0], summary.mean_ci95[0],
                              summary.mean_ci95[1], summary.median, summary.rms, summary.p90}) {
    EXPECT_TRUE(std::isnan(number));
  }
  EXPECT_EQ(summary.capped, 0);
}

// ---- Rates ----

// Newcombe, Statistics in Medicine 17 (1998) 857, table I, method 3.
TEST(WilsonInterval, HasPublishedValues) {
  const auto expect = [](int64_t count, int64_t trials, double low, double high) {
    const Interval95 interval = wilson_interval(count, trials);
    EXPECT_NEAR(interval[0], low, 5e-5) << count;
    EXPECT_NEAR(interval[1], high, 5e-5) << count;
  };
  expect(81, 263, 0.2553, 0.3662);
  expect(15, 148, 0.0624, 0.1605);
  expect(0, 20, 0, 0.1611);
  expect(1, 29, 0.0061, 0.1718);
  EXPECT_EQ(wilson_interval(20, 20)[1], 1);
  EXPECT_TRUE(std::isnan(wilson_interval(0, 0)[0]));
}

// Newcombe, Statistics in Medicine 17 (1998) 873, table II, method 10: MOVER of Wilson intervals.
TEST(DifferenceInterval, HasPublishedValues) {
  const auto of_rates = [](int64_t a, int64_t m, int64_t b, int64_t n) {
    return difference_interval(
        static_cast<double>(a) / static_cast<double>(m), wilson_interval(a, m),
        static_cast<double>(b) / static_cast<double>(n), wilson_interval(b, n));
  };
  EXPECT_NEAR(of_rates(48, 80, 56, 70)[0], 0.0524, 5e-5);
  EXPECT_NEAR(of_rates(48, 80, 56, 70)[1], 0.3339, 5e-5);
  EXPECT_NEAR(of_rates(3, 10, 9, 10)[0], 0.1705, 5e-5);
  EXPECT_NEAR(of_rates(3, 10, 9, 10)[1], 0.8090, 5e-5);
}

TEST(McNemar, IsTheBinomialTestOfTheDiscordantPairs) {
  EXPECT_DOUBLE_EQ(mcnemar_p(1, 8), 2 * (1 + 9) / 512.0);  // by hand
  EXPECT_DOUBLE_EQ(mcnemar_p(8, 1), mcnemar_p(1, 8));
  EXPECT_EQ(mcnemar_p(0, 0), 1);
  EXPECT_EQ(mcnemar_p(4, 4), 1);
  EXPECT_DOUBLE_EQ(mcnemar_p(0, 6), 2 / 64.0);
}

// Fisher's tea taster: Agresti, Categorical Data Analysis (2002), section 3.5.2.
TEST(FisherTest, HasThePublishedValue) {
  EXPECT_NEAR(fisher_p(3, 4, 1, 4), 34.0 / 70, 1e-12);
  EXPECT_NEAR(fisher_p(4, 4, 0, 4), 2.0 / 70, 1e-12);
  EXPECT_EQ(fisher_p(0, 10, 0, 20), 1);
  EXPECT_LT(fisher_p(0, 1'000'000, 40, 1'000'000), 1e-9);
}

TEST(Holm, StepsDown) {
  // R: p.adjust(c(0.01, 0.04, 0.03, 0.005), "holm")
  const std::vector<double> adjusted = holm_adjusted(std::vector{0.01, 0.04, 0.03, 0.005});
  const std::vector<double> expected{0.03, 0.06, 0.06, 0.02};
  for (size_t i = 0; i < expected.size(); ++i) EXPECT_DOUBLE_EQ(adjusted[i], expected[i]) << i;
  EXPECT_EQ(holm_adjusted(std::vector{0.6, 0.7}), (std::vector{1.0, 1.0}));
  EXPECT_TRUE(holm_adjusted({}).empty());
}

// ---- Percentiles ----

// The usual table of distribution-free intervals of a median: of 20 values the 6th to the 15th
// (95.9 %), of 6 the least to the greatest (96.9 %), of 5 none reaches 95 % (93.8 %).
TEST(QuantileRanks, AreThoseOfTheTable) {
  EXPECT_EQ(quantile_ranks(20, 0.5), (std::array<int64_t, 2>{5, 14}));
  EXPECT_EQ(quantile_ranks(6, 0.5), (std::array<int64_t, 2>{0, 5}));
  EXPECT_EQ(quantile_ranks(5, 0.5), (std::array<int64_t, 2>{-1, 5}));
  EXPECT_EQ(quantile_ranks(20, 0.9)[1], 20) << "20 values do not bound the 90th percentile above";
}

TEST(Summarise, HasIntervalsOfItsPercentiles) {
  std::vector<double> errors(20);
  std::iota(errors.begin(), errors.end(), 1.0);
  const ErrorSummary summary = summarise(errors, 100, 1, "ranks");
  EXPECT_EQ(summary.median_ci95, (Interval95{6, 15}));
  EXPECT_TRUE(std::isnan(summary.p90_ci95[1]));
  EXPECT_TRUE(std::isnan(summary.rms_ci95[0])) << "none holds";
}

// ---- Paired tests ----

// Darwin's maize: Fisher, The Design of Experiments (1935), section 21: of the 2^15 choices of
// signs, 863 give a sum as great as his 314.
TEST(PMeanAboveZero, IsFishersOfDarwinsMaize) {
  const std::vector<double> differences{49, -67, 8, 16, 6, 23, 28, 41, 14, 29, 56, 24, 75, 60, -48};
  EXPECT_DOUBLE_EQ(p_mean_above_zero(differences), 863 / 32768.0);
}

TEST(PMeanAboveZero, OfManyIsNearTheShareOfAllSigns) {
  std::vector<double> values = skewed_errors(17, 7);
  for (double& value : values) value -= 0.8;
  const double observed = std::accumulate(values.begin(), values.end(), 0.0);
  int as_great = 0;
  for (uint32_t signs = 0; signs < 1u << 17; ++signs) {
    double sum = 0;
    for (size_t i = 0; i < 17; ++i) sum += (signs >> i & 1) != 0 ? -values[i] : values[i];
    as_great += sum >= observed - 1e-9;
  }
  const double exact = as_great / static_cast<double>(1u << 17);
  EXPECT_GT(exact, 0.05);
  EXPECT_LT(exact, 0.95);
  EXPECT_NEAR(p_mean_above_zero(values), exact, 0.02);  // the sums of 17 are nearly normal
}

TEST(PMeanAboveZero, MakesNothingOfTwoTrialsOfManyThatFlip) {
  std::vector<double> differences(30, 0.0);
  EXPECT_EQ(p_mean_above_zero(differences), 1);
  differences[3] = differences[9] = 16;
  EXPECT_GT(p_mean_above_zero(differences), 0.05);
  for (size_t i = 10; i < 20; ++i) differences[i] = 16;
  EXPECT_LT(p_mean_above_zero(differences), 0.001) << "but of twelve";
  EXPECT_EQ(p_mean_above_zero({}), 1);
}

TEST(PMeanAboveZero, IsBelowALevelAsOftenAsThatLevelWhereNothingIsAbove) {
  constexpr int kSets = 2000;
  const auto rejection_rate = [](size_t count, double true_mean) {
    int rejected = 0;
    for (uint64_t set = 0; set < kSets; ++set) {
      RandomStream random(3, "null", set);
      std::vector<double> values(count);
      for (double& value : values) value = true_mean + random.normal();
      rejected += p_mean_above_zero(values) < 0.05;
    }
    return static_cast<double>(rejected) / kSets;
  };
  for (const size_t count : {size_t{10}, size_t{100}}) {
    // 2000 sets leave a deviation of 0.005; four of them.
    EXPECT_NEAR(rejection_rate(count, 0), 0.05, 0.02) << count;
    EXPECT_GT(rejection_rate(count, 1), 0.85) << count;
  }
}

// ---- Ratios and plans ----

TEST(RmsRatio, AgreesWithAHandComputedCase) {
  RmsRatio ratio;
  EXPECT_TRUE(std::isnan(ratio.value())) << "of none";
  ratio.add(1, 1);
  ratio.add(2, 1);
  EXPECT_DOUBLE_EQ(ratio.value(), std::sqrt(2.5));
}

TEST(TrialsFor, GoWithTheSquareOfTheWidth) {
  EXPECT_EQ(trials_for(0.0625, 100, 1, {0.875, 1.125}), 400);
  EXPECT_EQ(trials_for(0.125, 100, 1, {0.875, 1.125}), 100);
  EXPECT_FALSE(trials_for(0.05, 100, 0, {0, 0}));
  EXPECT_FALSE(trials_for(0.05, 1, 1, kNoInterval));
}

TEST(TrialsFor, ArePlannedRightFromAPilot) {
  // The exponential law has mean and deviation 1: (1.96 / 0.05)^2 values (Cochran 1977).
  std::vector<double> pilot(2000);
  RandomStream random(6, "pilot", 0);
  for (double& value : pilot) value = -std::log(random.uniform());
  const double mean = mean_of(pilot);
  const auto planned = trials_for(0.05, 2000, mean, bca_mean_interval(pilot, 1, "pilot"));
  ASSERT_TRUE(planned);
  EXPECT_NEAR(static_cast<double>(*planned), 1537, 0.15 * 1537);
}

// ---- Many values ----

TEST(ErrorStatistics, BeyondWhatItKeepsStaysRight) {
  constexpr size_t kCount = ErrorStatistics::kMostValuesKept + 20'000;
  std::vector<double> errors = skewed_errors(kCount, 9);
  errors[5] = 0;
  errors[7] = kInfinity;
  ErrorStatistics statistics(kCap);
  for (const double error : errors) statistics.add(error);
  const ErrorSummary summary = statistics.summary(1, "many");
  EXPECT_EQ(statistics.count(), static_cast<int64_t>(kCount));
  for (const double p : {0.001, 0.5, 0.9}) {
    EXPECT_NEAR(statistics.quantile(p) / percentile(errors, p), 1, 1.1e-3) << p;
  }
  EXPECT_EQ(summary.median, statistics.quantile(0.5));
  for (double& error : errors) error = std::min(error, kCap);
  const Interval95 interval = bca_mean_interval(errors, 1, "many");
  EXPECT_NEAR(summary.mean, mean_of(errors), 1e-12);
  EXPECT_NEAR(summary.mean_ci95[0], interval[0], 1e-9);
  // One more of the greatest is a hundred-thousandth of the capped errors' range.
  EXPECT_NEAR(summary.mean_ci95[1], interval[1], 2 * kCap / kCount);
  EXPECT_LT(summary.median_ci95[0], summary.median);
  EXPECT_GT(summary.median_ci95[1], summary.median);
}

}  // namespace
}  // namespace sightline
