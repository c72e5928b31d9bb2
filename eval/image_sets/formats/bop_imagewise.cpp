// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Image sets in BOP's imagewise format: all files of an image lie side by side in test/ and begin
// with the numbers of its scene, which is a chunk of the set, and its own. Archives of them, each
// of whole images, are BOP's webdataset format.

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "eval/datasets/bop/layout.h"
#include "eval/datasets/bop/mask_runs.h"
#include "eval/datasets/bop/write.h"
#include "eval/datasets/coco/write.h"
#include "eval/datasets/pictures.h"
#include "eval/image_sets/bop_truth.h"
#include "eval/image_sets/coco_keypoints.h"
#include "eval/image_sets/set_format.h"
#include "eval/image_sets/truth.h"
#include "scenes/files/input_file.h"
#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

std::string key_folder() {
  return std::string(bop::kTestSplit) + "/";
}

// "000001_000017", what the files of an image begin with.
std::string image_key(const SetPlan& plan, int64_t index) {
  return fmt::format("{}_{}", bop::scene_name(plan.chunk_of(index)),
                     bop::image_name(plan.number_in_chunk(index)));
}

// The files of an image, in the order in which they are told.
struct KeyPaths {
  std::string grey, depth, masks, visible_masks, camera, poses, visibilities;
  std::string grey_tiff;  // empty where the set has none
  std::string colour;     // empty where the image has none
};

KeyPaths key_paths(const SetPlan& plan, int64_t index, std::string_view colour_ending) {
  const std::string begin = key_folder() + image_key(plan, index);
  KeyPaths paths = {.grey = begin + ".gray.png",
                    .depth = begin + ".depth.png",
                    .masks = begin + ".mask.json",
                    .visible_masks = begin + ".mask_visib.json",
                    .camera = begin + ".camera.json",
                    .poses = begin + ".gt.json",
                    .visibilities = begin + ".gt_info.json",
                    .grey_tiff = "",
                    .colour = ""};
  if (plan.extras.has_grey_tiff) paths.grey_tiff = begin + ".gray.tiff";
  if (!colour_ending.empty()) paths.colour = fmt::format("{}.rgb{}", begin, colour_ending);
  return paths;
}

KeyPaths key_paths(const SetPlan& plan, const Json& truth) {
  return key_paths(plan, truth.at("index"), bop::colour_ending(plan, truth));
}

std::vector<std::string> imagewise_paths(const SetPlan& plan, const Json& truth) {
  const KeyPaths paths = key_paths(plan, truth);
  std::vector<std::string> all = {paths.grey,   paths.depth, paths.masks,       paths.visible_masks,
                                  paths.camera, paths.poses, paths.visibilities};
  if (!paths.grey_tiff.empty()) all.push_back(paths.grey_tiff);
  if (!paths.colour.empty()) all.push_back(paths.colour);
  return all;
}

std::string line_of(const Json& json) {
  return json.dump() + "\n";
}

// What the truth says of an image, in files of its own.
std::vector<SetFile> told_files(const SetPlan& plan, const KeyPaths& paths, const Json& truth) {
  return {{paths.camera, line_of(bop::image_camera(plan, truth))},
          {paths.poses, line_of(bop::image_poses(truth))},
          {paths.visibilities, line_of(bop::image_visibilities(truth))}};
}

std::vector<SetFile> imagewise_files(const SetPlan& plan, const SetImage& image) {
  const Frame& frame = image.frame;
  const KeyPaths paths = key_paths(plan, image.index, bop::colour_ending(plan, frame));
  Json whole = Json::object(), visible = Json::object();
  const std::vector<bop::InstanceMasks> masks = bop::masks_of(frame);
  for (size_t gt_id = 0; gt_id < masks.size(); ++gt_id) {
    whole[std::to_string(gt_id)] = coco::run_lengths(masks[gt_id].whole);
    visible[std::to_string(gt_id)] = coco::run_lengths(masks[gt_id].visible);
  }
  std::vector<SetFile> files = {
      {paths.grey, png_bytes(frame.image)},
      {paths.depth, png_bytes(bop::depth_steps(frame.depth_m, plan.depth_scale))},
      {paths.masks, line_of(whole)},
      {paths.visible_masks, line_of(visible)}};
  for (SetFile& file : told_files(plan, paths, truth_of(plan, image))) {
    files.push_back(std::move(file));
  }
  if (!paths.grey_tiff.empty()) files.push_back({paths.grey_tiff, tiff_bytes(frame.image)});
  if (!paths.colour.empty()) files.push_back({paths.colour, bop::colour_bytes(frame)});
  return files;
}

Json imagewise_told_by_files(const SetPlan& plan, const fs::path& folder, const Json& truth) {
  Json segmentations = Json::array();
  const MaskRuns masks(folder / key_paths(plan, truth).visible_masks);
  for (size_t i = 0; i < bop::annotated(truth).size(); ++i) {
    const cv::Mat mask = masks.mask(static_cast<int>(i));
    if (mask.empty()) return nullptr;
    segmentations.push_back(coco::run_lengths(mask));
  }
  return {{"segmentations", segmentations}};
}

std::vector<SetFile> imagewise_chunk_files(const SetPlan& plan, int64_t chunk,
                                           std::span<const Json> truths) {
  std::vector<AnnotatedImage> keypoints;
  for (const Json& truth : truths) {
    const KeyPaths paths = key_paths(plan, truth);
    const std::string& picture = paths.colour.empty() ? paths.grey : paths.colour;
    keypoints.push_back(bop::annotated_image(plan, truth, picture.substr(key_folder().size())));
  }
  return {{fmt::format("coco_keypoints/{}.json", bop::scene_name(chunk)),
           coco_keypoints_file(plan, keypoints)}};
}

std::vector<SetFile> imagewise_set_files(const SetPlan& plan) {
  return bop::set_files(plan, {.name = "imagewise",
                               .grey = ".gray.png",
                               .colour = ".rgb.png (or .jpg)",
                               .depth = ".depth.png",
                               .masks = ".mask.json",
                               .visible_masks = ".mask_visib.json"});
}

std::vector<std::string> imagewise_problems(const SetPlan& plan, const fs::path& folder,
                                            const Json& truth) {
  const KeyPaths paths = key_paths(plan, truth);
  const Json& camera = truth.at("camera");
  const cv::Size size(camera.at("width_px"), camera.at("height_px"));
  const int grey = truth.at("scene").at("sensor").at("bits") > 8 ? CV_16U : CV_8U;
  std::vector<std::string> problems;
  const auto checked = [&](const std::string& path, cv::Mat pixels, int type) {
    if (pixels.size() != size || pixels.type() != type) {
      problems.push_back(path + " is torn, or not of the camera's size");
    }
    return bop::ReadPicture{path, std::move(pixels)};
  };
  const auto picture = [&](const std::string& path, int type) {
    return checked(path, read_picture(folder / path), type);
  };
  picture(paths.grey, grey);
  if (!paths.grey_tiff.empty()) picture(paths.grey_tiff, grey);
  if (!paths.colour.empty()) picture(paths.colour, CV_MAKETYPE(grey, 3));
  bop::ReadImage image;
  image.depth = picture(paths.depth, CV_16U);
  const MaskRuns masks(folder / paths.masks), visible_masks(folder / paths.visible_masks);
  for (size_t i = 0; i < bop::annotated(truth).size(); ++i) {
    const auto gt_id = static_cast<int>(i);
    image.masks.push_back(checked(paths.masks, masks.mask(gt_id), CV_8U));
    image.visible_masks.push_back(checked(paths.visible_masks, visible_masks.mask(gt_id), CV_8U));
  }
  for (const SetFile& file : told_files(plan, paths, truth)) {
    if (bytes_of_file(folder / file.path, kMostInputBytes) != file.bytes) {
      problems.push_back(file.path + " is not what the truth says");
    }
  }
  if (!problems.empty()) return problems;
  return bop::instances_problems(plan, folder, truth, image);
}

}  // namespace

SetFormat bop_imagewise_format() {
  return {.name = "bop_imagewise",
          .summary = "the same, all files of an image side by side",
          .lens_note = "BOP has no lens distortion; it stands in dataset_info.md and sightline/",
          .extras = {.has_grey_tiff = true,
                     .has_rgb_of_grey = true,
                     .has_normals = true,
                     .has_coordinates = true},
          .grey_extras = {.has_grey_tiff = true},
          .image_files = imagewise_files,
          .image_paths = imagewise_paths,
          .image_problems = imagewise_problems,
          .told_by_files = imagewise_told_by_files,
          .chunk_files = imagewise_chunk_files,
          .list_path = bop::kTargetsFile,
          .list_elements = bop::image_targets,
          .set_files = imagewise_set_files};
}

}  // namespace sightline
