// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The airliner in its livery, whose edges are matched jointly because of the print: the corners of
// its wings are looked for by one extractor, its nose and engines by others, in one image.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "eval/study/study_file.h"
#include "eval/summary/localisation.h"
#include "eval/trial/image_trial.h"
#include "tests/eval/studies.h"

namespace sightline {
namespace {

constexpr int kLiveryTrials = 10;

// What an extractor of line intersections, and others beside it, find in the airliner's images.
std::vector<Trial> livery_trials(const std::string& line_intersection,
                                 const std::string& joint_edges) {
  const Study study =
      read_study("boeing-localisation",
                 {.trials = kLiveryTrials,
                  .seed = {},
                  .set = {"target=boeing707_livery", "features=all", "image.colour=rgb", "sweep={}",
                          "solvers=['oracle']", "extraction.corner=harris_subpixel",
                          "extraction.contour=contour", "extraction.joint_edges=" + joint_edges,
                          "extraction.line_intersection=" + line_intersection}});
  Renderer renderer;
  std::vector<Trial> trials;
  for (int64_t i = 0; i < kLiveryTrials; ++i) trials.push_back(run_trial(study, i, renderer));
  return trials;
}

bool is_line_intersection(const Trial& trial, const Observation& seen) {
  const TargetFeature& feature = trial.scene.target->features[static_cast<size_t>(seen.feature)];
  return feature.kind == FeatureKind::kLineIntersection;
}

bool are_same(const std::vector<ImageLine>& a, const std::vector<ImageLine>& b) {
  return std::ranges::equal(a, b, [](const ImageLine& one, const ImageLine& other) {
    return one.point == other.point && one.direction == other.direction;
  });
}

bool are_same(const Observation& a, const Observation& b) {
  return a.feature == b.feature && a.status == b.status && a.pixel == b.pixel &&
         a.covariance_px2 == b.covariance_px2 && a.predicted_px == b.predicted_px &&
         a.window == b.window && a.corners == b.corners && a.contour == b.contour &&
         are_same(a.lines, b.lines);
}

// How many of the line intersections, or of the other features, are the same in both.
struct Compared {
  int same = 0, others = 0;
};

Compared compared(const std::vector<Trial>& a, const std::vector<Trial>& b,
                  bool line_intersections) {
  Compared compared;
  for (size_t i = 0; i < a.size(); ++i) {
    for (size_t k = 0; k < a[i].observations.size(); ++k) {
      const Observation& seen = a[i].observations[k];
      if (is_line_intersection(a[i], seen) != line_intersections) continue;
      ++(are_same(seen, b[i].observations[k]) ? compared.same : compared.others);
    }
  }
  return compared;
}

// Of the line intersections that are to be seen.
Localisation located(const std::vector<Trial>& trials) {
  LocalisationStatistics statistics;
  for (const Trial& trial : trials) {
    for (size_t k = 0; k < trial.observations.size(); ++k) {
      const ObservationRecord& record = trial.record.observations()[k];
      const bool is_asked = is_line_intersection(trial, trial.observations[k]);
      if (is_asked && record.is_visible) statistics.add(record);
    }
    statistics.end_trial();
  }
  return statistics.summary();
}

// Of twelve corners, a nose and four engines an image.
constexpr int kOthers = 5 * kLiveryTrials, kLineIntersections = 12 * kLiveryTrials;

TEST(MixedExtractors, EdgesMatchedJointlyLeaveNoseAndEnginesAlone) {
  for (const char* const extractor : {"model_edges", "edges_else_contour"}) {
    const std::vector<Trial> alone = livery_trials(extractor, "off");
    const std::vector<Trial> jointly = livery_trials(extractor, "textured");
    EXPECT_EQ(compared(alone, jointly, false).same, kOthers) << extractor;
    // Another pose is looked around.
    EXPECT_EQ(compared(alone, jointly, true).others, kLineIntersections) << extractor;
    // 99 % are found, and a corner's own sigmas, half a pixel and less, allow five or six of them.
    const Localisation found = located(jointly);
    EXPECT_GE(found.near_rate.value, 0.97) << extractor;
    EXPECT_EQ(found.seen_outlier_rate.value, 0) << extractor;
    // By themselves the print is taken for edges: 90 % are near and 7 % outliers.
    EXPECT_LE(located(alone).near_rate.value, 0.93) << extractor;
    EXPECT_GE(located(alone).seen_outlier_rate.value, 0.04) << extractor;
  }
}

TEST(MixedExtractors, WhereNoneLooksForEdgesOfTheMeshNothingIsMatched) {
  const std::vector<Trial> alone = livery_trials("hough_subpixel", "off");
  const std::vector<Trial> jointly = livery_trials("hough_subpixel", "on");
  EXPECT_EQ(compared(alone, jointly, false).same, kOthers);
  EXPECT_EQ(compared(alone, jointly, true).same, kLineIntersections);
}

}  // namespace
}  // namespace sightline
