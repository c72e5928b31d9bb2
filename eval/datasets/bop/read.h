// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "pose/pose.h"
#include "scenes/mesh/mesh.h"

namespace sightline {

/// An object of a BOP data set, in mm.
struct BopModel {
  Eigen::Matrix3Xd points_mm;  ///< the file's vertices, all of them, as they stand there
  Mesh mesh_mm;                ///< the same with its triangles
  double diameter_mm = 0;
  /// Poses of the model that look alike, the identity first: the products of its discrete
  /// symmetries and its continuous ones in equal steps.
  std::vector<Pose> symmetries;
};

/// The true pose of an object in an image, mm.
struct BopInstance {
  int obj_id = 0;
  Pose cam_from_model;
  double visible_fraction = 1;
};

struct BopImage {
  std::filesystem::path folder;  ///< of its scene
  int scene_id = 0;
  int im_id = 0;
  int width_px = 0;  ///< of read_bop_dataset alone
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  double depth_scale = 1;            ///< mm a step of the depth
  std::filesystem::path depth_file;  ///< empty where there is none
  std::vector<BopInstance> instances;
  std::map<int, int> targets;  ///< how many instances of an object are asked for
};

struct BopDataset {
  std::map<int, BopModel> models;  ///< by obj_id
  std::vector<BopImage> images;    ///< those with targets
};

/// The poses that a models_info entry's symmetries make of one (BopModel::symmetries). A continuous
/// symmetry takes ceil(pi / 0.01) steps, so that no vertex moves by more than 1 % of the diameter
/// in one (Hodan et al., BOP Challenge 2019). `info` is the entry's JSON.
std::vector<Pose> bop_symmetries(const std::string& info);

/// The images of a data set in BOP's scenewise format, whoever made it, by scene and image: of the
/// split's scenes scene_camera.json, scene_gt.json and, where there is one, scene_gt_info.json.
/// `split` is a folder; empty: "test", or the only one whose name begins so. The targets are those
/// of test_targets_bop19.json or, without that file, all instances of which a tenth is visible.
/// Throws InputError, with the file, for whatever is missing or not so.
std::vector<BopImage> read_bop_images(const std::filesystem::path& folder,
                                      const std::string& split);

/// The picture of that name in a folder, whatever its format; empty where there is none.
std::filesystem::path bop_picture(const std::filesystem::path& folder, const std::string& name);

/// The image's picture, of rgb/ or else of gray/; empty where there is none.
std::filesystem::path bop_picture(const BopImage& image);

/// The instances of an object that the image asks for, as indices: the most visible first, those
/// that tie in their order.
std::vector<int> asked_instances(const BopImage& image, int obj_id);

/// The box that an object fills in its own frame, and which file says so.
struct BopBox {
  Eigen::AlignedBox3d box_mm;
  std::filesystem::path file;
};

/// As models_info.json has it or, where it has not, the model's vertices, in models_eval/ or else
/// in models/; none where there is neither.
std::optional<BopBox> bop_model_box(const std::filesystem::path& folder, int obj_id);

/// The same images with all models, of models_eval/ (or models/), which must be there.
BopDataset read_bop_dataset(const std::filesystem::path& folder, const std::string& split);

}  // namespace sightline
