// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The keys of [dataset]: an image study whose images, cameras and poses are somebody's.
#include <utility>

#include <fmt/format.h>

#include "eval/datasets/set_frame.h"
#include "eval/study/key_tables.h"
#include "eval/study/study_keys.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

// What [dataset] names, and the depth of its grey levels.
struct DatasetKeys {
  SightingSource source;
  int bits = kMostBits;
};

DatasetKeys read_keys_of(const TomlTable& table) {
  DatasetKeys keys;
  read_keys(table, dataset_keys(keys.source, keys.bits));
  keys.source.lens = read_lens(table.table("camera"));
  return keys;
}

}  // namespace

SightedImages read_dataset(const TomlTable& table, const std::shared_ptr<const Target>& target,
                           int& draws) {
  const auto [source, bits] = read_keys_of(table);
  SightedImages images;
  try {
    SightedSet set = read_sightings(source, target);
    const std::string note = note_on_bits(set.sightings, bits);
    if (!note.empty()) set.notes.push_back(note);
    images.set = std::make_shared<const SightedSet>(std::move(set));
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
  law.sensor.bits = read_keys_of(table).bits;
  return law;
}

}  // namespace sightline
