// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Sightings in BOP's scenewise format (bop/layout.h) and its imagewise one (bop/scenes.h).
#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/datasets/bop/image.h"
#include "eval/datasets/bop/models.h"
#include "eval/datasets/bop/numbered.h"
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

Sighting sighting_of(const SightingSource& source, const BopImage& image, int gt_id) {
  const BopInstance& instance = image.instances[gt_id];
  Sighting sighting;
  sighting.scene_id = image.scene_id;
  sighting.im_id = image.im_id;
  sighting.gt_id = gt_id;
  sighting.camera = bop_camera(image);
  if (is_pinhole(sighting.camera.lens)) sighting.camera.lens = source.lens;
  const Pose& mm = instance.cam_from_model;
  sighting.cam_from_target = {nearest_rotation(mm.rotation), kMetresPerMillimetre * mm.translation};
  sighting.visible_mask = bop_visible_mask(image, gt_id);
  sighting.picture = bop_picture(image);
  if (sighting.picture.empty()) {
    sighting.picture = missing_bop_picture(image);
    sighting.problem = EstimateOutcome::kPictureUnreadable;
  }
  if (!instance.has_pose) sighting.problem = EstimateOutcome::kNoTruth;
  return sighting;
}

SetReading read_bop_sightings(const SightingSource& source) {
  BopImages read = read_bop_images(source.folder, source.split, source.sensor);
  const std::vector<BopImage>& images = read.images;
  SetReading reading;
  reading.notes = std::move(read.notes);
  reading.obj_id = target_object(source, images);
  for (const BopImage& image : images) {
    std::vector<int> instances = asked_instances(image, reading.obj_id);
    std::sort(instances.begin(), instances.end());
    for (const int gt_id : instances) {
      reading.sightings.push_back(sighting_of(source, image, gt_id));
    }
  }
  BopModelFacts model = bop_model_facts(source.folder, reading.obj_id);
  reading.model_file = model.file;
  if (model.box_mm) {
    reading.model_box_m.emplace(kMetresPerMillimetre * model.box_mm->min(),
                                kMetresPerMillimetre * model.box_mm->max());
  }
  reading.symmetries = std::move(model.symmetries);
  return reading;
}

}  // namespace

SetReader bop_reader() {
  return {.name = "bop",
          .is_of = [](const SightingSource&) { return true; },
          .read = read_bop_sightings};
}

}  // namespace sightline
