// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Sightings in BOP's scenewise format (bop/layout.h).
#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/datasets/bop/layout.h"
#include "eval/datasets/bop/read.h"
#include "eval/datasets/conventions.h"
#include "eval/datasets/set_readers.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

int target_object(const SightingSource& source, const std::vector<BopImage>& images) {
  std::set<int> objects;
  for (const BopImage& image : images) {
    for (const auto& [obj_id, count] : image.targets) objects.insert(obj_id);
  }
  if (source.obj_id && objects.contains(*source.obj_id)) return *source.obj_id;
  if (!source.obj_id && objects.size() == 1) return *objects.begin();
  const std::string has =
      fmt::format("{}: has the objects {}", source.folder.string(), fmt::join(objects, ", "));
  throw InputError(source.obj_id
                       ? fmt::format("{}, not {}", has, *source.obj_id)
                       : fmt::format("{}; say --object which of them is the target", has));
}

fs::path picture_of(const BopImage& image) {
  fs::path file = bop_picture(image);
  if (!file.empty()) return file;
  throw InputError(fmt::format("{}: has no picture {} in rgb/ or gray/", image.folder.string(),
                               bop::image_name(image.im_id)));
}

Camera camera_of(const BopImage& image, const BrownConrady& distortion) {
  try {
    Camera camera = camera_from_matrix(image.k);
    camera.distortion = distortion;
    return camera;
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: image {}: cam_K {}",
                                 (image.folder / bop::kSceneCameraFile).string(), image.im_id,
                                 error.what()));
  }
}

Pose pose_of(const BopImage& image, int gt_id) {
  const Pose& mm = image.instances[gt_id].cam_from_model;
  try {
    return {nearest_rotation(mm.rotation), kMetresPerMillimetre * mm.translation};
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: image {}: cam_R_m2c {}",
                                 (image.folder / bop::kSceneTruthFile).string(), image.im_id,
                                 error.what()));
  }
}

SetReading read_bop_sightings(const SightingSource& source) {
  const std::vector<BopImage> images = read_bop_images(source.folder, source.split);
  SetReading reading;
  reading.obj_id = target_object(source, images);
  for (const BopImage& image : images) {
    std::vector<int> instances = asked_instances(image, reading.obj_id);
    std::sort(instances.begin(), instances.end());
    for (const int gt_id : instances) {
      Sighting& sighting = reading.sightings.emplace_back();
      sighting.picture = picture_of(image);
      sighting.visible_mask =
          bop_picture(image.folder / bop::kVisibleMaskFolder, bop::mask_name(image.im_id, gt_id));
      sighting.scene_id = image.scene_id;
      sighting.im_id = image.im_id;
      sighting.gt_id = gt_id;
      sighting.camera = camera_of(image, source.distortion);
      sighting.cam_from_target = pose_of(image, gt_id);
    }
  }
  if (const auto model = bop_model_box(source.folder, reading.obj_id)) {
    reading.model_file = model->file;
    reading.model_box_m.emplace(kMetresPerMillimetre * model->box_mm.min(),
                                kMetresPerMillimetre * model->box_mm.max());
  }
  return reading;
}

}  // namespace

SetReader bop_reader() {
  return {.name = "bop",
          .is_of = [](const SightingSource&) { return true; },
          .read = read_bop_sightings};
}

}  // namespace sightline
