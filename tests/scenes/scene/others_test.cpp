// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/others.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/scene/oriented_box.h"
#include "tests/scenes/scene/laws_for_tests.h"

namespace sightline {
namespace {

using testing::HasSubstr;

TEST(Others, OtherBodiesStandWhereTheLawSays) {
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

// Six crowded cubes; without `apart` some of them cut each other.
std::string crowd(bool is_apart, double widest_px) {
  return fmt::format(R"(
[[other]]
target = "cube"
count = 6
offset_px = [-{0}, {0}]
range_fraction = [0.9, 1.1]
apart = {1}
)",
                     widest_px, is_apart);
}

int cuts_in(const Scene& scene) {
  std::vector<OrientedBox> boxes{oriented_box(scene.target->mesh, scene.cam_from_target)};
  for (const OtherBody& other : scene.others) {
    boxes.push_back(oriented_box(other.target->mesh, other.cam_from_target));
  }
  int cuts = 0;
  for (size_t i = 0; i < boxes.size(); ++i) {
    for (size_t j = 0; j < i; ++j) cuts += do_overlap(boxes[i], boxes[j]) ? 1 : 0;
  }
  return cuts;
}

TEST(Others, ThoseThatKeepApartCutNobody) {
  constexpr double kWidest = 240;
  const SceneLaw free = law_of(crowd(false, kWidest)), apart = law_of(crowd(true, kWidest));
  int cuts = 0;
  for (int i = 0; i < 20; ++i) {
    cuts += cuts_in(draw_scene(free, 0, 7, i).scene);
    const DrawnScene drawn = draw_scene(apart, 0, 7, i);
    ASSERT_TRUE(drawn.is_imageable);
    ASSERT_EQ(drawn.scene.others.size(), 6u);
    EXPECT_EQ(cuts_in(drawn.scene), 0) << i;
  }
  EXPECT_GT(cuts, 0);
  // Where there is no room the scene is a failed one, with its reason.
  const DrawnScene crushed = draw_scene(law_of(crowd(true, 1)), 0, 7, 0);
  EXPECT_FALSE(crushed.is_imageable);
  EXPECT_THAT(why_not_imageable(crushed.scene), HasSubstr("found no place apart in 1000 draws"));
}

// Two unit cubes side by side, the second turned by 45 degrees about an axis: its corner reaches
// half its face's diagonal, sqrt(1/2).
TEST(Others, BoxesOverlapWhereTheyDo) {
  const double reach = 0.5 + std::sqrt(0.5);
  for (const double off : {-1e-6, 1e-6}) {
    const OrientedBox upright{Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity() / 2};
    const Eigen::Matrix3d turn = rotation_from_vector({0, 0, std::numbers::pi / 4});
    const OrientedBox turned{{reach + off, 0, 0}, turn / 2};
    EXPECT_EQ(do_overlap(upright, turned), off < 0);
    EXPECT_EQ(do_overlap(turned, upright), off < 0);
    // Edge against edge, which no face tells apart: both turned, about z and about y.
    const OrientedBox other{{0, 0, 0}, rotation_from_vector({0, std::numbers::pi / 4, 0}) / 2};
    const OrientedBox beside{{2 * std::sqrt(0.5) + off, 0, 0}, turn / 2};
    EXPECT_EQ(do_overlap(other, beside), off < 0);
  }
}

TEST(Others, FlatBoxesInOnePlaneOverlapWhereTheyDo) {
  const Eigen::Matrix3d half = Eigen::Vector3d(0.5, 0.5, 0).asDiagonal();
  const OrientedBox plate{Eigen::Vector3d::Zero(), half};
  EXPECT_FALSE(do_overlap(plate, {{1.01, 0, 0}, half}));
  EXPECT_TRUE(do_overlap(plate, {{0.99, 0, 0}, half}));
  EXPECT_FALSE(do_overlap(plate, {{0, 0, 0.01}, half}));
}

TEST(Others, MistakesGetOneClearLine) {
  EXPECT_THAT(law_error("[[other]]\ntarget = \"cub\""), HasSubstr("did you mean 'cube'"));
  EXPECT_THAT(law_error("[[other]]\ntarget = \"cube\"\ncount = 999"), HasSubstr("count"));
  EXPECT_THAT(law_error("[[other]]\nscale = 2"), HasSubstr("target is missing"));
}

}  // namespace
}  // namespace sightline
