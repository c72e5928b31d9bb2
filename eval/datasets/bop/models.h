// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The models of a data set in BOP's format, in mm.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "eval/datasets/symmetries.h"
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

/// The poses that a models_info entry's symmetries make of one (BopModel::symmetries). A continuous
/// symmetry takes ceil(pi / 0.01) steps, so that no vertex moves by more than 1 % of the diameter
/// in one (Hodan et al., BOP Challenge 2019). `info` is the entry's JSON.
std::vector<Pose> bop_symmetries(const std::string& info);

/// The models_info.json of a set: that beside the models that are read or, where they have none, as
/// in the models_eval/ of many, that of models/. Empty where there is neither.
std::filesystem::path bop_models_info(const std::filesystem::path& set);

/// The models of these objects, and of no others, from models_eval/ or else models/ or the first
/// folder whose name begins so. Their diameters and symmetries are those of models_info.json;
/// where that states no diameter it is measured, and without that file there are no symmetries.
/// Throws InputError, with the file, for whatever is missing or not so.
std::map<int, BopModel> read_bop_models(const std::filesystem::path& set,
                                        const std::set<int>& obj_ids);

/// What a set says of an object where models are not needed, but compared and turned.
struct BopModelFacts {
  std::optional<Eigen::AlignedBox3d> box_mm;  ///< that it fills in its own frame; none: not known
  std::filesystem::path file;                 ///< that says so
  Symmetries symmetries;                      ///< mm
};

/// As models_info.json has it or, where it has no box, the model's vertices, in the same folder as
/// read_bop_models; nothing where there is neither.
BopModelFacts bop_model_facts(const std::filesystem::path& set, int obj_id);

}  // namespace sightline
