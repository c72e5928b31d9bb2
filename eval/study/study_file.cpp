// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/study/study_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "eval/study/study_keys.h"
#include "scenes/files/assets.h"
#include "scenes/files/toml_text.h"

namespace sightline {
namespace {

constexpr double kMaxTrials = 10'000'000;

// The file as run. The word for all features is written out as their names: a run says what it
// looked for, whatever its target is given later.
std::string text_as_run(const TomlTable& table, const Study& study) {
  const PoseStudy* const of_target = study.pose_study();
  if (of_target == nullptr || !table.is_text("features")) return table.to_toml();
  const std::vector<std::string> names = names_of(of_target->target->features);
  const std::vector<std::string> settings = {"features=" + nlohmann::json(names).dump()};
  return TomlTable::read_text(table.to_toml(), table.file(), settings).to_toml();
}

std::vector<std::string> settings_of(const StudyOverrides& overrides) {
  std::vector<std::string> settings = overrides.set;
  if (overrides.trials) settings.push_back(fmt::format("trials={}", *overrides.trials));
  if (overrides.seed) settings.push_back(fmt::format("seed={}", *overrides.seed));
  return settings;
}

Study read_table(const TomlTable& table, const std::string& fallback_name, Use use,
                 const Guests& given) {
  Study study;
  const Guests guests = with_functions(table, given);
  const std::vector<std::string> kinds = {"images", "numeric", "orientation"};
  const std::string kind = table.choice("kind", kinds, kinds[0]);
  if (use == Use::kRendering && kind != kinds[0]) {
    table.fail("kind", "is of a study that renders nothing");
  }
  study.name = table.text("name", fallback_name);
  require_plain_name(table, study.name);  // it becomes that of a folder
  study.title = table.text("title", study.name);
  study.question = table.text("question", "");
  study.reference = table.text("reference", "");
  study.claim = table.text("claim", "");
  study.seed = static_cast<uint64_t>(table.integer("seed", {0, 9e15}, 1));
  study.draws = static_cast<int>(table.integer("trials", {1, kMaxTrials}, 100));
  if (kind == "numeric") {
    study.kind = read_numeric_study(table, study, guests);
  } else if (kind == "orientation") {
    study.kind = read_orientation_study(table, study);
  } else {
    study.kind = read_image_study(table, use, study, guests);
  }
  table.reject_unknown_keys();
  study.toml = text_as_run(table, study);
  return study;
}

Study read_file(const std::string& name_or_path, const StudyOverrides& overrides, Use use) {
  const std::filesystem::path file = find_study_file(name_or_path);
  std::vector<std::string> settings = settings_of(overrides);
  const TomlTable as_written = TomlTable::read_file(file, settings);
  // The study as run stands on its own: it says its name, and where what lies beside it is.
  if (!as_written.has("name")) settings.push_back("name=" + toml_text(file.stem().string()));
  const auto place_beside = [&](const std::string& key, const std::filesystem::path& given) {
    const std::filesystem::path beside = std::filesystem::absolute(file).parent_path() / given;
    if (given.empty() || !given.is_relative() || !std::filesystem::exists(beside)) return;
    settings.push_back(fmt::format("{}={}", key, toml_text(beside.lexically_normal().string())));
  };
  const std::filesystem::path target = as_written.text("target", "");
  if (target.has_extension()) place_beside("target", target);
  for (const char* key : {"path", "priors"}) {
    place_beside(fmt::format("dataset.{}", key), as_written.table("dataset").text(key, ""));
  }
  for (const char* pictures : {"background", "environment"}) {
    place_beside(fmt::format("{}.file", pictures), as_written.table(pictures).text("file", ""));
  }
  place_beside("material.textures", as_written.table("material").text("textures", ""));
  for (const char* guests : {"observations", "estimates"}) {
    const size_t count = as_written.tables(guests).size();
    for (size_t i = 0; i < count; ++i) {
      const TomlTable guest = as_written.tables(guests)[i];
      for (const char* key : {"file", "images"}) {
        place_beside(fmt::format("{}.{}.{}", guests, i, key), guest.text(key, ""));
      }
    }
  }
  return read_table(TomlTable::read_file(file, settings), file.stem(), use, overrides.guests);
}

}  // namespace

Study read_study(const std::string& name_or_path, const StudyOverrides& overrides) {
  return read_file(name_or_path, overrides, Use::kTrials);
}

Study read_scene(const std::string& name_or_path, const StudyOverrides& overrides) {
  return read_file(name_or_path, overrides, Use::kRendering);
}

Study read_study_text(const std::string& toml, const std::filesystem::path& source,
                      const StudyOverrides& overrides) {
  return read_table(TomlTable::read_text(toml, source, settings_of(overrides)), source.stem(),
                    Use::kTrials, overrides.guests);
}

Study read_scene_text(const std::string& toml, const std::filesystem::path& source,
                      const StudyOverrides& overrides) {
  return read_table(TomlTable::read_text(toml, source, settings_of(overrides)), source.stem(),
                    Use::kRendering, overrides.guests);
}

}  // namespace sightline
