// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "eval/datasets/bop/results_csv.h"
#include "eval/datasets/symmetries.h"
#include "eval/records/names.h"
#include "pose/camera.h"
#include "pose/pose.h"
#include "scenes/target/target.h"

namespace sightline {

/// A target in an image of somebody's data set, with its true pose: in our conventions, whatever
/// the set's.
struct Sighting {
  std::filesystem::path picture;
  std::filesystem::path visible_mask;  ///< not 0 where it is seen; empty where the set has none
  std::string image;                   ///< the picture's path within the set
  // As BOP numbers them. In SPEED+ the scene and the instance are 0 and an image's id is its place
  // in the list.
  int scene_id = 0;
  int64_t im_id = 0;
  int gt_id = 0;  ///< place of the instance in its image's truth
  Camera camera;  ///< its size is that of the set's first picture
  Pose cam_from_target;
  /// Why the set tells too little of it for a trial: its picture is missing, or its true pose is
  /// none. None where it tells enough.
  std::optional<EstimateOutcome> problem{};
  std::optional<Pose> prior_cam_from_target;  ///< where priors are given
};

/// A data set's sightings of the target, and how the set names it.
struct SightedSet {
  std::vector<Sighting> sightings;
  int obj_id = 1;  ///< of the target, in BOP
  /// Turns the frame that the set's poses are of into the target's.
  Eigen::Matrix3d target_from_model = Eigen::Matrix3d::Identity();
  /// Of the target, in metres: the true pose is each of those that look alike.
  Symmetries symmetries{};
  std::vector<std::string> notes{};  ///< what of the set is told but does not count, a line each
};

/// Which sightings to read.
struct SightingSource {
  std::filesystem::path folder;  ///< of the set
  /// Of BOP: the folder of its scenes; empty: "test", or the only one whose name begins so. Of
  /// SPEED+: its list without ".json", such as "train" or "lightbox/test"; empty: the only one that
  /// is there.
  std::string split;
  /// Of BOP's scenes with several sensors: the one to read, by its name; empty: that which BOP
  /// evaluates.
  std::string sensor;
  std::optional<int> obj_id;  ///< of BOP; none: the only object that the images have
  /// The poses are of the axes of the mesh's file instead of the target's.
  bool is_of_file_axes = false;
  double box_tolerance = 0.01;   ///< of the target's size, between its box and the set's
  Lens lens;                     ///< of BOP's cameras, which has no place for it
  std::filesystem::path priors;  ///< a BOP results CSV; empty: none are given
};

/// The target's sightings in a data set in BOP's scenewise format or SPEED+'s, whoever wrote it, in
/// the order of scene, image and instance (of SPEED+: of the list). Of BOP they are what its
/// targets ask for: the instances of test_targets_bop19.json or, without that file, all of which a
/// tenth is visible; where an image has more, the most visible. A given prior goes to the instance
/// whose origin is nearest, best score first. Throws InputError, with the file, for whatever is
/// missing or not so: all pictures, an object, a model whose box is not the target's (or does not
/// hold its keypoints, where it has nothing else), poses of which none puts the target into its
/// image. One picture that is missing, and one true pose that is none, is a sighting with a
/// problem.
SightedSet read_sightings(const SightingSource& source,
                          const std::shared_ptr<const Target>& target);

/// Whether the set has such a picture, though it may show no sighting: looked for among the files
/// beside those of the scene's sightings.
bool has_picture(std::span<const Sighting> sightings, int scene_id, int64_t im_id);

/// The pose of an estimate, which is in the set's frame of the model, as one of the target. One
/// that is no estimate has no finite translation.
Pose pose_in_metres(const BopEstimate& estimate, const Eigen::Matrix3d& target_from_model);

/// An instance's or an estimate's place: its image, and its origin in the camera's frame, which is
/// not finite of an estimate that is none.
struct PlaceInImage {
  int scene_id = 0;
  int64_t im_id = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
};

/// The sighting that each estimate is of, by its index, or -1: every estimate, in the order that
/// `scores` put them in, the best first, takes of its image's sightings the one that is nearest and
/// not yet taken. An estimate without a position takes what those with one leave.
std::vector<int> sightings_of(std::span<const PlaceInImage> estimates,
                              std::span<const double> scores, std::span<const Sighting> sightings);

}  // namespace sightline
