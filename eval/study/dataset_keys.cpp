// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The keys of [dataset]: an image study whose images, cameras and poses are somebody's.
#include <fmt/format.h>

#include "eval/study/key_tables.h"
#include "eval/study/study_keys.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

SightingSource read_source(const TomlTable& table) {
  SightingSource source;
  int bits = kMostBits;
  read_keys(table, dataset_keys(source, bits));
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
  SightingSource source;
  law.sensor.bits = kMostBits;
  read_keys(table, dataset_keys(source, law.sensor.bits));
  return law;
}

}  // namespace sightline
