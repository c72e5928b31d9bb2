// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a set has on request, sets that grow, and pictures that are not those that were rendered.
#include <cmath>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "pose/pose.h"
#include "tests/eval/image_sets/image_set_for_tests.h"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Of the cube whose edges are 1 m long, a step of the coordinates' pictures: its diagonal in 16
// bits.
constexpr double kStepM = 1.7320508 / 65535;

Pose true_pose(const nlohmann::json& truth) {
  const nlohmann::json& stated = truth["bodies"][0]["cam_from_target"];
  Pose pose;
  for (size_t i = 0; i < 9; ++i) {
    pose.rotation(static_cast<int>(i) / 3, static_cast<int>(i) % 3) = stated["rotation"][i];
  }
  for (size_t i = 0; i < 3; ++i) {
    pose.translation[static_cast<int>(i)] = stated["translation_m"][i];
  }
  return pose;
}

Eigen::Vector3d rgb_at(const cv::Mat& picture, int u, int v) {
  const cv::Vec3w& pixel = picture.at<cv::Vec3w>(v, u);
  return Eigen::Vector3d(pixel[2], pixel[1], pixel[0]) / 65535;
}

TEST_F(ImageSet, CoordinatesAndNormalsAreThoseOfTheSurfaceThatIsSeen) {
  ASSERT_EQ(render("set", "--count 1 --also nocs,normals").exit_code, 0);
  const nlohmann::json truth = read("set/sightline/000000/000000.json");
  const Pose pose = true_pose(truth);
  const cv::Mat nocs = picture("set/sightline/000000/000000_nocs.png");
  const cv::Mat normals = picture("set/sightline/000000/000000_normals.png");
  const cv::Mat depth = picture("set/sightline/000000/000000_depth.tiff");
  ASSERT_EQ(nocs.type(), CV_16UC3);
  ASSERT_EQ(normals.type(), CV_16UC3);
  int seen = 0;
  for (int v = 0; v < 64; ++v) {
    for (int u = 0; u < 64; ++u) {
      if (std::isnan(depth.at<float>(v, u))) {
        ASSERT_EQ(nocs.at<cv::Vec3w>(v, u), cv::Vec3w(0, 0, 0));
        ASSERT_EQ(normals.at<cv::Vec3w>(v, u), cv::Vec3w(0, 0, 0));
        continue;
      }
      ++seen;
      const Eigen::Vector3d on_body =
          (rgb_at(nocs, u, v).array() - 0.5) * std::sqrt(3.0);  // the diagonal of the cube
      const Eigen::Vector3d x = pose * on_body;
      ASSERT_NEAR(x.z(), truth["z0_m"].get<double>() + depth.at<float>(v, u), 2 * kStepM);
      const Eigen::Vector2d pixel = 250 * x.hnormalized() + Eigen::Vector2d(31.5, 31.5);
      ASSERT_LT((pixel - Eigen::Vector2d(u, v)).norm(), 250 * 2 * kStepM / x.z());
      // Its face is the axis along which the point lies on the cube's surface.
      int face = 0;
      on_body.cwiseAbs().maxCoeff(&face);
      const Eigen::Vector3d outward = pose.rotation.col(face) * (on_body[face] > 0 ? 1 : -1);
      const Eigen::Vector3d normal = 2 * rgb_at(normals, u, v).array() - 1;
      ASSERT_LT((normal - outward).norm(), 3.0 / 65535);
      ASSERT_LT(normal.dot(x), 0);
    }
  }
  EXPECT_EQ(seen, truth["bodies"][0]["visible_pixels"].get<int>());
  EXPECT_GT(seen, 100);
  EXPECT_EQ(verify("set").exit_code, 0) << verify("set").output;
}

// As BOP's toolkit has ITODD, the one of its sets that is grey.
TEST_F(ImageSet, InGreyHasItsPicturesAndDepthAsTiffToo) {
  ASSERT_EQ(render("plain", "--count 1 --truth minimal").exit_code, 0);
  for (const char* kind : {"gray", "depth"}) {
    const std::string stem = fmt::format("plain/test/000000/{}/000000", kind);
    const cv::Mat tiff = picture(stem + ".tif"), png = picture(stem + ".png");
    ASSERT_EQ(tiff.type(), png.type());
    EXPECT_EQ(cv::norm(tiff, png, cv::NORM_INF), 0);
    EXPECT_GT(cv::norm(tiff, cv::NORM_INF), 0);
  }
  EXPECT_EQ(verify("plain").exit_code, 0) << verify("plain").output;
  ASSERT_EQ(render("deep", "--count 1 --set image.bits=12").exit_code, 0);
  EXPECT_EQ(picture("deep/test/000000/gray/000000.tif").type(), CV_16UC1);
  EXPECT_EQ(verify("deep").exit_code, 0) << verify("deep").output;
}

TEST_F(ImageSet, InGreyHasColourPicturesWhereAskedFor) {
  ASSERT_EQ(render("set", "--count 1 --also rgb,tiff").exit_code, 0);
  const cv::Mat rgb = picture("set/test/000000/rgb/000000.png");
  ASSERT_EQ(rgb.type(), CV_8UC3);
  std::vector<cv::Mat> channels;
  cv::split(rgb, channels);
  channels.push_back(picture("set/test/000000/gray/000000.tiff"));
  for (const cv::Mat& channel : channels) {
    EXPECT_EQ(cv::norm(channel, picture("set/test/000000/gray/000000.png"), cv::NORM_INF), 0);
  }
  EXPECT_EQ(verify("set").exit_code, 0) << verify("set").output;
  ASSERT_EQ(render("imagewise", "--count 1 --also rgb --format bop_imagewise").exit_code, 0);
  EXPECT_EQ(cv::norm(picture("imagewise/test/000000_000000.rgb.png"), rgb, cv::NORM_INF), 0);
  EXPECT_EQ(picture("imagewise/test/000000_000000.gray.tiff").type(), CV_8UC1);
  EXPECT_EQ(verify("imagewise").exit_code, 0) << verify("imagewise").output;
}

TEST_F(ImageSet, InColourHasTiffWhereAskedForAndItsJpegAsItIs) {
  ASSERT_EQ(render("png", "--count 1 --set image.colour=rgb").exit_code, 0);
  const std::string jpeg = "--count 1 --set image.colour=rgb --set image.jpeg_quality=60 ";
  ASSERT_EQ(render("jpeg", jpeg).exit_code, 0);
  ASSERT_EQ(render("tiff", jpeg + "--also itodd").exit_code, 0);
  EXPECT_TRUE(tree("png").contains("test/000000/rgb/000000.png"));
  std::map<std::string, std::string> more = tree("tiff");
  EXPECT_EQ(more.erase("test/000000/gray/000000.tif"), 1u);
  EXPECT_EQ(more.erase("test/000000/depth/000000.tif"), 1u);
  EXPECT_EQ(more.size(), tree("jpeg").size());
  EXPECT_FALSE(more.contains("test/000000/rgb/000000.png"));
  const cv::Mat colour = picture("jpeg/test/000000/rgb/000000.jpg");
  ASSERT_EQ(colour.type(), CV_8UC3);
  cv::Mat grey;
  cv::cvtColor(colour, grey, cv::COLOR_BGR2GRAY);
  EXPECT_EQ(cv::norm(grey, picture("jpeg/test/000000/gray/000000.png"), cv::NORM_INF), 0);
  EXPECT_EQ(verify("jpeg").exit_code, 0) << verify("jpeg").output;
  ASSERT_EQ(render("imagewise", jpeg + "--format bop_imagewise").exit_code, 0);
  EXPECT_EQ(cv::norm(picture("imagewise/test/000000_000000.rgb.jpg"), colour, cv::NORM_INF), 0);
  EXPECT_EQ(verify("imagewise").exit_code, 0) << verify("imagewise").output;
}

TEST_F(ImageSet, HasNothingThatIsNotAskedFor) {
  ASSERT_EQ(render("grey", "--count 1").exit_code, 0);
  std::vector<std::string> files;
  for (const auto& [file, bytes] : tree("grey")) {
    if (!file.starts_with("models")) files.push_back(file);
  }
  EXPECT_THAT(
      files,
      ElementsAre("camera.json", "dataset_info.md", "scene.toml", "sightline.json",
                  "sightline/000000/000000.json", "sightline/000000/000000_depth.tiff",
                  "sightline/000000/000000_parts.png", "test/000000/depth/000000.png",
                  "test/000000/depth/000000.tif", "test/000000/gray/000000.png",
                  "test/000000/gray/000000.tif", "test/000000/mask/000000_000000.png",
                  "test/000000/mask_visib/000000_000000.png", "test/000000/scene_camera.json",
                  "test/000000/scene_gt.json", "test/000000/scene_gt_coco.json",
                  "test/000000/scene_gt_coco_keypoints.json", "test/000000/scene_gt_info.json",
                  "test_targets_bop19.json"));
  EXPECT_EQ(read("grey/sightline.json")["also"], nlohmann::json({"itodd"}));
  ASSERT_EQ(render("plain", "--count 1 --truth minimal --format speed").exit_code, 0);
  EXPECT_FALSE(read("plain/sightline.json").contains("also"));
  EXPECT_THAT(
      render("plain", "--count 1 --truth minimal --format speed --also nocs --resume").output,
      HasSubstr("was begun with also"));
  const Outcome refused = render("speed", "--count 1 --format speed --also tiff");
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(
      refused.output,
      HasSubstr("--also tiff: the format speed has no place for it, but for normals, nocs"));
  EXPECT_THAT(render("colour", "--count 1 --also rgb --set image.colour=rgb").output,
              HasSubstr("--also rgb: is of sets in grey"));
  EXPECT_EQ(render("other", "--count 1 --also depth").exit_code, 2);
}

// Whoever reads it, and however many read with it.
TEST_F(ImageSet, NamesTheFirstTruthThatCannotBeRead) {
  ASSERT_EQ(render("set", "--count 8 --shard 0/2").exit_code, 0);
  ASSERT_EQ(render("set", "--count 8 --shard 1/2").exit_code, 0);
  for (const int torn : {2, 5, 7}) {
    std::ofstream(path(fmt::format("set/sightline/000000/{:06}.json", torn))) << "{";
  }
  for (const int jobs : {1, 2, 3, 9}) {
    const Outcome refused = render("set", fmt::format("--count 8 --resume --jobs {}", jobs));
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.output, HasSubstr("000002.json: cannot be read as a truth"));
  }
}

TEST_F(ImageSet, GrowsToTheSetThatItWouldHaveBeen) {
  const std::string scenes = "--scene-size 4 --quiet ";
  ASSERT_EQ(render("whole", scenes + "--count 9").exit_code, 0);
  ASSERT_EQ(render("grown", scenes + "--count 3").exit_code, 0);
  EXPECT_EQ(render("grown", scenes + "--count 9").exit_code, 1);  // without --resume
  EXPECT_EQ(verify("grown").exit_code, 0) << verify("grown").output;
  ASSERT_EQ(render("grown", scenes + "--count 9 --resume --shard 1/2").exit_code, 0);
  // What is not whole has no list, as if it had never had one.
  EXPECT_FALSE(std::filesystem::exists(path("grown/test_targets_bop19.json")));
  ASSERT_EQ(render("grown", scenes + "--count 9 --resume --shard 0/2").exit_code, 0);
  expect_same("whole", "grown");
  EXPECT_EQ(verify("grown").exit_code, 0) << verify("grown").output;
  EXPECT_THAT(render("grown", scenes + "--count 5 --resume").output, HasSubstr("count 9, not 5"));
  EXPECT_THAT(render("grown", scenes + "--count 12 --resume --seed 2").output,
              HasSubstr("seed 1, not 2"));
  expect_same("whole", "grown");
}

TEST_F(ImageSet, VerifyKnowsThePicturesThatWereRendered) {
  ASSERT_EQ(render("set", "--count 2 --quiet --also normals").exit_code, 0);
  const auto output_with = [this](const std::string& file, const std::string& bytes) {
    const std::string before = read_whole(path("set/" + file));
    folder_.write("set/" + file, bytes);
    const Outcome outcome = verify("set");
    folder_.write("set/" + file, before);
    EXPECT_EQ(outcome.exit_code, 1) << file;
    return outcome.output;
  };
  const std::string gray = "test/000000/gray/000001.png";
  const std::string of_another = read_whole(path("set/test/000000/gray/000000.png"));
  EXPECT_THAT(output_with(gray, of_another), HasSubstr("image 1: " + gray + " is not the file"));
  const std::string black = png_bytes(cv::Mat::zeros(64, 64, CV_8U));
  EXPECT_THAT(output_with(gray, black), HasSubstr("image 1: " + gray + " is not the file"));
  const std::string normals = "sightline/000000/000001_normals.png";
  EXPECT_THAT(output_with(normals, png_bytes(cv::Mat::zeros(64, 64, CV_16UC3))),
              HasSubstr(normals + " is not the file"));
  EXPECT_EQ(verify("set").exit_code, 0) << verify("set").output;
}

}  // namespace
}  // namespace sightline
