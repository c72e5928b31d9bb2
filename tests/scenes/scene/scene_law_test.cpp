// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/scene_law.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pose/angles.h"
#include "pose/attitude.h"
#include "scenes/files/input_error.h"
#include "tests/scenes/error_text.h"

namespace sightline {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string kCube = R"(
[camera]
f_px = 4000
[poses]
attitude = "uniform"
lateral_m = [-0.2, 0.2]
range_m = [20, 30]
)";

SceneLaw law_of(const std::string& more) {
  const TomlTable table = TomlTable::read_text(kCube + more, "scene.toml");
  const SceneLaw law = read_scene_law(table, load_target("cube"), {0, 1, 2});
  table.reject_unknown_keys();
  return law;
}

std::string law_error(const std::string& more) {
  return error_of([&] { law_of(more); });
}

TEST(SceneLaw, ANumberIsThatNumberInEveryScene) {
  const SceneLaw law = law_of("[background]\nlevel = 0.4\n[noise]\nscale = 2\nread_noise_grey = 3");
  for (int i = 0; i < 5; ++i) {
    const Scene scene = draw_scene(law, 0, 7, i).scene;
    EXPECT_EQ(scene.background.level, 0.4);
    EXPECT_EQ(scene.sensor.read_noise_grey, 6);
  }
}

TEST(SceneLaw, ARangeIsDrawnUniformlyForEveryScene) {
  const SceneLaw law = law_of("[background]\nlevel = [0.2, 0.6]");
  double sum = 0, low = 1, high = 0;
  constexpr int kScenes = 2000;
  for (int i = 0; i < kScenes; ++i) {
    const double level = draw_scene(law, 0, 7, i).scene.background.level;
    sum += level;
    low = std::min(low, level);
    high = std::max(high, level);
  }
  // The mean of 2000 uniform values has sd 0.4 / sqrt(12 * 2000) = 0.0026.
  EXPECT_NEAR(sum / kScenes, 0.4, 0.01);
  EXPECT_NEAR(low, 0.2, 0.005);
  EXPECT_NEAR(high, 0.6, 0.005);
}

TEST(SceneLaw, WideningOneRangeLeavesAllOtherDraws) {
  const Scene plain = draw_scene(law_of(""), 0, 7, 3).scene;
  const Scene wide = draw_scene(law_of("[image]\ngain = [0.5, 2]\n[motion]\nshift_px = [0, 9]\n"
                                       "[[other]]\ntarget = \"cube\"\n"),
                                0, 7, 3)
                         .scene;
  EXPECT_NE(wide.sensor.gain, plain.sensor.gain);
  EXPECT_FALSE(wide.motion.is_still());
  EXPECT_EQ(wide.others.size(), 1u);
  EXPECT_EQ(wide.cam_from_target.rotation, plain.cam_from_target.rotation);
  EXPECT_EQ(wide.cam_from_target.translation, plain.cam_from_target.translation);
  EXPECT_EQ(wide.light.to_light_in_cam, plain.light.to_light_in_cam);
}

TEST(SceneLaw, TheLightStandsAtThePhaseAngleOnTheSideSaid) {
  const SceneLaw law = law_of("[light]\nphase_deg = 60\nazimuth_deg = 90");
  const Scene scene = draw_scene(law, 0, 7, 0).scene;
  const Eigen::Vector3d to_camera = -scene.cam_from_target.translation.normalized();
  const Eigen::Vector3d& light = scene.light.to_light_in_cam;
  EXPECT_NEAR(light.norm(), 1, 1e-12);
  EXPECT_NEAR(light.dot(to_camera), std::cos(60 * kDegree), 1e-12);
  EXPECT_GT(light.y(), 0.8);  // from below the image: its y points down
}

TEST(SceneLaw, ATiltIsTheAngleBetweenTheZAxes) {
  const TomlTable table = TomlTable::read_text(kCube + "[light]\n", "scene.toml",
                                               std::vector<std::string>{"poses.tilt_deg=30"});
  const SceneLaw law = read_scene_law(table, load_target("cube"), {});
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < 500; ++i) {
    const Eigen::Matrix3d rotation = draw_scene(law, 0, 7, i).scene.cam_from_target.rotation;
    EXPECT_NEAR(rotation(2, 2), std::cos(30 * kDegree), 1e-12);
    EXPECT_NEAR((rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm(), 0, 1e-12);
    sum += rotation.col(2) / 500;
  }
  // Uniform about the line of sight: the mean of 500 unit vectors in a plane is within 0.1.
  EXPECT_LT(sum.head<2>().norm(), 0.1 * 0.5 * std::sqrt(2));
}

TEST(SceneLaw, OtherBodiesStandWhereTheLawSays) {
  const SceneLaw law = law_of(R"(
[[other]]
target = "cube"
scale = 0.1
count = 3
offset_px = [-50, 50]
range_fraction = [0.5, 0.6]
[[other]]
target = "cube"
role = "target"
angle_deg = [0, 0]
)");
  const Scene scene = draw_scene(law, 0, 7, 0).scene;
  ASSERT_EQ(scene.others.size(), 4u);
  const auto main_pixel = project(scene.camera, scene.cam_from_target.translation);
  for (int i = 0; i < 3; ++i) {
    const OtherBody& other = scene.others[i];
    EXPECT_TRUE(other.is_occluder);
    EXPECT_NEAR(radius_m(other.target->mesh), 0.1 * std::sqrt(0.75), 1e-9);
    const double z = other.cam_from_target.translation.z() / scene.cam_from_target.translation.z();
    EXPECT_GE(z, 0.5);
    EXPECT_LE(z, 0.6);
    const auto pixel = project(scene.camera, other.cam_from_target.translation);
    EXPECT_LE((*pixel - *main_pixel).cwiseAbs().maxCoeff(), 50 + 1e-9);
  }
  EXPECT_FALSE(scene.others[3].is_occluder);
  EXPECT_TRUE(scene.others[3].cam_from_target.rotation.isIdentity(1e-12));
}

TEST(SceneLaw, MistakesGetOneClearLine) {
  EXPECT_THAT(law_error("[background]\nlevel = 2"), AllOf(HasSubstr("level"), HasSubstr("0 to 1")));
  EXPECT_THAT(law_error("[background]\nlevel = [0.5, 0.2]"), HasSubstr("[low, high]"));
  EXPECT_THAT(law_error("[background]\nkind = \"cloud\""), HasSubstr("clouds"));
  EXPECT_THAT(law_error("[background]\nfile = \"x.png\""), HasSubstr("kind = \"image\""));
  EXPECT_THAT(law_error("[background]\nkind = \"image\"\nfile = \"no.png\""),
              HasSubstr("no picture"));
  EXPECT_THAT(law_error("[light]\nphase_deg = 10\ncone_deg = 5"), HasSubstr("cone_deg"));
  EXPECT_THAT(law_error("[light]\nazimuth_deg = 10"), HasSubstr("needs phase_deg"));
  EXPECT_THAT(law_error("[[other]]\ntarget = \"cub\""), HasSubstr("did you mean 'cube'"));
  EXPECT_THAT(law_error("[[other]]\ntarget = \"cube\"\ncount = 999"), HasSubstr("count"));
  EXPECT_THAT(law_error("[motion]\nsamples = 1"), HasSubstr("samples"));
  EXPECT_THROW(read_scene_law(TomlTable::read_text("[camera]\nf_px = 300\n[poses]\ntilt_deg = 3\n"
                                                   "angle_deg = [0, 1]\nlateral_m = [0, 0]\n"
                                                   "range_m = [3, 4]\n",
                                                   "scene.toml"),
                              load_target("cube"), {}),
               InputError);
  EXPECT_THAT(law_error("[image]\npsf = 1"), HasSubstr("not a known key"));
}

TEST(SceneLaw, ALensThatFoldsTheImageIsRefused) {
  const std::string wide =
      "[camera]\nf_px = 300\ndistortion = [-0.9, 0, 0, 0, 0]\n"
      "[poses]\nattitude = \"uniform\"\nlateral_m = [0, 0]\nrange_m = [3, 4]\n";
  const TomlTable table = TomlTable::read_text(wide, "scene.toml");
  EXPECT_THROW(read_scene_law(table, load_target("cube"), {}), InputError);
  const TomlTable mild = TomlTable::read_text(
      "[camera]\nf_px = 300\ndistortion = [-0.1, 0.01, 0.001, 0, 0]\n"
      "[poses]\nattitude = \"uniform\"\nlateral_m = [0, 0]\nrange_m = [3, 4]\n",
      "scene.toml");
  EXPECT_EQ(read_scene_law(mild, load_target("cube"), {}).camera.distortion.k2, 0.01);
}

}  // namespace
}  // namespace sightline
