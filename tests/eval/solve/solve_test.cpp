// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// `sightline solve` and `sightline align`, as a user runs them.
#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "eval/solve/camera_file.h"
#include "eval/solve/number_rows.h"
#include "pose/camera.h"
#include "pose/pose.h"
#include "scenes/random/random.h"
#include "tests/eval/program.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kCalibration = R"(%YAML:1.0
---
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 800., 0., 319.5, 0., 810., 239.5, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -0.1, 0.01, 0.001, -0.002, 0. ]
)";

class Solve : public testing::Test {
 protected:
  Solve() : camera_file_(folder_.write("camera.yaml", kCalibration).string()) {}

  // Twenty points and their pixels, of which the first two are 30 px off.
  std::string points_file(double sigma_px, const std::string& more = "") const {
    const Camera camera = read_camera_file(camera_file_);
    RandomStream stream(1, "points", 0);
    std::string text = "# X Y Z u v\n";
    for (int i = 0; i < 20; ++i) {
      const auto coordinate = [&] { return stream.uniform(-1, 1); };
      const Eigen::Vector3d point(coordinate(), coordinate(), coordinate());
      const Eigen::Vector2d pixel = project(camera, truth_ * point).value();
      const double off = i < 2 ? 30 : 0;
      text += fmt::format("{} {} {} {} {}\n", point.x(), point.y(), point.z(),
                          pixel.x() + sigma_px * stream.normal() + off,
                          pixel.y() + sigma_px * stream.normal());
    }
    return folder_.write("points.txt", text + more).string();
  }
  Outcome solve(const std::string& points, const std::string& more = "") const {
    return run("solve " + points + " --camera " + camera_file_ + " " + more);
  }

  TemporaryFolder folder_;
  std::string camera_file_;
  Pose truth_{rotation_from_vector({0.3, -0.2, 0.5}), {0.1, -0.2, 6}};
};

TEST_F(Solve, FindsThePoseAndTheOutliersWithHonestIntervals) {
  const Outcome outcome = solve(points_file(0.5), "--json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const json answer = json::parse(outcome.output);
  EXPECT_EQ(answer["status"], "ok");
  EXPECT_THAT(answer["removed"].get<std::vector<int>>(), ElementsAre(0, 1));
  constexpr double kMostSigmas = 4.5;
  for (int i = 0; i < 3; ++i) {
    const double sd = std::sqrt(answer["covariance_rad_m"][3 + i][3 + i].get<double>());
    const double t = answer["cam_from_target"]["translation_m"][i];
    EXPECT_GT(sd, 0);
    EXPECT_LT(std::abs(t - truth_.translation[i]), kMostSigmas * sd);
  }
  EXPECT_NEAR(answer["noise_px"].get<double>(), 0.5, 0.35) << "of 18 points";
}

TEST_F(Solve, SaysItInWords) {
  const std::string points = points_file(0.5, "nan 0 0 1 2\n");
  const Outcome outcome = solve(points, "--sigma 0.5");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output,
              AllOf(HasSubstr("with 95 % intervals"), HasSubstr("points removed        2 (0, 1)"),
                    HasSubstr("points unusable       1 (20)"), HasSubstr("18 of 21"),
                    Not(HasSubstr("warning"))));
}

TEST_F(Solve, GivesAllPosesWhereAsked) {
  const std::string three =
      folder_
          .write("three.txt",
                 [&] {
                   std::string text;
                   for (const Eigen::Vector3d& x :
                        {Eigen::Vector3d(1, 0, 0), {0, 1, 0.5}, {-1, -0.5, 0}}) {
                     const Eigen::Vector2d pixel =
                         project(read_camera_file(camera_file_), truth_ * x).value();
                     text +=
                         fmt::format("{} {} {} {} {}\n", x.x(), x.y(), x.z(), pixel.x(), pixel.y());
                   }
                   return text;
                 }())
          .string();
  EXPECT_EQ(solve(three).exit_code, 1) << "which of them is meant nobody can say";
  const Outcome outcome = solve(three, "--all --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const json answer = json::parse(outcome.output);
  ASSERT_GE(answer["poses"].size(), 2u);
  ASSERT_LE(answer["poses"].size(), 4u);
  double nearest = 1;
  for (const json& pose : answer["poses"]) {
    EXPECT_LT(pose["residual_rms_px"].get<double>(), 1e-6);
    const json& t = pose["cam_from_target"]["translation_m"];
    const Eigen::Vector3d translation(t[0], t[1], t[2]);
    nearest = std::min(nearest, (translation - truth_.translation).norm());
  }
  EXPECT_LT(nearest, 1e-6);
  const Outcome words = solve(points_file(0.5), "--all");
  EXPECT_THAT(words.output, AllOf(HasSubstr("cam_from_target, 1 of "),
                                  HasSubstr("points removed        2 (0, 1)")));
}

// Twelve edges, of each two pixels of its line; `shifted` of them lies 15 px off.
std::string line_rows(const Camera& camera, const Pose& truth, int shifted) {
  RandomStream stream(2, "lines", 0);
  std::string text = "X1 Y1 Z1 X2 Y2 Z2 u1 v1 u2 v2 sigma\n";
  for (int i = 0; i < 12; ++i) {
    const auto coordinate = [&] { return stream.uniform(-1, 1); };
    const Eigen::Vector3d a(coordinate(), coordinate(), coordinate());
    const Eigen::Vector3d b(coordinate(), coordinate(), coordinate());
    const double off = i == shifted ? 15 : 0;
    const Eigen::Vector2d u = project(camera, truth * (0.9 * a + 0.1 * b)).value();
    const Eigen::Vector2d v = project(camera, truth * (0.2 * a + 0.8 * b)).value();
    text += fmt::format("{} {} {} {} {} {} {} {} {} {} 0.3\n", a.x(), a.y(), a.z(), b.x(), b.y(),
                        b.z(), u.x() + off, u.y() + off, v.x() + off, v.y() + off);
  }
  return text;
}

TEST_F(Solve, TakesLinesBesidePointsOrAlone) {
  const Camera camera = read_camera_file(camera_file_);
  const std::string lines = folder_.write("lines.txt", line_rows(camera, truth_, 3)).string();
  const json both =
      json::parse(solve(points_file(0.3), "--lines " + lines + " --sigma 0.3 --json").output);
  EXPECT_EQ(both["status"], "ok");
  EXPECT_EQ(both["removed_lines"], json::array({3}));
  EXPECT_EQ(both["removed"], json::array({0, 1}));
  const std::string right = folder_.write("right.txt", line_rows(camera, truth_, -1)).string();
  const Outcome alone = run("solve --camera " + camera_file_ + " --lines " + right);
  EXPECT_EQ(alone.exit_code, 0);
  EXPECT_THAT(alone.output, HasSubstr("12 of 12"));
  EXPECT_THAT(alone.output, HasSubstr("lines kept"));
}

TEST_F(Solve, SaysWhatIsNoLineInOneLine) {
  const std::string one_pixel =
      folder_.write("bad.txt", "0 0 0 1 0 0 10 10 20 20\n0 0 0 1 0 0 10 10 10 10\n").string();
  const Outcome bad = run("solve --camera " + camera_file_ + " --sigma 1 --lines " + one_pixel);
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_THAT(bad.output, AllOf(HasSubstr("bad.txt: row 2 is no line"), HasSubstr("must differ")));
  const Outcome orpe = solve(points_file(0.3), "--solver orpe --lines " + one_pixel);
  EXPECT_EQ(orpe.exit_code, 1);
  EXPECT_THAT(orpe.output, HasSubstr("only consensus and lspe use lines"));
  EXPECT_THAT(run("solve --camera " + camera_file_).output, HasSubstr("give a file of points"));
  const std::string good = folder_.write("ten.txt", "0 0 0 1 0 0 10 10 20 20\n").string();
  EXPECT_THAT(run("solve --camera " + camera_file_ + " --lines " + good).output,
              HasSubstr("lines need their noise"));
}

TEST_F(Solve, SolversWithoutTimeForManyPointsSaySo) {
  std::string rows;
  for (int i = 0; i < 400; ++i)
    rows += fmt::format("{} {} {} {} {}\n", i % 7, i % 11, i % 13, i, i % 17);
  const std::string file = folder_.write("many.txt", rows).string();
  const Outcome outcome = solve(file, "--solver orpe_tree");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.output, AllOf(HasSubstr("no pose: too_many_points"), HasSubstr("consensus")));
}

TEST_F(Solve, WarnsOfWhatHasNoPose) {
  std::string random = "X,Y,Z,u,v\n";
  RandomStream stream(2, "chance", 0);
  for (int i = 0; i < 12; ++i) {
    random += fmt::format("{},{},{},{},{}\n", stream.uniform(-1, 1), stream.uniform(-1, 1),
                          stream.uniform(-1, 1), stream.uniform(0, 640), stream.uniform(0, 480));
  }
  const Outcome chance = solve(folder_.write("chance.csv", random).string());
  EXPECT_TRUE(chance.exit_code != 0 || chance.output.find("warning") != std::string::npos)
      << chance.output;
  const Outcome few = solve(folder_.write("few.txt", "0 0 0 1 1\n1 0 0 2 2\n").string());
  EXPECT_EQ(few.exit_code, 1);
  EXPECT_THAT(few.output, HasSubstr("no pose: too_few_points"));
}

TEST_F(Solve, RefusesBadFilesInOneLine) {
  const auto refusal = [&](const std::string& text) {
    const Outcome outcome = solve(folder_.write("bad.txt", text).string());
    EXPECT_EQ(outcome.exit_code, 1) << text;
    EXPECT_EQ(lines_of(outcome.output), 1u) << outcome.output;
    return outcome.output;
  };
  EXPECT_THAT(refusal("1 2 3 4\n"), HasSubstr("bad.txt: line 1 has 4 numbers, must have X Y Z"));
  EXPECT_THAT(refusal("1 2 3 4 5\n1 2 3 x 5\n"), HasSubstr("line 2 has 'x'"));
  EXPECT_THAT(refusal("1 2 3 4 5\n1 2 3 4 5 6\n"), HasSubstr("line 2 has 6 numbers"));
  EXPECT_THAT(refusal("# nothing\n"), HasSubstr("has no rows of numbers"));
  EXPECT_THAT(solve(points_file(0.1), "--solver oracle").output, HasSubstr("cannot be asked"));
  EXPECT_THAT(run("solve " + points_file(0.1) + " --camera none.yaml").output,
              HasSubstr("none.yaml: is missing or cannot be read"));
  folder_.write("k.json", R"({"camera_matrix": 3})");
  EXPECT_THAT(
      run("solve " + points_file(0.1) + " --camera " + (folder_.path() / "k.json").string()).output,
      HasSubstr("camera_matrix is missing, must be 3 x 3"));
}

TEST_F(Solve, ReadsCamerasOfTomlToo) {
  const auto file =
      folder_.write("scene.toml", "[camera]\nwidth_px = 640\nheight_px = 480\nf_px = 800.0\n");
  const Camera camera = read_camera_file(file);
  EXPECT_EQ(camera.fx_px, 800);
  EXPECT_EQ(camera.cx_px, 319.5);
  EXPECT_EQ(std::get<BrownConrady>(read_camera_file(camera_file_).lens).p2, -0.002);
}

TEST_F(Solve, FindsAPoseThroughAFisheyeOfOneOfSeveralCameras) {
  const auto file = folder_.write("cameras.txt",
                                  "1 PINHOLE 640 480 400 410 320.5 240\n"
                                  "2 OPENCV_FISHEYE 640 480 400 410 320.5 240 -0.02 0.005 0 0\n");
  camera_file_ = file.string() + "#2";
  const std::string points = points_file(0.1);
  const auto error_m = [&](const std::string& camera) {
    camera_file_ = camera;
    const json answer = json::parse(solve(points, "--json --sigma 0.1").output);
    if (answer["status"] != "ok") return 1e9;
    return std::abs(answer["cam_from_target"]["translation_m"][2].get<double>() - 6);
  };
  EXPECT_LT(error_m(file.string() + "#2"), 0.01);
  EXPECT_GT(error_m(file.string() + "#1"), 0.03);
  EXPECT_THAT(run("solve " + points + " --camera " + file.string()).output,
              HasSubstr("cameras.txt: has the cameras 1, 2: say which by FILE#1"));
}

TEST(Align, FindsTheAlignmentAmongMostlyWrongPairs) {
  const TemporaryFolder folder;
  const Pose truth{rotation_from_vector({0.3, 1.2, -0.5}), {10, -20, 5}};
  RandomStream stream(3, "pairs", 0);
  const auto point = [&] {
    const double x = stream.uniform(-1, 1);
    const double y = stream.uniform(-1, 1);
    return Eigen::Vector3d(x, y, stream.uniform(-1, 1));
  };
  constexpr double kSigma = 0.01;
  std::string text;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d a = point();
    Eigen::Vector3d b = truth * a;
    for (double& coordinate : b) coordinate += kSigma * stream.normal();
    if (i % 10 != 0) b = truth.translation + point();
    text += fmt::format("{}\t{}\t{}\t{}\t{}\t{}\n", a.x(), a.y(), a.z(), b.x(), b.y(), b.z());
  }
  const std::string file = folder.write("pairs.txt", text).string();
  const Outcome outcome = run("align " + file + " --sigma 0.01 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const json answer = json::parse(outcome.output);
  EXPECT_EQ(answer["status"], "ok");
  EXPECT_TRUE(answer["is_significant"].get<bool>());
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(answer["b_from_a"]["translation_m"][i].get<double>(), truth.translation[i],
                5 * kSigma);
  }
  EXPECT_THAT(run("align " + file).output, AllOf(HasSubstr("b_from_a"), HasSubstr("pairs kept")));
  EXPECT_THAT(run("align " + file + " --method fast").output, HasSubstr("--method fast: is not"));
}

}  // namespace
}  // namespace sightline
