// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// How the tables of a study's file are read: what kinds of study share (pose_keys.cpp), and one
// reader for each kind (image_keys.cpp, numeric_keys.cpp, orientation_keys.cpp; dataset_keys.cpp
// for images of a data set). For eval/study/study_file.cpp alone.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "eval/study/guests.h"
#include "eval/study/study.h"
#include "scenes/files/toml_table.h"

namespace sightline {

/// What a file is read for: the trials of a study, or the rendering of its scenes alone, which
/// needs neither solvers nor features.
enum class Use { kTrials, kRendering };

/// Refuses, by an InputError, a name that is to be a file's or an option's and is not plain:
/// letters, digits, '-', '_' and '.', and not '.' first.
void require_plain_name(const TomlTable& table, const std::string& name);

/// The place of `name` in a list of names; an InputError with a suggestion where it has none.
size_t index_of(const std::string& name, const std::vector<std::string>& names,
                const TomlTable& table, const char* key);

template <typename Catalogue>
std::vector<std::string> names_of(const Catalogue& catalogue) {
  std::vector<std::string> names;
  for (const auto& entry : catalogue) names.emplace_back(entry.name);
  return names;
}

/// The solvers, the guests among them, and the table [solver]. A guest that `solvers` does not name
/// comes after those that it names.
Solving read_solving(const TomlTable& study, const std::string& default_start,
                     std::vector<TrialSolver> guests);

std::shared_ptr<const Target> read_target(const TomlTable& study);

/// The features named by the study, as indices into the target's; none where a target without
/// features is to be rendered.
std::vector<int> read_features(const TomlTable& study, Use use, const Target& target);

/// The images of the table [dataset], and as many draws as there are of them unless the file says
/// how many.
SightedImages read_dataset(const TomlTable& study, const std::shared_ptr<const Target>& target,
                           int& draws);
/// What is known of the scenes of a data set's images.
SceneLaw dataset_scene(const TomlTable& study, const ImageStudy& images);

// The kinds. Each reader appends the conditions of its cells to `common`; of images of a data set
// it also says how many draws there are.
ImageStudy read_image_study(const TomlTable& study, Use use, Study& common, const Guests& guests);
NumericStudy read_numeric_study(const TomlTable& study, Study& common, const Guests& guests);
OrientationStudy read_orientation_study(const TomlTable& study, Study& common);

}  // namespace sightline
