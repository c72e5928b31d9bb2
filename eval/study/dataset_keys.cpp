// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The keys of [dataset]: an image study whose images, cameras and poses are somebody's.
#include <fmt/format.h>

#include "eval/study/study_keys.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

constexpr int kMostBits = 16;

SightingSource read_source(const TomlTable& table) {
  const TomlTable dataset = table.table("dataset");
  const std::vector<std::string> axes = {"target", "file"};
  SightingSource source;
  source.folder = dataset.text("path");
  source.split = dataset.text("split", "");
  if (dataset.has("object")) {
    source.obj_id = static_cast<int>(dataset.integer("object", {0, 1e9}));
  }
  source.is_of_file_axes = dataset.choice("axes", axes, axes[0]) == axes[1];
  source.box_tolerance = dataset.number("box_tolerance", {0, 1e6}, source.box_tolerance);
  source.priors = dataset.text("priors", "");
  const std::vector<double> k =
      table.table("camera").numbers("distortion", 5, std::vector<double>(5, 0.0));
  source.distortion = {.k1 = k[0], .k2 = k[1], .p1 = k[2], .p2 = k[3], .k3 = k[4]};
  return source;
}

}  // namespace

SightedImages read_dataset(const TomlTable& table, const std::shared_ptr<const Target>& target,
                           int& draws) {
  const SightingSource source = read_source(table);
  SightedImages images;
  try {
    images.sightings =
        std::make_shared<const std::vector<Sighting>>(read_sightings(source, target));
  } catch (const InputError& error) {
    table.fail("dataset", fmt::format("cannot be used: {}", error.what()));
  }
  images.has_given_priors = !source.priors.empty();
  const auto count = static_cast<int>(images.sightings->size());
  if (!table.has("trials")) draws = count;
  if (draws > count) {
    table.fail("trials",
               fmt::format("is {}, but the data set shows the target {} times", draws, count));
  }
  return images;
}

SceneLaw dataset_scene(const TomlTable& table, const ImageStudy& images) {
  SceneLaw law;
  law.target = images.target;
  law.features = images.features;
  law.camera = images.sighted->sightings->front().camera;
  law.bits = static_cast<int>(table.table("dataset").integer("bits", {1, kMostBits}, kMostBits));
  return law;
}

}  // namespace sightline
