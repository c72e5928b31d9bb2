// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/poses.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/scene/laws_for_tests.h"

namespace sightline {
namespace {

using testing::HasSubstr;

constexpr double kDegreeRad = std::numbers::pi / 180;

TEST(Poses, ATiltIsTheAngleBetweenTheZAxes) {
  const TomlTable table = TomlTable::read_text(kCubeScene + "[light]\n", "scene.toml",
                                               std::vector<std::string>{"poses.tilt_deg=30"});
  const SceneLaw law = read_scene_law(table, load_target("cube"), {});
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < 500; ++i) {
    const Eigen::Matrix3d rotation = draw_scene(law, 0, 7, i).scene.cam_from_target.rotation;
    EXPECT_NEAR(rotation(2, 2), std::cos(30 * kDegreeRad), 1e-12);
    EXPECT_NEAR((rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm(), 0, 1e-12);
    sum += rotation.col(2) / 500;
  }
  // Uniform about the line of sight: the mean of 500 unit vectors in a plane is within 0.1.
  EXPECT_LT(sum.head<2>().norm(), 0.1 * 0.5 * std::sqrt(2));
}

TEST(Poses, TheyPlaceThePointThatIsAimedAt) {
  const auto law_of = [](const std::string& aim) {
    const TomlTable table = TomlTable::read_text(kCubeScene + "[light]\n", "scene.toml",
                                                 std::vector<std::string>{"poses.aim_m=" + aim});
    return read_scene_law(table, load_target("cube"), {});
  };
  const SceneLaw origin = law_of("[0, 0, 0]");
  const SceneLaw aimed = law_of("[30, -20, 10]");
  for (int i = 0; i < 20; ++i) {
    RandomStream stream(7, "pose", i);
    RandomStream again(7, "pose", i);
    const Pose pose = drawn_pose(aimed.poses, stream);
    const Pose of_origin = drawn_pose(origin.poses, again);
    EXPECT_NEAR((pose * Eigen::Vector3d(30, -20, 10) - of_origin.translation).norm(), 0, 1e-12);
    EXPECT_EQ(pose.rotation, of_origin.rotation);
    EXPECT_GT((pose.translation - of_origin.translation).norm(), 30);
  }
}

TEST(Poses, MistakesGetOneClearLine) {
  const std::string camera = "[camera]\nf_px = 300\n";
  const auto error = [&](const std::string& poses) {
    const TomlTable table = TomlTable::read_text(camera + "[poses]\n" + poses, "scene.toml");
    return error_of([&] { read_scene_law(table, load_target("cube"), {}); });
  };
  EXPECT_THAT(error("tilt_deg = 3\nangle_deg = [0, 1]\nlateral_m = [0, 0]\nrange_m = [3, 4]\n"),
              HasSubstr("tilt_deg needs attitude"));
  EXPECT_THAT(error("lateral_m = [0, 0]\n"), HasSubstr("fixed is missing"));
  EXPECT_THAT(error("lateral_m = [0, 0]\nrange_m = [3, 4]\n"), HasSubstr("angle_deg is missing"));
  EXPECT_THAT(error("fixed = [{theta_deg = [0, 0, 0], t_m = [0, 0, 9]}]\nrange_m = [3, 4]\n"),
              HasSubstr("cannot stand beside [[poses.fixed]]"));
  EXPECT_THAT(error("fixed = [{theta_deg = [0, 0, 0], t_m = [0, 0, 9]}]\naim_m = [3, 4, 5]\n"),
              HasSubstr("aim_m cannot stand beside [[poses.fixed]]"));
}

// What a paper found at a pose is a study's: a scene does not know the key.
TEST(Poses, TheFiguresOfAPaperAreNoKeyOfAScene) {
  const TomlTable table = TomlTable::read_text(
      "[camera]\nf_px = 300\n[[poses.fixed]]\ntheta_deg = [0, 0, 0]\nt_m = [0, 0, 9]\n"
      "[poses.fixed.paper]\norpe = [1, 1]\n",
      "scene.toml");
  EXPECT_EQ(read_scene_law(table, load_target("cube"), {}).poses.t_m.size(), 1u);
  EXPECT_THAT(error_of([&] { table.reject_unknown_keys(); }),
              HasSubstr("paper is not a known key"));
}

}  // namespace
}  // namespace sightline
