// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Files that a set lacks, and files that it draws from folders.
#include <filesystem>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/eval/image_sets/image_set_for_tests.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST_F(ImageSet, MakesAgainWhatIsGone) {
  for (const std::string format : {"bop", "bop_imagewise", "speed", "yolo"}) {
    const std::string more = "--count 3 --quiet --also normals --format " + format;
    ASSERT_EQ(render(format, more).exit_code, 0);
    const auto whole = tree(format);
    for (const auto& [file, bytes] : whole) {
      const bool is_of_image = file.find("000001") != std::string::npos;
      if (!is_of_image) continue;
      fs::remove(path(format + "/" + file));
      const Outcome resumed = render(format, more + " --resume");
      EXPECT_EQ(resumed.exit_code, 0) << file << resumed.output;
      EXPECT_TRUE(tree(format) == whole) << format << "/" << file;
    }
    EXPECT_EQ(verify(format).exit_code, 0) << verify(format).output;
  }
}

TEST_F(ImageSet, ThatLacksAPictureIsNotCalledWhole) {
  const std::string more = "--count 4 --quiet ";
  ASSERT_EQ(render("set", more).exit_code, 0);
  const auto whole = tree("set");
  const fs::path list = path("set/test_targets_bop19.json");
  ASSERT_TRUE(fs::exists(list));
  ASSERT_TRUE(fs::remove(path("set/test/000000/gray/000001.png")));
  const Outcome other = render("set", more + "--resume --shard 0/2");
  EXPECT_EQ(other.exit_code, 0) << other.output;
  EXPECT_THAT(other.output, testing::Not(HasSubstr("complete")));
  EXPECT_FALSE(fs::exists(list));
  EXPECT_EQ(render("set", more + "--resume --shard 1/2").exit_code, 0);
  EXPECT_TRUE(tree("set") == whole);
}

// What cannot be made again is known before anything of the set is taken away.
TEST_F(ImageSet, IsNotRepairedWithATornFileOfAFolder) {
  cv::Mat noise(64, 64, CV_8UC3);
  cv::randu(noise, 0, 255);
  const std::string good = png_bytes(noise);
  fs::create_directory(path("pictures"));
  folder_.write("pictures/a.png", good);
  const std::string more = "--count 2 --quiet --set material.textures=" + path("pictures") + " ";
  ASSERT_EQ(render("set", more).exit_code, 0);
  ASSERT_TRUE(fs::remove(path("set/test/000000/gray/000001.png")));
  const auto before = tree("set");
  folder_.write("pictures/a.png", good.substr(0, good.size() / 2));
  const Outcome torn = render("set", more + "--resume");
  EXPECT_EQ(torn.exit_code, 1);
  EXPECT_THAT(torn.output, HasSubstr("whose a.png "));
  EXPECT_TRUE(tree("set") == before);
}

TEST_F(ImageSet, IsNotBegunWithATornFileOfAFolder) {
  cv::Mat noise(64, 64, CV_8UC3);
  cv::randu(noise, 0, 255);
  const std::string good = png_bytes(noise);
  fs::create_directory(path("pictures"));
  folder_.write("pictures/a.png", good);
  folder_.write("pictures/b.png", good.substr(0, good.size() / 2));
  for (const std::string key : {"material.textures", "background.file"}) {
    const std::string kind = key == "background.file" ? "--set background.kind=image " : "";
    const std::string more =
        fmt::format("--count 12 --quiet {}--set {}={} ", kind, key, path("pictures"));
    for (const std::string jobs : {"--jobs 1", "--jobs 2"}) {
      const Outcome torn = render("set", more + jobs);
      EXPECT_EQ(torn.exit_code, 1);
      EXPECT_THAT(torn.output, HasSubstr(key + " is"));
      EXPECT_THAT(torn.output, HasSubstr("whose b.png "));
      EXPECT_FALSE(fs::exists(path("set")));
    }
  }
}

TEST_F(ImageSet, OfStudiesIsNotBegunEither) {
  fs::create_directory(path("skies"));
  folder_.write("skies/a.hdr",
                "#?RADIANCE\n\n-Y 1 +X 2\n" + std::string({64, 64, 64, 127, 64, 64, 64, 127}));
  folder_.write("skies/b.hdr", "#?RADIANCE\n\n-Y 1 +X 2\n@@");
  const Outcome torn =
      run("study feature-localisation --quiet --trials 12 --set 'sweep={}' --set "
          "environment.file=" +
          path("skies") + " --out " + path("run"));
  EXPECT_EQ(torn.exit_code, 1);
  EXPECT_THAT(torn.output, HasSubstr("environment.file is"));
  EXPECT_THAT(torn.output, HasSubstr("whose b.hdr is torn"));
  EXPECT_FALSE(fs::exists(path("run")));
}

// Random materials make other pictures and the same truth of shape, whoever makes them.
TEST_F(ImageSet, InRandomMaterialsIsTheSameByJobsAndShards) {
  cv::Mat noise(32, 32, CV_8UC3);
  cv::randu(noise, 0, 255);
  fs::create_directory(path("pictures"));
  for (const std::string name : {"a", "b", "c"}) {
    folder_.write("pictures/" + name + ".png", png_bytes(noise));
    noise = noise / 2;
  }
  const std::string more = "--count 4 --quiet --set image.colour=rgb ";
  const std::string material = fmt::format(
      "{}--set material.textures={} --set material.roughness=[0.1,0.9] --set "
      "material.hue_deg=[0,360] --set material.saturation=[0,1] ",
      more, path("pictures"));
  ASSERT_EQ(render("plain", more).exit_code, 0);
  ASSERT_EQ(render("one", material + "--jobs 1").exit_code, 0);
  ASSERT_EQ(render("two", material + "--jobs 2").exit_code, 0);
  expect_same("one", "two");
  const auto plain = tree("plain"), one = tree("one");
  for (const char* file : {"test/000000/depth/000000.png", "test/000000/scene_gt.json",
                           "test/000000/mask_visib/000002_000000.png"}) {
    EXPECT_TRUE(plain.at(file) == one.at(file)) << file;
  }
  EXPECT_FALSE(plain.at("test/000000/rgb/000000.png") == one.at("test/000000/rgb/000000.png"));
  const nlohmann::json drawn = read("one/sightline/000000/000000.json")["scene"]["materials"];
  ASSERT_EQ(drawn.size(), 1u);
  EXPECT_THAT(drawn[0]["texture"].get<std::string>(), HasSubstr("pictures/"));
  EXPECT_EQ(verify("one").exit_code, 0) << verify("one").output;
}

}  // namespace
}  // namespace sightline
