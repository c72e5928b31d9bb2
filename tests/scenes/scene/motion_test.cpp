// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/scene/laws_for_tests.h"

namespace sightline {
namespace {

using testing::HasSubstr;

TEST(Motion, ATargetIsStillUnlessTheFileMovesIt) {
  EXPECT_TRUE(draw_scene(law_of(""), 0, 7, 0).scene.motion.is_still());
  const Scene scene = draw_scene(law_of("[motion]\nshift_px = 4"), 0, 7, 0).scene;
  EXPECT_FALSE(scene.motion.is_still());
  EXPECT_NEAR(scene.motion.translation_m.norm() * scene.camera.fx_px /
                  scene.cam_from_target.translation.z(),
              4, 1e-9);
}

TEST(Motion, MistakesGetOneClearLine) {
  EXPECT_THAT(law_error("[motion]\nsamples = 1"), HasSubstr("samples"));
}

}  // namespace
}  // namespace sightline
