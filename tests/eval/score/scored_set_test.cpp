// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// `score` with several methods, with requirements, and of sets in SPEED+'s format.
#include "eval/score/scored_set.h"

#include <map>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "eval/datasets/picture_names.h"
#include "eval/score/score.h"
#include "tests/eval/program.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

class SpeedScores : public testing::Test {
 protected:
  void SetUp() override {
    const Outcome made =
        run("render cube --format speed --set camera.width_px=64 --set camera.height_px=64 "
            "--set camera.f_px=250 --set image.samples_per_pixel=1 --quiet --count 3 --out " +
            path("set"));
    ASSERT_EQ(made.exit_code, 0) << made.output;
    list_ = json::parse(read_whole(path("set/train.json")));
  }

  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  json read(const std::string& file) const { return json::parse(read_whole(path(file))); }

  // The challenges' CSV of the true poses, at positions that are farther by a factor.
  std::string csv(double factor = 1) const {
    std::string text;
    for (const json& entry : list_) {
      const json& q = entry["q_vbs2tango_true"];
      const json& r = entry["r_Vo2To_vbs_true"];
      text += fmt::format("{}, {}, {}, {}, {}, {}, {}, {}\n", entry["filename"].get<std::string>(),
                          q[0].get<double>(), q[1].get<double>(), q[2].get<double>(),
                          q[3].get<double>(), factor * r[0].get<double>(),
                          factor * r[1].get<double>(), factor * r[2].get<double>());
    }
    return text;
  }

  Outcome score(const std::string& results, const std::string& more) const {
    return run("score " + results + " --dataset " + path("set") + " " + more);
  }

  TemporaryFolder folder_;
  json list_;
};

TEST_F(SpeedScores, OfTheTrueListAreFullMarksAndOfAFartherOneNot) {
  const std::string truth = folder_.write("truth.csv", csv());
  const std::string farther =
      folder_.write("farther.csv", "filename,q0,q1,q2,q3,x,y,z\n" + csv(1.1));
  const Outcome scored =
      score("list=" + path("set/train.json") + " " + truth + " " + farther,
            "--out " + path("scores") + " --require 'add_recall>=0.9' --junit " + path("x.xml"));
  EXPECT_EQ(scored.exit_code, 3) << scored.output;
  EXPECT_THAT(scored.output, HasSubstr("farther: add_recall is 0, must be 0.9 or more"));
  EXPECT_THAT(read_whole(path("x.xml")), HasSubstr("tests=\"3\" failures=\"1\""));
  for (const char* name : {"list", "truth"}) {
    const json all = read(fmt::format("scores/{}/scores.json", name))["all"];
    EXPECT_EQ(all["targets"], 3) << name;
    EXPECT_EQ(all["add_recall"]["value"], 1.0) << name;
    EXPECT_EQ(all["ar_mspd"]["value"], 1.0) << name;
    EXPECT_LT(all["speed_score"]["mean"].get<double>(), 1e-6) << name;
    EXPECT_THAT(scored.output, HasSubstr(fmt::format("{}: add_recall is 1, which is", name)));
  }
  const json methods = read("scores/scores.json")["methods"];
  ASSERT_EQ(methods.size(), 3u);
  EXPECT_EQ(methods[2]["name"], "farther");
  EXPECT_NEAR(methods[2]["all"]["speed_score"]["mean"].get<double>(), 0.1, 1e-6);
  EXPECT_EQ(methods[2]["all"]["add_recall"]["value"], 0.0);
  EXPECT_EQ(score(truth, "--quiet --require 'add_recall>=0.9' --out " + path("met")).exit_code, 0);
}

// As SPEED+ itself comes: without a mesh.
TEST_F(SpeedScores, WithoutAModelAreOfThePosesAlone) {
  fs::remove(path("set/model/target.ply"));
  const std::string farther = folder_.write("farther.csv", csv(1.1));
  const Outcome scored = score(farther, "--out " + path("scores"));
  EXPECT_EQ(scored.exit_code, 0) << scored.output;
  EXPECT_THAT(scored.output, HasSubstr("the data set has no model"));
  const json all = read("scores/scores.json")["all"];
  EXPECT_NEAR(all["speed_score"]["mean"].get<double>(), 0.1, 1e-6);
  EXPECT_EQ(all["estimated"], 3);
  EXPECT_TRUE(all["add_recall"]["value"].is_null());
  EXPECT_TRUE(all["ar_mssd"]["value"].is_null());
  EXPECT_THAT(read_whole(path("scores/report.html")), HasSubstr("Mean SPEED score: 0.1000"));
  EXPECT_FALSE(fs::exists(path("scores/figures/recall-mssd.svg")));
  const std::string truth = folder_.write("truth.csv", csv());
  ASSERT_EQ(score(truth, "--quiet --out " + path("true")).exit_code, 0);
  const Outcome compared = run("compare " + path("true") + " " + path("scores") +
                               " --measure speed_score.mean,failure_rate");
  EXPECT_THAT(compared.output, HasSubstr("paired: 3 targets"));
  EXPECT_EQ(run("compare " + path("true") + " " + path("scores") + " --measure add_mm").exit_code,
            1);
  EXPECT_EQ(score(truth, "--require 'ADD>=0.9' --out " + path("none")).exit_code, 1);
  EXPECT_FALSE(fs::exists(path("none")));
}

TEST_F(SpeedScores, SayInALineWhatIsWrong) {
  const ScoredSet set = read_scored_set(path("set"), "");
  const auto error = [&](const std::string& name, const std::string& text) {
    return error_of([&] { read_estimates(folder_.write(name, text), set); });
  };
  const std::string row = csv().substr(0, csv().find('\n') + 1);
  EXPECT_EQ(read_estimates(folder_.write("good.csv", row), set).size(), 1u);
  EXPECT_THAT(error("twice.csv", row + row), HasSubstr("twice.csv: line 2 names a picture that"));
  EXPECT_THAT(
      error("no.csv", "img9.png,1,0,0,0,0,0,9\n"),
      HasSubstr("no.csv: the set has none of its pictures, the first of which is 'img9.png'"));
  EXPECT_EQ(error("more.csv", row + "img9.png,1,0,0,0,0,0,9\n"), "") << "of another split";
  EXPECT_EQ(score_bop(set.dataset, read_estimates(path("more.csv"), set), 15).ignored_estimates,
            1u);
  EXPECT_THAT(error("none.csv", "\n"), HasSubstr("none.csv: has no estimates"));
  EXPECT_THAT(error("none.json", "[]"), HasSubstr("none.json: has no estimates"));
  EXPECT_THAT(error("paths.csv", row + "images/" + row),
              HasSubstr("has two estimates of one picture"));
  EXPECT_THAT(error("few.csv", row + "img000001.png,1,0\n"), HasSubstr("line 2 has 3 fields"));
  EXPECT_THAT(error("text.csv", "img000001.png,1,0,0,0,0,x,9\n"), HasSubstr("line 1 has 'x'"));
  EXPECT_EQ(error("long.csv", "img000001.png,2,0,0,0,0,0,9\n"), "");
  EXPECT_THAT(failed_rows(read_estimates(path("long.csv"), set)),
              HasSubstr("in line 1: the quaternion has the length 2, must have length 1"));
  EXPECT_THAT(error("list.json", R"([{"filename": "img000001.png"}])"),
              HasSubstr("has no 'q_vbs2tango_true'"));
  EXPECT_THAT(error("text.json", "[1"), HasSubstr("is not as its format has it"));

  const json list = json::parse(read_whole(path("set/train.json")));
  json twice = list;
  twice.push_back(list.front());
  folder_.write("set/train.json", twice.dump());
  EXPECT_THAT(error_of([&] { read_scored_set(path("set"), ""); }), HasSubstr("is listed twice"));
  folder_.write("set/train.json", list.dump());

  const std::string good = path("good.csv");
  const std::string out = " --out " + path("out");
  for (const std::string& arguments :
       {good + " " + good + out, "../x=" + good + out, good + out + " --junit " + path("x.xml"),
        good + out + " --require 'add>0.9'", good + out + " --split none"}) {
    const Outcome outcome = score(arguments, "");
    EXPECT_EQ(outcome.exit_code, 1) << arguments << outcome.output;
    EXPECT_EQ(lines_of(outcome.output), 1u) << outcome.output;
  }
  EXPECT_FALSE(fs::exists(path("out")));
}

// Sets may have pictures of one name in several folders: an estimate must say of which it is.
TEST_F(SpeedScores, KnowPicturesByTheirFoldersToo) {
  PictureNames names;
  names.add("/set/images/a/1.png", 0);
  names.add("/set/images/b/1.png", 1);
  names.add("/set/images/b/2.png", 2);
  for (const auto& [name, id] : std::map<std::string, int>{{"a/1.png", 0},
                                                           {"images/b/1.png", 1},
                                                           {"./b//1.png", 1},
                                                           {"2.png", 2},
                                                           {"../b/2.png", 2},
                                                           {"/set/images/a/1.png", 0},
                                                           {"/mnt/set/images/b/2.png", 2}}) {
    EXPECT_EQ(names.find(name, "r.csv"), id) << name;
  }
  // Of another set, such as a split of SPEED+, the file may have the same name.
  for (const char* name : {"3.png", "elsewhere/2.png", "c/1.png", "/other/images/b/2.png"}) {
    EXPECT_EQ(names.find(name, "r.csv"), std::nullopt) << name;
  }
  EXPECT_THAT(error_of([&] { names.find("1.png", "r.csv"); }),
              HasSubstr("r.csv: the set has several pictures '1.png': say which"));
}

}  // namespace
}  // namespace sightline
