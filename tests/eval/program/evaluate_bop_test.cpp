// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// A BOP set as others write it, read by the documentation of its format alone.
#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "eval/datasets/model_file.h"
#include "eval/datasets/pictures.h"
#include "eval/datasets/set_frame.h"
#include "eval/datasets/sightings.h"
#include "eval/study/study_file.h"
#include "eval/trial/image_trial.h"
#include "scenes/picture/picture_file.h"
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

constexpr int kWidth = 320, kHeight = 240;

Camera foreign_camera() {
  Camera camera;
  camera.width_px = kWidth;
  camera.height_px = kHeight;
  camera.fx_px = 900;
  camera.fy_px = 915;
  camera.cx_px = 150.25;
  camera.cy_px = 118.75;
  return camera;
}

Pose cube_pose(double x_m, double turn_rad) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 0.5).normalized();
  return {Eigen::AngleAxisd(turn_rad, axis).toRotationMatrix(), Eigen::Vector3d(x_m, 0.1, 10)};
}

json entry_of(const Pose& pose, int obj_id) {
  json entry = {{"obj_id", obj_id}};
  for (int i = 0; i < 9; ++i) entry["cam_R_m2c"].push_back(pose.rotation(i / 3, i % 3));
  for (const double t : pose.translation) entry["cam_t_m2c"].push_back(1000 * t);
  return entry;
}

// Scene 5 of a split of another name, with the images 3 (JPEG) and 17 (PNG), both in colour, two
// objects, of which the cube is 4, and nothing that BOP calls optional.
class ForeignSet : public testing::Test {
 protected:
  ForeignSet() {
    fs::create_directories(scene_ / "rgb");
    const json camera = {{"cam_K", {900, 0, 150.25, 0, 915, 118.75, 0, 0, 1}},
                         {"depth_scale", 0.1}};
    write("scene_camera.json", {{"3", camera}, {"17", camera}});
    Pose other;
    other.translation = {0, 0, 0.5};
    write("scene_gt.json", {{"17", {entry_of(poses_[1], 4), entry_of(other, 9)}},
                            {"3", {entry_of(other, 9), entry_of(poses_[0], 4)}}});
    draw("000003.jpg", poses_[0]);
    draw("000017.png", poses_[1]);
  }
  void write(const std::string& name, const json& content) const {
    std::ofstream(scene_ / name) << content;
  }
  void draw(const std::string& name, const Pose& pose) const {
    Scene scene;
    scene.target = cube_;
    scene.camera = foreign_camera();
    scene.cam_from_target = pose;
    scene.sensor.read_noise_grey = 1;
    scene.light.to_light_in_cam = Eigen::Vector3d(0.3, -0.4, -1).normalized();
    Renderer renderer;
    cv::Mat colour;
    cv::cvtColor(renderer.render(scene, RandomStream(1, name, 0)).image, colour,
                 cv::COLOR_GRAY2BGR);
    const bool is_jpeg = fs::path(name).extension() == ".jpg";
    std::ofstream(scene_ / "rgb" / name, std::ios::binary)
        << (is_jpeg ? jpeg_bytes(colour) : png_bytes(colour));
  }
  SightingSource source() const {
    SightingSource source;
    source.folder = folder_.path() / "set";
    source.obj_id = 4;
    return source;
  }
  std::string error_now() const {
    return error_of([this] { read_sightings(source(), cube_); });
  }
  Outcome evaluate(const std::string& more) const {
    return run("evaluate " + source().folder.string() + " --target cube --out " +
               (folder_.path() / "out").string() + " " + more);
  }

  TemporaryFolder folder_;
  fs::path scene_ = folder_.path() / "set/test_camera/000005";
  std::shared_ptr<const Target> cube_ = load_target("cube");
  std::array<Pose, 2> poses_{cube_pose(-0.4, 0.7), cube_pose(0.5, 1.9)};
};

TEST_F(ForeignSet, IsReadInTheOrderOfItsImages) {
  const std::vector<Sighting> sightings = read_sightings(source(), cube_).sightings;
  ASSERT_EQ(sightings.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    const Sighting& sighting = sightings[i];
    EXPECT_EQ(sighting.scene_id, 5);
    EXPECT_EQ(sighting.im_id, i == 0 ? 3 : 17);
    EXPECT_EQ(sighting.gt_id, i == 0 ? 1 : 0);
    EXPECT_EQ(sighting.camera.width_px, kWidth);
    EXPECT_EQ(sighting.camera.height_px, kHeight);
    EXPECT_EQ(sighting.camera.fy_px, 915);
    EXPECT_EQ(sighting.camera.cx_px, 150.25);
    EXPECT_TRUE(sighting.visible_mask.empty());
    EXPECT_TRUE(sighting.cam_from_target.rotation.isApprox(poses_[i].rotation, 1e-12));
    EXPECT_TRUE(sighting.cam_from_target.translation.isApprox(poses_[i].translation, 1e-12));
  }
  EXPECT_EQ(sightings[0].image, "test_camera/000005/rgb/000003.jpg");
}

TEST_F(ForeignSet, ShowsItsCubeWhereItsPosesSay) {
  const Study study = read_study_text(
      "target = 'cube'\nsolvers = ['lspe']\n[dataset]\npath = '" + source().folder.string() +
          "'\nobject = 4\n[extraction]\nline_intersection = 'model_edges'\n",
      "evaluate");
  Renderer renderer;
  for (int i = 0; i < 2; ++i) {
    const TrialRecord record = run_trial(study, i, renderer).record;
    EXPECT_GE(inliers_of(record), 5) << i;
    ASSERT_TRUE(record.estimates()[0].is_ok());
    EXPECT_LT(record.estimates()[0].geodesic_deg, 1) << i;
  }
}

TEST_F(ForeignSet, AsksForTheObjectWhereThereAreTwo) {
  const Outcome asked = evaluate("");
  EXPECT_EQ(asked.exit_code, 1);
  EXPECT_THAT(asked.output, HasSubstr("has the objects 4, 9; say --object"));
  EXPECT_THAT(evaluate("--object 5").output, HasSubstr("has the objects 4, 9, not 5"));
  EXPECT_FALSE(fs::exists(folder_.path() / "out"));
  const Outcome told = evaluate("--object 4 --extractor model_edges");
  EXPECT_EQ(told.exit_code, 0) << told.output;
  EXPECT_THAT(told.output, AllOf(HasSubstr("2 trials in 1 condition"), HasSubstr("report: ")));
}

TEST_F(ForeignSet, IsSeenByTheSensorThatIsChosen) {
  for (const char* file : {"scene_gt", "scene_camera"}) {
    fs::rename(scene_ / (std::string(file) + ".json"), scene_ / (std::string(file) + "_left.json"));
  }
  fs::rename(scene_ / "rgb", scene_ / "rgb_left");
  const std::string quick = "--object 4 --trials 1 --extractor model_edges --quiet --sensor ";
  EXPECT_THAT(evaluate(quick + "right").output,
              AllOf(HasSubstr("has no sensor 'right'"), HasSubstr("its sensors are left")));
  const Outcome left = evaluate(quick + "left");
  EXPECT_EQ(left.exit_code, 0) << left.output;
}

TEST_F(ForeignSet, HasItsPosesOfTheAxesOfTheFile) {
  SightingSource of_file = source();
  of_file.is_of_file_axes = true;
  Pose of_axes = poses_[1];
  of_axes.rotation = poses_[1].rotation * cube_->target_from_file;
  ASSERT_FALSE(of_axes.rotation.isApprox(poses_[1].rotation, 0.1));
  Pose other;
  write("scene_gt.json", {{"17", {entry_of(of_axes, 4)}}});
  const auto sightings = read_sightings(of_file, cube_).sightings;
  EXPECT_TRUE(sightings[0].cam_from_target.rotation.isApprox(poses_[1].rotation, 1e-12));
  EXPECT_FALSE(read_sightings(source(), cube_)
                   .sightings[0]
                   .cam_from_target.rotation.isApprox(poses_[1].rotation, 0.1));
}

TEST_F(ForeignSet, MustBeOfTheTargetsModel) {
  const fs::path models = folder_.path() / "set/models";
  fs::create_directories(models);
  const std::string name = "set/models/obj_000004.ply";
  folder_.write(name, ply_bytes(cube_->mesh));
  EXPECT_EQ(error_now(), "");
  folder_.write(name, ply_bytes(scaled(cube_, 1e-3)->mesh));  // metres
  EXPECT_THAT(error_now(), HasSubstr("obj_000004.ply: object 4 fills (-0.0005, -0.0005, -0.0005)"));
  folder_.write("set/models/models_info.json", R"({"4": {"diameter": 1732, "min_x": -500,
      "min_y": -500, "min_z": -500, "size_x": 1000, "size_y": 1000, "size_z": 1005}})");
  EXPECT_EQ(error_now(), "");  // it says so itself
  folder_.write("set/models/models_info.json", R"({"4": {"diameter": 1732, "min_x": -500,
      "min_y": -500, "min_z": -500, "size_x": 1000, "size_y": 1000, "size_z": 1030}})");
  EXPECT_THAT(error_now(), HasSubstr("must agree within 1 %"));
}

TEST_F(ForeignSet, ObeysTheListOfTargetsInTestSplitsAlone) {
  folder_.write("set/test_targets_bop19.json",
                R"([{"scene_id": 5, "im_id": 17, "obj_id": 4, "inst_count": 1}])");
  EXPECT_EQ(read_sightings(source(), cube_).sightings.size(), 1u);
  fs::rename(scene_.parent_path(), folder_.path() / "set/train_pbr");
  SightingSource training = source();
  training.split = "train_pbr";
  EXPECT_EQ(read_sightings(training, cube_).sightings.size(), 2u);
}

TEST_F(ForeignSet, TakesTheMostVisibleOfMoreInstancesThanAreAskedFor) {
  folder_.write("set/test_targets_bop19.json",
                R"([{"scene_id": 5, "im_id": 17, "obj_id": 4, "inst_count": 1}])");
  Pose other;
  other.translation = {0, 0, 0.5};
  write("scene_gt.json", {{"17", {entry_of(poses_[0], 4), entry_of(poses_[1], 4)}},
                          {"3", {entry_of(other, 9), entry_of(poses_[0], 4)}}});
  const auto seen_with = [&](double first, double second) {
    write("scene_gt_info.json", {{"17", {{{"visib_fract", first}}, {{"visib_fract", second}}}},
                                 {"3", {{{"visib_fract", 1}}, {{"visib_fract", 1}}}}});
    const std::vector<Sighting> sightings = read_sightings(source(), cube_).sightings;
    EXPECT_EQ(sightings.size(), 1u);
    return sightings.front().gt_id;
  };
  EXPECT_EQ(seen_with(0.3, 0.9), 1);
  EXPECT_EQ(seen_with(0.9, 0.3), 0);
}

// The left half of the image is all that the mask has of the cube.
TEST_F(ForeignSet, HidesWhatTheMaskLeavesOut) {
  const std::string toml = "target = 'cube'\nsolvers = ['lspe']\n[dataset]\npath = '" +
                           source().folder.string() + "'\nobject = 4\n";
  Renderer renderer;
  const Trial whole = run_trial(read_study_text(toml, "evaluate"), 1, renderer);
  cv::Mat mask = cv::Mat::zeros(kHeight, kWidth, CV_8U);
  const int half_px = 195;  // through the cube
  mask(cv::Rect(0, 0, half_px, kHeight)) = 255;
  fs::create_directories(scene_ / "mask_visib");
  std::ofstream(scene_ / "mask_visib/000017_000000.png", std::ios::binary) << png_bytes(mask);
  const Trial half = run_trial(read_study_text(toml, "evaluate"), 1, renderer);
  int hidden = 0, visible = 0;
  for (size_t i = 0; i < cube_->features.size(); ++i) {
    const FeatureTruth& before = whole.frame.truth.target().features[i];
    const FeatureTruth& after = half.frame.truth.target().features[i];
    const bool is_covered = before.pixel.x() > half_px + 3;
    EXPECT_EQ(after.is_hidden_by_other, is_covered);
    EXPECT_EQ(after.is_visible, before.is_visible && !is_covered);
    hidden += before.is_visible && is_covered;
    visible += after.is_visible;
  }
  EXPECT_GT(hidden, 0);
  EXPECT_GT(visible, 0);
  EXPECT_LE(half.frame.truth.target().visible_box.br().x, half_px + 3);
  EXPECT_EQ(half.frame.body_ids.at<uint8_t>(110, 210), 2);
  EXPECT_EQ(whole.frame.body_ids.at<uint8_t>(110, 210), 1);
}

// The conditions of a sweep share an instance's mask and picture, which are then read once.
TEST_F(ForeignSet, HasItsMaskReadOnceForAllConditions) {
  const fs::path mask = scene_ / "mask_visib/000017_000000.png";
  fs::create_directories(mask.parent_path());
  std::ofstream(mask, std::ios::binary) << png_bytes(cv::Mat(kHeight, kWidth, CV_8U, 255));
  const std::vector<Sighting> sightings = read_sightings(source(), cube_).sightings;
  const auto masked = std::find_if(sightings.begin(), sightings.end(),
                                   [&](const Sighting& s) { return s.visible_mask == mask; });
  ASSERT_NE(masked, sightings.end());
  Sighting sighting = *masked;
  SetFiles files;
  ASSERT_FALSE(read_set_frame(cube_, 8, sighting, files).problem);
  fs::remove(mask);
  EXPECT_FALSE(read_set_frame(cube_, 8, sighting, files).problem);
  sighting.visible_mask = scene_ / "mask_visib/000017_000001.png";
  EXPECT_EQ(read_set_frame(cube_, 8, sighting, files).problem, EstimateOutcome::kMaskUnreadable);
}

// Eight bits in a file of sixteen are next to black where the file's white is taken for white.
TEST_F(ForeignSet, NotesPicturesThatUseFewOfTheirBits) {
  const std::vector<Sighting> sightings = read_sightings(source(), cube_).sightings;
  EXPECT_EQ(note_on_bits(sightings, 16), "") << "has 8 bits";
  cv::Mat grey = cv::Mat::zeros(kHeight, kWidth, CV_16U);
  const auto note = [&](uint16_t brightest, int bits) {
    grey.at<uint16_t>(5, 5) = brightest;
    std::ofstream(sightings.front().picture, std::ios::binary) << png_bytes(grey);
    return note_on_bits(sightings, bits);
  };
  EXPECT_THAT(note(200, 16), HasSubstr("has 16 bits and no grey level over 200, where white is "
                                       "taken to be 65535: if white is less, say --set "
                                       "dataset.bits=8"));
  EXPECT_THAT(note(4000, 16), HasSubstr("dataset.bits=12"));
  EXPECT_EQ(note(200, 8), "");
  EXPECT_EQ(note(5000, 16), "");
  EXPECT_EQ(note(0, 16), "") << "black";
}

std::string line_of(int im_id, double score, const Pose& pose, int obj_id = 4) {
  const json entry = entry_of(pose, obj_id);
  std::string r, t;
  for (const json& value : entry["cam_R_m2c"]) r += value.dump() + " ";
  for (const json& value : entry["cam_t_m2c"]) t += value.dump() + " ";
  return fmt::format("5,{},{},{},{},{},-1\n", im_id, obj_id, score, r, t);
}

const std::string kHeader = "scene_id,im_id,obj_id,score,R,t,time\n";

TEST_F(ForeignSet, TakesPriorsFromAFile) {
  Pose near = poses_[0], far = poses_[0];
  near.translation.x() += 0.02;
  far.translation.x() += 0.3;
  SightingSource with_priors = source();
  with_priors.priors =
      folder_.write("priors.csv", kHeader + line_of(3, 0.1, far) + line_of(3, 0.9, near) +
                                      line_of(3, 1, far, 9) + line_of(4, 1, far));
  const auto sightings = read_sightings(with_priors, cube_).sightings;
  ASSERT_TRUE(sightings[0].prior_cam_from_target);
  EXPECT_TRUE(sightings[0].prior_cam_from_target->translation.isApprox(near.translation, 1e-12));
  EXPECT_FALSE(sightings[1].prior_cam_from_target);

  const Outcome outcome =
      evaluate("--object 4 --solvers lspe --quiet --prior " + with_priors.priors.string());
  EXPECT_EQ(outcome.exit_code, 4);
  EXPECT_THAT(outcome.output, HasSubstr("1 of 2 trials could not be run"));
  const std::string csv = read_whole(folder_.path() / "out/results.csv");
  EXPECT_THAT(csv, AllOf(HasSubstr("000003.jpg,5,3,1,lspe,ok"),
                         HasSubstr("000017.png,5,17,0,lspe,no prior")));
  const json cell = json::parse(read_whole(folder_.path() / "out/summary.json"))["cells"][0];
  EXPECT_EQ(cell["trials"], 2);
  EXPECT_EQ(cell["failures"], 1);

  near.translation.z() = -10;  // behind the camera nothing is found
  with_priors.priors = folder_.write("behind.csv", kHeader + line_of(3, 0.9, near));
  const Outcome behind = evaluate("--object 4 --solvers lspe --quiet --set dataset.priors=" +
                                  with_priors.priors.string() + "2");
  EXPECT_THAT(behind.output, HasSubstr("behind.csv2: is missing or cannot be read"));
  fs::remove_all(folder_.path() / "out");
  evaluate("--object 4 --solvers lspe --quiet --prior " + with_priors.priors.string());
  EXPECT_THAT(read_whole(folder_.path() / "out/results.csv"), Not(HasSubstr("lspe,ok")));

  with_priors.priors = folder_.write("none.csv", kHeader + line_of(4, 1, far));
  EXPECT_THAT(error_of([&] { read_sightings(with_priors, cube_).sightings; }),
              HasSubstr("has no pose of object 4"));
}

TEST_F(ForeignSet, GivesEachInstanceThePriorThatIsNear) {
  write("scene_gt.json", {{"17", {entry_of(poses_[0], 4), entry_of(poses_[1], 4)}}});
  SightingSource with_priors = source();
  with_priors.priors = folder_.write(
      "priors.csv", kHeader + line_of(17, 0.5, poses_[1]) + line_of(17, 0.4, poses_[0]));
  const auto sightings = read_sightings(with_priors, cube_).sightings;
  ASSERT_EQ(sightings.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(sightings[i].gt_id, static_cast<int>(i));
    EXPECT_TRUE(sightings[i].prior_cam_from_target->translation.isApprox(poses_[i].translation));
  }
}

// The cube looks alike after a quarter turn about z, and after any turn about x, says the set.
TEST_F(ForeignSet, JudgesByTheSymmetriesThatItsModelHas) {
  const auto geodesic_deg = [this](const std::string& symmetries, const Eigen::Vector3d& turn) {
    fs::create_directories(folder_.path() / "set/models");
    folder_.write("set/models/models_info.json", R"({"4": {"diameter": 1732)" + symmetries + "}}");
    Pose turned = poses_[0];
    turned.rotation = poses_[0].rotation * rotation_from_vector(turn);
    const fs::path file = folder_.write("e.csv", kHeader + line_of(3, 1, turned));
    fs::remove_all(folder_.path() / "out");
    const Outcome outcome =
        evaluate("--object 4 --solvers lspe --quiet --trials 1 --estimates given=" + file.string());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    const json summary = json::parse(read_whole(folder_.path() / "out/summary.json"));
    for (const json& cell : summary["cells"]) {
      if (cell["solver"] == "given") return cell["geodesic_deg"]["median"].get<double>();
    }
    return -1.0;
  };
  constexpr double kRoundingDeg = 1e-5;
  const std::string quarter =
      R"(, "symmetries_discrete": [[0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]])";
  const std::string any =
      R"(, "symmetries_continuous": [{"axis": [1, 0, 0], "offset": [0, 0, 0]}])";
  const Eigen::Vector3d about_z(0, 0, std::numbers::pi / 2);
  EXPECT_NEAR(geodesic_deg("", about_z), 90, kRoundingDeg);
  EXPECT_NEAR(geodesic_deg(quarter, about_z), 0, kRoundingDeg);
  EXPECT_NEAR(geodesic_deg(any, {0.777, 0, 0}), 0, kRoundingDeg);  // between two steps
  EXPECT_NEAR(geodesic_deg(any, about_z), 90, kRoundingDeg);
}

TEST_F(ForeignSet, HasOneFailureARowPictureOrTruePoseThatIsNone) {
  const auto status = [this](const std::string& r_and_t) {
    const fs::path file = folder_.write(
        "e.csv", kHeader + line_of(17, 1, poses_[1]) + "5,3,4,1," + r_and_t + ",-1\n");
    fs::remove_all(folder_.path() / "out");
    const Outcome outcome =
        evaluate("--object 4 --solvers lspe --quiet --estimates given=" + file.string());
    EXPECT_LE(outcome.exit_code, 4) << outcome.output;
    const std::string csv = read_whole(folder_.path() / "out/results.csv");
    EXPECT_THAT(csv, HasSubstr("000017.png,5,17,0,given,ok"));
    const std::string before = ",5,3,1,given,";
    const size_t begin = csv.find(before) + before.size();
    return csv.substr(begin, csv.find(',', begin) - begin);
  };
  const std::string eye = "1 0 0 0 1 0 0 0 1";
  EXPECT_EQ(status(eye + ",0 0 10000"), "ok");
  EXPECT_EQ(status(eye + ",0 nan 10000"), "not rigid");
  EXPECT_EQ(status("2 0 0 0 2 0 0 0 2,0 0 10000"), "not rigid");
  fs::remove(scene_ / "rgb/000003.jpg");
  EXPECT_EQ(status(eye + ",0 0 10000"), "picture unreadable");
  Pose scaled = poses_[0];
  scaled.rotation *= 2;
  write("scene_gt.json",
        {{"17", {entry_of(poses_[1], 4)}}, {"3", {entry_of(Pose{}, 9), entry_of(scaled, 4)}}});
  EXPECT_EQ(status(eye + ",0 0 10000"), "no true pose");
}

TEST_F(ForeignSet, FailsInTheTrialWhosePictureIsTorn) {
  folder_.write("set/test_camera/000005/rgb/000017.png", "no picture");
  EXPECT_FALSE(read_picture(scene_ / "rgb/000003.jpg").empty());
  const Outcome torn = evaluate("--object 4 --solvers lspe --quiet");
  EXPECT_EQ(torn.exit_code, 4);
  EXPECT_THAT(read_whole(folder_.path() / "out/results.csv"),
              AllOf(HasSubstr("000003.jpg,5,3,1,lspe,ok"), HasSubstr("lspe,picture unreadable")));
}

// The reader of JPEGs would fill in what is missing.
TEST_F(ForeignSet, FailsInTheTrialWhoseJpegIsTorn) {
  const fs::path file = scene_ / "rgb/000003.jpg";
  const std::string whole = read_whole(file);
  fs::copy_file(file, scene_ / "rgb/000017.jpg");
  fs::remove(scene_ / "rgb/000017.png");
  std::ofstream(scene_ / "rgb/000017.jpg", std::ios::binary) << whole.substr(0, whole.size() - 900);
  const Outcome torn = evaluate("--object 4 --solvers lspe --quiet");
  EXPECT_EQ(torn.exit_code, 4) << torn.output;
  EXPECT_THAT(read_whole(folder_.path() / "out/results.csv"),
              AllOf(HasSubstr("000003.jpg,5,3,1,lspe,ok"), HasSubstr("lspe,picture unreadable")));
  EXPECT_THAT(read_whole(folder_.path() / "out/report.html"), HasSubstr("It could not be run."));
}

TEST_F(ForeignSet, IsRefusedInOneLineThatNamesTheFile) {
  EXPECT_EQ(error_now(), "");
  const json good = json::parse(read_whole(scene_ / "scene_gt.json"));
  json bad = good;
  bad["3"][1]["cam_R_m2c"][0] = 2;
  write("scene_gt.json", bad);
  EXPECT_EQ(error_now(), "") << "one true pose that is none is one failed trial";
  bad = good;
  bad["17"][0].erase("cam_t_m2c");
  write("scene_gt.json", bad);
  EXPECT_THAT(error_now(), HasSubstr("scene_gt.json: is not as its format has it"));
  write("scene_gt.json", good);
  const json cameras = json::parse(read_whole(scene_ / "scene_camera.json"));
  bad = cameras;
  bad["3"]["cam_K"][3] = 4;
  write("scene_camera.json", bad);
  EXPECT_THAT(error_now(), HasSubstr("scene_camera.json: image 3: cam_K must be fx s cx"));
  write("scene_camera.json", cameras);
  fs::rename(scene_ / "rgb", scene_ / "pictures");
  EXPECT_THAT(error_now(), HasSubstr("rgb/000003.png: cannot be read, nor any other picture"));
  fs::rename(scene_ / "pictures", scene_ / "rgb");
  EXPECT_THAT(evaluate("--object 4 --set dataset.obj=4").output, HasSubstr("dataset.obj"));
  fs::remove_all(scene_.parent_path());
  EXPECT_THAT(error_now(), HasSubstr("is no folder"));
  EXPECT_FALSE(fs::exists(folder_.path() / "out"));
}

}  // namespace
}  // namespace sightline
