// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "eval/study/guests.h"
#include "eval/study/study.h"

namespace sightline {

/// What the command line may say over a study's file.
struct StudyOverrides {
  std::optional<int> trials;  ///< a condition
  std::optional<int64_t> seed;
  std::vector<std::string> set;  ///< "key=value"
  Guests guests{};               ///< of whoever embeds this program
};

/// Reads a study by name or file. Throws InputError for whatever is missing, misspelt, out of range
/// or cannot be imaged.
Study read_study(const std::string& name_or_path, const StudyOverrides& overrides = {});

/// A study from its text; `source` stands for the file in errors.
Study read_study_text(const std::string& toml, const std::filesystem::path& source,
                      const StudyOverrides& overrides = {});

/// What a scene file says, to be rendered only: as a study of images, but it needs no solvers, and
/// its target no features. A study's name or file is one too.
Study read_scene(const std::string& name_or_path, const StudyOverrides& overrides = {});
Study read_scene_text(const std::string& toml, const std::filesystem::path& source,
                      const StudyOverrides& overrides = {});

}  // namespace sightline
