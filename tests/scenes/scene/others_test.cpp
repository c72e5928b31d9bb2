// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/others.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

TEST(Others, MistakesGetOneClearLine) {
  EXPECT_THAT(law_error("[[other]]\ntarget = \"cub\""), HasSubstr("did you mean 'cube'"));
  EXPECT_THAT(law_error("[[other]]\ntarget = \"cube\"\ncount = 999"), HasSubstr("count"));
  EXPECT_THAT(law_error("[[other]]\nscale = 2"), HasSubstr("target is missing"));
}

}  // namespace
}  // namespace sightline
