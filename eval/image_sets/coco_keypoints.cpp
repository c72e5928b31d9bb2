// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/image_sets/coco_keypoints.h"

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "eval/datasets/bop/layout.h"
#include "eval/datasets/coco/write.h"
#include "eval/datasets/pictures.h"

namespace sightline {
namespace {

std::vector<Json> category_entries(const SetPlan& plan) {
  std::vector<Json> entries;
  for (const auto& object : plan.objects) {
    coco::Category category{.id = object_id(plan, *object), .name = object->name, .keypoints = {}};
    for (const TargetFeature& feature : object->features) {
      category.keypoints.push_back(feature.name);
    }
    entries.push_back(coco::category_entry(category));
  }
  return entries;
}

coco::Keypoint keypoint_of(const Json& feature) {
  coco::Keypoint keypoint;
  const Json& pixel = feature.at("pixel");
  keypoint.pixel = {pixel.at(0).get<double>(), pixel.at(1).get<double>()};
  if (!feature.at("is_in_image").get<bool>()) return keypoint;
  keypoint.labelled =
      feature.at("is_visible").get<bool>() ? coco::Labelled::kVisible : coco::Labelled::kHidden;
  return keypoint;
}

coco::Annotation annotation_of(const AnnotatedImage& image, size_t i) {
  const Json& body = image.bodies[i];
  const Json& box = body.at("visible_box");
  coco::Annotation annotation{.image_id = image.id,
                              .category_id = body.at("obj_id"),
                              .box = {box.at(0).get<int>(), box.at(1).get<int>(),
                                      box.at(2).get<int>(), box.at(3).get<int>()},
                              .area = body.at("visible_pixels"),
                              .segmentation = image.segmentations.at(i),
                              .keypoints = {}};
  for (const Json& feature : body.at("features")) {
    annotation.keypoints.push_back(keypoint_of(feature));
  }
  return annotation;
}

// Of bodies of which nothing is seen there is nothing to find, and COCO has no empty boxes.
bool is_annotated(const AnnotatedImage& image, size_t i) {
  return i < image.segmentations.size() && image.bodies[i].at("visible_pixels") > 0;
}

Json info_of(const SetPlan& plan) {
  return {{"description",
           fmt::format("Keypoints of {}: rendered by Sightline from scene.toml with seed {}",
                       plan.study.name, plan.study.seed)},
          {"version", SIGHTLINE_VERSION},
          {"keypoints",
           "Pixel centres are at integers: (0, 0) is the centre of the top-left pixel, as "
           "Detectron2 takes COCO's keypoints. v: 0 is not on the image (x = y = 0), 1 is hidden, "
           "2 is visible."},
          {"boxes",
           "bbox, area and segmentation (run lengths, uncompressed, column by column) are of the "
           "visible pixels; a box reaches from corner to corner of its pixels."}};
}

Json boxed_image_entry(const AnnotatedImage& image) {
  Json entry = coco::image_entry(image.id, image.file_name, {image.width_px, image.height_px});
  entry["license"] = 1;
  for (const char* unsaid : {"date_captured", "coco_url", "flickr_url"}) entry[unsaid] = "";
  return entry;
}

Json boxed_entry(int64_t id, const AnnotatedImage& image, size_t i) {
  const Json& body = image.bodies[i];
  return {{"id", id},
          {"image_id", image.id},
          {"category_id", body.at("obj_id")},
          {"iscrowd", 0},
          {"area", body.at("visible_pixels")},
          {"bbox", image.whole_boxes.at(i)},
          {"segmentation", image.segmentations.at(i)},
          {"width", image.width_px},
          {"height", image.height_px},
          {"ignore", body.at("visible_fraction") < bop::kLeastVisibleFraction}};
}

}  // namespace

Json segmentations_in(const std::filesystem::path& folder, std::span<const std::string> masks) {
  Json segmentations = Json::array();
  for (const std::string& path : masks) {
    const cv::Mat mask = read_picture(folder / path);
    if (mask.empty() || mask.type() != CV_8U) return nullptr;
    segmentations.push_back(coco::run_lengths(mask));
  }
  return segmentations;
}

std::string coco_keypoints_file(const SetPlan& plan, std::span<const AnnotatedImage> images) {
  std::vector<Json> image_entries;
  std::vector<Json> annotations;
  for (const AnnotatedImage& image : images) {
    image_entries.push_back(
        coco::image_entry(image.id, image.file_name, {image.width_px, image.height_px}));
    for (size_t i = 0; i < image.bodies.size(); ++i) {
      if (!is_annotated(image, i)) continue;
      const auto id = static_cast<int64_t>(annotations.size()) + 1;
      annotations.push_back(coco::annotation_entry(id, annotation_of(image, i)));
    }
  }
  return coco::annotation_file(info_of(plan), category_entries(plan), image_entries, annotations);
}

std::string coco_boxes_file(const SetPlan& plan, std::span<const AnnotatedImage> images) {
  std::vector<Json> categories, image_entries, annotations;
  for (const auto& object : plan.objects) {
    const int id = object_id(plan, *object);
    categories.push_back(
        {{"id", id}, {"name", std::to_string(id)}, {"supercategory", plan.study.name}});
  }
  for (const AnnotatedImage& image : images) {
    image_entries.push_back(boxed_image_entry(image));
    for (size_t i = 0; i < image.bodies.size(); ++i) {
      if (!is_annotated(image, i)) continue;
      const auto id = static_cast<int64_t>(annotations.size()) + 1;
      annotations.push_back(boxed_entry(id, image, i));
    }
  }
  const Json info = {{"description", plan.study.name + "_" + std::string(bop::kTestSplit)},
                     {"url", "https://github.com/thodan/bop_toolkit"},
                     {"version", SIGHTLINE_VERSION},
                     {"contributor", "Sightline"}};
  return coco::annotation_file(info, categories, image_entries, annotations);
}

}  // namespace sightline
