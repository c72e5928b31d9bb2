// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Sets in BOP's imagewise format say what the same sets say scenewise.
#include <fstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/eval/image_sets/image_set_for_tests.h"

namespace sightline {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// A cube behind another, in colour, two scenes.
const std::string kSameSet =
    "--count 3 --scene-size 2 --also tiff --set image.colour=rgb --set image.bits=12 "
    "--set 'other=[{target=\"cube\", role=\"target\", offset_px=[-9, 9], range_fraction=[1.2, "
    "1.3]}]' ";

class ImagewiseSet : public ImageSet {
 protected:
  void SetUp() override {
    ASSERT_EQ(render("scenes", kSameSet).exit_code, 0) << render("scenes", kSameSet).output;
    ASSERT_EQ(render("images", kSameSet + "--format bop_imagewise").exit_code, 0);
  }
};

TEST_F(ImagewiseSet, HasEachImagesFilesSideBySide) {
  size_t instances = 0;
  for (const auto& [scene, image] : {std::pair{0, 0}, {0, 1}, {1, 0}}) {
    const std::string key = fmt::format("images/test/{:06}_{:06}", scene, image);
    const std::string folder = fmt::format("scenes/test/{:06}/", scene);
    const std::string number = std::to_string(image), name = fmt::format("{:06}", image);
    EXPECT_EQ(read(key + ".camera.json"), read(folder + "scene_camera.json")[number]);
    EXPECT_EQ(read(key + ".gt.json"), read(folder + "scene_gt.json")[number]);
    EXPECT_EQ(read(key + ".gt_info.json"), read(folder + "scene_gt_info.json")[number]);
    for (const auto& [ending, in_folder] : {std::pair{".gray.png", "gray/{}.png"},
                                            {".gray.tiff", "gray/{}.tiff"},
                                            {".rgb.png", "rgb/{}.png"},
                                            {".depth.png", "depth/{}.png"}}) {
      EXPECT_EQ(read_whole(path(key + ending)),
                read_whole(path(folder + fmt::format(fmt::runtime(in_folder), name))));
    }
    for (const auto& [ending, masks] :
         {std::pair{".mask.json", "mask"}, {".mask_visib.json", "mask_visib"}}) {
      const json runs = read(key + ending);
      ASSERT_EQ(runs.size(), read(key + ".gt.json").size());
      for (const auto& [gt_id, run] : runs.items()) {
        const cv::Mat png =
            picture(fmt::format("{}{}/{}_{:06}.png", folder, masks, name, std::stoi(gt_id)));
        EXPECT_EQ(cv::norm(decoded(run), png, cv::NORM_INF), 0) << key << ending;
        ++instances;
      }
    }
  }
  EXPECT_EQ(instances, 12u);
  EXPECT_EQ(read("images/test_targets_bop19.json"), read("scenes/test_targets_bop19.json"));
  EXPECT_EQ(tree("images").at("models/obj_000001.ply"), tree("scenes").at("models/obj_000001.ply"));
}

TEST_F(ImagewiseSet, HasTheSameKeypointsForCoco) {
  const json images = read("images/coco_keypoints/000001.json");
  const json scenes = read("scenes/test/000001/scene_gt_coco_keypoints.json");
  EXPECT_EQ(images["annotations"], scenes["annotations"]);
  EXPECT_EQ(images["images"][0]["file_name"], "000001_000000.rgb.png");
}

TEST_F(ImagewiseSet, IsReadWithTheSamePosesAndPictures) {
  for (const std::string set : {"scenes", "images"}) {
    const Outcome judged = run(
        fmt::format("evaluate {0} --target cube --solvers lspe --quiet --out {0}-run", path(set)));
    ASSERT_EQ(judged.exit_code, 0) << judged.output;
  }
  EXPECT_EQ(read("images-run/summary.json")["cells"], read("scenes-run/summary.json")["cells"]);
}

TEST_F(ImagewiseSet, IsVerifiedLikeAnyOther) {
  EXPECT_EQ(verify("images").exit_code, 0) << verify("images").output;
  const std::string poses = path("images/test/000001_000000.gt.json");
  const std::string before = read_whole(poses);
  std::ofstream(poses) << "[]\n";
  EXPECT_THAT(verify("images").output, HasSubstr("gt.json is not what the truth says"));
  std::ofstream(poses) << before;
  EXPECT_EQ(verify("images").exit_code, 0);
  std::ofstream(path("images/test/000000_000001.mask_visib.json")) << R"({"0": {"size": [1)";
  const Outcome torn = verify("images");
  EXPECT_EQ(torn.exit_code, 1);
  EXPECT_THAT(torn.output, HasSubstr("000000_000001.mask_visib.json"));
}

}  // namespace
}  // namespace sightline
