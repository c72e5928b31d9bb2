// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// COCO's annotations of an image set, read by COCO's documentation alone and held against the
// pictures and the truth beside them.
#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "eval/datasets/coco/write.h"
#include "scenes/picture/picture_file.h"
#include "tests/eval/image_sets/image_set_for_tests.h"
#include "tests/eval/program.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

const std::string kFile = "test/000000/scene_gt_coco_keypoints.json";

class CocoKeypoints : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  Outcome render(const std::string& out, const std::string& more) const {
    return run(
        "render cube --quiet --set camera.width_px=64 --set camera.height_px=64 --set "
        "camera.f_px=250 --set image.samples_per_pixel=1 --out " +
        path(out) + " " + more);
  }
  Outcome verify(const std::string& set) const {
    return run("render --quiet --verify " + path(set));
  }
  json read(const std::string& file) const {
    return json::parse(read_whole(folder_.path() / file));
  }
  cv::Mat picture(const std::string& file) const { return read_picture_file(path(file)).pixels; }
  // The body of an annotation in our own truth; of sets of one scene.
  json body_of(const std::string& set, const json& annotation) const {
    const json truth = read(
        fmt::format("{}/sightline/000000/{:06}.json", set, annotation.at("image_id").get<int>()));
    for (const json& body : truth.at("bodies")) {
      if (body.at("obj_id") == annotation.at("category_id")) return body;
    }
    return nullptr;
  }
  TemporaryFolder folder_;
};

int differing_pixels(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() ? cv::countNonZero(a != b) : -1;
}

json run_lengths_of(const cv::Mat& mask) {
  return json::parse(coco::run_lengths(mask).dump());
}

TEST(RunLengths, GoColumnByColumnFromTheBackground) {
  const cv::Mat mask = (cv::Mat_<uchar>(2, 3) << 0, 255, 0,  //
                        0, 255, 255);
  EXPECT_EQ(run_lengths_of(mask), json({{"size", {2, 3}}, {"counts", {2, 2, 1, 1}}}));
  EXPECT_EQ(differing_pixels(decoded(run_lengths_of(mask)), mask), 0);
  const cv::Mat transposed = mask.t();
  EXPECT_NE(run_lengths_of(transposed).at("counts"), run_lengths_of(mask).at("counts"));
  // The first pixel is the object's, then all are, then none.
  const cv::Mat first = (cv::Mat_<uchar>(2, 1) << 1, 0);
  EXPECT_EQ(run_lengths_of(first).at("counts"), json({0, 1, 1}));
  EXPECT_EQ(run_lengths_of(cv::Mat(2, 2, CV_8U, 255)).at("counts"), json({0, 4}));
  EXPECT_EQ(run_lengths_of(cv::Mat::zeros(2, 2, CV_8U)).at("counts"), json({4}));
}

TEST(CocoAnnotation, CountsWhatIsLabelled) {
  coco::Annotation annotation;
  annotation.keypoints = {{{1.25, 2}, coco::Labelled::kVisible},
                          {{3, 4}, coco::Labelled::kHidden},
                          {{-70, 900}, coco::Labelled::kNot}};
  const json entry = json::parse(coco::annotation_entry(1, annotation).dump());
  EXPECT_EQ(entry.at("keypoints"), json({1.25, 2.0, 2, 3.0, 4.0, 1, 0.0, 0.0, 0}));
  EXPECT_EQ(entry.at("num_keypoints"), 2);
}

TEST_F(CocoKeypoints, AnnotateEveryImageOfTheScene) {
  ASSERT_EQ(render("set", "--count 6 --scene-size 4").exit_code, 0);
  for (const auto& [scene, images] : {std::pair("test/000000/", 4), std::pair("test/000001/", 2)}) {
    const json coco = read(fmt::format("set/{}scene_gt_coco_keypoints.json", scene));
    ASSERT_EQ(coco.at("categories").size(), 1u);
    const json& category = coco.at("categories").at(0);
    EXPECT_EQ(category.at("id"), 1);
    EXPECT_EQ(category.at("name"), "cube");
    ASSERT_EQ(category.at("keypoints").size(), 8u);
    EXPECT_EQ(category.at("keypoints").at(3), "vertex_3");
    ASSERT_EQ(coco.at("images").size(), static_cast<size_t>(images));
    ASSERT_EQ(coco.at("annotations").size(), static_cast<size_t>(images));
    EXPECT_THAT(coco.at("info").at("keypoints").get<std::string>(),
                HasSubstr("Pixel centres are at integers"));
    for (int i = 0; i < images; ++i) {
      const json& image = coco.at("images").at(i);
      EXPECT_EQ(image.at("id"), i);
      const cv::Mat grey =
          picture(fmt::format("set/{}{}", scene, image.at("file_name").get<std::string>()));
      EXPECT_EQ(grey.size(), cv::Size(image.at("width"), image.at("height")));
      const json& annotation = coco.at("annotations").at(i);
      EXPECT_EQ(annotation.at("id"), i + 1);
      EXPECT_EQ(annotation.at("image_id"), i);
      EXPECT_EQ(annotation.at("category_id"), 1);
      EXPECT_EQ(annotation.at("iscrowd"), 0);
      const cv::Mat seen = picture(fmt::format("set/{}mask_visib/{:06}_000000.png", scene, i));
      const cv::Mat other =
          picture(fmt::format("set/{}mask_visib/{:06}_000000.png", scene, (i + 1) % images));
      EXPECT_EQ(differing_pixels(decoded(annotation.at("segmentation")), seen), 0);
      EXPECT_NE(differing_pixels(decoded(annotation.at("segmentation")), other), 0);
      EXPECT_EQ(annotation.at("area"), cv::countNonZero(seen));
      const cv::Rect box = cv::boundingRect(seen);
      EXPECT_EQ(annotation.at("bbox"), json({box.x, box.y, box.width, box.height}));
    }
  }
  EXPECT_EQ(verify("set").exit_code, 0) << verify("set").output;
}

// What BOP's toolkit writes (calc_gt_coco, all poses): boxes of whole masks, masks of what is seen.
TEST_F(CocoKeypoints, StandBesideTheBoxesOfBopsToolkit) {
  ASSERT_EQ(render("set",
                   "--count 8 --set 'poses.lateral_m=[-1.4,1.4]' --set 'poses.range_m=[8,12]' "
                   "--set poses.max_redraws=0 --set 'other=[{target=\"cube\", scale=0.8, "
                   "offset_px=[-5, 5]}]'")
                .exit_code,
            0);
  const json coco = read("set/test/000000/scene_gt_coco.json");
  const json keypoints = read("set/" + kFile);
  EXPECT_EQ(coco.at("categories"),
            json::parse(R"([{"id": 1, "name": "1", "supercategory": "cube"}])"));
  ASSERT_EQ(coco.at("images").size(), 8u);
  EXPECT_EQ(coco.at("images")[3].at("file_name"), keypoints.at("images")[3].at("file_name"));
  ASSERT_EQ(coco.at("annotations").size(), keypoints.at("annotations").size());
  int cut = 0, ignored = 0;
  for (const json& annotation : coco.at("annotations")) {
    const int im_id = annotation.at("image_id");
    const cv::Mat whole = picture(fmt::format("set/test/000000/mask/{:06}_000000.png", im_id));
    const cv::Mat seen = picture(fmt::format("set/test/000000/mask_visib/{:06}_000000.png", im_id));
    const cv::Rect box = cv::boundingRect(whole);
    EXPECT_EQ(annotation.at("bbox"), json({box.x, box.y, box.width, box.height}));
    EXPECT_EQ(annotation.at("area"), cv::countNonZero(seen));
    EXPECT_EQ(differing_pixels(decoded(annotation.at("segmentation")), seen), 0);
    const json body = body_of("set", annotation);
    EXPECT_EQ(annotation.at("ignore"), body.at("visible_fraction") < 0.1);
    EXPECT_EQ(annotation.at("width"), 64);
    cut += box != cv::Rect(body.at("amodal_box")[0], body.at("amodal_box")[1],
                           body.at("amodal_box")[2], body.at("amodal_box")[3]);
    ignored += annotation.at("ignore").get<bool>();
  }
  EXPECT_GT(cut, 0);
  EXPECT_LT(cut, 8);
  EXPECT_LT(ignored, 8);
  EXPECT_EQ(verify("set").exit_code, 0) << verify("set").output;
}

// The cube reaches over the image's border, so that there are keypoints of every kind.
TEST_F(CocoKeypoints, AreTheTruthsPixelsAndSayWhatIsSeen) {
  ASSERT_EQ(render("set",
                   "--count 20 --set 'poses.lateral_m=[-1.4,1.4]' --set 'poses.range_m=[8,12]' "
                   "--set poses.max_redraws=0")
                .exit_code,
            0);
  const json coco = read("set/" + kFile);
  ASSERT_EQ(coco.at("annotations").size(), 20u);
  std::array<int, 3> seen_of = {0, 0, 0};
  for (const json& annotation : coco.at("annotations")) {
    const json& keypoints = annotation.at("keypoints");
    const json features = body_of("set", annotation).at("features");
    ASSERT_EQ(keypoints.size(), 3 * features.size());
    int labelled = 0;
    for (size_t k = 0; k < features.size(); ++k) {
      const json& feature = features[k];
      const int v = keypoints.at(3 * k + 2);
      ++seen_of.at(static_cast<size_t>(v));
      labelled += v > 0 ? 1 : 0;
      EXPECT_EQ(v == 2, feature.at("is_visible").get<bool>());
      EXPECT_EQ(v > 0, feature.at("is_in_image").get<bool>());
      const json pixel = {keypoints.at(3 * k), keypoints.at(3 * k + 1)};
      EXPECT_EQ(pixel, v > 0 ? feature.at("pixel") : json({0.0, 0.0}));
    }
    EXPECT_EQ(annotation.at("num_keypoints"), labelled);
  }
  for (const int count : seen_of) EXPECT_GE(count, 10);
}

// How far the keypoints lie to the right of and below what the pictures show, on average over the
// images, with `shift_px` added to them. The cube is convex, so that its outermost keypoints bound
// its mask: of pixel centres at integers the first column is the first integer right of the
// leftmost keypoint, and the last the last integer left of the rightmost. What pixels cut off, and
// what sharp corners lose, is alike on both sides, and leaves the mean of the two differences.
double offset_from_masks_px(const json& coco, double shift_px) {
  double sum = 0;
  int count = 0;
  for (const json& annotation : coco.at("annotations")) {
    const json& keypoints = annotation.at("keypoints");
    for (const size_t axis : {0u, 1u}) {
      double least = 1e9;
      double greatest = -1e9;
      for (size_t k = axis; k < keypoints.size(); k += 3) {
        least = std::min(least, keypoints[k].get<double>() + shift_px);
        greatest = std::max(greatest, keypoints[k].get<double>() + shift_px);
      }
      const double first = annotation.at("bbox").at(axis);
      const double last = first + annotation.at("bbox").at(axis + 2).get<double>() - 1;
      sum += ((greatest - last) - (first - least)) / 2;
      ++count;
    }
  }
  return sum / count;
}

TEST_F(CocoKeypoints, HaveThePixelCentresOfThePictures) {
  ASSERT_EQ(render("set", "--count 60").exit_code, 0);
  const json coco = read("set/" + kFile);
  ASSERT_EQ(coco.at("annotations").size(), 60u);
  // Each side is cut by up to a pixel, uniformly, and by somewhat less at sharp corners: the mean
  // of both sides has a standard deviation of about 0.25 px, of 120 such means 0.023 px.
  constexpr double kFourSdPx = 0.1;
  EXPECT_NEAR(offset_from_masks_px(coco, 0), 0, kFourSdPx);
  EXPECT_GT(offset_from_masks_px(coco, 0.5), 0.5 - kFourSdPx);  // half a pixel would be seen
  EXPECT_LT(offset_from_masks_px(coco, -0.5), -0.5 + kFourSdPx);
}

TEST_F(CocoKeypoints, AreTheSameWhoeverWritesThem) {
  const std::string count = "--count 9 --scene-size 9 ";
  ASSERT_EQ(render("one", count + "--jobs 1").exit_code, 0);
  ASSERT_EQ(render("jobs", count + "--jobs 3").exit_code, 0);
  ASSERT_EQ(render("shards", count + "--shard 1/2").exit_code, 0);
  EXPECT_FALSE(fs::exists(path("shards/" + kFile)));
  ASSERT_EQ(render("shards", count + "--shard 0/2").exit_code, 0);
  const std::string text = read_whole(path("one/" + kFile));
  EXPECT_TRUE(text == read_whole(path("jobs/" + kFile)));
  EXPECT_TRUE(text == read_whole(path("shards/" + kFile)));
  ASSERT_EQ(render("other", count + "--seed 2").exit_code, 0);
  EXPECT_FALSE(text == read_whole(path("other/" + kFile)));
}

TEST_F(CocoKeypoints, AreVerifiedAndMadeAnew) {
  ASSERT_EQ(render("set", "--count 3").exit_code, 0);
  const std::string text = read_whole(path("set/" + kFile));
  std::string changed = text;
  changed.replace(changed.find("\"num_keypoints\":8"), 17, "\"num_keypoints\":7");
  folder_.write("set/" + kFile, changed);
  EXPECT_EQ(verify("set").exit_code, 1);
  EXPECT_THAT(verify("set").output, HasSubstr(kFile + ": is not what"));
  fs::remove(path("set/" + kFile));
  EXPECT_THAT(verify("set").output, HasSubstr(kFile + ": is missing"));
  ASSERT_EQ(render("set", "--count 3 --resume").exit_code, 0);
  EXPECT_TRUE(read_whole(path("set/" + kFile)) == text);
  EXPECT_EQ(verify("set").exit_code, 0) << verify("set").output;
}

TEST_F(CocoKeypoints, AMaskThatCannotBeReadIsOneLine) {
  ASSERT_EQ(render("set", "--count 3").exit_code, 0);
  folder_.write("set/test/000000/mask_visib/000001_000000.png", "torn");
  const Outcome outcome = render("set", "--count 3 --resume");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(lines_of(outcome.output), 1u) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("sightline/000000/000001.json"));
  // What it says to do repairs the set.
  fs::remove(path("set/sightline/000000/000001.json"));
  EXPECT_EQ(render("set", "--count 3 --resume").exit_code, 0);
  EXPECT_EQ(verify("set").exit_code, 0) << verify("set").output;
}

// A smaller cube, a mesh that has no features and an occluder beside the target.
TEST_F(CocoKeypoints, OfSeveralBodiesAreThoseOfTheOnesWithFeatures) {
  const std::string mesh = SIGHTLINE_SOURCE_DIR "/assets/targets/cube/mesh.glb";
  const std::string others = fmt::format(
      "--set 'other=[{{target=\"cube\", scale=0.5, role=\"target\", offset_px=[-25, 25]}}, "
      "{{target=\"{}\", scale=0.4, role=\"target\", offset_px=[-25, 25]}}, "
      "{{target=\"cube\", scale=0.2, offset_px=[-10, 10]}}]'",
      mesh);
  const Outcome outcome = render("set", "--count 12 " + others);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const json coco = read("set/" + kFile);
  ASSERT_EQ(coco.at("categories").size(), 3u);
  EXPECT_EQ(coco.at("categories").at(1).at("keypoints").size(), 8u);
  EXPECT_EQ(coco.at("categories").at(2).at("keypoints").size(), 0u);
  const json poses = read("set/test/000000/scene_gt.json");
  std::array<int, 4> annotated = {0, 0, 0, 0};
  for (const json& annotation : coco.at("annotations")) {
    const int category = annotation.at("category_id");
    ++annotated.at(static_cast<size_t>(category));
    EXPECT_EQ(annotation.at("id"), annotated[1] + annotated[2] + annotated[3]);
    const json features = body_of("set", annotation).at("features");
    EXPECT_EQ(annotation.at("keypoints").size(), 3 * features.size());
    EXPECT_EQ(annotation.at("num_keypoints") == 0, category == 3);
    const json& gts = poses.at(std::to_string(annotation.at("image_id").get<int>()));
    for (size_t gt_id = 0; gt_id < gts.size(); ++gt_id) {
      if (gts[gt_id].at("obj_id") != category) continue;
      const cv::Mat seen = picture(fmt::format("set/test/000000/mask_visib/{:06}_{:06}.png",
                                               annotation.at("image_id").get<int>(), gt_id));
      EXPECT_EQ(differing_pixels(decoded(annotation.at("segmentation")), seen), 0);
    }
  }
  EXPECT_EQ(annotated[1], 12);
  EXPECT_GE(annotated[2], 6);
  EXPECT_GE(annotated[3], 6);
  EXPECT_EQ(verify("set").exit_code, 0) << verify("set").output;
}

// An occluder right before the target hides it wholly now and then: there is nothing to find.
TEST_F(CocoKeypoints, LeaveOutWhatIsNotSeenAtAll) {
  const std::string before =
      "--set 'other=[{target=\"cube\", scale=2, offset_px=[0, 0], range_fraction=[0.8, 0.8]}]'";
  ASSERT_EQ(render("set", "--count 3 " + before).exit_code, 0);
  const json coco = read("set/" + kFile);
  EXPECT_EQ(coco.at("images").size(), 3u);
  EXPECT_EQ(coco.at("annotations").size(), 0u);
  EXPECT_EQ(verify("set").exit_code, 0) << verify("set").output;
}

TEST_F(CocoKeypoints, AreOfBopAlone) {
  ASSERT_EQ(render("set", "--count 2 --format speed").exit_code, 0);
  for (const auto& entry : fs::recursive_directory_iterator(path("set"))) {
    EXPECT_NE(entry.path().filename(), "scene_gt_coco_keypoints.json");
  }
  EXPECT_EQ(verify("set").exit_code, 0) << verify("set").output;
}

// Read by the documentation of Ultralytics: parts of the image from its top-left corner.
TEST_F(CocoKeypoints, OfYoloAreTheSameInPartsOfTheImage) {
  const std::string more =
      "--count 4 --set 'poses.lateral_m=[-1.4,1.4]' --set 'poses.range_m=[8,12]' "
      "--set poses.max_redraws=0";
  ASSERT_EQ(render("set", more).exit_code, 0);
  ASSERT_EQ(render("yolo", "--format yolo " + more).exit_code, 0);
  EXPECT_EQ(verify("yolo").exit_code, 0) << verify("yolo").output;
  EXPECT_THAT(read_whole(path("yolo/data.yaml")), HasSubstr("kpt_shape: [8, 3]"));
  const json coco = read("set/" + kFile);
  for (const json& annotation : coco.at("annotations")) {
    std::ifstream label(
        path(fmt::format("yolo/labels/{:06}.txt", annotation.at("image_id").get<int>())));
    const std::vector<double> numbers{std::istream_iterator<double>(label), {}};
    ASSERT_EQ(numbers.size(), 5u + 3 * 8);
    const json& box = annotation.at("bbox");
    EXPECT_EQ(numbers[0], 0);
    EXPECT_NEAR(64 * (numbers[1] - numbers[3] / 2), box[0].get<double>(), 1e-5);
    EXPECT_NEAR(64 * numbers[4], box[3].get<double>(), 1e-5);
    for (size_t k = 0; k < 8; ++k) {
      const json& keypoints = annotation.at("keypoints");
      const double v = keypoints[3 * k + 2];
      EXPECT_EQ(numbers[5 + 3 * k + 2], v);
      const double u = v > 0 ? keypoints[3 * k].get<double>() + 0.5 : 0;
      EXPECT_NEAR(64 * numbers[5 + 3 * k], u, 1e-5);
    }
  }
  std::ofstream(path("yolo/labels/000002.txt")) << "0 0.5 0.5 1 1";
  EXPECT_THAT(verify("yolo").output, HasSubstr("labels/000002.txt is not what the truth says"));
}

}  // namespace
}  // namespace sightline
