// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/environment.h"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/scenes/scene/laws_for_tests.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::HasSubstr;

// A row of one grey, mantissa / 128 (which must not be 1: that repeats the pixel before).
std::string small_panorama(int width, char mantissa) {
  std::string text =
      "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X " + std::to_string(width) + "\n";
  for (int i = 0; i < width; ++i) text += {mantissa, mantissa, mantissa, static_cast<char>(129)};
  return text;
}

std::string naming(const std::filesystem::path& file, const std::string& more = "") {
  return "[environment]\nfile = \"" + file.string() + "\"\n" + more;
}

TEST(Environment, ItIsDrawnAndStatedAndIsAllTheLightThereIs) {
  const TemporaryFolder folder;
  const auto file = folder.write("sky.hdr", small_panorama(2, 64));
  const SceneLaw law = law_of(
      naming(file, "strength = 2\nyaw_deg = [-180, 180]\n[background]\nkind = \"environment\""));
  const Scene scene = draw_scene(law, 0, 7, 0).scene;
  ASSERT_TRUE(scene.environment.is_there());
  EXPECT_EQ(scene.environment.light->at<cv::Vec3f>(0, 1), cv::Vec3f(0.5f, 0.5f, 0.5f));
  EXPECT_EQ(scene.environment.strength, 2);
  EXPECT_NE(scene.environment.yaw_deg, draw_scene(law, 0, 7, 1).scene.environment.yaw_deg);
  EXPECT_EQ(scene.light.ambient, 0);
  EXPECT_EQ(scene.light.directional, 0);
  EXPECT_EQ(scene.background.kind, BackgroundKind::kEnvironment);
  EXPECT_EQ(facts_of(scene.environment).front().name, "file");
  const Scene lit = draw_scene(law_of(naming(file, "[light]\ndirectional = 0.5")), 0, 7, 0).scene;
  EXPECT_EQ(lit.light.directional, 0.5);
  // Without one nothing is stated, and the light is what it was.
  const Scene plain = draw_scene(law_of(""), 0, 7, 0).scene;
  EXPECT_TRUE(facts_of(plain.environment).empty());
  EXPECT_EQ(plain.light.directional, Light{}.directional);
  EXPECT_EQ(plain.cam_from_target.translation, scene.cam_from_target.translation);
}

TEST(Environment, OfAFolderEachFrameDrawsOne) {
  const TemporaryFolder folder;
  folder.write("a.hdr", small_panorama(2, 32));
  folder.write("b.HDR", small_panorama(2, 64));
  folder.write("notes.txt", "no panorama");
  const SceneLaw law = law_of(naming(folder.path()));
  std::set<std::string> files;
  for (int64_t i = 0; i < 20; ++i) {
    const Environment drawn = draw_scene(law, 0, 7, i).scene.environment;
    files.insert(drawn.file);
    const bool is_a = drawn.file.ends_with("a.hdr");
    EXPECT_EQ(drawn.light->at<cv::Vec3f>(0, 0)[0], is_a ? 0.25f : 0.5f);
    EXPECT_EQ(drawn.file, draw_scene(law, 0, 7, i).scene.environment.file);
  }
  EXPECT_EQ(files.size(), 2U);
}

TEST(Environment, MistakesGetOneClearLine) {
  const TemporaryFolder folder;
  EXPECT_THAT(law_error("[environment]\nstrength = 2"), HasSubstr("needs file beside it"));
  EXPECT_THAT(law_error("[background]\nkind = \"environment\""), HasSubstr("environment.file"));
  EXPECT_THAT(law_error(naming(folder.path())), HasSubstr("a folder without .exr or .hdr"));
  EXPECT_THAT(law_error(naming(folder.path() / "none.exr")), HasSubstr("is not there"));
  EXPECT_THAT(law_error(naming(folder.write("wide.hdr", small_panorama(3, 9)))),
              HasSubstr("is 3 x 1 pixels, must be twice as wide as high"));
  EXPECT_THAT(law_error(naming(folder.write("torn.hdr", "#?RADIANCE\n"))), HasSubstr("is torn"));
  const auto good = folder.write("good.hdr", small_panorama(2, 9));
  EXPECT_THAT(law_error(naming(good, "strength = -1")), HasSubstr("strength"));
  EXPECT_THAT(law_error(naming(good, "turn_deg = 1")), HasSubstr("turn_deg"));
}

}  // namespace
}  // namespace sightline
