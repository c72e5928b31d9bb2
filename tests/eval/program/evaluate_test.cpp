// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Image sets that are there: what the program itself wrote comes back to the digit, what others
// wrote is read by their formats' documentation alone.
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "eval/datasets/pictures.h"
#include "eval/datasets/sightings.h"
#include "eval/image_sets/models.h"
#include "eval/image_sets/set_format.h"
#include "eval/trial/image_trial.h"
#include "scenes/files/input_error.h"
#include "tests/eval/program.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// ---- sets of our own

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

int inliers_of(const TrialRecord& record) {
  int count = 0;
  for (const ObservationRecord& o : record.observations()) count += o.is_found() && !o.is_outlier;
  return count;
}

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
  const std::string all = evaluate("all", "");
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
  EXPECT_EQ(study.sighting_of(4 * 2 + 3).im_id, 2);
  EXPECT_THAT(error_of([&] { study_of(set, "[sweep]\n'background.level' = [0, 1]\n"); }),
              HasSubstr("[prior], [extraction]"));
  EXPECT_THAT(error_of([&] { study_of(set, "[extraction]\nbias_removal = 'known_light'\n"); }),
              HasSubstr("nobody knows the light"));
  EXPECT_THAT(error_of([&] { study_of(set, "[light]\nambient = 1\n"); }), HasSubstr("light"));
}

// ---- a set as others write it

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
    ASSERT_TRUE(cv::imwrite((scene_ / "rgb" / name).string(), colour));
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
  const std::vector<Sighting> sightings = read_sightings(source(), cube_);
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

TEST_F(ForeignSet, HasItsPosesOfTheAxesOfTheFile) {
  SightingSource of_file = source();
  of_file.is_of_file_axes = true;
  Pose of_axes = poses_[1];
  of_axes.rotation = poses_[1].rotation * cube_->target_from_file;
  ASSERT_FALSE(of_axes.rotation.isApprox(poses_[1].rotation, 0.1));
  Pose other;
  write("scene_gt.json", {{"17", {entry_of(of_axes, 4)}}});
  const auto sightings = read_sightings(of_file, cube_);
  EXPECT_TRUE(sightings[0].cam_from_target.rotation.isApprox(poses_[1].rotation, 1e-12));
  EXPECT_FALSE(read_sightings(source(), cube_)[0].cam_from_target.rotation.isApprox(
      poses_[1].rotation, 0.1));
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
  EXPECT_EQ(read_sightings(source(), cube_).size(), 1u);
  fs::rename(scene_.parent_path(), folder_.path() / "set/train_pbr");
  SightingSource training = source();
  training.split = "train_pbr";
  EXPECT_EQ(read_sightings(training, cube_).size(), 2u);
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
    const std::vector<Sighting> sightings = read_sightings(source(), cube_);
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
  ASSERT_TRUE(cv::imwrite((scene_ / "mask_visib/000017_000000.png").string(), mask));
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
  const auto sightings = read_sightings(with_priors, cube_);
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
  EXPECT_THAT(behind.output, HasSubstr("behind.csv2: cannot be read"));
  fs::remove_all(folder_.path() / "out");
  evaluate("--object 4 --solvers lspe --quiet --prior " + with_priors.priors.string());
  EXPECT_THAT(read_whole(folder_.path() / "out/results.csv"), Not(HasSubstr("lspe,ok")));

  with_priors.priors = folder_.write("none.csv", kHeader + line_of(4, 1, far));
  EXPECT_THAT(error_of([&] { read_sightings(with_priors, cube_); }),
              HasSubstr("has no pose of object 4"));
}

TEST_F(ForeignSet, GivesEachInstanceThePriorThatIsNear) {
  write("scene_gt.json", {{"17", {entry_of(poses_[0], 4), entry_of(poses_[1], 4)}}});
  SightingSource with_priors = source();
  with_priors.priors = folder_.write(
      "priors.csv", kHeader + line_of(17, 0.5, poses_[1]) + line_of(17, 0.4, poses_[0]));
  const auto sightings = read_sightings(with_priors, cube_);
  ASSERT_EQ(sightings.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(sightings[i].gt_id, static_cast<int>(i));
    EXPECT_TRUE(sightings[i].prior_cam_from_target->translation.isApprox(poses_[i].translation));
  }
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
  EXPECT_THAT(error_now(), HasSubstr("scene_gt.json: image 3: cam_R_m2c is no rotation"));
  bad = good;
  bad["17"][0].erase("cam_t_m2c");
  write("scene_gt.json", bad);
  EXPECT_THAT(error_now(), HasSubstr("scene_gt.json: is not as its format has it"));
  write("scene_gt.json", good);
  const json cameras = json::parse(read_whole(scene_ / "scene_camera.json"));
  bad = cameras;
  bad["3"]["cam_K"][1] = 4;
  write("scene_camera.json", bad);
  EXPECT_THAT(error_now(), HasSubstr("scene_camera.json: image 3: cam_K must be fx 0 cx"));
  write("scene_camera.json", cameras);
  fs::rename(scene_ / "rgb/000003.jpg", scene_ / "rgb/3.jpg");
  EXPECT_THAT(error_now(), HasSubstr("000005: has no picture 000003 in rgb/ or gray/"));
  fs::rename(scene_ / "rgb/3.jpg", scene_ / "rgb/000003.jpg");
  EXPECT_THAT(evaluate("--object 4 --set dataset.obj=4").output, HasSubstr("dataset.obj"));
  fs::remove_all(scene_.parent_path());
  EXPECT_THAT(error_now(), AllOf(HasSubstr("is no folder"), HasSubstr("--split")));
  EXPECT_FALSE(fs::exists(folder_.path() / "out"));
}

// ---- SPEED+ and SPEED as others write them

class ForeignSpeed : public testing::Test {
 protected:
  ForeignSpeed() {
    fs::create_directories(folder_.path() / "synthetic/images");
    cv::imwrite((folder_.path() / "synthetic/images/img1.jpg").string(),
                cv::Mat(kHeight, kWidth, CV_8U, cv::Scalar(40)));
    folder_.write("camera.json",
                  R"({"Nu": 320, "Nv": 240, "ppx": 1e-5, "ppy": 2e-5, "fx": 0.009, "fy": 0.0183,
                      "ccx": 160, "ccy": 120, "cameraMatrix": [[900, 0, 160], [0, 915, 120],
                      [0, 0, 1]], "distCoeffs": [-0.1, 0.02, 0.003, 0.004, 0.05]})");
    folder_.write("synthetic/train.json", kList);
  }
  SightingSource source(const std::string& folder, const std::string& split) const {
    SightingSource source;
    source.folder = folder_.path() / folder;
    source.split = split;
    return source;
  }
  const std::string kList =
      R"([{"filename": "img1.jpg", "q_vbs2tango_true": [0.6, 0, 0, 0.8],
           "r_Vo2To_vbs_true": [0.1, -0.2, 10]}])";
  TemporaryFolder folder_;
  std::shared_ptr<const Target> cube_ = load_target("cube");
};

TEST_F(ForeignSpeed, IsReadByItsDocumentation) {
  for (const auto& sightings : {read_sightings(source("synthetic", ""), cube_),
                                read_sightings(source("", "synthetic/train"), cube_)}) {
    ASSERT_EQ(sightings.size(), 1u);
    const Sighting& sighting = sightings[0];
    EXPECT_EQ(sighting.camera.fy_px, 915);
    EXPECT_EQ(sighting.camera.cx_px, 159.5);  // its pixels begin at 0, ours at -0.5
    EXPECT_EQ(sighting.camera.cy_px, 119.5);
    EXPECT_EQ(sighting.camera.distortion.k1, -0.1);
    EXPECT_EQ(sighting.camera.distortion.p2, 0.004);
    EXPECT_EQ(sighting.camera.distortion.k3, 0.05);
    const Eigen::Matrix3d& r = sighting.cam_from_target.rotation;
    EXPECT_NEAR(r(0, 0), -0.28, 1e-12);  // cos of 2 acos(0.6), about z
    EXPECT_NEAR(r(1, 0), 0.96, 1e-12);
    EXPECT_NEAR(r(2, 2), 1, 1e-12);
    EXPECT_EQ(sighting.cam_from_target.translation, Eigen::Vector3d(0.1, -0.2, 10));
  }
}

TEST_F(ForeignSpeed, OfTheFirstChallengeIsReadToo) {
  fs::create_directories(folder_.path() / "images/train");
  fs::rename(folder_.path() / "synthetic/images/img1.jpg",
             folder_.path() / "images/train/img1.jpg");
  folder_.write("camera.json", R"({"Nu": 320, "Nv": 240, "ppx": 1e-5, "ppy": 2e-5, "fx": 0.009,
                                   "fy": 0.0183})");
  folder_.write("train.json", R"([{"filename": "img1.jpg", "q_vbs2tango": [1, 0, 0, 0],
                                   "r_Vo2To_vbs_true": [0.1, -0.2, 10]}])");
  const auto sightings = read_sightings(source("", ""), cube_);
  EXPECT_NEAR(sightings[0].camera.fx_px, 900, 1e-9);
  EXPECT_NEAR(sightings[0].camera.fy_px, 915, 1e-9);
  EXPECT_EQ(sightings[0].camera.cx_px, 159.5);
  EXPECT_EQ(sightings[0].image, "images/train/img1.jpg");
}

TEST_F(ForeignSpeed, IsRefusedInOneLineThatNamesTheFile) {
  const auto error = [this] {
    return error_of([this] { read_sightings(source("synthetic", ""), cube_); });
  };
  EXPECT_EQ(error(), "");
  folder_.write("synthetic/validation.json", "[]");
  EXPECT_THAT(error(), HasSubstr("has train.json and validation.json; say --split"));
  fs::remove(folder_.path() / "synthetic/validation.json");
  folder_.write("synthetic/train.json", R"([{"filename": "img2.jpg"}])");
  EXPECT_THAT(error(), HasSubstr("train.json: names img2.jpg, which is not in"));
  folder_.write("synthetic/train.json", "[]");
  EXPECT_THAT(error(), HasSubstr("train.json: lists no image"));
  folder_.write("synthetic/train.json", R"([{"filename": "img1.jpg",
      "q_vbs2tango_true": [2, 0, 0, 0], "r_Vo2To_vbs_true": [0, 0, 10]}])");
  EXPECT_THAT(error(), HasSubstr("q_vbs2tango_true has the length 2"));
  folder_.write("synthetic/train.json", R"([{"filename": "img1.jpg",
      "q_vbs2tango_true": [1, 0, 0, 0], "r_Vo2To_vbs_true": [0, 0, -10]}])");
  EXPECT_THAT(error(), HasSubstr("none of its 1 poses puts 'cube' into its image"));
  folder_.write("synthetic/train.json", kList);
  fs::remove(folder_.path() / "camera.json");
  EXPECT_THAT(error(), HasSubstr("camera.json: is missing"));
}

}  // namespace
}  // namespace sightline
