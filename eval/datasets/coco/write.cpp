// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/coco/write.h"

#include <fmt/format.h>
#include <opencv2/core.hpp>

namespace sightline::coco {
namespace {

// "name": [...], an entry a line.
std::string lines_of(const char* name, std::span<const Json> entries) {
  std::string text = fmt::format("\"{}\": [", name);
  bool is_first = true;
  for (const Json& entry : entries) {
    text += fmt::format("{}\n  {}", is_first ? "" : ",", entry.dump());
    is_first = false;
  }
  return text + "\n]";
}

}  // namespace

Json run_lengths(const cv::Mat& mask) {
  const cv::Mat columns = mask.t();  // the order of COCO, and in one piece
  const uchar* const pixels = columns.ptr();
  const size_t end = columns.total();
  Json counts = Json::array();
  bool is_background = true;
  size_t begin = 0;
  for (size_t i = 0; i < end; ++i) {
    if ((pixels[i] == 0) == is_background) continue;
    counts.push_back(i - begin);
    begin = i;
    is_background = !is_background;
  }
  counts.push_back(end - begin);
  return {{"size", {mask.rows, mask.cols}}, {"counts", counts}};
}

Json category_entry(const Category& category) {
  return {{"id", category.id},
          {"name", category.name},
          {"keypoints", category.keypoints},
          {"skeleton", Json::array()}};
}

Json image_entry(int64_t id, const std::string& file_name, const cv::Size& size) {
  return {{"id", id}, {"file_name", file_name}, {"width", size.width}, {"height", size.height}};
}

Json annotation_entry(int64_t id, const Annotation& annotation) {
  Json keypoints = Json::array();
  int labelled = 0;
  for (const Keypoint& keypoint : annotation.keypoints) {
    const bool is_labelled = keypoint.labelled != Labelled::kNot;
    labelled += is_labelled ? 1 : 0;
    keypoints.push_back(is_labelled ? keypoint.pixel.x() : 0.0);
    keypoints.push_back(is_labelled ? keypoint.pixel.y() : 0.0);
    keypoints.push_back(static_cast<int>(keypoint.labelled));
  }
  const cv::Rect& box = annotation.box;
  return {{"id", id},
          {"image_id", annotation.image_id},
          {"category_id", annotation.category_id},
          {"iscrowd", 0},
          {"bbox", {box.x, box.y, box.width, box.height}},
          {"area", annotation.area},
          {"num_keypoints", labelled},
          {"keypoints", keypoints},
          {"segmentation", annotation.segmentation}};
}

std::string annotation_file(const Json& info, std::span<const Json> categories,
                            std::span<const Json> images, std::span<const Json> annotations) {
  return fmt::format("{{\n\"info\": {},\n\"licenses\": [],\n{},\n{},\n{}\n}}\n", info.dump(2),
                     lines_of("categories", categories), lines_of("images", images),
                     lines_of("annotations", annotations));
}

}  // namespace sightline::coco
