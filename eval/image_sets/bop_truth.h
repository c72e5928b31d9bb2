// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What image sets in BOP's formats have in common, however their files lie (formats/bop.cpp,
// formats/bop_imagewise.cpp): entries of JSON, masks, what is there once a set, and the checks.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "eval/datasets/set_file.h"
#include "eval/image_sets/coco_keypoints.h"
#include "eval/image_sets/set_plan.h"
#include "eval/output/json.h"

namespace sightline::bop {

/// What of an image's bodies BOP tells of, in the order of scene_gt.
std::vector<Json> annotated(const Json& truth);

/// The masks of an instance, CV_8U: the whole of it as if nothing hid it, and what of it is seen.
struct InstanceMasks {
  cv::Mat whole;
  cv::Mat visible;
};

/// Those of the bodies that BOP tells of, in the same order.
std::vector<InstanceMasks> masks_of(const Frame& frame);

/// ".png" or, of a sensor whose JPEG it is, ".jpg": how the file in rgb/ ends; empty where an image
/// has none.
std::string_view colour_ending(const SetPlan& plan, const Frame& frame);
std::string_view colour_ending(const SetPlan& plan, const Json& truth);
/// That file; of a picture in grey with three channels alike.
std::string colour_bytes(const Frame& frame);

// What an image with this truth says in BOP's files of cameras, poses and visibilities, and in the
// list of targets.
Json image_camera(const SetPlan& plan, const Json& truth);
Json image_poses(const Json& truth);
Json image_visibilities(const Json& truth);
std::vector<Json> image_targets(const SetPlan& plan, const Json& truth);

/// What COCO's annotations say of an image, whose picture lies at that path relative to theirs. The
/// truth must have what its files tell (kToldByFiles).
AnnotatedImage annotated_image(const SetPlan& plan, const Json& truth, std::string file_name);

/// What a layout calls itself, and where it has its pictures, in words for its description.
struct LayoutText {
  std::string_view name;
  std::string_view grey;
  std::string_view colour;
  std::string_view depth;
  std::string_view masks;
  std::string_view visible_masks;
};

/// The camera, the models, and the set's description.
std::vector<SetFile> set_files(const SetPlan& plan, const LayoutText& layout);

/// A picture that was read, and where it lies in the set.
struct ReadPicture {
  std::string path;
  cv::Mat pixels;
};

/// Of an image, all of the camera's size and of their right types.
struct ReadImage {
  ReadPicture depth;
  std::vector<ReadPicture> masks;          ///< an instance each
  std::vector<ReadPicture> visible_masks;  ///< an instance each
};

/// What is wrong with the instances' masks and with the depth of an image with this truth.
std::vector<std::string> instances_problems(const SetPlan& plan,
                                            const std::filesystem::path& folder, const Json& truth,
                                            const ReadImage& image);

}  // namespace sightline::bop
