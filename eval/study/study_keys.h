// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// How the keys of a study's file are read: what the kinds of study share (study.cpp), and the
// readers of those that draw no images (numeric_study.cpp) or take them from a data set
// (evaluate/dataset_keys.cpp). For read_study alone.
#pragma once

#include "eval/study/study.h"
#include "scenes/files/toml_table.h"

namespace sightline {

/// The place of `name` in a list of names; an InputError with a suggestion where it has none.
size_t index_of(const std::string& name, const std::vector<std::string>& names,
                const TomlTable& table, const char* key);

template <typename Catalogue>
std::vector<std::string> names_of(const Catalogue& catalogue) {
  std::vector<std::string> names;
  for (const auto& entry : catalogue) names.emplace_back(entry.name);
  return names;
}

/// The solvers, and the keys of [solver] that all kinds of study have.
void read_solvers(const TomlTable& table, const std::string& default_start, Study& study);

/// The target and its features.
void read_target_and_features(const TomlTable& table, Study& study);

/// Of a study with [dataset]: its images, and as many trials as there are of them unless the file
/// says how many. The target must have been read.
void read_dataset(const TomlTable& table, Study& study);
/// What is known of the scenes of its images.
SceneLaw dataset_scene(const TomlTable& table, const Study& study);

void read_numeric_study(const TomlTable& table, Study& study);
void read_orientation_study(const TomlTable& table, Study& study);

}  // namespace sightline
