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

TEST(Light, MistakesGetOneClearLine) {
  EXPECT_THAT(law_error("[light]\nphase_deg = 10\ncone_deg = 5"), HasSubstr("cone_deg"));
  EXPECT_THAT(law_error("[light]\nazimuth_deg = 10"), HasSubstr("needs phase_deg"));
}

}  // namespace
}  // namespace sightline
