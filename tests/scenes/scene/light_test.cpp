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

TEST(Light, ADiscIsStatedWhereThereIsOne) {
  const auto light_of = [](const std::string& keys) {
    return draw_scene(law_of("[light]\ncasts_shadow = true\n" + keys), 0, 7, 0).scene.light;
  };
  EXPECT_EQ(light_of("radius_deg = 0.27").radius_deg, 0.27);
  EXPECT_EQ(facts_of(light_of("radius_deg = 0.27")).size(), facts_of(light_of("")).size() + 1);
}

TEST(Lamps, TheyStandWhereTheyAreSaidAndShineAsFarAsTheTarget) {
  const SceneLaw law = law_of(
      "[[lamp]]\nposition_m = [0.5, 0, 0]\nstrength = [0.5, 0.75]\n"
      "[[lamp]]\nspread_m = 0.1\ndirection = [0, 0, 2]\ncone_deg = 20\ndistance_m = 3");
  const Scene scene = draw_scene(law, 0, 7, 0).scene;
  ASSERT_EQ(scene.lamps.size(), 2U);
  const auto& first = scene.lamps[0];
  EXPECT_EQ(first.position_in_cam_m, Eigen::Vector3d(0.5, 0, 0));
  EXPECT_GE(first.strength, 0.5);
  EXPECT_LE(first.strength, 0.75);
  EXPECT_EQ(first.distance_m, (scene.cam_from_target.translation - first.position_in_cam_m).norm());
  const auto& second = scene.lamps[1];
  EXPECT_GT(second.position_in_cam_m.norm(), 0);
  EXPECT_LE(second.position_in_cam_m.cwiseAbs().maxCoeff(), 0.1);
  EXPECT_EQ(second.distance_m, 3);
  EXPECT_EQ(second.direction_in_cam, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(cone_share(second, std::cos(21 * kDegree)), 0);
  EXPECT_NE(draw_scene(law, 0, 7, 1).scene.lamps[0].strength, first.strength);
  // Other draws stay what they were.
  EXPECT_EQ(draw_scene(law_of(""), 0, 7, 0).scene.cam_from_target.translation,
            scene.cam_from_target.translation);
}

TEST(Lamps, MistakesGetOneClearLine) {
  EXPECT_THAT(law_error("[[lamp]]\ndirection = [0, 0, 0]"), HasSubstr("must point somewhere"));
  EXPECT_THAT(law_error("[[lamp]]\ncone_deg = 10\nfull_deg = 20"), HasSubstr("at most cone_deg"));
  EXPECT_THAT(law_error("[[lamp]]\ncolour = [2, 0, 0]"), HasSubstr("from 0 to 1"));
  EXPECT_THAT(law_error("[[lamp]]\nstrength = -1"), HasSubstr("strength"));
  EXPECT_THAT(law_error("[[lamp]]\nstrenght = 1"), HasSubstr("strenght"));
}

TEST(Light, MistakesGetOneClearLine) {
  EXPECT_THAT(law_error("[light]\nradius_deg = 1"), HasSubstr("needs casts_shadow"));
  EXPECT_THAT(law_error("[light]\ncolour = [1.0, 2.0, 0.0]"), HasSubstr("from 0 to 1"));
  EXPECT_THAT(law_error("[light]\nsecond = 1.5"), HasSubstr("second"));
  EXPECT_THAT(law_error("[light]\nphase_deg = 10\ncone_deg = 5"), HasSubstr("cone_deg"));
  EXPECT_THAT(law_error("[light]\nazimuth_deg = 10"), HasSubstr("needs phase_deg"));
}

}  // namespace
}  // namespace sightline
