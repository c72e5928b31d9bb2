// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// BOP's scores against cases worked by hand, and the program against its own sets.
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "eval/score/score.h"
#include "tests/eval/cube_of_100_mm.h"
#include "tests/eval/program.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

// Images of a cube 1000 mm away, f = 500 px, 640 px wide, each with so many instances, 300 mm
// apart.
BopDataset cubes(int images, int instances = 1) {
  BopModel model;
  model.points_mm = cube_points();
  for (const auto& point : model.points_mm.colwise()) model.mesh_mm.vertices.emplace_back(point);
  model.diameter_mm = 100 * std::sqrt(3.0);
  model.symmetries = kNoSymmetry;
  BopDataset dataset{.models = {{1, model}}, .images = {}};
  for (int i = 0; i < images; ++i) {
    BopImage image;
    image.im_id = i;
    image.width_px = 640;
    image.k = k_of(500, 320);
    for (int k = 0; k < instances; ++k) {
      image.instances.push_back(
          {.obj_id = 1, .cam_from_model = shifted(at_1000_mm(), {300.0 * k, 0, 0})});
    }
    image.targets[1] = instances;
    dataset.images.push_back(image);
  }
  return dataset;
}

BopEstimate estimate(int im_id, double shift_mm, double score = 1) {
  return {.scene_id = 0,
          .im_id = im_id,
          .obj_id = 1,
          .score = score,
          .cam_from_model = shifted(at_1000_mm(), {shift_mm, 0, 0})};
}

// Shifts of 0.02, 0.12 and 0.37 diameters (3.46, 20.8, 64.1 mm) along x, and no estimate.
// MSSD passes 10, 8 (from 0.15) and 3 (from 0.40) of the ten thresholds: (1 + 0.8 + 0.3) / 4.
// MSPD is 500 / 950 px a mm, 1.8, 10.9 and 33.7 px, passes 10, 8 and 4: (1 + 0.8 + 0.4) / 4.
// Below a tenth of the diameter is one of four. T_error = shift / sqrt 3 / 1000 mm: 0.2, 1.2 and
// 3.7 %, and infinite, so that the median is 2.45 %.
TEST(BopScore, OfKnownErrorsAndAMissingEstimate) {
  const double d = 100 * std::sqrt(3.0);
  const std::vector<BopEstimate> estimates{estimate(0, 0.02 * d), estimate(1, 0.12 * d),
                                           estimate(2, 0.37 * d)};
  BopDataset dataset = cubes(4);
  const BopScores scores = score_bop(dataset, estimates, 15);
  const BopSummary summary = summarise(scores);
  EXPECT_EQ(scores.ignored_estimates, 0u);
  EXPECT_EQ(summary.targets, 4);
  EXPECT_EQ(summary.estimated, 3);
  EXPECT_NEAR(summary.ar_mssd.value, 0.525, kRounding);
  EXPECT_NEAR(summary.ar_mspd.value, 0.55, kRounding);
  EXPECT_EQ(summary.add.value, 0.25);
  EXPECT_EQ(summary.mssd_recalls[0], 0.25);
  EXPECT_EQ(summary.mssd_recalls[2], 0.5);
  EXPECT_NEAR(summary.t_error_percent.median, 2.45, kRounding);
  EXPECT_EQ(summary.t_error_percent.capped, 1);
  EXPECT_FALSE(scores.has_vsd);  // there is no depth
  EXPECT_TRUE(std::isnan(summary.ar.value));
  // Thresholds of pixels are those of an image 640 wide: in one half as wide the errors count
  // double, 3.6, 21.9 and 67.4 px: 10, 6 and 0.
  for (BopImage& image : dataset.images) image.width_px = 320;
  EXPECT_NEAR(summarise(score_bop(dataset, estimates, 15)).ar_mspd.value, 0.4, kRounding);
}

// Two cubes, so that two estimates count. The two of the best scores are of the second cube; the
// better one of those, which has the lower score, finds it taken, and the first cube is missed.
TEST(BopScore, TheBestScoresTakeTheirInstancesFirst) {
  std::vector<BopEstimate> estimates{estimate(0, 303, 0.9), estimate(0, 300, 0.5),
                                     estimate(0, 0, 0.4)};
  const BopDataset dataset = cubes(1, 2);
  BopScores scores = score_bop(dataset, estimates, 15);
  EXPECT_EQ(scores.ignored_estimates, 1u);
  EXPECT_EQ(summarise(scores).ar_mssd.value, 0.5);
  ASSERT_EQ(scores.targets.size(), 2u);
  ASSERT_TRUE(scores.targets[1].chosen);
  EXPECT_NEAR(scores.targets[1].pairs[*scores.targets[1].chosen].mssd_mm, 3, kRounding);
  estimates[2].score = 0.6;
  EXPECT_EQ(summarise(score_bop(dataset, estimates, 15)).ar_mssd.value, 1);
}

// Of two instances one is asked for: the one that is seen better.
TEST(BopScore, TheMostVisibleInstancesAreAskedFor) {
  BopDataset dataset = cubes(1, 2);
  dataset.images[0].targets[1] = 1;
  dataset.images[0].instances[0].visible_fraction = 0.3;
  dataset.images[0].instances[1].visible_fraction = 0.9;
  EXPECT_EQ(summarise(score_bop(dataset, std::array{estimate(0, 300)}, 15)).ar_mssd.value, 1);
  EXPECT_EQ(summarise(score_bop(dataset, std::array{estimate(0, 0)}, 15)).ar_mssd.value, 0);
}

TEST(BopScore, OfEstimatesInAnotherUnitAreNotedAsSuch) {
  const BopDataset dataset = cubes(2);
  const auto note = [&](double factor_of_first, double factor_of_second) {
    std::vector<BopEstimate> estimates = {estimate(0, 10), estimate(1, 10)};
    estimates[0].cam_from_model.translation *= factor_of_first;
    estimates[1].cam_from_model.translation *= factor_of_second;
    return note_on_units(dataset, estimates, score_bop(dataset, estimates, 15));
  };
  EXPECT_THAT(note(1e-3, 1e-3), HasSubstr("all estimates are over 100 times nearer or farther"));
  EXPECT_THAT(note(1e3, 1e3), HasSubstr("t must be in mm"));
  EXPECT_EQ(note(1e-3, 0.5), "");
  EXPECT_EQ(note_on_units(dataset, {}, score_bop(dataset, {}, 15)), "");
}

TEST(BopScore, EstimatesOfWhatIsNotAskedForAreIgnored) {
  std::vector<BopEstimate> estimates{estimate(0, 0), estimate(7, 0), estimate(0, 0)};
  estimates[2].obj_id = 2;
  const BopScores scores = score_bop(cubes(1), estimates, 15);
  EXPECT_EQ(scores.ignored_estimates, 2u);
  EXPECT_EQ(summarise(scores).ar_mssd.value, 1);
}

// ---- the program

class ScoreProgram : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  json read(const std::string& file) const { return json::parse(read_whole(path(file))); }

  void render_set() const {
    const Outcome made =
        run("render cube --set camera.width_px=64 --set camera.height_px=64 --set camera.f_px=250 "
            "--set image.samples_per_pixel=1 --quiet --count 3 --truth minimal --out " +
            path("set"));
    ASSERT_EQ(made.exit_code, 0) << made.output;
  }

  // The true poses as results, their translations in mm times `unit`.
  void write_truth(const std::string& name, double unit) const {
    std::string text = "scene_id,im_id,obj_id,score,R,t,time\n";
    const json truths = read("set/test/000000/scene_gt.json");
    for (const auto& [im_id, entries] : truths.items()) {
      const auto r = entries[0]["cam_R_m2c"].get<std::vector<double>>();
      const auto t = entries[0]["cam_t_m2c"].get<std::vector<double>>();
      text += fmt::format("0,{},1,1,{},{} {} {},-1\n", im_id, joined(r), unit * t[0], unit * t[1],
                          unit * t[2]);
    }
    folder_.write(name, text);
  }

  static std::string joined(const std::vector<double>& values) {
    std::string text;
    for (const double value : values) text += fmt::format("{} ", value);
    return text;
  }

  Outcome score(const std::string& results, const std::string& more) const {
    return run("score " + path(results) + " --dataset " + path("set") + " " + more);
  }

  TemporaryFolder folder_;
};

TEST_F(ScoreProgram, GivesTheTruthOfOurOwnSetsFullMarksAndMetresNone) {
  render_set();
  write_truth("mm.csv", 1);
  const Outcome scored = score("mm.csv", "--out " + path("mm"));
  ASSERT_EQ(scored.exit_code, 0) << scored.output;
  EXPECT_THAT(scored.output, HasSubstr("AR_MSSD"));
  const json all = read("mm/scores.json")["all"];
  EXPECT_EQ(all["targets"], 3);
  for (const char* key : {"ar", "ar_mssd", "ar_mspd", "ar_vsd", "add_recall", "adi_recall"}) {
    EXPECT_EQ(all[key]["value"], 1.0) << key;
  }
  EXPECT_LT(all["geodesic_deg"]["median"].get<double>(), 1e-6);
  EXPECT_EQ(all["within_5deg_5cm"]["value"], 1.0);
  EXPECT_EQ(all["projection_5px_recall"]["value"], 1.0);
  EXPECT_EQ(all["speed_plus_score"]["mean"], 0.0);
  EXPECT_EQ(lines_of(read_whole(path("mm/errors.csv"))), 4u);
  const std::string page = read_whole(path("mm/report.html"));
  EXPECT_THAT(page, HasSubstr("Average recall: 1.000"));
  EXPECT_THAT(page, HasSubstr("0 of 3 instances are missed"));
  EXPECT_TRUE(fs::exists(path("mm/figures/recall-mssd.svg")));

  write_truth("metres.csv", 0.001);
  const Outcome metres = score("metres.csv", "--out " + path("metres"));
  ASSERT_EQ(metres.exit_code, 0) << metres.output;
  for (const char* key : {"ar", "ar_mssd", "ar_mspd", "ar_vsd", "add_recall", "adi_recall"}) {
    EXPECT_EQ(read("metres/scores.json")["all"][key]["value"], 0.0) << key;
  }
  EXPECT_THAT(read_whole(path("metres/report.html")), HasSubstr("Average recall: 0.000"));
}

TEST_F(ScoreProgram, NotesNamesThatWouldSteerATerminalInPlainLines) {
  render_set();
  write_truth("mm.csv", 1);
  const fs::path copy = path("set/test/\x1b[31m\nred");
  fs::copy(path("set/test/000000"), copy, fs::copy_options::recursive);
  fs::remove(path("set/test_targets_bop19.json"));
  for (const Outcome& outcome :
       {score("mm.csv", "--quiet --out " + path("scores")),
        run("evaluate " + path("set") + " --target cube --solvers lspe --quiet --out " +
            path("run"))}) {
    EXPECT_THAT(outcome.output, HasSubstr("not read as scenes, whose names are numbers: "));
    EXPECT_EQ(outcome.output.find('\x1b'), std::string::npos) << outcome.output;
    EXPECT_EQ(outcome.output.find("\nred"), std::string::npos) << outcome.output;
  }
}

TEST_F(ScoreProgram, SaysInALineWhatIsWrong) {
  render_set();
  write_truth("mm.csv", 1);
  const auto expect_error = [](const Outcome& outcome, const std::string& text) {
    EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
    EXPECT_EQ(lines_of(outcome.output), 1u) << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr(text));
  };
  const std::string out = "--out " + path("out");
  expect_error(score("none.csv", out), "none.csv: is missing or cannot be read");
  expect_error(score("mm.csv", out + " --split train"), "train: is no folder");
  expect_error(run("score " + path("mm.csv") + " --dataset " + path("none") + " " + out),
               "none: is no folder");
  expect_error(score("mm.csv", "--out " + path("set")), "set");
  fs::remove(path("set/models_eval/obj_000001.ply"));
  expect_error(score("mm.csv", out), "obj_000001.ply: is missing");
  folder_.write("set/models_eval/obj_000001.ply", "solid cube\n");
  expect_error(score("mm.csv", out), "obj_000001.ply: cannot be read as a PLY mesh");
  fs::remove(path("set/models_eval/obj_000001.ply"));
  folder_.write("set/test/000000/scene_gt.json", "{\"0\": [{\"obj_id\": 1}]}");
  fs::copy_file(path("set/models/obj_000001.ply"), path("set/models_eval/obj_000001.ply"));
  expect_error(score("mm.csv", out), "scene_gt.json: is not as its format has it");
  EXPECT_FALSE(fs::exists(path("out")));
}

}  // namespace
}  // namespace sightline
