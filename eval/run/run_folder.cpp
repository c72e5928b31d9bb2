// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/run/run_folder.h"

#include <algorithm>

#include <fmt/format.h>

#include "eval/study/study_file.h"
#include "renderer/renderer.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// Who draws, as --gl says it: pixels depend on it.
std::string name_of(GlChoice gl) {
  return std::string(gl_choice_names()[static_cast<size_t>(gl)]);
}

// How many trials an ended run left beside its folder, in all its stores that can be read.
int64_t finished_trials(const fs::path& staging) {
  std::vector<fs::path> files = job_files(staging);
  if (fs::exists(staging / kStoreFile)) files.push_back(staging / kStoreFile);
  int64_t count = 0;
  for (const fs::path& file : files) {
    try {
      count += Store::open(file).size();
    } catch (const InputError&) {
      continue;  // its reader will say what is wrong with it
    }
  }
  return count;
}

}  // namespace

RunMeta meta_of(const Study& study, const Shard& shard, GlChoice gl) {
  return {{"version", SIGHTLINE_VERSION},
          {"study", study.name},
          {"study_toml", study.toml},
          {"seed", fmt::format("{}", study.seed)},
          {"trials", fmt::format("{}", study.trial_count())},
          {"gl", name_of(gl)},
          {"shard", fmt::format("{}/{}", shard.index, shard.count)}};
}

RunMeta meta_of(const Study& study, const RunOptions& options) {
  return meta_of(study, options.shard, options.renderer.gl);
}

Study study_from_meta(const RunMeta& meta, const fs::path& file) {
  const auto text = meta.find("study_toml");
  if (text == meta.end()) {
    throw InputError(fmt::format("{}: holds no study", file.string()));
  }
  StudyOverrides overrides;
  overrides.guests.may_be_absent = true;  // their answers are in the store
  return read_study_text(text->second, file, overrides);
}

void require_same_run(const RunMeta& there, const RunMeta& asked, const fs::path& file) {
  for (const char* key : {"version", "study", "seed", "trials", "gl", "shard", "study_toml"}) {
    const auto value = there.find(key);
    if (value != there.end() && value->second == asked.at(key)) continue;
    if (std::string_view(key) == "study_toml") {
      throw InputError(fmt::format("--resume: {} was begun with other keys of the study {}",
                                   file.string(), asked.at("study")));
    }
    throw InputError(fmt::format("--resume: {} was begun with {} {}, not {}", file.string(), key,
                                 value == there.end() ? "unknown" : value->second, asked.at(key)));
  }
}

std::vector<fs::path> job_files(const fs::path& staging) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(staging)) {
    const fs::path& file = entry.path();
    const bool is_store = file.extension() == ".sqlite";
    if (is_store && file.filename().string().starts_with(kJobPrefix)) files.push_back(file);
  }
  std::sort(files.begin(), files.end());
  return files;
}

void refuse_finished_trials(OutputFolder& folder, const fs::path& out) {
  const int64_t count = finished_trials(folder.staging());
  if (count == 0) return;
  folder.keep();
  throw InputError(
      fmt::format("--out {}: an ended run left {} finished trial{} in {}; continue it with "
                  "--resume, or remove that folder",
                  out.string(), count, count == 1 ? "" : "s", folder.staging().string()));
}

Store store_for(OutputFolder& folder, const RunOptions& options, const RunMeta& meta) {
  const fs::path file = folder / kStoreFile;
  if (!options.is_resumed || !fs::exists(file)) {
    refuse_finished_trials(folder, options.out);
    folder.clear();
    return Store::create(file, meta);
  }
  folder.keep();
  Store store = Store::open(file);
  require_same_run(store.meta(), meta, folder.staging());
  return store;
}

std::string keep_finished(OutputFolder& folder) {
  const int64_t count = finished_trials(folder.staging());
  folder.keep(count > 0);
  if (count == 0) return "";
  return fmt::format("; {} finished trial{} kept for --resume", count,
                     count == 1 ? " is" : "s are");
}

}  // namespace sightline
