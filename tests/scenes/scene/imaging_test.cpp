// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/imaging.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/scene/laws_for_tests.h"
#include "tests/scenes/temporary_folder.h"

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
  EXPECT_EQ(read_scene_law(mild, load_target("cube"), {}).camera.lens,
            Lens(BrownConrady{.k1 = -0.1, .k2 = 0.01, .p1 = 0.001}));
}

TEST(Imaging, TheLensSaysWhatItsCoefficientsAre) {
  const auto camera = [](const std::string& keys) {
    return read_camera(TomlTable::read_text("f_px = 300\n" + keys, "camera.toml"));
  };
  EXPECT_EQ(camera("lens = \"fisheye\"\ndistortion = [-0.02, 0.005, 0, 0]\n").lens,
            Lens(KannalaBrandt{.k1 = -0.02, .k2 = 0.005}));
  EXPECT_EQ(camera("lens = \"fisheye\"\n").lens, Lens(KannalaBrandt{}));
  const std::string eight = "0.9, 0.25, 0.001, 0, 0.01, 1.2, 0.5, 0.05";
  const Camera rational =
      camera("lens = \"rational\"\nskew_px = 2\ndistortion = [" + eight + "]\n");
  EXPECT_EQ(std::get<RationalLens>(rational.lens).k5, 0.5);
  EXPECT_EQ(rational.skew_px, 2);
  const auto error = [&](const std::string& keys) { return error_of([&] { camera(keys); }); };
  EXPECT_THAT(error("distortion = [0, 0, 0, 0]\n"), HasSubstr("must be an array of 5 finite"));
  EXPECT_THAT(error("lens = \"fisheye\"\ndistortion = [0, 0, 0, 0, 0]\n"),
              HasSubstr("distortion is [ 0, 0, 0, 0, 0 ], must be an array of 4 finite numbers"));
  EXPECT_THAT(error("lens = \"rational\"\ndistortion = [0, 0, 0, 0]\n"),
              HasSubstr("must be an array of 8 or 12 finite numbers"));
  EXPECT_THAT(error("lens = \"omni\"\n"),
              HasSubstr("lens is \"omni\" (known: brown_conrady, rational, fisheye)"));
  EXPECT_THAT(error("lens = \"fisheye\"\ndistortion = [-0.3, 0, 0, 0]\n"),
              HasSubstr("distortion cannot be undone at pixel (-0.5, -0.5)"));
}

TEST(Imaging, ACalibrationStandsForAllOtherKeys) {
  const TemporaryFolder folder;
  folder.write("cameras.txt", "3 PINHOLE 64 48 500 510 32 24\n");
  const auto camera = [&folder](const std::string& keys) {
    return read_camera(TomlTable::read_file(folder.write("scene.toml", keys)));
  };
  EXPECT_EQ(camera("file = \"cameras.txt\"\n").fy_px, 510);
  EXPECT_EQ(camera("file = \"cameras.txt#3\"\n").width_px, 64);
  const auto error = [&](const std::string& keys) { return error_of([&] { camera(keys); }); };
  EXPECT_THAT(error("file = \"cameras.txt\"\nf_px = 3\n"),
              HasSubstr("f_px cannot stand beside file"));
  EXPECT_THAT(error("file = \"cameras.txt#4\"\n"), HasSubstr("has no camera 4"));
  EXPECT_THAT(error("file = \"none.txt\"\n"), HasSubstr("none.txt: is missing or cannot be read"));
}

TEST(Imaging, TheTruthNamesTheLensUnlessItIsAsMost) {
  Camera camera = centred_camera(64, 48, 300);
  const auto names = [&camera] {
    std::string text;
    for (const Fact& fact : facts_of(camera)) text += fact.name + " ";
    return text;
  };
  EXPECT_EQ(names(), "width_px height_px fx_px fy_px cx_px cy_px distortion_k1_k2_p1_p2_k3 ");
  camera.lens = KannalaBrandt{};
  camera.skew_px = 1;
  EXPECT_EQ(names(),
            "width_px height_px fx_px fy_px cx_px cy_px skew_px lens distortion_k1_k2_k3_k4 ");
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
