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
  source.distortion = read_lens(table.table("camera"));
  return source;
}

}  // namespace

void read_dataset(const TomlTable& table, Study& study) {
  const SightingSource source = read_source(table);
  try {
    study.sightings =
        std::make_shared<const std::vector<Sighting>>(read_sightings(source, study.target));
  } catch (const InputError& error) {
    table.fail("dataset", fmt::format("cannot be used: {}", error.what()));
  }
  study.has_given_priors = !source.priors.empty();
  const auto count = static_cast<int>(study.sightings->size());
  if (!table.has("trials")) study.draws = count;
  if (study.draws > count) {
    table.fail("trials", fmt::format("is {}, but the data set shows the target {} times",
                                     study.draws, count));
  }
}

SceneLaw dataset_scene(const TomlTable& table, const Study& study) {
  SceneLaw law;
  law.target = study.target;
  law.features = study.features;
  law.camera = study.sightings->front().camera;
  law.sensor.bits = static_cast<int>(table.table("dataset").integer("bits", {1, kMostBits}, kMostBits));
  return law;
}

}  // namespace sightline
