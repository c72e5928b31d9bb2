// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/background.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/scene/laws_for_tests.h"

namespace sightline {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(Background, ARangeIsDrawnUniformlyForEveryScene) {
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

TEST(Background, MistakesGetOneClearLine) {
  EXPECT_THAT(law_error("[background]\nlevel = 2"), AllOf(HasSubstr("level"), HasSubstr("0 to 1")));
  EXPECT_THAT(law_error("[background]\nlevel = [0.5, 0.2]"), HasSubstr("[low, high]"));
  EXPECT_THAT(law_error("[background]\nkind = \"cloud\""), HasSubstr("clouds"));
  EXPECT_THAT(law_error("[background]\nfile = \"x.png\""), HasSubstr("kind = \"image\""));
  EXPECT_THAT(law_error("[background]\nkind = \"image\"\nfile = \"no.png\""),
              HasSubstr("file is \"no.png\", which is not there"));
}

}  // namespace
}  // namespace sightline
