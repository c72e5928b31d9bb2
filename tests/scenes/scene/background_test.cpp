// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/background.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "scenes/picture/picture_file.h"
#include "tests/scenes/scene/laws_for_tests.h"
#include "tests/scenes/temporary_folder.h"

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

TEST(Background, OfAFolderEveryFrameHasAPictureOfItsOwn) {
  const TemporaryFolder folder;
  for (const int blue : {100, 255}) {
    const cv::Mat picture(2, 3, CV_8UC3, cv::Scalar(blue, 0, 0));
    folder.write(fmt::format("{}.png", blue), png_bytes(picture));
  }
  folder.write("notes.txt", "no picture");
  const std::string file =
      "[background]\nkind = \"image\"\nfile = \"" + folder.path().string() + "\"\n";
  const SceneLaw law = law_of(file + "[image]\ncolour = \"rgb\"\n");
  std::map<std::string, int> drawn;
  for (int i = 0; i < 40; ++i) {
    const Background background = draw_scene(law, 0, 7, i).scene.background;
    ASSERT_EQ(background.picture_width, 3);
    ASSERT_EQ(background.colours->size(), 18u);
    const bool is_white = background.file.ends_with("/255.png");
    EXPECT_NEAR((*background.colours)[0],
                is_white ? 1 : std::pow((100 / 255.0 + 0.055) / 1.055, 2.4), 1e-6);
    EXPECT_EQ((*background.colours)[1], 0);
    ++drawn[background.file];
  }
  EXPECT_EQ(drawn.size(), 2u);  // else with a chance of 2^-39
  EXPECT_EQ(draw_scene(law_of(file), 0, 7, 0).scene.background.colours, nullptr);  // grey
  const TemporaryFolder empty;
  EXPECT_THAT(
      law_error("[background]\nkind = \"image\"\nfile = \"" + empty.path().string() + "\"\n"),
      HasSubstr("without pictures"));
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
