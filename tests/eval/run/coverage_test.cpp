// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/run/coverage.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/study/study_file.h"

namespace sightline {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr int kRepeats = 60;

std::vector<NumberCoverage> coverage_of(const std::vector<std::string>& more) {
  StudyOverrides overrides;
  overrides.trials = 40;
  overrides.set = {"sweep.noise_px=[1.0]", "solvers=[\"lspe\", \"oracle\"]"};
  overrides.set.insert(overrides.set.end(), more.begin(), more.end());
  CoverageOptions options;
  options.repeats = kRepeats;
  return interval_coverage(read_study("cube-noise", overrides), options);
}

const NumberCoverage& number(const std::vector<NumberCoverage>& all, const std::string& name) {
  return *std::find_if(all.begin(), all.end(), [&](const auto& n) { return n.name == name; });
}

// 95 % of 60 runs leave a deviation of 2.8 %; four of them, of the worse of two cells.
TEST(Coverage, IsThatOfTheIntervalsThatArePrinted) {
  const auto coverage = coverage_of({});
  for (const char* name : {"geodesic_deg.mean", "geodesic_deg.median", "t_error_percent.mean"}) {
    EXPECT_EQ(number(coverage, name).cells, 2) << name;
    EXPECT_GT(number(coverage, name).least, 0.84) << name;
    EXPECT_EQ(number(coverage, name).without, 0) << name;
  }
  EXPECT_EQ(number(coverage, "geodesic_deg.rms").cells, 0);
  EXPECT_EQ(number(coverage, "geodesic_deg.rms").without, 1) << "of an RMS none holds";
  EXPECT_EQ(number(coverage, "ratio_to_oracle_median").cells, 1) << "the oracle's own is always 1";
  EXPECT_THAT(coverage_table(coverage), HasSubstr("| geodesic_deg.median | 2 |"));
  EXPECT_THAT(coverage_table(coverage), Not(HasSubstr("angle_error_deg")));
}

TEST(Coverage, OfThetaHasItsCellsFarFromGimbalLockAlone) {
  EXPECT_EQ(number(coverage_of({}), "theta_error_deg.mean").cells, 0);
  const auto far = coverage_of({"poses.angle_deg=[-50, 50]"});
  EXPECT_EQ(number(far, "theta_error_deg.mean").cells, 2);
  EXPECT_EQ(number(far, "theta_error_deg.mean").without, 0);
}

// Two cells of some 860 bytes a run: 200 million runs are some 350 GB.
TEST(Coverage, SaysWhatDoesNotFitBeforeItBegins) {
  StudyOverrides overrides;
  overrides.trials = 30;
  overrides.set = {"sweep.noise_px=[1.0]", "solvers=[\"lspe\", \"oracle\"]"};
  const Study study = read_study("cube-noise", overrides);
  EXPECT_EQ(why_no_memory_for_runs(study, 200, 1e9), "");
  EXPECT_EQ(why_no_memory_for_runs(study, 200'000'000, std::nullopt), "") << "nobody knows";
  EXPECT_THAT(why_no_memory_for_runs(study, 200'000'000, 1e9),
              AllOf(HasSubstr("200000000 runs of 30 trials with 2 cells"),
                    HasSubstr("GB, and 1.0 GB are free")));
  // The errors of all runs are kept up to a number of them, so that more runs add their cells
  // alone.
  EXPECT_NE(why_no_memory_for_runs(study, 4'000, 20e6), "");
  EXPECT_EQ(why_no_memory_for_runs(study, 8'000, 40e6), "");
}

}  // namespace
}  // namespace sightline
