// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// An image of a set in BOP's formats, and where its pictures are.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "eval/output/json.h"
#include "pose/camera.h"
#include "pose/lenses/lens.h"
#include "pose/pose.h"

namespace sightline {

/// The true pose of an object in an image, mm.
struct BopInstance {
  int obj_id = 0;
  Pose cam_from_model;  ///< its rotation as usable_rotation has it
  double visible_fraction = 1;
  bool has_pose = true;  ///< else the set's numbers are no pose: nothing can be held against it
  /// What of its entry is not as its format has it, which matters where it is asked for.
  std::string problem{};
};

struct BopImage {
  std::filesystem::path folder;  ///< of its scene; in the imagewise format of all images
  /// Of sets with several cameras, whose files and folders have its name behind theirs.
  std::string sensor{};
  std::string key{};  ///< in the imagewise format: what the image's files begin with; else empty
  int scene_id = 0;
  int64_t im_id = 0;
  int width_px = 0;   ///< of the picture; of read_bop_dataset alone
  int height_px = 0;  ///< likewise; 0: not known
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  Lens lens;                         ///< of a cam_model that has one; read_bop_dataset takes none
  double depth_scale = 1;            ///< mm a step of the depth
  bool states_depth_scale = false;   ///< else it is not the image's own
  std::filesystem::path depth_file;  ///< empty where there is none
  std::vector<BopInstance> instances;
  std::map<int, int> targets;  ///< how many instances of an object are asked for
};

// What JSON says of an image, the same in all of BOP's formats. All throw InputError for what is
// not so.

/// The camera's matrix or, as sets of 2024 have it, its model where that is a pinhole or a fisheye
/// of Kannala and Brandt: focal lengths, principal point and the lens's coefficients. Then the
/// depth's scale.
void add_bop_camera(const Json& camera, BopImage& image);

/// The true poses.
void add_bop_truth(const Json& entries, BopImage& image);

/// How much of each instance is visible. `truth_file` is what has the instances.
void add_bop_visibility(const Json& infos, const std::string& truth_file, BopImage& image);

/// The image's picture of a kind (bop::kDepthFolder), whatever its format; empty where there is
/// none.
std::filesystem::path bop_picture_of_kind(const BopImage& image, std::string_view kind);

/// The image's picture in colour, or else in grey.
std::filesystem::path bop_picture(const BopImage& image);

/// Where that should be.
std::filesystem::path missing_bop_picture(const BopImage& image);

/// Its camera, without a size and of the lens that the set states. Throws InputError, with the
/// file, for a matrix that is none of a camera.
Camera bop_camera(const BopImage& image);

/// What says its camera, for errors.
std::filesystem::path bop_camera_file(const BopImage& image);

/// What says its true poses, likewise.
std::filesystem::path bop_truth_file(const BopImage& image);

/// What holds the mask of the visible pixels of an instance: a picture or, in the imagewise format,
/// a .json of the masks of all (mask_runs.h). Empty where there is none.
std::filesystem::path bop_visible_mask(const BopImage& image, int gt_id);

}  // namespace sightline
