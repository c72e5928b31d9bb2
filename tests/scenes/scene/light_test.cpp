// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/light.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/scene/laws_for_tests.h"

namespace sightline {
namespace {

using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;

TEST(Light, TheLightStandsAtThePhaseAngleOnTheSideSaid) {
  const SceneLaw law = law_of("[light]\nphase_deg = 60\nazimuth_deg = 90");
  const Scene scene = draw_scene(law, 0, 7, 0).scene;
  const Eigen::Vector3d to_camera = -scene.cam_from_target.translation.normalized();
  const Eigen::Vector3d& light = scene.light.to_light_in_cam;
  EXPECT_NEAR(light.norm(), 1, 1e-12);
  EXPECT_NEAR(light.dot(to_camera), std::cos(60 * kDegree), 1e-12);
  EXPECT_GT(light.y(), 0.8);  // from below the image: its y points down
}

TEST(Light, ASecondOneStandsWhereItIsSaidAndMovesNoOther) {
  const Scene alone = draw_scene(law_of("[light]\ncone_deg = 30"), 0, 7, 0).scene;
  const Scene both = draw_scene(law_of("[light]\ncone_deg = 30\nsecond = 0.25\n"
                                       "second_phase_deg = 90\nsecond_azimuth_deg = 0\n"
                                       "second_colour = [0.5, 0.75, 1.0]"),
                                0, 7, 0)
                         .scene;
  EXPECT_EQ(both.light.to_light_in_cam, alone.light.to_light_in_cam);
  EXPECT_EQ(both.light.second, 0.25);
  const Eigen::Vector3d to_camera = -both.cam_from_target.translation.normalized();
  EXPECT_NEAR(both.light.to_second_in_cam.dot(to_camera), 0, 1e-12);
  EXPECT_GT(both.light.to_second_in_cam.x(), 0.99);  // from the image's right
  EXPECT_EQ(both.light.second_colour, Eigen::Vector3d(0.5, 0.75, 1));
  EXPECT_EQ(facts_of(both.light).size(), facts_of(alone.light).size() + 3);
}

TEST(Light, MistakesGetOneClearLine) {
  EXPECT_THAT(law_error("[light]\ncolour = [1.0, 2.0, 0.0]"), HasSubstr("from 0 to 1"));
  EXPECT_THAT(law_error("[light]\nsecond = 1.5"), HasSubstr("second"));
  EXPECT_THAT(law_error("[light]\nphase_deg = 10\ncone_deg = 5"), HasSubstr("cone_deg"));
  EXPECT_THAT(law_error("[light]\nazimuth_deg = 10"), HasSubstr("needs phase_deg"));
}

}  // namespace
}  // namespace sightline
