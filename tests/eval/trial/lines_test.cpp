// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lines as observations, from the image to the record.
#include <algorithm>
#include <cmath>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/records/line_records.h"
#include "eval/study/study_file.h"
#include "eval/summary/trial_bounds.h"
#include "eval/trial/line_labels.h"
#include "features/image_line.h"
#include "tests/eval/studies.h"
#include "tests/scenes/error_text.h"

namespace sightline {
namespace {

using testing::HasSubstr;

// The airliner from any side, one extractor.
Study any_side(bool uses_lines) {
  return read_study(
      "boeing-any-side",
      {.trials = 4,
       .seed = 5,
       .set = {"sweep={}", "extraction.line_intersection='model_edges'",
               "solvers=['consensus','lspe','orpe_weighed']",
               uses_lines ? "extraction.use_lines=true" : "extraction.use_lines=false"}});
}

TEST(Lines, OfAnImageAreRecordedWithTheirErrors) {
  const Study study = any_side(true);
  Renderer renderer;
  size_t lines = 0, right = 0;
  for (int64_t i = 0; i < 4; ++i) {
    const Trial trial = run_trial(study, i, renderer);
    for (const LineRecord& line : trial.record.lines()) {
      ++lines;
      right += line.is_right();
      EXPECT_EQ(line.is_right(), std::abs(line.offset_px) <= 3 && std::isfinite(line.error_sigmas));
    }
  }
  EXPECT_GT(lines, 15U);
  EXPECT_GT(right, lines * 9 / 10);
}

TEST(Lines, AreNotRecordedUnlessAskedFor) {
  const Study study = any_side(false);
  Renderer renderer;
  EXPECT_TRUE(run_trial(study, 0, renderer).record.lines().empty());
}

TEST(Lines, ChangeWhatSolversWithLinesSayAndTheBound) {
  Renderer renderer;
  const Study with = any_side(true), without = any_side(false);
  const TrialRecord a = run_trial(with, 0, renderer).record;
  const TrialRecord b = run_trial(without, 0, renderer).record;
  for (const size_t solver : {0, 1}) {
    EXPECT_NE(a.estimates()[solver].geodesic_deg, b.estimates()[solver].geodesic_deg);
  }
  EXPECT_EQ(a.estimates()[2].geodesic_deg, b.estimates()[2].geodesic_deg) << "orpe_weighed";
  TrialBounds bounds(with);
  std::map<std::string, double> noise_px;
  for (const ObservationRecord& o : a.observations()) noise_px[o.feature] = 0.2;
  bounds.set_noise_px(0, noise_px);
  TrialRecord points = a;
  points.pose_trial().lines.clear();
  EXPECT_LT(bounds.of(a).value().theta_deg, bounds.of(points).value().theta_deg);
}

TEST(Lines, ThatLieOffTheirEdgeAreWrong) {
  const Study study = any_side(true);
  Renderer renderer;
  const Trial trial = run_trial(study, 0, renderer);
  std::vector<Observation> observations = trial.observations;
  size_t moved = 0;
  for (Observation& observation : observations) {
    for (EdgeLine& found : observation.edge_lines) {
      const Eigen::Vector2d& along = found.line.direction;
      found.line.point += 10 * Eigen::Vector2d(-along.y(), along.x());
      ++moved;
    }
  }
  ASSERT_GT(moved, 0U);
  for (const LineRecord& line :
       compare_lines(observations, *study.images()->target, trial.scene.camera,
                     trial.record.true_cam_from_target, study.images()->setups[0].limits)) {
    EXPECT_EQ(line.label, LineLabel::kWrong) << name_of(line);
  }
}

// The offset is that where the edge pixels are, which may be far from the line's point.
TEST(Lines, ThatAreTurnedAboutAFarPointAreWrong) {
  const Study study = any_side(true);
  Renderer renderer;
  size_t turned = 0;
  for (int64_t i = 0; i < 4; ++i) {
    const Trial trial = run_trial(study, i, renderer);
    for (Observation observation : trial.observations) {
      std::erase_if(observation.edge_lines, [](const EdgeLine& found) {
        return (seen_middle(found.line) - found.line.point).norm() < 40;
      });
      for (EdgeLine& found : observation.edge_lines) {
        Eigen::Vector2d& along = found.line.direction;
        const Eigen::Vector2d middle = seen_middle(found.line);
        along = (along + 0.25 * Eigen::Vector2d(-along.y(), along.x())).normalized();
        const Eigen::Vector2d shift =
            found.line.direction.dot(middle - found.line.point) * found.line.direction +
            found.line.point - middle;
        for (Eigen::Vector2d& pixel : found.line.edge_pixels) pixel += shift;
        ++turned;
      }
      const std::vector<Observation> one = {observation};
      for (const LineRecord& line :
           compare_lines(one, *study.images()->target, trial.scene.camera,
                         trial.record.true_cam_from_target, study.images()->setups[0].limits)) {
        EXPECT_GT(std::abs(line.offset_px), 3) << name_of(line);
        EXPECT_EQ(line.label, LineLabel::kWrong) << name_of(line);
      }
    }
  }
  EXPECT_GT(turned, 0U);
}

// Of a study cube-lines: the mean NEES of consensus, the mean bound, and the trials.
struct CubeLines {
  double nees = 0;
  double bound_deg = 0;
  double error_deg = 0;
  std::vector<TrialRecord> trials;
};

Study cube_lines_study(int trials, std::vector<std::string> settings) {
  settings.insert(settings.begin(), {"sweep={}", "noise.pixel_px=1", "edges.observed='lines'"});
  return read_study("cube-lines", {.trials = trials, .seed = 2, .set = settings});
}

CubeLines cube_lines(const std::string& observed) {
  constexpr int kTrials = 120;
  const Study study = cube_lines_study(kTrials, {"edges.observed='" + observed + "'"});
  const TrialBounds bounds(study);
  CubeLines out;
  for (int64_t i = 0; i < kTrials; ++i) {
    out.trials.push_back(run_numeric_trial(study, i));
    const EstimateRecord& estimate = out.trials.back().estimates()[0];
    EXPECT_TRUE(estimate.is_ok());
    out.nees += estimate.nees.value() / kTrials;
    out.bound_deg += bounds.of(out.trials.back()).value().geodesic_deg / kTrials;
    out.error_deg += estimate.geodesic_deg / kTrials;
  }
  return out;
}

TEST(CubeLines, WhatIsObservedIsToldWithItsNoise) {
  // A mean of 120 chi-squared numbers of 6 degrees of freedom errs by 0.3.
  for (const char* observed : {"points", "lines", "both"}) {
    EXPECT_NEAR(cube_lines(observed).nees, 6, 1.2) << observed;
  }
}

TEST(CubeLines, PointsLoseWhatTheirReachLeaves) {
  const CubeLines points = cube_lines("points"), lines = cube_lines("lines"),
                  both = cube_lines("both");
  EXPECT_TRUE(points.trials[0].lines().empty());
  EXPECT_FALSE(points.trials[0].observations()[0].status == ObservationOutcome::kMissing);
  EXPECT_EQ(lines.trials[0].lines().size(), 12U);
  EXPECT_TRUE(lines.trials[0].observations()[0].status == ObservationOutcome::kMissing);
  EXPECT_LT(both.bound_deg, points.bound_deg);
  EXPECT_LT(lines.bound_deg, both.bound_deg) << "all that the edge pixels say";
  EXPECT_LT(lines.error_deg, points.error_deg);
  for (const LineRecord& line : lines.trials[0].lines()) {
    EXPECT_LT(line.error_sigmas, 6);
  }
}

// Of what a line of one edge pixel a pixel is fitted to: its variances are sigma^2 / L and 12
// sigma^2 / L^3.
double line_length_px(const LineRecord& line) {
  return std::sqrt(12 * line.offset_variance_px2 / line.slope_variance);
}

// How far a line passes from the ends of its edge's image, across itself, in px.
std::pair<double, double> distances_at_ends(const LineRecord& record, const Study& study,
                                            const Pose& truth) {
  const NumericStudy& numeric = *study.numeric();
  const LineObservation line = line_of(record, *numeric.target).value();
  const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
  const auto distance = [&](const Eigen::Vector3d& point) {
    return std::abs(
        normal.dot(project(numeric.setup_of(0).camera, truth * point).value() - line.pixel));
  };
  return {distance(line.begin_in_target), distance(line.end_in_target)};
}

TEST(CubeWrongLines, AreAsManyAndAsWrongAsIsSaidAndTheOthersAsTheyWere) {
  const Study with = cube_lines_study(20, {"outliers.lines=3", "noise.pixel_px=0.001"});
  const Study without = cube_lines_study(20, {"noise.pixel_px=0.001"});
  for (int64_t i = 0; i < 20; ++i) {
    const TrialRecord trial = run_numeric_trial(with, i), plain = run_numeric_trial(without, i);
    ASSERT_EQ(trial.lines().size(), plain.lines().size());
    EXPECT_EQ(std::ranges::count(trial.lines(), LineLabel::kWrong, &LineRecord::label), 3);
    for (size_t k = 0; k < trial.lines().size(); ++k) {
      const LineRecord& line = trial.lines()[k];
      if (line.is_right()) {
        EXPECT_EQ(line.pixel, plain.lines()[k].pixel);
        EXPECT_EQ(line.direction, plain.lines()[k].direction);
        EXPECT_LT(line.error_sigmas, 6);
        continue;
      }
      EXPECT_GT(line.error_sigmas, 1000);
      // Of 15 to 30 px along the edge's normal; that of the line leans by up to 60 px in the
      // length.
      const auto [begin_px, end_px] = distances_at_ends(line, with, trial.true_cam_from_target);
      const double cosine = std::cos(std::atan(60 / line_length_px(line)));
      for (const double px : {begin_px, end_px}) {
        EXPECT_GT(px, 15 * cosine - 0.1);
        EXPECT_LT(px, 30.1);
      }
    }
  }
}

TEST(CubeWrongLines, AreLeftOutByConsensusAndSpoilLeastSquares) {
  constexpr int kTrials = 100;
  const Study study = cube_lines_study(kTrials, {"outliers.lines=3"});
  const TrialBounds bounds(study);
  std::vector<double> consensus_deg, lspe_deg;
  double bound_deg = 0, nees = 0;
  for (int64_t i = 0; i < kTrials; ++i) {
    const TrialRecord trial = run_numeric_trial(study, i);
    consensus_deg.push_back(trial.estimates()[0].geodesic_deg);
    lspe_deg.push_back(trial.estimates()[1].geodesic_deg);
    nees += trial.estimates()[0].nees.value() / kTrials;
    bound_deg += bounds.of(trial).value().geodesic_deg / kTrials;
  }
  // The bound is of the right lines alone; a mean of 100 errors has a twentieth's standard
  // deviation.
  const auto mean = [](const std::vector<double>& v) {
    return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
  };
  EXPECT_NEAR(mean(consensus_deg), bound_deg, 0.2 * bound_deg);
  EXPECT_NEAR(nees, 6, 1.5);
  EXPECT_GT(mean(lspe_deg), 5 * bound_deg);
}

TEST(CubeWrongLines, WithoutLinesOrALawOfSizesAreRefused) {
  const auto error = [](std::vector<std::string> settings) {
    return error_of([&] { cube_lines_study(1, std::move(settings)); });
  };
  EXPECT_EQ(error({"outliers.lines=12"}), "");
  EXPECT_THAT(error({"outliers.lines=13"}),
              HasSubstr("lines is 13, but the features have only 12"));
  EXPECT_THAT(error({"outliers.lines=1", "edges.observed='points'"}),
              HasSubstr("lines must be 0 where edges.observed is neither"));
  EXPECT_THAT(error({"outliers.lines=1", "outliers.law='clustered'"}),
              HasSubstr("law must be \"uniform\", \"fixed\" or \"tailed\""));
  EXPECT_THAT(error({"outliers.lines=1.5"}), HasSubstr("whole"));
}

}  // namespace
}  // namespace sightline
