// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "eval/datasets/bop/models.h"
#include "pose/lenses/lens.h"
#include "pose/pose.h"

namespace sightline {

/// The true pose of an object in an image, mm.
struct BopInstance {
  int obj_id = 0;
  Pose cam_from_model;  ///< its rotation as usable_rotation has it
  double visible_fraction = 1;
  bool has_pose = true;  ///< else the set's numbers are no pose: nothing can be held against it
};

struct BopImage {
  std::filesystem::path folder;  ///< of its scene
  int scene_id = 0;
  int im_id = 0;
  int width_px = 0;  ///< of the picture; of read_bop_dataset alone
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  Lens lens;                         ///< of a cam_model that has one; read_bop_dataset takes none
  double depth_scale = 1;            ///< mm a step of the depth
  std::filesystem::path depth_file;  ///< empty where there is none
  std::vector<BopInstance> instances;
  std::map<int, int> targets;  ///< how many instances of an object are asked for
};

struct BopDataset {
  std::map<int, BopModel> models;       ///< by obj_id, those of the targets
  std::vector<BopImage> images;         ///< those with targets
  std::vector<std::string> notes = {};  ///< as BopImages has them
};

/// The images of a data set, and what of it is told but does not count, a line each.
struct BopImages {
  std::vector<BopImage> images;  ///< those with targets
  std::vector<std::string> notes;
};

/// The images of a data set in BOP's scenewise format, whoever made it, by scene and image: of the
/// split's scenes scene_camera.json, scene_gt.json and, where there is one, scene_gt_info.json.
/// `split` is a folder; empty: "test", or the only one whose name begins so. The targets are those
/// of test_targets_bop19.json, else of test_targets_bop24.json or, without either, all instances of
/// which a tenth is visible. A list may name images alone, as that of detection does: then it asks
/// for all such instances in them. Throws InputError, with the file, for whatever is missing or not
/// so; a true pose that is none is an instance without a pose.
BopImages read_bop_images(const std::filesystem::path& folder, const std::string& split);

/// The image's picture, of rgb/ or else of gray/, as numbered_picture finds it; empty where there
/// is none.
std::filesystem::path bop_picture(const BopImage& image);

/// Where that should be.
std::filesystem::path missing_bop_picture(const BopImage& image);

/// The instances of an object that the image asks for, as indices: the most visible first, those
/// that tie in their order.
std::vector<int> asked_instances(const BopImage& image, int obj_id);

/// The same images with the models of all their targets.
BopDataset read_bop_dataset(const std::filesystem::path& folder, const std::string& split);

}  // namespace sightline
