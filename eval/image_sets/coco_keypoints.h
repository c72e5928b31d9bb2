// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The truth that networks which find objects and keypoints are trained on: COCO's annotations of a
// scene, as BOP's toolkit writes them, and with the target's features as keypoints
// (datasets/coco/write.h).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "eval/image_sets/set_plan.h"
#include "eval/output/json.h"

namespace sightline {

/// What annotations need of an image's masks of what is seen, an element a mask, in their order;
/// null where a file is missing or torn.
Json segmentations_in(const std::filesystem::path& folder, std::span<const std::string> masks);

/// What COCO is told of an image.
struct AnnotatedImage {
  int64_t id = 0;
  std::string file_name;
  int width_px = 0;
  int height_px = 0;
  std::vector<Json> bodies;  ///< as in the image's truth
  Json segmentations;        ///< of these bodies, in their order
  Json whole_boxes;          ///< of their whole masks, the same; null where nobody asks for them
};

/// The annotations of a chunk's images. A category is an object of the set, its id the obj_id, its
/// keypoints its features. A body is annotated where some of it is seen; of a mesh without features
/// that is its box and its mask, with no keypoints. A keypoint is labelled where it lies on the
/// image, and visible where nothing hides it.
std::string coco_keypoints_file(const SetPlan& plan, std::span<const AnnotatedImage> images);

/// The same as the calc_gt_coco of BOP's toolkit writes it for all poses, but for dates, of which
/// there are none: a category's name is its id, the box is that of the whole mask, whatever hides
/// it, area and segmentation are of what is seen, and of whom less than a tenth is seen is to be
/// ignored.
std::string coco_boxes_file(const SetPlan& plan, std::span<const AnnotatedImage> images);

}  // namespace sightline
