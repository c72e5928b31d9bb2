// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// BOP sets as people have them: legal, but not as our own writer writes them. Each is read to the
// numbers that the plain set gives, or is refused in one line that says what is not so.
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "eval/datasets/bop/models.h"
#include "eval/datasets/bop/read.h"
#include "eval/datasets/bop/results_csv.h"
#include "eval/datasets/model_file.h"
#include "eval/score/score.h"
#include "scenes/picture/picture_file.h"
#include "tests/eval/cube_of_100_mm.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr int kWidth = 64, kHeight = 48;
constexpr double kDeltaMm = 15;  // of VSD

// Three images of a cube of 100 mm, 1000 mm away, with depth.
class OddSet : public testing::Test {
 protected:
  OddSet() {
    for (const char* kind : {"rgb", "depth"}) fs::create_directories(scene() / kind);
    fs::create_directories(set() / "models");
    json cameras, truths;
    for (int im_id = 0; im_id < 3; ++im_id) {
      cameras[std::to_string(im_id)] = {{"cam_K", {500, 0, 32, 0, 500, 24, 0, 0, 1}},
                                        {"depth_scale", 1.0}};
      truths[std::to_string(im_id)] = json::array({truth()});
      const std::string name = fmt::format("{:06}.png", im_id);
      std::ofstream(scene() / "rgb" / name, std::ios::binary)
          << png_bytes(cv::Mat::zeros(kHeight, kWidth, CV_8UC3));
      std::ofstream(scene() / "depth" / name, std::ios::binary)
          << png_bytes(cv::Mat::zeros(kHeight, kWidth, CV_16U));
    }
    write("test/000001/scene_camera.json", cameras.dump());
    write("test/000001/scene_gt.json", truths.dump());
    write("models/obj_000001.ply", ply_bytes(cube()));
    write("models/models_info.json", R"({"1": {"diameter": 173.205}})");
  }

  static Mesh cube() {
    Mesh mesh;
    const Eigen::Matrix3Xd points = cube_points();
    for (int i = 0; i < points.cols(); ++i) mesh.vertices.emplace_back(1e-3 * points.col(i));
    constexpr std::array<std::array<int, 3>, 12> kFaces = {{{0, 1, 3},
                                                            {0, 3, 2},
                                                            {4, 5, 7},
                                                            {4, 7, 6},
                                                            {0, 1, 5},
                                                            {0, 5, 4},
                                                            {2, 3, 7},
                                                            {2, 7, 6},
                                                            {0, 2, 6},
                                                            {0, 6, 4},
                                                            {1, 3, 7},
                                                            {1, 7, 5}}};
    for (const std::array<int, 3>& face : kFaces) mesh.triangles.push_back({.vertex = face});
    return mesh;
  }
  static json truth() {
    return {{"obj_id", 1}, {"cam_R_m2c", {1, 0, 0, 0, 1, 0, 0, 0, 1}}, {"cam_t_m2c", {0, 0, 1000}}};
  }
  fs::path set() const { return folder_.path() / "set"; }
  fs::path scene() const { return set() / "test/000001"; }
  void write(const std::string& name, const std::string& text) const {
    folder_.write("set/" + name, text);
  }
  json read(const std::string& name) const { return json::parse(read_whole(set() / name)); }
  BopDataset dataset() const { return read_bop_dataset(set(), ""); }
  std::string error() const {
    return error_of([this] { dataset(); });
  }

  // A row of results, of the true pose where nothing else is said.
  static std::string row(int im_id, const std::string& r = "1 0 0 0 1 0 0 0 1",
                         const std::string& t = "0 0 1000", const std::string& score = "1",
                         const std::string& time = "-1", int scene_id = 1) {
    return fmt::format("{},{},1,{},{},{},{}\n", scene_id, im_id, score, r, t, time);
  }
  std::vector<BopEstimate> estimates(const std::string& rows) const {
    return read_bop_results(
        folder_.write("r.csv", "scene_id,im_id,obj_id,score,R,t,time\n" + rows));
  }
  BopScores scores(const std::string& rows) const {
    return score_bop(dataset(), estimates(rows), kDeltaMm);
  }
  double recall(const std::string& rows) const { return summarise(scores(rows)).ar_mssd.value; }

  TemporaryFolder folder_;
};

const std::string kEye = "1 0 0 0 1 0 0 0 1";

TEST_F(OddSet, IsReadAndGivenFullMarksAsItStands) {
  const BopSummary summary = summarise(scores(row(0) + row(1) + row(2)));
  EXPECT_EQ(summary.ar.value, 1);
  EXPECT_EQ(summary.ar_vsd.value, 1);
  EXPECT_THAT(dataset().notes, IsEmpty());
}

TEST_F(OddSet, OfPointsWithoutFacesHasNoVsdInsteadOfNone) {
  Mesh points = cube();
  points.triangles.clear();
  write("models/obj_000001.ply", ply_bytes(points));
  const BopScores scored = scores(row(0) + row(1) + row(2));
  EXPECT_FALSE(scored.has_vsd);
  EXPECT_THAT(note_on_vsd(scored), HasSubstr("points and no faces"));
  const BopSummary summary = summarise(scored);
  EXPECT_TRUE(std::isnan(summary.ar.value));
  EXPECT_EQ(summary.ar_mssd.value, 1);
}

TEST_F(OddSet, TakesEachRowThatIsNoPoseForAFailure) {
  const std::string good = row(0) + row(1);
  EXPECT_EQ(recall(good + row(2)), 1);
  const std::string with_nan = "nan 0 0 0 1 0 0 0 1";
  for (const std::string& bad :
       {row(2, with_nan), row(2, "2 0 0 0 2 0 0 0 2"), row(2, "-1 0 0 0 1 0 0 0 1"),
        row(2, kEye, "0 inf 1000"), row(2, kEye, "0 0 1000", "nan"),
        row(2, kEye, "0 0 1000", "1", "inf"), row(2, kEye, "0 0 1000", "1", "-1", -1)}) {
    EXPECT_DOUBLE_EQ(recall(good + bad), 2.0 / 3) << bad;
    EXPECT_EQ(summarise(scores(good + bad)).estimated, 2) << bad;
  }
  EXPECT_EQ(failed_rows(estimates(good)), "");
  EXPECT_EQ(failed_rows(estimates(good + row(2, with_nan))),
            "1 row is no estimate and counts as failed, the first in line 4: R is not finite");
}

// Half a percent of scale is 1e-2 of the transpose times itself.
TEST_F(OddSet, MendsARotationThatWasRoundedAndKeepsOneThatWasNot) {
  const auto rotation = [&](const std::string& r) {
    return estimates(row(0, r)).front().cam_from_model.rotation;
  };
  EXPECT_EQ(rotation("1.000004 0 0 0 1 0 0 0 1")(0, 0), 1.000004);
  EXPECT_TRUE(rotation("1.004 0 0 0 1.004 0 0 0 1.004").isApprox(Eigen::Matrix3d::Identity()));
  EXPECT_EQ(estimates(row(0, "1.006 0 0 0 1.006 0 0 0 1.006")).front().problem, "R is no rotation");
}

TEST_F(OddSet, HasOneFailureWhereATruePoseIsNone) {
  std::string text = read("test/000001/scene_gt.json").dump();
  text.replace(text.rfind("1000"), 4, "NaN");  // as Python writes it
  write("test/000001/scene_gt.json", text);
  EXPECT_DOUBLE_EQ(recall(row(0) + row(1) + row(2)), 2.0 / 3);
}

TEST_F(OddSet, HasOneMissByVsdWhereDepthIsTornOrAbsent) {
  const std::string rows = row(0) + row(1) + row(2);
  write("test/000001/depth/000001.png", "torn");
  EXPECT_DOUBLE_EQ(summarise(scores(rows)).ar_vsd.value, 2.0 / 3);
  EXPECT_EQ(summarise(scores(rows)).ar_mssd.value, 1);
  EXPECT_THAT(note_on_vsd(scores(rows)), HasSubstr("the depth of 1 of the images"));
  fs::remove(scene() / "depth/000001.png");
  EXPECT_DOUBLE_EQ(summarise(scores(rows)).ar_vsd.value, 2.0 / 3);
  // One of half the size would be compared with what is elsewhere.
  write("test/000001/depth/000001.png", png_bytes(cv::Mat::zeros(kHeight / 2, kWidth / 2, CV_16U)));
  EXPECT_DOUBLE_EQ(summarise(scores(rows)).ar_vsd.value, 2.0 / 3);
  EXPECT_THAT(note_on_vsd(scores(rows)), HasSubstr("1 of the images is missing, of another size"));
  write("test/000001/depth/000001.png", png_bytes(cv::Mat::zeros(kHeight - 8, kWidth, CV_16U)));
  EXPECT_DOUBLE_EQ(summarise(scores(rows)).ar_vsd.value, 2.0 / 3);
}

TEST_F(OddSet, HasNoVsdWhereAllDepthIsOfAnotherSize) {
  const std::string depth = png_bytes(cv::Mat::zeros(kHeight / 2, kWidth / 2, CV_16U));
  for (const char* name : {"000000", "000001", "000002"}) {
    write(fmt::format("test/000001/depth/{}.png", name), depth);
  }
  const BopScores scored = scores(row(0) + row(1) + row(2));
  EXPECT_FALSE(scored.has_vsd);
  EXPECT_THAT(note_on_vsd(scored), HasSubstr("the depth of all images is of another size"));
  EXPECT_TRUE(std::isnan(summarise(scored).ar.value));
  EXPECT_EQ(summarise(scored).ar_mssd.value, 1);
}

TEST_F(OddSet, TakesTheScaleOfItsDepthFromItsCameraWhereNoImageStatesOne) {
  json cameras = read("test/000001/scene_camera.json");
  cameras["1"].erase("depth_scale");
  write("test/000001/scene_camera.json", cameras.dump());
  EXPECT_EQ(dataset().images[1].depth_scale, 1);
  EXPECT_THAT(dataset().notes, ElementsAre(HasSubstr("1 image with depth but no depth_scale: 1 mm "
                                                     "counts, as nothing else is stated")));
  write("camera.json", R"({"depth_scale": 0.1})");
  EXPECT_EQ(dataset().images[0].depth_scale, 1);
  EXPECT_EQ(dataset().images[1].depth_scale, 0.1);
  EXPECT_THAT(dataset().notes, ElementsAre(HasSubstr("0.1 mm counts, by ")));
  fs::remove_all(scene() / "depth");
  EXPECT_THAT(dataset().notes, IsEmpty());
}

TEST_F(OddSet, TakesTheWidthOfItsPicturesAndNotThatOfItsCamera) {
  write("camera.json", R"({"width": 64, "height": 48})");
  EXPECT_THAT(dataset().notes, IsEmpty());
  write("camera.json", R"({"width": 128, "height": 96})");
  EXPECT_EQ(dataset().images[0].width_px, kWidth);
  EXPECT_THAT(dataset().notes, ElementsAre(HasSubstr("128 px wide, they are 64")));
  fs::remove_all(scene() / "rgb");
  fs::remove_all(scene() / "depth");
  EXPECT_EQ(dataset().images[0].width_px, 128);
}

TEST_F(OddSet, ObeysTheListOfDetectionWhereItHasNoOther) {
  write("test_targets_bop24.json", R"([{"scene_id": 1, "im_id": 2}])");
  ASSERT_EQ(dataset().images.size(), 1u);
  EXPECT_EQ(dataset().images[0].im_id, 2);
  EXPECT_EQ(dataset().images[0].targets.at(1), 1);
  write("test_targets_bop19.json",
        R"([{"scene_id": 1, "im_id": 0, "obj_id": 1, "inst_count": 1}])");
  EXPECT_EQ(dataset().images[0].im_id, 0);
  EXPECT_THAT(dataset().notes, ElementsAre(HasSubstr("test_targets_bop24.json: is not used")));
  write("test_targets_bop19.json",
        R"([{"scene_id": 1, "im_id": 7, "obj_id": 1, "inst_count": 1}])");
  EXPECT_THAT(error(), HasSubstr("asks for scene 1 image 7, which scene_gt.json has not"));
}

TEST_F(OddSet, IsReadAsItsOwnToolkitReadsIt) {
  const std::string rows = row(0) + row(1) + row(2);
  const json truths = read("test/000001/scene_gt.json");
  json nested;
  for (const auto& [key, value] : truths.items()) {
    nested["00000" + key] = {{{"obj_id", 1},
                              {"cam_R_m2c", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                              {"cam_t_m2c", {{0}, {0}, {1000}}}}};
  }
  write("test/000001/scene_gt.json", "\xEF\xBB\xBF" + nested.dump());
  EXPECT_EQ(recall(rows), 1);
  write("test/000001/scene_gt_info.json", R"({"000000": [{"visib_fract": 0.5}]})");
  EXPECT_EQ(dataset().images.size(), 3u);  // what it does not tell of is visible
  fs::rename(scene(), set() / "test/1");
  EXPECT_EQ(recall(rows), 1);
  fs::rename(set() / "test/1/rgb/000000.png", set() / "test/1/rgb/0000.PNG");
  EXPECT_EQ(bop_picture(dataset().images[0]).filename(), "0000.PNG");
  fs::remove(set() / "test/1/rgb/0000.PNG");
  EXPECT_THAT(bop_picture(dataset().images[0]).string(), IsEmpty());
  folder_.write("bare.csv", rows);
  EXPECT_EQ(read_bop_results(folder_.path() / "bare.csv").size(), 3u);
}

TEST_F(OddSet, NeedsTheModelsOfItsTargetsAlone) {
  const std::string rows = row(0) + row(1) + row(2);
  write("models/models_info.json", R"({"000001": {"diameter": 173.205}, "2": {"diameter": 5}})");
  EXPECT_EQ(recall(rows), 1);
  write("models/models_info.json", R"({"1": {"symmetries_discrete": []}})");
  EXPECT_NEAR(dataset().models.at(1).diameter_mm, 173.205, 1e-3);
  EXPECT_THAT(dataset().notes, IsEmpty());
  fs::remove(set() / "models/models_info.json");
  EXPECT_THAT(dataset().notes, ElementsAre(HasSubstr("has no models_info.json: diameters are "
                                                     "measured, and no object has symmetries")));
  EXPECT_NEAR(dataset().models.at(1).diameter_mm, 173.205, 1e-3);
  fs::rename(set() / "models", set() / "models_cad");
  EXPECT_EQ(recall(rows), 1);
  fs::remove(set() / "models_cad/obj_000001.ply");
  EXPECT_THAT(error(), HasSubstr("obj_000001.ply: is missing"));
}

// Many sets have it there alone: without its symmetries the recalls would be others.
TEST_F(OddSet, TakesModelsInfoOfModelsWhereModelsEvalHasNone) {
  write(
      "models/models_info.json",
      R"({"1": {"diameter": 170, "symmetries_discrete": [[-1,0,0,0,0,-1,0,0,0,0,1,0,0,0,0,1]]}})");
  const std::string turned = "-1 0 0 0 -1 0 0 0 1";
  const std::string rows = row(0, turned) + row(1, turned) + row(2, turned);
  EXPECT_EQ(recall(rows), 1);
  fs::create_directories(set() / "models_eval");
  write("models_eval/obj_000001.ply", ply_bytes(cube()));
  EXPECT_EQ(recall(rows), 1);
  EXPECT_EQ(bop_model_facts(set(), 1).symmetries.poses.size(), 2u);
  write("models_eval/models_info.json", R"({"1": {"diameter": 170}})");
  EXPECT_EQ(recall(rows), 0) << "its own counts";
}

TEST_F(OddSet, IsNotJudgedByWhatNobodyAsksFor) {
  json truths = read("test/000001/scene_gt.json");
  json cameras = read("test/000001/scene_camera.json");
  truths["7"] = json::array({truth()});  // an image that is on no list, of a camera that is none
  cameras["7"] = {{"cam_K", {1, 2, 3}}};
  write("test/000001/scene_camera.json", cameras.dump());
  write("test/000001/scene_gt_info.json", R"({"7": []})");
  truths["0"].push_back({{"obj_id", 8}});
  truths["1"].push_back({{"obj_id", 8}, {"cam_R_m2c", {1}}, {"cam_t_m2c", {0, 0, 1e15}}});
  write("test/000001/scene_gt.json", truths.dump());
  const auto listed = [this](const std::string& more) {
    std::string list;
    for (int im_id = 0; im_id < 3; ++im_id) {
      list +=
          fmt::format(R"({{"scene_id": 1, "im_id": {}, "obj_id": 1.0, "inst_count": 1}}, )", im_id);
    }
    write("test_targets_bop19.json", "[" + list + more + "]");
    return error();
  };
  // An object of which none is asked for need not be there at all.
  EXPECT_EQ(listed(R"({"scene_id": 1, "im_id": 0, "obj_id": 9, "inst_count": 0})"), "");
  EXPECT_EQ(recall(row(0) + row(1) + row(2)), 1);
  EXPECT_THAT(listed(R"({"scene_id": 1, "im_id": 0, "obj_id": 8, "inst_count": 1})"),
              HasSubstr("scene_gt.json: is not as its format has it: has no 'cam_R_m2c'"));
  EXPECT_THAT(listed(R"({"scene_id": 1, "im_id": 7, "obj_id": 1, "inst_count": 1})"),
              HasSubstr("scene_camera.json: cam_K has 3 numbers"));
  EXPECT_THAT(listed(R"({"scene_id": 1, "im_id": 0, "obj_id": 9, "inst_count": -1})"),
              HasSubstr("test_targets_bop19.json: inst_count must be 0 or more"));
  // An image of which nothing is asked for has no target, and not those that are visible.
  write("test_targets_bop19.json", R"([{"scene_id": 1, "im_id": 0, "obj_id": 1, "inst_count": 1},
                                       {"scene_id": 1, "im_id": 2, "obj_id": 1, "inst_count": 0}])");
  EXPECT_EQ(dataset().images.size(), 1u);
}

TEST_F(OddSet, ReadsNoScenesInFoldersWhoseNamesAreNoNumbers) {
  for (const char* name : {"000001 (copy)", ".ipynb_checkpoints"}) {
    fs::copy(scene(), set() / "test" / name, fs::copy_options::recursive);
  }
  EXPECT_EQ(dataset().images.size(), 3u);
  EXPECT_THAT(dataset().notes,
              ElementsAre(HasSubstr("test: not read as scenes, whose names are numbers: "
                                    ".ipynb_checkpoints, 000001 (copy)")));
  fs::remove_all(scene());
  EXPECT_THAT(error(), HasSubstr("test: not read as scenes, whose names are numbers: .ipynb"));
}

TEST_F(OddSet, OffersTheSplitsThatThereAre) {
  fs::rename(set() / "test", set() / "test_one");
  fs::copy(set() / "test_one", set() / "test_two", fs::copy_options::recursive);
  EXPECT_THAT(error(), HasSubstr("test: is no folder; say --split test_one or test_two"));
  EXPECT_THAT(error_of([this] { read_bop_dataset(set() / "test_one", ""); }),
              HasSubstr("it is a split itself: name the folder of the set, above it"));
  fs::remove_all(set() / "test_one");
  fs::remove_all(set() / "test_two");
  EXPECT_THAT(error(), testing::EndsWith("test: is no folder"));
}

TEST_F(OddSet, IsRefusedInWordsOfOurs) {
  const auto truth_with = [this](const std::string& text) {
    write("test/000001/scene_gt.json", text);
    return error();
  };
  EXPECT_THAT(truth_with(R"({"0": [{"obj_id": 1.5}]})"),
              HasSubstr("obj_id is 1.5, must be a whole"));
  EXPECT_THAT(truth_with(R"({"0": [{"obj_id": 1}]})"), HasSubstr("has no 'cam_R_m2c'"));
  EXPECT_THAT(truth_with(R"({"0": [{"obj_id": NaN}]})"), HasSubstr("obj_id is null or NaN, must"));
  EXPECT_THAT(truth_with("{\n \"0\": [}"), HasSubstr("is no JSON at line 2, column 8"));
  for (const std::string text : {"[]", "3", "{\"x\": []}", "{\"0\": 7}", "{\"0\": [7]}"}) {
    EXPECT_THAT(truth_with(text), AllOf(HasSubstr("scene_gt.json: "), Not(HasSubstr("json.exc"))));
  }
}

// Numbers that are finite and overflow where they are squared.
TEST_F(OddSet, IsRefusedWithNumbersThatCannotBe) {
  const json truths = read("test/000001/scene_gt.json");
  json far = truths;
  far["1"][0]["cam_t_m2c"] = {0, 0, 1e12};
  write("test/000001/scene_gt.json", far.dump());
  EXPECT_THAT(error(), HasSubstr("scene_gt.json: cam_t_m2c is 1e+09 m away, must be within 1e+08"));
  write("test/000001/scene_gt.json", truths.dump());
  EXPECT_EQ(error(), "");
  json cameras = read("test/000001/scene_camera.json");
  cameras["2"]["cam_K"][0] = 1e308;
  write("test/000001/scene_camera.json", cameras.dump());
  EXPECT_THAT(error(), HasSubstr("scene_camera.json: image 2: its camera has a number beyond"));
}

// Recalls against these would be numbers that mean nothing.
TEST_F(OddSet, IsRefusedWhereNothingCouldBeScored) {
  const json cameras = read("test/000001/scene_camera.json");
  const auto camera_error = [&](const char* key, const json& value) {
    json bad = cameras;
    bad["1"][key] = value;
    write("test/000001/scene_camera.json", bad.dump());
    return error();
  };
  for (const json& k :
       {json{-500, 0, 32, 0, 500, 24, 0, 0, 1}, json{500, 0, 0, 0, 500, 0, 32, 24, 1},
        json{1000, 0, 64, 0, 1000, 48, 0, 0, 2}, json{0, 0, 0, 0, 0, 0, 0, 0, 0}}) {
    EXPECT_THAT(camera_error("cam_K", k),
                HasSubstr("scene_camera.json: image 1: cam_K must be fx s cx, 0 fy cy, 0 0 1"));
  }
  EXPECT_THAT(camera_error("cam_model", json::object()),
              HasSubstr("scene_camera.json: image 1: has both cam_K and cam_model"));
  EXPECT_THAT(camera_error("depth_scale", -1.0),
              HasSubstr("scene_camera.json: image 1: depth_scale is -1, must be above 0"));
  EXPECT_EQ(camera_error("depth_scale", 0.1), "");
  const auto truths_at = [&](double z_mm) {
    json truths = read("test/000001/scene_gt.json");
    for (json& image : truths) image[0]["cam_t_m2c"] = {0, 0, z_mm};
    write("test/000001/scene_gt.json", truths.dump());
    return error();
  };
  for (const double z_mm : {1.0, 0.0, -1000.0}) {
    EXPECT_THAT(truths_at(z_mm), HasSubstr("none of its 3 true poses has the object in front"));
  }
  EXPECT_EQ(truths_at(1000), "");
  EXPECT_EQ(truths_at(60), "") << "a centimetre before the cube";
}

TEST_F(OddSet, SaysWhereADiameterIsNotThatOfTheModel) {
  for (const char* good : {"173.205", "170", "95"}) {
    write("models/models_info.json", fmt::format(R"({{"1": {{"diameter": {}}}}})", good));
    EXPECT_THAT(dataset().notes, IsEmpty()) << good;
  }
  for (const char* bad : {"0.173205", "80", "1732", "173205"}) {
    write("models/models_info.json", fmt::format(R"({{"1": {{"diameter": {}}}}})", bad));
    EXPECT_THAT(dataset().notes, ElementsAre(HasSubstr(fmt::format("a diameter of {} mm, its model "
                                                                   "is 100 x 100 x 100",
                                                                   bad))));
  }
}

TEST_F(OddSet, HasSymmetriesThatAreRotationsAndNotTooMany) {
  const auto error_with = [&](const json& discrete, size_t axes) {
    json info = {{"diameter", 173.205}, {"symmetries_discrete", discrete}};
    for (size_t i = 0; i < axes; ++i) {
      info["symmetries_continuous"].push_back({{"axis", {0, 0, 1}}, {"offset", {0, 0, 0}}});
    }
    write("models/models_info.json", json{{"1", info}}.dump());
    return error();
  };
  const auto scaled = [](double x, double y) {
    return json{x, 0, 0, 0, 0, y, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  };
  const json half_turn = scaled(-1, -1);
  EXPECT_EQ(error_with(json::array({half_turn}), 1), "");
  EXPECT_THAT(error_with(json::array({half_turn, scaled(2, 2)}), 0),
              HasSubstr("symmetries_discrete has no rotation at place 1"));
  EXPECT_THAT(error_with(json::array({scaled(-1, 1)}), 0),
              HasSubstr("no rotation at place 0"));  // a mirror
  // Each axis makes 315 poses, of which each discrete one makes as many again.
  EXPECT_EQ(error_with(json(99, half_turn), 3), "");
  EXPECT_THAT(error_with(json(99, half_turn), 4),
              HasSubstr("symmetries make 126000 poses of one, must make 100000 at most"));
}

TEST_F(OddSet, HasEachSceneOnce) {
  fs::copy(scene(), set() / "test/0001", fs::copy_options::recursive);
  EXPECT_THAT(error(), HasSubstr("test: has scene 1 twice, as 000001 and 0001"));
  fs::remove_all(set() / "test/0001");
  EXPECT_EQ(error(), "");
}

TEST_F(OddSet, NeedsNoCameraOfAnImageThatShowsNothing) {
  json truths = read("test/000001/scene_gt.json");
  truths["7"] = json::array();
  write("test/000001/scene_gt.json", truths.dump());
  EXPECT_EQ(dataset().images.size(), 3u);
  truths["7"].push_back(truth());
  write("test/000001/scene_gt.json", truths.dump());
  EXPECT_THAT(error(), HasSubstr("scene_camera.json: has no image 7"));
}

TEST_F(OddSet, SaysWhichPicturesItHasThroughLinks) {
  fs::rename(scene() / "rgb", folder_.path() / "elsewhere");
  fs::create_directory_symlink(folder_.path() / "elsewhere", scene() / "rgb");
  EXPECT_THAT(dataset().notes,
              ElementsAre(HasSubstr("3 pictures lie behind links out of the set")));
}

TEST_F(OddSet, HasPicturesInWebP) {
  fs::rename(scene() / "rgb/000000.png", scene() / "rgb/000000.webp");
  EXPECT_EQ(bop_picture(dataset().images[0]).filename(), "000000.webp");
}

// 30 000 x 30 000 pixels of one bit: 100 kB that would be 900 MB.
TEST_F(OddSet, IsNotDecodedWhereAPictureIsTooLarge) {
  std::string png("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x75\x30\0\0\x75\x30\x01\0\0\0\0", 29);
  write("test/000001/rgb/000000.png", png);
  EXPECT_EQ(picture_size(scene() / "rgb/000000.png")->width, 30000);
  EXPECT_TRUE(read_picture_file(scene() / "rgb/000000.png").pixels.empty());
  EXPECT_FALSE(read_picture_file(scene() / "rgb/000001.png").pixels.empty());
}

}  // namespace
}  // namespace sightline
