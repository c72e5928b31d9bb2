// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// BOP's errors and scores against cases worked by hand, and the program against its own sets.
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "eval/score/pose_errors.h"
#include "eval/score/score.h"
#include "renderer/truth.h"
#include "tests/eval/program.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

constexpr double kRounding = 1e-9;  // mm and px, of coordinates up to 1e3
const std::vector<Pose> kNoSymmetry{Pose{}};

// The eight corners of a cube of 100 mm about the origin.
Eigen::Matrix3Xd cube_points() {
  Eigen::Matrix3Xd points(3, 8);
  for (int i = 0; i < 8; ++i) {
    points.col(i) << (i & 1 ? 50 : -50), (i & 2 ? 50 : -50), (i & 4 ? 50 : -50);
  }
  return points;
}

Pose at_1000_mm(const Eigen::Matrix3d& rotation = Eigen::Matrix3d::Identity()) {
  return {rotation, {0, 0, 1000}};
}

Pose shifted(Pose pose, const Eigen::Vector3d& by_mm) {
  pose.translation += by_mm;
  return pose;
}

Eigen::Matrix3d turn_z(double angle_rad) {
  return rotation_from_vector({0, 0, angle_rad});
}

Eigen::Matrix3d k_of(double f, double c) {
  Eigen::Matrix3d k;
  k << f, 0, c, 0, f, c, 0, 0, 1;
  return k;
}

// Every vertex moves by |(3, 4, 0)| = 5 mm; on the near face, 950 mm away, that is 5 x 500 / 950
// px.
TEST(BopPoseErrors, OfATranslation) {
  const auto points = cube_points();
  const Pose truth = at_1000_mm();
  const Pose estimated = shifted(truth, {3, 4, 0});
  EXPECT_NEAR(mssd_mm(points, estimated, truth, kNoSymmetry), 5, kRounding);
  EXPECT_NEAR(add_mm(points, estimated, truth), 5, kRounding);
  EXPECT_NEAR(adi_mm(points, estimated, truth), 5, kRounding);
  EXPECT_NEAR(mspd_px(points, k_of(500, 320), estimated, truth, kNoSymmetry), 2500.0 / 950,
              kRounding);
}

// By one edge: ADD is 100 mm. Four of the true corners coincide with estimated ones, the other four
// are 100 mm from the nearest: ADI is 50 mm.
TEST(BopPoseErrors, AdiIsOfTheNearest) {
  const auto points = cube_points();
  const Pose estimated = shifted(at_1000_mm(), {100, 0, 0});
  EXPECT_NEAR(add_mm(points, estimated, at_1000_mm()), 100, kRounding);
  EXPECT_NEAR(adi_mm(points, estimated, at_1000_mm()), 50, kRounding);
}

// A quarter turn about z takes each corner to its neighbour, 100 mm away, and the cube to itself.
TEST(BopPoseErrors, OfARotationWithAndWithoutSymmetry) {
  const auto points = cube_points();
  const Pose truth = at_1000_mm(rotation_from_vector({0.3, -0.2, 0.5}));
  const Pose estimated{truth.rotation * turn_z(std::numbers::pi / 2), truth.translation};
  EXPECT_NEAR(mssd_mm(points, estimated, truth, kNoSymmetry), 100, kRounding);
  EXPECT_NEAR(add_mm(points, estimated, truth), 100, kRounding);
  EXPECT_NEAR(adi_mm(points, estimated, truth), 0, kRounding);
  EXPECT_GT(mspd_px(points, k_of(500, 320), estimated, truth, kNoSymmetry), 40);
  const auto symmetries =
      bop_symmetries(R"({"symmetries_discrete": [[0,-1,0,0, 1,0,0,0, 0,0,1,0, 0,0,0,1]]})");
  EXPECT_NEAR(mssd_mm(points, estimated, truth, symmetries), 0, kRounding);
  EXPECT_NEAR(mspd_px(points, k_of(500, 320), estimated, truth, symmetries), 0, kRounding);
  EXPECT_NEAR(add_mm(points, estimated, truth), 100, kRounding);  // which knows no symmetry
  // Without tilt, the near face's corners move by 100 mm at 950 mm.
  const Pose turned = at_1000_mm(turn_z(std::numbers::pi / 2));
  EXPECT_NEAR(mspd_px(points, k_of(500, 320), turned, at_1000_mm(), kNoSymmetry), 50000.0 / 950,
              kRounding);
}

// A cylinder's rims (radius 50 mm), turned by 1 rad about its axis: 50 steps of 2 pi / 315 leave
// 1 - 50 x 2 pi / 315 = 0.0026697 rad, a chord of 2 x 50 sin(0.0026697 / 2) = 0.133483 mm.
TEST(BopPoseErrors, OfAContinuousSymmetry) {
  Eigen::Matrix3Xd points(3, 720);
  for (int i = 0; i < 720; ++i) {
    const double angle = std::numbers::pi * i / 360;
    points.col(i) << 50 * std::cos(angle), 50 * std::sin(angle), (i % 2 ? 80 : -80);
  }
  const Pose turned = at_1000_mm(turn_z(1));
  const auto symmetries =
      bop_symmetries(R"({"symmetries_continuous": [{"axis": [0,0,1], "offset": [0,0,0]}]})");
  const double left_rad = 1 - 50 * 2 * std::numbers::pi / 315;
  const double chord_mm = 100 * std::sin(left_rad / 2);
  EXPECT_NEAR(chord_mm, 0.133, 1e-3);
  EXPECT_NEAR(mssd_mm(points, turned, at_1000_mm(), symmetries), chord_mm, kRounding);
  EXPECT_NEAR(mssd_mm(points, turned, at_1000_mm(), kNoSymmetry), 100 * std::sin(0.5), kRounding);
}

// ---- other benchmarks

// |(3, 4, 0)| = 5 mm of 1000 mm; all vertices at z = 950 or 1050 mm: 2500 / 950 and 2500 / 1050 px,
// four each.
TEST(OtherPoseErrors, OfATranslation) {
  const Pose truth = at_1000_mm();
  const Pose estimated = shifted(truth, {3, 4, 0});
  EXPECT_NEAR(projection_px(cube_points(), k_of(500, 320), estimated, truth),
              (2500.0 / 950 + 2500.0 / 1050) / 2, kRounding);
  EXPECT_NEAR(speed_score(estimated, truth), 0.005, 1e-15);
  EXPECT_NEAR(speed_plus_score(estimated, truth), 0.005, 1e-15);
  EXPECT_EQ(speed_plus_score(shifted(truth, {0, 0, 2.172}), truth), 0);
  EXPECT_NEAR(speed_plus_score(shifted(truth, {0, 0, 2.174}), truth), 0.002174, 1e-15);
}

TEST(OtherPoseErrors, OfARotationEachThresholdForItself) {
  const Pose truth = at_1000_mm();
  const auto turned = [](double angle_deg) {
    return at_1000_mm(turn_z(angle_deg * std::numbers::pi / 180));
  };
  EXPECT_NEAR(speed_score(turned(0.168), truth), 0.168 * std::numbers::pi / 180, 1e-12);
  EXPECT_EQ(speed_plus_score(turned(0.168), truth), 0);
  EXPECT_NEAR(speed_plus_score(turned(0.170), truth), 0.170 * std::numbers::pi / 180, 1e-12);
  // The angle counts, the distance beside it does not.
  EXPECT_NEAR(speed_plus_score(shifted(turned(90), {2, 0, 0}), truth), std::numbers::pi / 2, 1e-12);
  EXPECT_TRUE(is_within_5deg_5cm(shifted(turned(4.99), {0, 0, 49.9}), truth));
  EXPECT_FALSE(is_within_5deg_5cm(turned(5.01), truth));
  EXPECT_FALSE(is_within_5deg_5cm(shifted(truth, {0, 0, 50.1}), truth));
}

// ---- VSD

// A plane at z = 0 that fills every image.
Mesh plane() {
  Mesh mesh;
  mesh.vertices = {{-9e3, -9e3, 0}, {9e3, -9e3, 0}, {9e3, 9e3, 0}, {-9e3, 9e3, 0}};
  mesh.triangles = {{.vertex = {0, 1, 2}}, {.vertex = {0, 2, 3}}};
  mesh.parts.resize(1);
  return mesh;
}

cv::Mat plane_seen(double z_mm, double focal_px) {
  const Camera camera = centred_camera(64, 64, focal_px);
  return distances_of_depth(
      depth_alone(plane(), camera, {Eigen::Matrix3d::Identity(), {0, 0, z_mm}}),
      k_of(focal_px, 31.5));
}

// A narrow camera, so that 20 mm in depth are 20 mm along every ray but for 0.1 %.
TEST(BopVsd, OfAPlaneMovedInDepthIsZeroBelowTauAndOneAbove) {
  const cv::Mat truth = plane_seen(1000, 1000);
  for (const double z_mm : {980.0, 1020.0}) {
    const auto errors =
        vsd(truth, truth, plane_seen(z_mm, 1000), 15, std::array{10.0, 19.9, 20.1, 50.0});
    EXPECT_THAT(errors, testing::ElementsAre(1, 1, 0, 0)) << z_mm;
  }
}

// A wide one: along a ray (x, y, 1) they are 20 sqrt(1 + x^2 + y^2) mm. Not below 30 mm where
// x^2 + y^2 >= 1.25.
TEST(BopVsd, IsOfDistancesAlongTheRay) {
  const cv::Mat truth = plane_seen(1000, 32);
  int above = 0;
  for (int v = 0; v < 64; ++v) {
    for (int u = 0; u < 64; ++u) {
      above += std::pow((u - 31.5) / 32, 2) + std::pow((v - 31.5) / 32, 2) >= 1.25;
    }
  }
  ASSERT_GT(above, 0);
  const auto errors = vsd(truth, truth, plane_seen(1020, 32), 15, std::array{30.0});
  EXPECT_NEAR(errors[0], above / 4096.0, kRounding);
}

// Left half: something 100 mm before the plane hides it. An estimate 300 mm nearer is before that,
// so it is visible everywhere, and wrong there; one that equals the truth is hidden with it.
TEST(BopVsd, LeavesOutWhatIsHidden) {
  const cv::Mat truth = plane_seen(1000, 1000);
  cv::Mat test = truth.clone();
  test.colRange(0, 32) -= 100;
  EXPECT_EQ(vsd(test, truth, truth, 15, std::array{20.0})[0], 0);
  EXPECT_EQ(vsd(test, truth, plane_seen(700, 1000), 15, std::array{500.0})[0], 0.5);
  EXPECT_EQ(vsd(test, truth, plane_seen(700, 1000), 150, std::array{500.0})[0], 0);  // all visible
  test.colRange(0, 32) = 0;  // no depth there: taken as visible
  EXPECT_EQ(vsd(test, truth, plane_seen(700, 1000), 15, std::array{500.0})[0], 0);
}

TEST(BopVsd, IsOneOfNothing) {
  const cv::Mat truth = plane_seen(1000, 1000);
  const cv::Mat nothing = cv::Mat::zeros(64, 64, CV_64F);
  EXPECT_EQ(cv::norm(plane_seen(-1000, 1000), nothing), 0);  // behind the camera
  EXPECT_EQ(vsd(truth, truth, nothing, 15, std::array{500.0})[0], 1);
  EXPECT_EQ(vsd(truth, nothing, nothing, 15, std::array{500.0})[0], 1);
}

// ---- scores

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

TEST_F(ScoreProgram, SaysInALineWhatIsWrong) {
  render_set();
  write_truth("mm.csv", 1);
  const auto expect_error = [](const Outcome& outcome, const std::string& text) {
    EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
    EXPECT_EQ(lines_of(outcome.output), 1u) << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr(text));
  };
  const std::string out = "--out " + path("out");
  expect_error(score("none.csv", out), "none.csv: cannot be read");
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
