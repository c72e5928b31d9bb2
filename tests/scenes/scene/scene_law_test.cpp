// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/scene_law.h"

#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/scene/laws_for_tests.h"

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(SceneLaw, ANumberIsThatNumberInEveryScene) {
  const SceneLaw law = law_of("[background]\nlevel = 0.4\n[noise]\nscale = 2\nread_noise_grey = 3");
  for (int i = 0; i < 5; ++i) {
    const Scene scene = draw_scene(law, 0, 7, i).scene;
    EXPECT_EQ(scene.background.level, 0.4);
    EXPECT_EQ(scene.sensor.read_noise_grey, 6);
  }
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

TEST(SceneLaw, EveryKeyThatIsListedIsKnownToTheReader) {
  for (const KeyText& key : scene_keys()) {
    if (key.table == "poses" || key.table == "poses.fixed" || key.table == "camera") continue;
    const bool is_other = key.table == "other";
    const bool is_list = is_other || key.table == "lamp";
    const std::string heading = is_list ? "[[" + key.table + "]]\n" : "[" + key.table + "]\n";
    const std::string target = is_other && key.name != "target" ? "target = \"cube\"\n" : "";
    const std::string error = law_error(heading + target + key.name + " = {}\n");
    EXPECT_THAT(error, HasSubstr(key.table)) << key.name;
    EXPECT_THAT(error, HasSubstr(key.name)) << error;
    EXPECT_THAT(error, Not(HasSubstr("not a known key"))) << key.name;
  }
}

TEST(SceneLaw, EveryKeyIsListedOnceWithWhatItMeans) {
  std::set<std::string> paths;
  for (const KeyText& key : scene_keys()) {
    EXPECT_TRUE(paths.insert(key.table + "." + key.name).second) << key.name;
    EXPECT_NE(key.meaning, "") << key.name;
    EXPECT_NE(key.range, "") << key.name;
    EXPECT_NE(key.fallback, "") << key.name;
  }
  EXPECT_TRUE(paths.contains("image.psf_sigma_px"));
}

}  // namespace
}  // namespace sightline
