// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/run/run.h"

#include <chrono>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "eval/output/output_folder.h"
#include "eval/results/store.h"
#include "eval/run/asked_processes.h"
#include "eval/run/manifest.h"
#include "eval/run/run_folder.h"
#include "eval/run/run_results.h"
#include "eval/run/trial_runner.h"
#include "eval/work/interrupt.h"
#include "eval/work/memory.h"
#include "eval/work/shares.h"
#include "renderer/renderer.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// What a batch may hold and take, so that a run that is killed loses little.
constexpr size_t kMostTrialsABatch = 1000;
constexpr std::chrono::seconds kLongestBatch{1};

// Runs the trials of a shard that are not done yet.
void run_shard(const Study& study, const Shard& shard, const RendererOptions& renderer,
               const std::vector<bool>& done, Store& store, const Tick& tick) {
  using Clock = std::chrono::steady_clock;
  TrialRunner runner(study, renderer);
  std::vector<TrialRecord> batch;
  Clock::time_point batch_start = Clock::now();
  const auto run_all = [&] {
    for (int64_t index = shard.index; index < study.trial_count(); index += shard.count) {
      if (done[static_cast<size_t>(index)]) continue;
      stop_if_interrupted();
      batch.push_back(runner.run(index));
      if (batch.size() == kMostTrialsABatch || Clock::now() - batch_start > kLongestBatch) {
        store.add(batch);
        batch.clear();
        batch_start = Clock::now();
      }
      tick();
    }
  };
  try {
    run_all();
  } catch (const Interrupted&) {
    store.add(batch);  // what is finished is kept, whatever ends the run
    throw;
  }
  store.add(batch);
}

// Moves the trials of all job stores into the run's own. One transaction takes a whole store over,
// so that one whose first trial is there has been before, by a run that was killed right then.
void join_jobs(const fs::path& staging, Store& store) {
  for (const fs::path& file : job_files(staging)) {
    const std::optional<int64_t> first = Store::open(file).first_trial();
    if (first && !store.holds(*first)) store.add_all_of(file);
    fs::remove(file);
  }
}

// What the trials of a shard that are not done draw of folders is read before any is begun.
void check_drawn_files(const Study& study, const Shard& shard, const std::vector<bool>& done) {
  if (!study.renders()) return;
  const ImageStudy& images = *study.images();
  CheckedFiles checked;
  for (int64_t index = shard.index; index < study.trial_count(); index += shard.count) {
    if (done[static_cast<size_t>(index)]) continue;
    stop_if_interrupted();
    check_drawn_files(images.setup_of(study.condition_of(index)).scene, study.seed,
                      images.draw_of(index), checked);
  }
}

// Runs what is not done of a share of the trials in `jobs` processes, each with a store of its own,
// and joins them. Returns how many trials were done before.
int64_t run_jobs(const Study& study, const RunOptions& options, const OutputFolder& folder,
                 Store& store) {
  join_jobs(folder.staging(), store);
  const std::vector<bool> done = store.held(study.trial_count());
  const int64_t done_before = store.size();
  check_drawn_files(study, options.shard, done);
  const AskedProcesses processes(study, folder.staging());
  const ShardWork shard_work{
      .label = study.name,
      .shard = options.shard,
      .to_do = size_of(options.shard, study.trial_count()) - done_before,
      .jobs = options.jobs,
      .show_progress = options.show_progress,
  };
  run_shares(shard_work, [&](int job, const Shard& share, const Tick& tick) {
    const AskedProcesses::Session session = processes.begin(job);
    if (shard_work.processes() == 1)
      return run_shard(study, share, options.renderer, done, store, tick);
    Store job_store = Store::create(folder / fmt::format("{}{}.sqlite", kJobPrefix, job),
                                    meta_of(study, share, options.renderer.gl));
    run_shard(study, share, options.renderer, done, job_store, tick);
  });
  join_jobs(folder.staging(), store);
  return done_before;
}

// Images that the machine has no memory for are refused before anything is begun.
void require_memory(const Study& study, const RunOptions& options) {
  if (!study.renders()) return;
  for (const ImageSetup& setup : study.images()->setups) {
    const Camera& camera = setup.scene.camera;
    const std::string why_not =
        why_no_memory(camera.width_px, camera.height_px, options.jobs, free_memory_bytes());
    if (!why_not.empty()) throw InputError(fmt::format("camera.width_px: {}", why_not));
  }
}

// A run that is complete, of which nothing is left to do; none where there is no such run.
std::optional<RunResult> complete_run(const Study& study, const RunOptions& options) {
  const fs::path file = options.out / kStoreFile;
  std::error_code none;  // who may not look will hear so when the folder is to be written
  if (!fs::exists(file, none) || !fs::exists(options.out / kReportFile, none)) return std::nullopt;
  const Store store = Store::open(file);
  require_same_run(store.meta(), meta_of(study, options), options.out);
  RunResult result = summarise_store(study, store);
  result.resumed_trials = result.trials;
  return result;
}

RunResult run_into(OutputFolder& folder, Store& store, const Study& study,
                   const RunOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  nlohmann::json manifest = manifest_of(study, options.command);
  const int64_t resumed_trials = run_jobs(study, options, folder, store);
  manifest["jobs"] = options.jobs;
  manifest["shard"] = fmt::format("{}/{}", options.shard.index, options.shard.count);
  if (resumed_trials > 0) manifest["resumed_trials"] = resumed_trials;
  if (study.renders()) {
    manifest["renderer"] = Renderer(options.renderer).description();
  }

  RunResult result = write_results(study, store, manifest, folder.staging());
  result.resumed_trials = resumed_trials;
  const auto wall = std::chrono::steady_clock::now() - start;
  manifest["wall_s"] = std::chrono::duration_cast<std::chrono::milliseconds>(wall).count() / 1e3;
  write_file(folder / "study.toml", study.toml);
  write_manifest(manifest, folder.staging());
  folder.commit();
  return result;
}

}  // namespace

RunResult run_study(const Study& study, const RunOptions& options) {
  if (options.is_resumed) {
    if (const std::optional<RunResult> result = complete_run(study, options)) return *result;
  }
  require_memory(study, options);
  OutputFolder folder(options.out, OutputFolder::Leftovers::kKeep);
  Store store = store_for(folder, options, meta_of(study, options));
  try {
    return run_into(folder, store, study, options);
  } catch (const Interrupted&) {
    const std::string kept = keep_finished(folder);
    if (kept.empty()) throw;
    throw Interrupted("interrupted" + kept);
  } catch (const InputError& error) {
    throw InputError(error.what() + keep_finished(folder));
  } catch (...) {
    keep_finished(folder);
    throw;
  }
}

Summary run_pilot(const Study& study, const RunOptions& options) {
  const OutputFolder folder(options.out);
  Store store = Store::create(folder / kStoreFile, meta_of(study, options));
  run_jobs(study, options, folder, store);
  return summarise_store(study, store).summary;
}

RunResult rewrite_report(const fs::path& folder) {
  const fs::path file = folder / kStoreFile;
  const Store store = Store::open(file);
  const Study study = study_from_meta(store.meta(), file);
  return write_results(study, store, read_manifest(folder), folder);
}

}  // namespace sightline
