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

}  // namespace
}  // namespace sightline
