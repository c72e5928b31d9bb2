// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Sets whose images are numbered by the time at which they were taken, in nanoseconds: two that no
// double tells apart, and one whose zeros fill its names.
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "eval/datasets/bop/read.h"
#include "eval/datasets/bop/results_csv.h"
#include "eval/datasets/pictures.h"
#include "eval/output/csv_reader.h"
#include "tests/eval/program.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using testing::UnorderedElementsAreArray;

const std::vector<int64_t> kTimes = {1'700'000'000'123'456'789, 1'700'000'000'123'456'790, 4711};
const std::set<std::string> kTimesAsText = {"1700000000123456789", "1700000000123456790", "4711"};

// As of a writer that gives every number thirteen digits.
std::string padded(int64_t number) {
  return fmt::format("{:013}", number);
}

std::set<std::string> texts_in(const fs::path& file, const std::string& column) {
  std::set<std::string> texts;
  for (CsvReader csv(file); csv.next();) texts.emplace(csv.text(column));
  return texts;
}

// The errors of a solver in a run, by the images' ids.
std::map<std::string, double> thetas_deg(const fs::path& run, const std::string& solver) {
  std::map<std::string, double> thetas_deg;
  for (CsvReader csv(run / "results.csv"); csv.next();) {
    if (csv.text("solver") != solver) continue;
    thetas_deg[std::string(csv.text("im_id"))] = csv.number("theta_error_deg");
  }
  return thetas_deg;
}

class ImageIds : public testing::Test {
 protected:
  ImageIds() {
    const Outcome made = run(fmt::format("render cube --count {} --seed 5 --quiet --out {}",
                                         kTimes.size(), path("set")));
    EXPECT_EQ(made.exit_code, 0) << made.output;
    for (const char* file : {"scene_gt.json", "scene_camera.json", "scene_gt_info.json"}) {
      edit(scene() / file, [](json& content) {
        json by_time;
        for (size_t i = 0; i < kTimes.size(); ++i) {
          by_time[padded(kTimes[i])] = content.at(std::to_string(i));
        }
        content = by_time;
      });
    }
    edit(targets(), [](json& list) {
      for (json& target : list) target["im_id"] = kTimes[target.at("im_id").get<size_t>()];
    });
    for (size_t i = 0; i < kTimes.size(); ++i) {
      const std::string from = six_digits(static_cast<int64_t>(i));
      const std::string to = padded(kTimes[i]);
      for (const char* kind : {"gray", "depth"}) rename(kind, from, to);
      rename("mask_visib", from + "_000000", to + "_" + padded(0));
    }
  }

  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  fs::path scene() const { return path("set") + "/test/000000"; }
  fs::path targets() const { return path("set") + "/test_targets_bop19.json"; }
  void edit(const fs::path& file, const std::function<void(json&)>& change) const {
    json content = json::parse(read_whole(file));
    change(content);
    std::ofstream(file) << content;
  }
  void rename(const std::string& kind, const std::string& from, const std::string& to) const {
    fs::rename(scene() / kind / (from + ".png"), scene() / kind / (to + ".png"));
  }
  std::string evaluation(const std::string& out) const {
    return fmt::format("{} evaluate {} --target cube --quiet --solvers lspe --out {}",
                       SIGHTLINE_PROGRAM, path("set"), path(out));
  }
  Outcome evaluate(const std::string& out, const std::string& more) const {
    return run_shell(evaluation(out) + " " + more);
  }
  // The poses of a run, as others would hand them in.
  std::string results_of(const std::string& name) const {
    const std::string file = path(name + "_poses.csv");
    const Outcome out = run("export " + path(name) + " --solver lspe --out " + file);
    EXPECT_EQ(out.exit_code, 0) << out.output;
    return file;
  }

  TemporaryFolder folder_;
};

TEST_F(ImageIds, GoOutAndComeInAgainToTheDigit) {
  const Outcome own = evaluate("own", "");
  ASSERT_EQ(own.exit_code, 0) << own.output;
  EXPECT_EQ(texts_in(path("own") + "/results.csv", "im_id"), kTimesAsText);
  EXPECT_EQ(texts_in(path("own") + "/results.csv", "status"), std::set<std::string>{"ok"});
  const std::string poses = results_of("own");
  EXPECT_EQ(texts_in(poses, "im_id"), kTimesAsText);
  const std::string found = path("found.json");
  ASSERT_EQ(run("export " + path("own") + " --format coco --out " + found).exit_code, 0);
  for (const json& detection : json::parse(read_whole(found))) {
    EXPECT_TRUE(kTimesAsText.contains(detection.at("image_id").dump())) << detection;
  }

  const Outcome again = evaluate("again", "--estimates back=" + poses + " --prior " + poses +
                                              " --observations found=" + found);
  ASSERT_EQ(again.exit_code, 0) << again.output;
  EXPECT_EQ(texts_in(path("again") + "/results.csv", "status"), std::set<std::string>{"ok"});
  const auto before = thetas_deg(path("own"), "lspe");
  const auto after = thetas_deg(path("again"), "back");
  ASSERT_EQ(after.size(), kTimes.size());
  for (const auto& [im_id, theta_deg] : after) {
    EXPECT_NEAR(theta_deg, before.at(im_id), 1e-6) << im_id;
  }
}

TEST_F(ImageIds, AreThoseOfARunThatIsContinuedAndOneThatIsReportedAnew) {
  ASSERT_EQ(evaluate("own", "").exit_code, 0);
  const std::string results = read_whole(path("own") + "/results.csv");
  // Room for all but the report, which leaves the trials finished.
  const Outcome full = run_shell("ulimit -f 400; " + evaluation("full"));
  ASSERT_EQ(full.exit_code, 1) << full.output;
  ASSERT_THAT(full.output, HasSubstr("3 finished trials are kept for --resume"));
  const Outcome resumed = evaluate("full", "--resume");
  ASSERT_EQ(resumed.exit_code, 0) << resumed.output;
  EXPECT_EQ(read_whole(path("full") + "/results.csv"), results);
  fs::remove(path("own") + "/results.csv");
  ASSERT_EQ(run("report " + path("own")).exit_code, 0);
  EXPECT_EQ(read_whole(path("own") + "/results.csv"), results);
}

TEST_F(ImageIds, AreScoredAndComparedToTheDigit) {
  ASSERT_EQ(evaluate("own", "").exit_code, 0);
  const std::string score = "score own=" + results_of("own") + " --quiet --dataset " + path("set");
  const Outcome scored = run(score + " --out " + path("scores"));
  ASSERT_EQ(scored.exit_code, 0) << scored.output;
  for (const char* file : {"/targets.csv", "/errors.csv"}) {
    EXPECT_EQ(texts_in(path("scores") + file, "im_id"), kTimesAsText) << file;
  }
  EXPECT_EQ(texts_in(path("scores") + "/targets.csv", "estimated"), std::set<std::string>{"1"});
  const Outcome same = run("compare " + path("scores") + " " + path("scores"));
  EXPECT_EQ(same.exit_code, 0) << same.output;
}

TEST_F(ImageIds, AreThoseOfObservations) {
  std::string rows = "scene_id,im_id,feature,u,v,sigma\n";
  for (const int64_t time_ns : kTimes) rows += fmt::format("0,+{},vertex_0,1,2,0.5\n", time_ns);
  const std::string file = folder_.write("seen.csv", rows).string();
  const Outcome seen = evaluate("seen", "--observations seen=" + file);
  EXPECT_EQ(seen.exit_code, 0) << seen.output;
  folder_.write("seen.csv", rows + "0,1700000000123456788,vertex_0,1,2,0.5\n");
  EXPECT_THAT(evaluate("not", "--observations seen=" + file).output,
              HasSubstr("is about image 1700000000123456788 of scene 0, which the set does not"));
}

TEST_F(ImageIds, AreThoseOfImagewiseFilesToo) {
  const fs::path folder = folder_.path() / "imagewise/test";
  fs::create_directories(folder);
  const json truth = json::parse(read_whole(scene() / "scene_gt.json"));
  const json cameras = json::parse(read_whole(scene() / "scene_camera.json"));
  for (const int64_t time_ns : kTimes) {
    const fs::path beginning = folder / ("000003_" + padded(time_ns));
    std::ofstream(beginning.string() + ".gt.json") << truth.at(padded(time_ns));
    std::ofstream(beginning.string() + ".camera.json") << cameras.at(padded(time_ns));
  }
  std::vector<int64_t> times;
  for (const BopImage& image : read_bop_images(folder.parent_path(), "").images) {
    times.push_back(image.im_id);
    EXPECT_EQ(image.scene_id, 3);
  }
  EXPECT_THAT(times, UnorderedElementsAreArray(kTimes));
  std::ofstream(folder / "9223372036854775808.gt.json") << truth.begin().value();
  EXPECT_THAT(error_of([&] { read_bop_images(folder.parent_path(), ""); }),
              HasSubstr("must begin with the numbers of scene and image"));
}

TEST_F(ImageIds, EndBelowTwoToThe63) {
  const auto error = [this] { return error_of([this] { read_bop_images(path("set"), ""); }); };
  const auto ask_for = [this](const json& im_id) {
    edit(targets(), [&](json& list) { list.front()["im_id"] = im_id; });
  };
  ask_for(9223372036854775807);
  EXPECT_THAT(error(), HasSubstr("asks for scene 0 image 9223372036854775807, which"));
  ask_for(9223372036854775808u);
  EXPECT_THAT(error(),
              HasSubstr("im_id is 9223372036854775808, must be a whole number below 2^63"));
  ask_for(1e20);
  EXPECT_THAT(error(), HasSubstr("must be a whole number below 2^63"));
  ask_for(1.7e18);
  EXPECT_THAT(error(), HasSubstr("must be a whole number in all its digits"));
  ask_for(4711.0);
  EXPECT_EQ(error(), "");
  edit(scene() / "scene_gt.json",
       [](json& truth) { truth["9223372036854775808"] = json::array(); });
  EXPECT_THAT(error(), HasSubstr("'9223372036854775808' is no id, which must be a whole number "
                                 "below 2^63"));
}

TEST_F(ImageIds, OfResultsStandInAllTheirDigits) {
  const auto read = [this](const std::string& im_id) {
    const fs::path file =
        folder_.write("poses.csv", "scene_id,im_id,obj_id,score,R,t,time\n0," + im_id +
                                       ",1,1,1 0 0 0 1 0 0 0 1,0 0 1000,-1\n");
    return read_bop_results(file).front().im_id;
  };
  EXPECT_EQ(read("9223372036854775807"), 9223372036854775807);
  EXPECT_EQ(read("1700000000123456789"), 1700000000123456789);
  EXPECT_EQ(read("+3.0"), 3);
  EXPECT_EQ(read("-3"), -3);
  for (const char* rounded : {"9223372036854775808", "1.7e18", "1700000000123456789.0"}) {
    EXPECT_THAT(error_of([&] { read(rounded); }),
                HasSubstr("line 2 has im_id '" + std::string(rounded) +
                          "', must be a whole number below 2^63 in all its digits"));
  }
}

}  // namespace
}  // namespace sightline
