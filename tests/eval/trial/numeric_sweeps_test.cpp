// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Numeric studies whose keys are swept by name, and their laws with heavy tails.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/study/study_file.h"
#include "tests/eval/studies.h"
#include "tests/scenes/error_text.h"

namespace sightline {
namespace {

using testing::HasSubstr;

Study cube_study(int trials, const std::vector<std::string>& settings) {
  return read_study("cube-noise", {.trials = trials, .seed = {}, .set = settings});
}

std::string cube_error(const std::string& setting) {
  return error_of([&] { cube_study(1, {setting}); });
}

// The observations of all trials, of a study in which the oracle alone solves.
template <typename Use>
void for_each_observation(int trials, std::vector<std::string> settings, const Use& use) {
  settings.push_back("solvers=['oracle']");
  const Study study = cube_study(trials, settings);
  for (int64_t i = 0; i < study.trial_count(); ++i) {
    const TrialRecord trial = run_numeric_trial(study, i);
    for (const ObservationRecord& o : trial.observations()) use(o);
  }
}

// Of a count of `number` independent chances of probability p: four standard deviations.
double four_sigma(double number, double p) {
  return 4 * std::sqrt(number * p * (1 - p));
}

TEST(NumericSweeps, TakeAnyKeyByItsNameBesideNoiseAndOutliers) {
  const Study study = cube_study(1, {"sweep={noise_px=[1, 2], 'outliers.size_px'=[[5, 10], [15, "
                                     "30]], 'solver.rho'=[5, 20], 'solver.sigma'=['known']}"});
  ASSERT_EQ(study.conditions.size(), 8u);
  EXPECT_EQ(study.conditions[0].values,
            (std::map<std::string, double>{{"noise_px", 1}, {"solver.rho", 5}}));
  EXPECT_EQ(study.conditions[0].words.at("outliers.size_px"), "[5,10]");
  EXPECT_EQ(study.conditions[0].label, "known, size_px [5,10], rho 5, 1 px");
  const NumericStudy& numeric = *study.numeric();
  EXPECT_EQ(numeric.setup_of(0).planted.size_px.max, 10);
  EXPECT_EQ(numeric.setup_of(7).planted.size_px.min, 15);
  EXPECT_EQ(numeric.setup_of(7).options.orpe.rho, 20);
  EXPECT_EQ(numeric.cells[7].noise_px, 2);
  EXPECT_EQ(numeric.cells[6].noise_px, 1);
}

TEST(NumericSweeps, MakeTheTrialThatTheKeyItselfMakes) {
  const Study swept =
      cube_study(1, {"sweep={'outliers.size_px'=[[50, 60]], 'noise.pixel_px'=[1], "
                     "'camera.f_px'=[9000], 'poses.range_m'=[[60, 70]], 'outliers.count'=[2]}"});
  const Study set =
      cube_study(1, {"sweep={}", "outliers.size_px=[50, 60]", "noise.pixel_px=1",
                     "camera.f_px=9000", "poses.range_m=[60, 70]", "outliers.count=2"});
  const TrialRecord a = run_numeric_trial(swept, 0);
  const TrialRecord b = run_numeric_trial(set, 0);
  EXPECT_EQ(a.true_cam_from_target.translation, b.true_cam_from_target.translation);
  for (size_t i = 0; i < a.observations().size(); ++i) {
    EXPECT_EQ(a.observations()[i].pixel, b.observations()[i].pixel);
  }
  EXPECT_EQ(swept.camera_of(0).fx_px, 9000);
}

TEST(NumericSweeps, BlameTheSweepForWhatIsWrong) {
  EXPECT_THAT(cube_error("sweep={noise_px=[1], 'solver.rho'=[5, 0.5]}"),
              HasSubstr("sweep: solver.rho=0.5: "));
  for (const char* none : {"inf", "-inf", "nan"}) {
    EXPECT_THAT(cube_error(std::string("sweep={noise_px=[1], 'solver.rho'=[5, ") + none + "]}"),
                HasSubstr(std::string("solver.rho is ") + none + ", must be a number, from 1 to "));
  }
  EXPECT_THAT(cube_error("sweep={noise_px=[1], 'solver.rho'=[1e400]}"),
              HasSubstr("'1e400' is beyond numbers of 64 bits"));
  EXPECT_THAT(cube_error("sweep={noise_px=[1], 'solver.roh'=[5]}"),
              HasSubstr("did you mean 'rho'"));
  EXPECT_THAT(cube_error("sweep={'image.bits'=[8]}"), HasSubstr("or one of noise_px, outliers"));
  EXPECT_THAT(cube_error("sweep={'solver.inputs'=['exact']}"), HasSubstr("cannot be swept"));
  EXPECT_THAT(cube_error("sweep={'noise.pixel_px'=[1], noise_px=[2]}"), HasSubstr("beside"));
  EXPECT_THAT(
      cube_error("sweep={noise_px=[1], 'outliers.law'=['tailed'], 'outliers.size_px'=[[0, 9]]}"),
      HasSubstr("must begin above 0"));
  std::string many = "sweep={outliers=[0, 1, 2, 3, 4, 5, 6, 7], noise_px=[0";
  for (int i = 1; i < 1300; ++i) many += fmt::format(", {}", i);
  EXPECT_THAT(error_of([&] {
                cube_study(1, {"outliers={}", many + "]}"});
              }),
              HasSubstr("makes over 10000 cells"));
}

// Of Student's t with three degrees of freedom in units of its standard deviation, |x| lies below a
// with probability 2/pi (a / (1 + a^2) + atan a): 0.9938 of 4, where the normal law has 0.99994.
TEST(NumericLaws, NoiseMayHaveHeavyTails) {
  constexpr double kSdPx = 2;
  const auto beyond = [&](const std::string& law, double sds) {
    int count = 0;
    for_each_observation(1000, {"sweep={noise_px=[2]}", "outliers.count=0", "noise.law=" + law},
                         [&](const ObservationRecord& o) {
                           const Eigen::Vector2d error = o.pixel - o.true_pixel;
                           count += std::abs(error.x()) > sds * kSdPx;
                           count += std::abs(error.y()) > sds * kSdPx;
                         });
    return count;
  };
  constexpr double kNumbers = 1000 * 8 * 2;
  for (const double sds : {0.5, 4.0}) {
    const double p = 1 - 2 / std::numbers::pi * (sds / (1 + sds * sds) + std::atan(sds));
    EXPECT_NEAR(beyond("student", sds), kNumbers * p, four_sigma(kNumbers, p)) << sds;
  }
  const double normal = std::erfc(4 / std::numbers::sqrt2);
  EXPECT_NEAR(beyond("normal", 4), kNumbers * normal, four_sigma(kNumbers, normal));
}

// Of a density that falls with the square between 10 and 1000 px, (1/s - 1/1000) / (1/10 - 1/1000)
// lie above s.
TEST(NumericLaws, OutliersMayHaveHeavyTails) {
  int outliers = 0, large = 0;
  double least = 1e9, greatest = 0;
  for_each_observation(600,
                       {"sweep={noise_px=[0]}", "outliers.law=tailed", "outliers.count=2",
                        "outliers.size_px=[10, 1000]"},
                       [&](const ObservationRecord& o) {
                         if (!o.is_outlier) return;
                         ++outliers;
                         large += o.error_px > 100;
                         least = std::min(least, o.error_px);
                         greatest = std::max(greatest, o.error_px);
                       });
  ASSERT_EQ(outliers, 1200);
  constexpr double kLarge = (1.0 / 100 - 1.0 / 1000) / (1.0 / 10 - 1.0 / 1000);
  EXPECT_NEAR(large, outliers * kLarge, four_sigma(outliers, kLarge));
  EXPECT_GE(least, 10 - 1e-9);
  EXPECT_LE(greatest, 1000 + 1e-9);
}

TEST(NumericLaws, EachPointMayBeAnOutlierByChance) {
  int outliers = 0, points = 0;
  for_each_observation(500, {"sweep={noise_px=[0]}", "outliers={rate=0.25}"},
                       [&](const ObservationRecord& o) {
                         outliers += o.is_outlier;
                         ++points;
                       });
  EXPECT_NEAR(outliers, 0.25 * points, four_sigma(points, 0.25));
  EXPECT_THAT(cube_error("outliers={law='swapped', rate=0.25}"), HasSubstr("rate must be 0"));
  EXPECT_THAT(cube_error("outliers={}"), HasSubstr("outliers.count"));
}

}  // namespace
}  // namespace sightline
