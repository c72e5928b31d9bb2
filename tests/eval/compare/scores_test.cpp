// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Scores of anyone's estimates, one beside the other: `score` and then `compare`, as a CI job does.
#include <numbers>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/compare/compare.h"
#include "eval/compare/compare_text.h"
#include "eval/compare/junit.h"
#include "eval/datasets/bop/read.h"
#include "scenes/random/random.h"
#include "tests/eval/program.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr int kImages = 12;

class CompareScores : public testing::Test {
 protected:
  void SetUp() override {
    const Outcome made =
        run("render cube --set camera.width_px=64 --set camera.height_px=64 --set camera.f_px=250 "
            "--set image.samples_per_pixel=1 --quiet --truth minimal --count " +
            std::to_string(kImages) + " --out " + path("set"));
    ASSERT_EQ(made.exit_code, 0) << made.output;
  }

  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  // The true poses with an error of some degrees and per mille, drawn for the name of the method;
  // the first images are missed.
  void write_estimates(const std::string& name, double angle_deg, double per_mille,
                       int missed = 0) const {
    std::string text = "scene_id,im_id,obj_id,score,R,t,time\n";
    const BopDataset dataset = read_bop_dataset(path("set"), "");
    for (size_t i = static_cast<size_t>(missed); i < dataset.images.size(); ++i) {
      RandomStream random(1, "estimates", i);
      const Pose& truth = dataset.images[i].instances[0].cam_from_model;
      const Eigen::Vector3d turn = random.normal3().normalized();
      const Eigen::Matrix3d r =
          rotation_from_vector(turn * angle_deg * std::numbers::pi / 180) * truth.rotation;
      const Eigen::Vector3d t = truth.translation * (1 + per_mille / 1000);
      text += fmt::format("{},{},1,1,", dataset.images[i].scene_id, dataset.images[i].im_id);
      for (int row = 0; row < 3; ++row) {
        text += fmt::format("{} {} {} ", r(row, 0), r(row, 1), r(row, 2));
      }
      text += fmt::format(",{} {} {},-1\n", t.x(), t.y(), t.z());
    }
    folder_.write(name, text);
  }

  std::string score(const std::string& results, const std::string& out) const {
    const Outcome scored =
        run("score " + results + " --quiet --dataset " + path("set") + " --out " + path(out));
    EXPECT_EQ(scored.exit_code, 0) << scored.output;
    return path(out);
  }

  TemporaryFolder folder_;
};

TEST_F(CompareScores, AreWorseBetterOrTheSameTargetByTarget) {
  write_estimates("good.csv", 0.5, 0.5);
  write_estimates("bad.csv", 5, 20);
  const std::string good = score(path("good.csv"), "good");
  const std::string bad = score(path("bad.csv"), "bad");
  const Comparison worse = compare_runs(good, bad, 0);
  EXPECT_EQ(worse.how, fmt::format("paired: {} targets that are in both", kImages));
  EXPECT_EQ(worse.settings, "settings: the same in both");
  ASSERT_EQ(worse.cells.size(), 1u);
  EXPECT_EQ(worse.cells[0].solver, "good to bad") << "single methods need not be called alike";
  EXPECT_EQ(worse.cells[0].verdict, Verdict::kWorse);
  EXPECT_THAT(changes_text(worse.cells[0]), HasSubstr("ar_mssd is worse"));
  EXPECT_THAT(changes_text(worse.cells[0]), HasSubstr("geodesic_deg.middle is worse"));
  EXPECT_EQ(compare_runs(bad, good, 0).cells[0].verdict, Verdict::kBetter);
  const Comparison same = compare_runs(good, good, 0);
  EXPECT_EQ(same.count(Verdict::kUnchanged), 1);
  EXPECT_FALSE(same.has_regression());
  // A baseline need be no more than the one file.
  EXPECT_TRUE(compare_runs(good + "/targets.csv", bad, 0).has_regression());
  EXPECT_THAT(to_junit(worse), HasSubstr("classname=\"scores.all\" name=\"good to bad\""));
  const Outcome program = run("compare " + good + " " + bad + " --measure AR,ADD");
  EXPECT_EQ(program.exit_code, 3) << program.output;
  EXPECT_THAT(program.output, HasSubstr("add_recall"));
  EXPECT_EQ(run("compare " + good + " " + good).exit_code, 0);
}

TEST_F(CompareScores, AMissedTargetCountsAgainstAMethod) {
  write_estimates("whole.csv", 0.5, 0.5);
  write_estimates("half.csv", 0.5, 0.5, kImages * 2 / 3);
  const Comparison comparison =
      compare_runs(score(path("whole.csv"), "whole"), score(path("half.csv"), "half"), 0,
                   {"failure_rate", "add_mm.median", "ar_mssd"});
  const std::vector<Difference>& differences = comparison.cells.at(0).differences;
  ASSERT_EQ(differences.size(), 3u);
  EXPECT_EQ(differences[0].quantity, "failure_rate");
  EXPECT_DOUBLE_EQ(differences[0].now, 2.0 / 3);
  EXPECT_EQ(differences[0].verdict, Verdict::kWorse);
  EXPECT_TRUE(std::isinf(differences[1].now)) << "more than half are missed";
  EXPECT_EQ(differences[1].verdict, Verdict::kWorse);
  EXPECT_EQ(differences[2].verdict, Verdict::kWorse);
}

TEST_F(CompareScores, OfSeveralMethodsEachWithItsOwn) {
  write_estimates("a.csv", 0.5, 0.5);
  write_estimates("b.csv", 5, 20);
  const std::string both = score(path("a.csv") + " other=" + path("b.csv"), "both");
  for (const char* file : {"a/report.html", "other/scores.json", "scores.json", "targets.csv"}) {
    EXPECT_TRUE(fs::exists(fs::path(both) / file)) << file;
  }
  const Comparison same = compare_runs(both, both, 0);
  ASSERT_EQ(same.cells.size(), 2u);
  EXPECT_EQ(same.cells[1].solver, "other");
  EXPECT_FALSE(same.has_regression());
  // In the new scores one of the two is another method's, or is gone.
  const std::string swapped = score("a=" + path("b.csv") + " other=" + path("b.csv"), "swapped");
  const Comparison worse = compare_runs(both, swapped, 0);
  EXPECT_EQ(worse.cells[0].verdict, Verdict::kWorse);
  EXPECT_EQ(worse.cells[1].verdict, Verdict::kUnchanged);
  const Comparison gone = compare_runs(both, score(path("a.csv"), "alone"), 0);
  EXPECT_EQ(gone.count(Verdict::kMissing), 1);
  EXPECT_TRUE(gone.has_regression());
}

TEST_F(CompareScores, WhatCannotBeComparedIsOneLine) {
  write_estimates("a.csv", 0.5, 0.5);
  const std::string scores = score(path("a.csv"), "scores");
  const auto error = [&](const std::string& base, const std::string& now,
                         const std::vector<std::string>& measures = {}) {
    return error_of([&] { compare_runs(base, now, 0, measures); });
  };
  const std::string summary = folder_.write("summary.json", R"({"study": "x", "cells": []})");
  EXPECT_THAT(error(scores, summary), HasSubstr("must be of one kind"));
  EXPECT_THAT(error(summary, scores), HasSubstr("must be of one kind"));
  EXPECT_THAT(error(scores, scores, {"found_rate"}), HasSubstr("no such measure"));
  EXPECT_THAT(error(scores, path("a.csv")), HasSubstr("is no targets.csv of `sightline score`"));
  const std::string whole = read_whole(scores + "/targets.csv");
  const std::string head = whole.substr(0, whole.find('\n') + 1);
  const std::string torn = folder_.write("torn.csv", whole.substr(0, whole.size() - 30));
  EXPECT_THAT(error(scores, torn), HasSubstr("torn.csv: line 13 has"));
  EXPECT_THAT(error(scores, folder_.write("none.csv", head)), HasSubstr("has no target"));
  const std::string row = whole.substr(head.size(), whole.find('\n', head.size()) - head.size());
  const std::string twice = folder_.write("twice.csv", head + row + "\n" + row + "\n");
  EXPECT_THAT(error(scores, twice), HasSubstr("has scene 0 image 0 object 1 instance 0 twice"));
  // Another set has the same numbers of images.
  std::string moved = row;
  const size_t x = moved.find(",1,0,") + 5;
  moved.replace(x, moved.find(',', x) - x, "12345");
  EXPECT_THAT(error(scores, folder_.write("moved.csv", head + moved + "\n")),
              HasSubstr("is at another true position in each"));
  const std::string elsewhere = row.substr(0, row.find(',')) + ",7" + row.substr(row.find(',') + 2);
  EXPECT_THAT(error(scores, folder_.write("elsewhere.csv", head + elsewhere + "\n")),
              HasSubstr("have no target and method in common"));
}

}  // namespace
}  // namespace sightline
