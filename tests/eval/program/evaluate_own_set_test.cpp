// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Image sets that the program itself wrote come back to the digit.
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "eval/study/study_file.h"
#include "eval/trial/image_trial.h"
#include "tests/eval/program.h"
#include "tests/eval/studies.h"
#include "tests/eval/trial/inliers.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string kFive =
    "features = ['wing_tip_le_port', 'wing_tip_te_port', 'wing_tip_le_starboard', "
    "'wing_tip_te_starboard', 'nose']\n";
constexpr int kImages = 4;
// What millimetres and quaternions round, and solvers' last steps make of it.
constexpr double kSamePx = 1e-6;
constexpr double kSameDeg = 1e-4;

class OwnSet : public testing::Test {
 protected:
  std::string render(const std::string& format, const StudyOverrides& overrides = {}) const {
    const std::string set = (folder_.path() / format).string();
    fs::remove_all(set);
    std::string line =
        fmt::format("render boeing-random --count {} --scene-size 3 --quiet", kImages);
    for (const std::string& key : overrides.set) line += fmt::format(" --set '{}'", key);
    const Outcome made = run(line + " --format " + format + " --out " + set);
    EXPECT_EQ(made.exit_code, 0) << made.output;
    return set;
  }
  Study study_of(const std::string& set, const std::string& more = "") const {
    return read_study_text("target = 'boeing707'\nsolvers = ['orpe', 'lspe', 'oracle']\n" + kFive +
                               "[dataset]\npath = '" + set + "'\n" + more,
                           "evaluate");
  }
  void edit(const fs::path& file, const std::function<void(json&)>& change) const {
    json content = json::parse(read_whole(file));
    change(content);
    std::ofstream(file) << content;
  }
  // Of both scenes of a BOP set.
  void edit_truth(const fs::path& set, const std::function<void(json&)>& change) const {
    for (const char* scene : {"000000", "000001"})
      edit(set / "test" / scene / "scene_gt.json", change);
  }
  TemporaryFolder folder_;
};

void expect_same(const Trial& a, const Trial& b) {
  EXPECT_EQ(cv::norm(a.frame.image, b.frame.image, cv::NORM_INF), 0);
  ASSERT_EQ(a.record.observations().size(), b.record.observations().size());
  for (size_t i = 0; i < a.record.observations().size(); ++i) {
    const ObservationRecord& x = a.record.observations()[i];
    const ObservationRecord& y = b.record.observations()[i];
    EXPECT_EQ(x.feature, y.feature);
    EXPECT_EQ(x.status, y.status);
    EXPECT_EQ(x.label, y.label);
    EXPECT_EQ(x.is_visible, y.is_visible);
    EXPECT_LT((x.true_pixel - y.true_pixel).norm(), kSamePx);
    EXPECT_LT((x.pixel - y.pixel).norm(), kSamePx);
  }
  ASSERT_EQ(a.record.estimates().size(), b.record.estimates().size());
  for (size_t i = 0; i < a.record.estimates().size(); ++i) {
    const EstimateRecord& x = a.record.estimates()[i];
    const EstimateRecord& y = b.record.estimates()[i];
    EXPECT_EQ(x.status, y.status);
    EXPECT_EQ(x.removed, y.removed);
    EXPECT_NEAR(x.geodesic_deg, y.geodesic_deg, kSameDeg);
    EXPECT_NEAR(x.t_error_percent, y.t_error_percent, kSameDeg);
  }
}

// A set and what has to be said of it that its format cannot say.
struct OwnCase {
  std::string format;
  std::vector<std::string> rendered;
  std::string evaluated;
};

const std::string kLens = "camera.distortion=[-0.5, 3, 0.01, 0.02, 0]";
const std::string kFisheye = "camera.lens=fisheye";
const std::string kFisheyeLens = "camera.distortion=[-20, 3, 1, 2]";
const std::string kRational = "camera.lens=rational";
const std::string kRationalLens = "camera.distortion=[-0.5, 3, 0.01, 0.02, 0, 1, 2, 3]";
const std::string kSkew = "camera.skew_px=50";
const std::string kOccluders = R"(other=[{target="cube", scale=12, count=3, offset_px=[-90, 90]}])";

// Poses, units, the half pixel, lenses, masks and the draws of priors survive the way through the
// files.
TEST_F(OwnSet, GivesWhatTheStudyGaveThatRenderedIt) {
  const std::vector<OwnCase> cases = {
      {"bop", {}, ""},
      {"speed", {}, ""},
      {"bop", {"image.bits=12"}, "bits = 12\n"},
      {"speed", {kLens}, ""},
      {"bop", {kLens}, "[camera]\ndistortion = [-0.5, 3, 0.01, 0.02, 0]\n"},
      {"speed", {kFisheye, kFisheyeLens}, ""},
      {"bop",
       {kRational, kRationalLens, kSkew},
       "[camera]\nlens = \"rational\"\ndistortion = [-0.5, 3, 0.01, 0.02, 0, 1, 2, 3]\n"},
      {"bop",
       {"image.colour=rgb", "extraction.channel=contrast"},
       "[extraction]\nchannel = \"contrast\"\n"},
      {"bop", {kOccluders}, ""}};
  Renderer renderer;
  for (const OwnCase& c : cases) {
    const StudyOverrides overrides{.trials = kImages, .seed = {}, .set = c.rendered};
    const Study rendered = read_study("boeing-random", overrides);
    const Study evaluated = study_of(render(c.format, overrides), c.evaluated);
    ASSERT_EQ(evaluated.trial_count(), kImages);
    int hidden = 0;
    for (int i = 0; i < kImages; ++i) {
      SCOPED_TRACE(fmt::format("{} {} image {}", c.format, c.evaluated, i));
      const Trial trial = run_trial(evaluated, i, renderer);
      expect_same(run_trial(rendered, i, renderer), trial);
      for (const FeatureTruth& f : trial.frame.truth.target().features)
        hidden += f.is_hidden_by_other;
    }
    EXPECT_EQ(hidden > 0, !c.rendered.empty() && c.rendered[0] == kOccluders);
  }
}

TEST_F(OwnSet, ShowsAHalfPixelTooMuch) {
  const std::string set = render("speed");
  Renderer renderer;
  const Trial right = run_trial(study_of(set), 0, renderer);
  edit(fs::path(set) / "camera.json",
       [](json& camera) { camera["cameraMatrix"][0][2] = 0.5 + double(camera["ccx"]); });
  const Trial wrong = run_trial(study_of(set), 0, renderer);
  for (size_t i = 0; i < right.record.observations().size(); ++i) {
    EXPECT_NEAR(wrong.record.observations()[i].true_pixel.x(),
                right.record.observations()[i].true_pixel.x() + 0.5, kSamePx);
  }
}

TEST_F(OwnSet, ShowsATransposedRotation) {
  const std::string set = render("bop");
  Renderer renderer;
  const auto inliers = [&] {
    const Study study = study_of(set);
    int count = 0;
    for (int i = 0; i < kImages; ++i) count += inliers_of(run_trial(study, i, renderer).record);
    return count;
  };
  const int right = inliers();
  edit_truth(set, [](json& images) {
    for (json& image : images) {
      json& r = image[0]["cam_R_m2c"];
      r = {r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]};
    }
  });
  EXPECT_GT(right, 2 * kImages);
  EXPECT_LT(2 * inliers(), right);
}

TEST_F(OwnSet, IsRefusedInMetres) {
  const std::string set = render("bop");
  edit_truth(set, [](json& images) {
    for (json& image : images) {
      for (json& t : image[0]["cam_t_m2c"]) t = 1e-3 * double(t);
    }
  });
  EXPECT_THAT(error_of([&] { study_of(set); }),
              AllOf(HasSubstr("none of its 4 poses"), HasSubstr("must be in mm in BOP")));
}

TEST_F(OwnSet, IsRefusedForAnotherModelOrOtherAxes) {
  const std::string set = render("bop");
  EXPECT_EQ(error_of([&] { study_of(set, "box_tolerance = 0.0001\n"); }), "");
  EXPECT_THAT(error_of([&] { study_of(set, "axes = 'file'\n"); }),
              AllOf(HasSubstr("models_info.json: object 1 fills"), HasSubstr("--axes target")));
  EXPECT_EQ(run("evaluate " + set + " --target cube --quiet --out " + set + "-out").exit_code, 1);
  EXPECT_FALSE(fs::exists(set + "-out"));
  const std::string speed = render("speed");
  EXPECT_THAT(run("evaluate " + speed + " --target cube --out " + set + "-out").output,
              HasSubstr("model/target.ply: object 1 fills"));
}

TEST_F(OwnSet, IsEvaluatedAsAnyRunIs) {
  const std::string set = render("bop");
  const auto evaluate = [&](const std::string& out, const std::string& more) {
    const Outcome outcome = run(fmt::format(
        "evaluate {} --target boeing707 --solvers lspe,oracle --extractor model_edges --quiet "
        "--out {}/{} {}",
        set, folder_.path().string(), out, more));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    return read_whole(folder_.path() / out / "results.csv");
  };
  const std::string all = evaluate("all", "--jobs 1");
  EXPECT_EQ(lines_of(all), 1u + 2 * kImages);
  EXPECT_THAT(all, HasSubstr("\n3,all,test/000001/gray/000000.png,1,0,0,lspe,ok,"));
  EXPECT_EQ(evaluate("jobs", "--jobs 2"), all);
  EXPECT_THAT(all, testing::StartsWith(evaluate("two", "--trials 2")));
  evaluate("a", "--shard 0/2");
  evaluate("b", "--shard 1/2");
  const std::string at = folder_.path().string() + "/";
  EXPECT_EQ(run("merge " + at + "a " + at + "b --out " + at + "merged").exit_code, 0);
  EXPECT_EQ(read_whole(at + "merged/results.csv"), all);
  EXPECT_EQ(run("study " + at + "all/study.toml --quiet --out " + at + "again").exit_code, 0);
  EXPECT_EQ(read_whole(at + "again/results.csv"), all);
  EXPECT_THAT(read_whole(at + "all/report.html"),
              HasSubstr("How well do these solvers do on bop?"));
  EXPECT_EQ(json::parse(read_whole(at + "all/summary.json"))["cells"].size(), 2u);
}

TEST_F(OwnSet, IsSweptOverPriorsAndExtractorsAlone) {
  const std::string set = render("bop");
  const Study study =
      study_of(set, "[sweep]\n'prior.attitude_deg' = [1, 4]\n'extraction.passes' = [1, 2]\n");
  EXPECT_EQ(study.conditions.size(), 4u);
  EXPECT_EQ(study.trial_count(), 4 * kImages);
  EXPECT_EQ(study.images()->sighting_of(4 * 2 + 3).im_id, 2);
  EXPECT_THAT(error_of([&] { study_of(set, "[sweep]\n'background.level' = [0, 1]\n"); }),
              HasSubstr("[prior], [extraction]"));
  EXPECT_THAT(error_of([&] { study_of(set, "[extraction]\nbias_removal = 'known_light'\n"); }),
              HasSubstr("nobody knows the light"));
  EXPECT_THAT(error_of([&] { study_of(set, "[light]\nambient = 1\n"); }), HasSubstr("light"));
}

}  // namespace
}  // namespace sightline
