// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lines as observations, from the image to the record.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "eval/records/line_records.h"
#include "eval/study/study_file.h"
#include "eval/summary/trial_bounds.h"
#include "eval/trial/line_labels.h"
#include "features/image_line.h"
#include "tests/eval/studies.h"

namespace sightline {
namespace {

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

CubeLines cube_lines(const std::string& observed) {
  constexpr int kTrials = 120;
  const Study study = read_study(
      "cube-lines", {.trials = kTrials,
                     .seed = 2,
                     .set = {"sweep={}", "noise.pixel_px=1", "edges.observed='" + observed + "'"}});
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

}  // namespace
}  // namespace sightline
