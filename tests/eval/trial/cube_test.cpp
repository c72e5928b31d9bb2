// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// How well model_edges and hough_subpixel find the vertices of the cube, in the scene of
// feature-localisation: blur of 0.7 px, noise of 3 grey levels, windows from a prior of 2 degrees
// and 1 percent.
#include <gtest/gtest.h>

#include "eval/study/study_file.h"
#include "eval/summary/localisation.h"
#include "eval/trial/image_trial.h"
#include "tests/eval/studies.h"

namespace sightline {
namespace {

Localisation localisation_of(std::vector<std::string> settings) {
  constexpr int kTrials = 100;
  settings.push_back("sweep={}");
  settings.push_back("solvers=['oracle']");
  const Study study =
      read_study("feature-localisation", {.trials = kTrials, .seed = {}, .set = settings});
  Renderer renderer;
  LocalisationStatistics statistics;
  for (int64_t i = 0; i < kTrials; ++i) statistics.add(run_trial(study, i, renderer).record);
  return statistics.summary();
}

// 1000 trials have 99.4 % found, 0.03 % of them outliers, 0.060 px and 1.11 sigmas. 100 must not be
// worse than these bounds by more than chance: their 95 % intervals reach as far.
TEST(Cube, TwoPassesOfModelEdgesFindItsVerticesToATenthOfAPixel) {
  const Localisation cube =
      localisation_of({"extraction.line_intersection='model_edges'", "extraction.passes=2"});
  EXPECT_GE(cube.found_rate.ci95[1], 0.99);
  EXPECT_GE(cube.found_rate.value, 0.98);
  EXPECT_LE(cube.outlier_rate.ci95[0], 0.002);
  EXPECT_LE(cube.rms_px.ci95[0], 0.08);
  EXPECT_LE(cube.rms_sigmas.ci95[0], 1.25);
  EXPECT_GE(cube.rms_sigmas.ci95[1], 0.8);
}

// 1000 trials have 98.5 % found, 0.6 % of them outliers, and 0.106 px.
TEST(Cube, OnePassOfModelEdgesMissesFewOfThem) {
  const Localisation cube = localisation_of({"extraction.line_intersection='model_edges'"});
  EXPECT_GE(cube.found_rate.ci95[1], 0.98);
  EXPECT_LE(cube.outlier_rate.ci95[0], 0.01);
  EXPECT_LE(cube.rms_px.ci95[0], 0.12);
}

// 1000 trials have 99.2 % found, 0.1 % of them outliers, 0.083 px and 1.12 sigmas.
TEST(Cube, TwoPassesOfHoughSubpixelFindItsVerticesToATenthOfAPixel) {
  const Localisation cube =
      localisation_of({"extraction.line_intersection='hough_subpixel'", "extraction.passes=2"});
  EXPECT_GE(cube.found_rate.ci95[1], 0.99);
  EXPECT_GE(cube.found_rate.value, 0.98);
  EXPECT_LE(cube.outlier_rate.ci95[0], 0.002);
  EXPECT_LE(cube.rms_px.ci95[0], 0.10);
  EXPECT_LE(cube.rms_sigmas.ci95[0], 1.25);
  EXPECT_GE(cube.rms_sigmas.ci95[1], 0.8);
}

// 1000 trials have 97.0 % found, 1.1 % of them outliers, and 0.126 px.
TEST(Cube, OnePassOfHoughSubpixelMissesFewOfThem) {
  const Localisation cube = localisation_of({"extraction.line_intersection='hough_subpixel'"});
  EXPECT_GE(cube.found_rate.ci95[1], 0.965);
  EXPECT_LE(cube.outlier_rate.ci95[0], 0.015);
  EXPECT_LE(cube.rms_px.ci95[0], 0.14);
}

// The paper's lines are worse by more than chance.
TEST(Cube, LinesThroughEdgePixelsDoNot) {
  const Localisation cube =
      localisation_of({"extraction.line_intersection='hough_intersection'", "extraction.passes=2"});
  EXPECT_LT(cube.found_rate.ci95[1], 0.975);
  EXPECT_GT(cube.rms_px.ci95[0], 0.10);
}

TEST(Cube, SigmasStayHonestAtFourTimesTheNoise) {
  const Localisation cube = localisation_of({"extraction.line_intersection='model_edges'",
                                             "extraction.passes=2", "noise.read_noise_grey=12"});
  EXPECT_LE(cube.rms_sigmas.ci95[0], 1.25);
  EXPECT_GE(cube.rms_sigmas.ci95[1], 0.8);
}

}  // namespace
}  // namespace sightline
