// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/run/merge.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "eval/output/output_error.h"
#include "eval/output/output_folder.h"
#include "eval/results/store.h"
#include "eval/run/manifest.h"
#include "eval/run/run_folder.h"
#include "eval/run/run_results.h"
#include "eval/work/interrupt.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// In the store of a merge: of how many shards.
constexpr const char* kMergedKey = "merged";

Shard shard_in(const RunMeta& meta, const fs::path& folder) {
  const auto found = meta.find("shard");
  if (found == meta.end()) throw InputError(fmt::format("{}: holds no shard", folder.string()));
  return read_shard(found->second, [](const char*) -> const char* { return nullptr; }).shard;
}

void require_same(const RunMeta& a, const RunMeta& b, const fs::path& first,
                  const fs::path& other) {
  for (const char* key : {"version", "study", "seed", "trials", "gl", "study_toml"}) {
    const auto in_a = a.find(key);
    const auto in_b = b.find(key);
    if (in_a != a.end() && in_b != b.end() && in_a->second == in_b->second) continue;
    throw InputError(fmt::format("{}: differs from {} in its {}; shards must come from one study",
                                 other.string(), first.string(), key));
  }
}

// The folders of all shards of one study.
struct ShardFolders {
  RunMeta meta;                           // of the first; of the others alike but for their shard
  std::map<int64_t, fs::path> folder_of;  // by the shard's index, each there once
};

// Throws InputError for shards of different studies, missing ones and double ones.
ShardFolders shard_folders(const std::vector<fs::path>& shards) {
  ShardFolders found;
  int64_t count = 0;
  for (const fs::path& folder : shards) {
    const RunMeta meta = Store::open(folder / kStoreFile).meta();
    if (found.meta.empty()) found.meta = meta;
    require_same(found.meta, meta, shards.front(), folder);
    const Shard shard = shard_in(meta, folder);
    if (count != 0 && shard.count != count) {
      throw InputError(fmt::format("{}: is one of {} shards, {} is one of {}", folder.string(),
                                   shard.count, shards.front().string(), count));
    }
    count = shard.count;
    const auto [before, is_new] = found.folder_of.emplace(shard.index, folder);
    if (!is_new) {
      throw InputError(fmt::format("{} and {} are both shard {} of {}", before->second.string(),
                                   folder.string(), shard.index, count));
    }
  }
  for (int64_t index = 0; index < count; ++index) {
    if (!found.folder_of.contains(index)) {
      throw InputError(fmt::format("merge: shard {} of {} is missing", index, count));
    }
  }
  return found;
}

// Shards may be there and yet lack trials, which would be missing from every mean.
void require_every_trial(const Study& study, const Store& store, const ShardFolders& found) {
  const auto shards = static_cast<int64_t>(found.folder_of.size());
  const std::vector<bool> held = store.held(study.trial_count());
  const auto gap = std::find(held.begin(), held.end(), false);
  if (gap == held.end()) return;
  const int64_t trial = gap - held.begin();
  const auto missing = std::count(held.begin(), held.end(), false);
  throw InputError(fmt::format("{}: lacks trial {}{}; must hold every trial of shard {} of {}",
                               found.folder_of.at(trial % shards).string(), trial,
                               missing > 1 ? fmt::format(" ({} are missing in all)", missing) : "",
                               trial % shards, shards));
}

// Does something with the trials of all shards. What is wrong with one of them is said of that
// shard and not of the copy that is removed. They are all read for it, unless it is the disk.
template <typename Action>
auto blaming_shards(const Study& study, const std::vector<fs::path>& shards, const Action& action) {
  try {
    return action();
  } catch (const OutputError&) {
    throw;
  } catch (const InputError&) {
    for (const fs::path& shard : shards) summarise_store(study, Store::open(shard / kStoreFile));
    throw;
  }
}

// What a merge that was killed left: copies of what the shards hold.
bool is_begun_merge(const OutputFolder& folder) {
  const fs::path store = folder / kStoreFile;
  return fs::is_regular_file(store) && Store::open(store).meta().contains(kMergedKey);
}

}  // namespace

RunResult merge_runs(const std::vector<fs::path>& shards, const fs::path& out,
                     const std::string& command) {
  const ShardFolders found = shard_folders(shards);
  const Study study = study_from_meta(found.meta, shards.front() / kStoreFile);
  OutputFolder folder(out, OutputFolder::Leftovers::kKeep);
  if (!is_begun_merge(folder)) refuse_finished_trials(folder, out);
  folder.clear();
  RunMeta meta = meta_of(study, RunOptions{});
  meta["gl"] = found.meta.at("gl");
  meta[kMergedKey] = fmt::to_string(found.folder_of.size());
  Store store = Store::create(folder / kStoreFile, meta);
  blaming_shards(study, shards, [&] {
    for (const fs::path& shard : shards) {
      stop_if_interrupted();
      store.add_all_of(shard / kStoreFile);
    }
  });
  require_every_trial(study, store, found);
  nlohmann::json manifest = manifest_of(study, command);
  manifest["shard"] = fmt::format("merged from {}", found.folder_of.size());
  const RunResult result = blaming_shards(
      study, shards, [&] { return write_results(study, store, manifest, folder.staging()); });
  write_file(folder / "study.toml", study.toml);
  write_manifest(manifest, folder.staging());
  folder.commit();
  return result;
}

}  // namespace sightline
