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

TEST(Optics, AreAPinholesUnlessTheFileOpensIt) {
  EXPECT_FALSE(draw_scene(law_of(""), 0, 7, 0).scene.optics.has_aperture());
  const Scene scene = draw_scene(law_of("[optics]\naperture_mm = [20, 30]"), 0, 7, 0).scene;
  EXPECT_GE(scene.optics.aperture_mm, 20);
  EXPECT_LE(scene.optics.aperture_mm, 30);
  EXPECT_TRUE(facts_of(Optics{}).empty());
}

TEST(Optics, OfALensThatBendsHaveNoOpening) {
  EXPECT_THAT(law_error("[optics]\naperture_mm = -1"), HasSubstr("aperture_mm"));
  const auto error_with_lens = [](const std::string& more) {
    std::string file = kCubeScene;
    file.replace(file.find("f_px"), 0, "distortion = [-0.1, 0.0, 0.0, 0.0, 0.0]\n");
    return error_of([&] {
      read_scene_law(TomlTable::read_text(file + more, "scene.toml"), load_target("cube"), {0});
    });
  };
  EXPECT_THAT(error_with_lens("[optics]\naperture_mm = 20"),
              HasSubstr("needs a camera without lens distortion"));
  EXPECT_EQ(error_with_lens("[optics]\nred_scale = 0.01"), "");
}

TEST(Motion, MistakesGetOneClearLine) {
  EXPECT_THAT(law_error("[motion]\nsamples = 1"), HasSubstr("samples"));
}

}  // namespace
}  // namespace sightline
