// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Image sets in BOP's scenewise format (datasets/bop/layout.h): a scene is a chunk of the set.
#include <algorithm>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "eval/datasets/bop/layout.h"
#include "eval/datasets/bop/write.h"
#include "eval/datasets/pictures.h"
#include "eval/image_sets/bop_truth.h"
#include "eval/image_sets/coco_keypoints.h"
#include "eval/image_sets/set_format.h"
#include "eval/image_sets/truth.h"
#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

std::string scene_folder(int64_t chunk) {
  return fmt::format("{}/{}/", bop::kTestSplit, bop::scene_name(chunk));
}

// Where the files of an image lie.
struct ImagePaths {
  std::string grey;
  std::string depth;
  // Empty where the set has none.
  std::string grey_tif, depth_tif, grey_tiff;
  std::string colour;                      // empty where the image has none
  std::vector<std::string> masks;          // an instance each
  std::vector<std::string> visible_masks;  // an instance each: its pixels that are seen
};

ImagePaths paths_of(const SetPlan& plan, int64_t index, int64_t instances,
                    std::string_view colour_ending) {
  const std::string scene = scene_folder(plan.chunk_of(index));
  const int64_t im_id = plan.number_in_chunk(index);
  const auto path = [&scene](std::string_view folder, const std::string& name) {
    return fmt::format("{}{}/{}.png", scene, folder, name);
  };
  ImagePaths paths;
  paths.grey = path(bop::kGreyFolder, bop::image_name(im_id));
  paths.depth = path(bop::kDepthFolder, bop::image_name(im_id));
  if (plan.extras.has_itodd_tif) {
    paths.grey_tif = fs::path(paths.grey).replace_extension(".tif").string();
    paths.depth_tif = fs::path(paths.depth).replace_extension(".tif").string();
  }
  if (plan.extras.has_grey_tiff) {
    paths.grey_tiff = fs::path(paths.grey).replace_extension(".tiff").string();
  }
  if (!colour_ending.empty()) {
    paths.colour =
        fmt::format("{}{}/{}{}", scene, bop::kColourFolder, bop::image_name(im_id), colour_ending);
  }
  for (int64_t gt_id = 0; gt_id < instances; ++gt_id) {
    const std::string name = bop::mask_name(im_id, gt_id);
    paths.masks.push_back(path(bop::kMaskFolder, name));
    paths.visible_masks.push_back(path(bop::kVisibleMaskFolder, name));
  }
  return paths;
}

ImagePaths paths_of(const SetPlan& plan, const Json& truth) {
  return paths_of(plan, truth.at("index"), static_cast<int64_t>(bop::annotated(truth).size()),
                  bop::colour_ending(plan, truth));
}

// In the order in which they are told.
std::vector<std::string> bop_image_paths(const SetPlan& plan, const Json& truth) {
  const ImagePaths paths = paths_of(plan, truth);
  std::vector<std::string> all = {paths.grey, paths.depth};
  for (size_t gt_id = 0; gt_id < paths.masks.size(); ++gt_id) {
    all.push_back(paths.masks[gt_id]);
    all.push_back(paths.visible_masks[gt_id]);
  }
  for (const std::string& path : {paths.grey_tif, paths.depth_tif, paths.grey_tiff, paths.colour}) {
    if (!path.empty()) all.push_back(path);
  }
  return all;
}

std::vector<SetFile> bop_image_files(const SetPlan& plan, const SetImage& image) {
  const Frame& frame = image.frame;
  const std::vector<bop::InstanceMasks> masks = bop::masks_of(frame);
  const ImagePaths paths = paths_of(plan, image.index, static_cast<int64_t>(masks.size()),
                                    bop::colour_ending(plan, frame));
  const cv::Mat depth = bop::depth_steps(frame.depth_m, plan.depth_scale);
  std::vector<SetFile> files = {{paths.grey, png_bytes(frame.image)},
                                {paths.depth, png_bytes(depth)}};
  for (size_t gt_id = 0; gt_id < masks.size(); ++gt_id) {
    const auto& [whole, seen] = masks[gt_id];
    const std::string whole_png = png_bytes(whole);
    const bool is_all_seen =
        std::equal(whole.datastart, whole.dataend, seen.datastart, seen.dataend);
    files.push_back({paths.masks[gt_id], whole_png});
    files.push_back({paths.visible_masks[gt_id], is_all_seen ? whole_png : png_bytes(seen)});
  }
  if (!paths.grey_tif.empty()) {
    files.push_back({paths.grey_tif, tiff_bytes(frame.image)});
    files.push_back({paths.depth_tif, tiff_bytes(depth, TiffPacking::kDeflate)});
  }
  if (!paths.grey_tiff.empty()) files.push_back({paths.grey_tiff, tiff_bytes(frame.image)});
  if (!paths.colour.empty()) files.push_back({paths.colour, bop::colour_bytes(frame)});
  return files;
}

// The boxes of whole masks, which end where the image ends; null where a file is missing or torn.
Json whole_boxes_in(const fs::path& folder, const std::vector<std::string>& masks,
                    const Json& truth) {
  const Json& camera = truth.at("camera");
  const cv::Rect image(0, 0, camera.at("width_px"), camera.at("height_px"));
  const std::vector<Json> bodies = bop::annotated(truth);
  Json boxes = Json::array();
  for (size_t i = 0; i < bodies.size(); ++i) {
    const Json& stated = bodies[i].at("amodal_box");
    cv::Rect box(stated.at(0), stated.at(1), stated.at(2), stated.at(3));
    if ((box & image) != box) {  // what the border leaves of it is in the mask alone
      const cv::Mat mask = read_picture(folder / masks[i]);
      if (mask.size() != image.size() || mask.type() != CV_8U) return nullptr;
      box = cv::boundingRect(mask);
    }
    boxes.push_back({box.x, box.y, box.width, box.height});
  }
  return boxes;
}

Json bop_told_by_files(const SetPlan& plan, const fs::path& folder, const Json& truth) {
  const ImagePaths paths = paths_of(plan, truth);
  Json segmentations = segmentations_in(folder, paths.visible_masks);
  Json boxes = whole_boxes_in(folder, paths.masks, truth);
  if (segmentations.is_null() || boxes.is_null()) return nullptr;
  return {{"segmentations", std::move(segmentations)}, {"whole_boxes", std::move(boxes)}};
}

// The picture that extractors and networks see, relative to its scene.
std::string picture_in_scene(const SetPlan& plan, const std::string& scene, const Json& truth) {
  const ImagePaths paths = paths_of(plan, truth);
  return (paths.colour.empty() ? paths.grey : paths.colour).substr(scene.size());
}

std::vector<SetFile> bop_chunk_files(const SetPlan& plan, int64_t chunk,
                                     std::span<const Json> truths) {
  const std::string scene = scene_folder(chunk);
  std::vector<bop::ImageEntry> cameras, poses, visibilities;
  std::vector<AnnotatedImage> annotated;
  for (const Json& truth : truths) {
    const int64_t im_id = plan.number_in_chunk(truth.at("index"));
    cameras.push_back({im_id, bop::image_camera(plan, truth)});
    poses.push_back({im_id, bop::image_poses(truth)});
    visibilities.push_back({im_id, bop::image_visibilities(truth)});
    annotated.push_back(bop::annotated_image(plan, truth, picture_in_scene(plan, scene, truth)));
  }
  const auto path = [&](std::string_view file) { return scene + std::string(file); };
  return {{path(bop::kSceneCameraFile), bop::scene_file(cameras)},
          {path(bop::kSceneTruthFile), bop::scene_file(poses)},
          {path(bop::kSceneInfoFile), bop::scene_file(visibilities)},
          {path(bop::kSceneBoxesFile), coco_boxes_file(plan, annotated)},
          {path(bop::kSceneKeypointsFile), coco_keypoints_file(plan, annotated)}};
}

std::vector<std::string> bop_image_problems(const SetPlan& plan, const fs::path& folder,
                                            const Json& truth) {
  const ImagePaths paths = paths_of(plan, truth);
  const Json& camera = truth.at("camera");
  const cv::Size size(camera.at("width_px"), camera.at("height_px"));
  const int grey = truth.at("scene").at("sensor").at("bits") > 8 ? CV_16U : CV_8U;
  std::vector<std::string> problems;
  const auto picture = [&](const std::string& path, int type) {
    cv::Mat pixels = read_picture(folder / path);
    if (pixels.size() != size || pixels.type() != type) {
      problems.push_back(path + " is torn, or not of the camera's size");
    }
    return bop::ReadPicture{path, std::move(pixels)};
  };
  picture(paths.grey, grey);
  if (!paths.grey_tif.empty()) picture(paths.grey_tif, grey);
  if (!paths.depth_tif.empty()) picture(paths.depth_tif, CV_16U);
  if (!paths.grey_tiff.empty()) picture(paths.grey_tiff, grey);
  if (!paths.colour.empty()) picture(paths.colour, CV_MAKETYPE(grey, 3));
  bop::ReadImage image;
  image.depth = picture(paths.depth, CV_16U);
  for (size_t gt_id = 0; gt_id < paths.masks.size(); ++gt_id) {
    image.masks.push_back(picture(paths.masks[gt_id], CV_8U));
    image.visible_masks.push_back(picture(paths.visible_masks[gt_id], CV_8U));
  }
  if (!problems.empty()) return problems;
  return bop::instances_problems(plan, folder, truth, image);
}

std::vector<SetFile> bop_set_files(const SetPlan& plan) {
  return bop::set_files(plan, {.name = "scenewise",
                               .grey = "gray/",
                               .colour = "rgb/",
                               .depth = "depth/",
                               .masks = "mask/",
                               .visible_masks = "mask_visib/"});
}

}  // namespace

SetFormat bop_format() {
  return {.name = "bop",
          .summary = "Benchmark for 6D Object Pose Estimation, scenewise",
          .lens_note = "BOP has no lens distortion; it stands in dataset_info.md and sightline/",
          .extras = {.has_itodd_tif = true,
                     .has_grey_tiff = true,
                     .has_rgb_of_grey = true,
                     .has_normals = true,
                     .has_coordinates = true},
          .grey_extras = {.has_itodd_tif = true},
          .image_files = bop_image_files,
          .image_paths = bop_image_paths,
          .image_problems = bop_image_problems,
          .told_by_files = bop_told_by_files,
          .chunk_files = bop_chunk_files,
          .list_path = bop::kTargetsFile,
          .list_elements = bop::image_targets,
          .set_files = bop_set_files};
}

}  // namespace sightline
