// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/imaging.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/scene/laws_for_tests.h"

namespace sightline {
namespace {

using testing::HasSubstr;

TEST(Imaging, ALensThatFoldsTheImageIsRefused) {
  const std::string wide =
      "[camera]\nf_px = 300\ndistortion = [-0.9, 0, 0, 0, 0]\n"
      "[poses]\nattitude = \"uniform\"\nlateral_m = [0, 0]\nrange_m = [3, 4]\n";
  const TomlTable table = TomlTable::read_text(wide, "scene.toml");
  EXPECT_THROW(read_scene_law(table, load_target("cube"), {}), InputError);
  const TomlTable mild = TomlTable::read_text(
      "[camera]\nf_px = 300\ndistortion = [-0.1, 0.01, 0.001, 0, 0]\n"
      "[poses]\nattitude = \"uniform\"\nlateral_m = [0, 0]\nrange_m = [3, 4]\n",
      "scene.toml");
  EXPECT_EQ(read_scene_law(mild, load_target("cube"), {}).camera.distortion.k2, 0.01);
}

TEST(Imaging, APrincipalPointIsTheCentreUnlessGiven) {
  EXPECT_EQ(law_of("").camera.cx_px, 255.5);
  const TomlTable table =
      TomlTable::read_text("f_px = 300\nprincipal_point_px = [100, 120]\n", "camera.toml");
  EXPECT_EQ(read_camera(table).cx_px, 100);
  EXPECT_EQ(read_camera(table).cy_px, 120);
}

TEST(Imaging, MistakesGetOneClearLine) {
  EXPECT_THAT(law_error("[image]\nsamples_per_pixel = 17"),
              HasSubstr("is 17, must be one of 1, 4"));
  EXPECT_THAT(law_error("[image]\nsamples_per_pixel = 300"), HasSubstr("from 1 to 256"));
  EXPECT_THAT(error_of([] { read_camera(TomlTable::read_text("", "camera.toml")); }),
              HasSubstr("f_px is missing"));
}

}  // namespace
}  // namespace sightline
