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
  source.lens = read_lens(table.table("camera"));
  return source;
}

}  // namespace

SightedImages read_dataset(const TomlTable& table, const std::shared_ptr<const Target>& target,
                           int& draws) {
  const SightingSource source = read_source(table);
  SightedImages images;
  try {
    images.set = std::make_shared<const SightedSet>(read_sightings(source, target));
  } catch (const InputError& error) {
    table.fail("dataset", fmt::format("cannot be used: {}", error.what()));
  }
  images.has_given_priors = !source.priors.empty();
  const auto count = static_cast<int>(images.set->sightings.size());
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
  law.camera = images.sighted->set->sightings.front().camera;
  SightingSource source;
  law.sensor.bits = kMostBits;
  read_keys(table, dataset_keys(source, law.sensor.bits));
  return law;
}

}  // namespace sightline
