// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Image sets with YOLO's labels of poses (https://docs.ultralytics.com/datasets/pose): one text
// file an image, one line an object: class, the box's middle and size, then x, y and visibility of
// each keypoint. Coordinates are parts of the image's width and height from its top-left corner,
// which lies half a pixel before the first pixel's centre.
#include <algorithm>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "eval/datasets/pictures.h"
#include "eval/image_sets/set_format.h"
#include "eval/image_sets/truth.h"
#include "scenes/files/input_file.h"
#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

constexpr double kCornerPx = 0.5;  // from the image's corner to the first pixel's centre

std::string yolo_picture_path(int64_t index) {
  return fmt::format("images/{}.png", six_digits(index));
}

std::string yolo_label_path(int64_t index) {
  return fmt::format("labels/{}.txt", six_digits(index));
}

// All objects have as many keypoints: those of one that has fewer are filled up with some that
// nobody sees.
size_t keypoints_of(const SetPlan& plan) {
  size_t most = 0;
  for (const auto& object : plan.objects) most = std::max(most, object->features.size());
  return most;
}

// An image's size, to make parts of its coordinates.
struct LabelScale {
  double width = 1, height = 1;

  std::string part(double x, double y) const {
    return fmt::format("{:.8f} {:.8f}", x / width, y / height);
  }
};

std::string keypoint_text(const Json& feature, const LabelScale& scale) {
  if (!feature.at("is_in_image").get<bool>()) return " 0 0 0";
  const Json& pixel = feature.at("pixel");
  return fmt::format(
      " {} {}",
      scale.part(pixel.at(0).get<double>() + kCornerPx, pixel.at(1).get<double>() + kCornerPx),
      feature.at("is_visible").get<bool>() ? 2 : 1);
}

std::string object_text(const SetPlan& plan, const Json& body, const LabelScale& scale) {
  const std::vector<double> box = numbers_in(body, "visible_box", 4);
  std::string text =
      fmt::format("{} {} {}", body.at("obj_id").get<int>() - 1,
                  scale.part(box[0] + box[2] / 2, box[1] + box[3] / 2), scale.part(box[2], box[3]));
  const Json& features = body.at("features");
  for (const Json& feature : features) text += keypoint_text(feature, scale);
  for (size_t i = features.size(); i < keypoints_of(plan); ++i) text += " 0 0 0";
  return text + "\n";
}

// Occluders are not told of, nor is what is not seen.
std::string label_text(const SetPlan& plan, const Json& truth) {
  if (!truth.contains("bodies")) return "";
  const LabelScale scale{truth.at("camera").at("width_px"), truth.at("camera").at("height_px")};
  std::string text;
  for (const Json& body : truth.at("bodies")) {
    const bool is_told = !body.at("is_occluder").get<bool>() && body.at("visible_pixels") > 0;
    if (is_told) text += object_text(plan, body, scale);
  }
  return text;
}

std::vector<std::string> yolo_image_paths(const SetPlan&, const Json& truth) {
  return {yolo_picture_path(truth.at("index")), yolo_label_path(truth.at("index"))};
}

std::vector<SetFile> yolo_image_files(const SetPlan& plan, const SetImage& image) {
  const Frame& frame = image.frame;
  return {{yolo_picture_path(image.index),
           png_bytes(frame.colour.empty() ? frame.image : frame.colour)},
          {yolo_label_path(image.index), label_text(plan, truth_of(plan, image))}};
}

std::vector<std::string> yolo_image_problems(const SetPlan& plan,
                                             const std::filesystem::path& folder,
                                             const Json& truth) {
  const std::vector<std::string> paths = yolo_image_paths(plan, truth);
  std::vector<std::string> problems;
  const cv::Mat picture = read_picture(folder / paths[0]);
  const Json& camera = truth.at("camera");
  if (picture.cols != camera.at("width_px") || picture.rows != camera.at("height_px")) {
    problems.push_back(paths[0] + " is torn, or not of the camera's size");
  }
  if (bytes_of_file(folder / paths[1], kMostInputBytes) != label_text(plan, truth)) {
    problems.push_back(paths[1] + " is not what the truth says");
  }
  return problems;
}

std::vector<SetFile> yolo_chunk_files(const SetPlan&, int64_t, std::span<const Json>) {
  return {};
}

std::vector<Json> yolo_list_elements(const SetPlan&, const Json& truth) {
  return {{{"file_name", yolo_picture_path(truth.at("index"))},
           {"label", yolo_label_path(truth.at("index"))}}};
}

std::string data_file(const SetPlan& plan) {
  std::string names;
  for (size_t i = 0; i < plan.objects.size(); ++i) {
    names += fmt::format("  {}: {}\n", i, Json(plan.objects[i]->name).dump());
  }
  return fmt::format(
      "# {} images rendered by Sightline {} from scene.toml with seed {}. Keypoints are the\n"
      "# targets' features in their order; visibility 0: not on the image, 1: hidden, 2: seen.\n"
      "path: .\ntrain: images\nval: images\nkpt_shape: [{}, 3]\nnames:\n{}",
      plan.count, SIGHTLINE_VERSION, plan.study.seed, keypoints_of(plan), names);
}

std::vector<SetFile> yolo_set_files(const SetPlan& plan) {
  return {{"data.yaml", data_file(plan)}};
}

}  // namespace

SetFormat yolo_format() {
  return {.name = "yolo",
          .summary = "YOLO's labels of boxes and keypoints",
          .lens_note = "YOLO has no cameras; lens and poses stand in sightline/",
          .image_files = yolo_image_files,
          .image_paths = yolo_image_paths,
          .image_problems = yolo_image_problems,
          .told_by_files = nullptr,
          .chunk_files = yolo_chunk_files,
          .list_path = "images.json",
          .list_elements = yolo_list_elements,
          .set_files = yolo_set_files};
}

}  // namespace sightline
