// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/run.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <map>
#include <optional>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/utsname.h>

#include "eval/interrupt.h"
#include "eval/numeric_trial.h"
#include "eval/orientation_trial.h"
#include "eval/output_folder.h"
#include "eval/progress.h"
#include "eval/report/evidence.h"
#include "eval/report/gnuplot.h"
#include "eval/report/report.h"
#include "eval/store.h"
#include "eval/trial.h"
#include "eval/workers.h"
#include "renderer/renderer.h"
#include "scenes/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using Meta = std::map<std::string, std::string>;

constexpr const char* kStoreFile = "results.sqlite";
constexpr size_t kImagedTrialsATransaction = 50;
constexpr size_t kOtherTrialsATransaction = 2000;  // each takes well under a millisecond

std::string machine() {
  utsname system{};
  uname(&system);
  std::string processor = "unknown processor";
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (!line.starts_with("model name")) continue;
    processor = line.substr(std::min(line.size(), line.find(':') + 2));
    break;
  }
  return fmt::format("{} {}, {}", system.sysname, system.machine, processor);
}

// What identifies a run: kept in its store, so that merge can tell what belongs together.
Meta meta_of(const Study& study, const Shard& shard) {
  return {{"version", SIGHTLINE_VERSION},
          {"study", study.name},
          {"study_toml", study.toml},
          {"seed", fmt::format("{}", study.seed)},
          {"trials", fmt::format("{}", study.trial_count())},
          {"shard", fmt::format("{}/{}", shard.index, shard.count)}};
}

// Runs trials of any kind of study. Only images need a graphics context.
class TrialRunner {
 public:
  explicit TrialRunner(const Study& study) : study_(study) {
    if (study.kind == StudyKind::kImages) renderer_.emplace();
  }

  TrialRecord run(int64_t index) {
    switch (study_.kind) {
      case StudyKind::kImages:
        return run_trial(study_, index, *renderer_).record;
      case StudyKind::kNumeric:
        return run_numeric_trial(study_, index);
      case StudyKind::kOrientation:
        return run_orientation_trial(study_, index);
    }
    return {};
  }

 private:
  const Study& study_;
  std::optional<Renderer> renderer_;
};

void run_shard(const Study& study, const Shard& shard, Store& store, const Tick& tick) {
  const size_t batch_size =
      study.kind == StudyKind::kImages ? kImagedTrialsATransaction : kOtherTrialsATransaction;
  TrialRunner runner(study);
  std::vector<TrialRecord> batch;
  for (int64_t index = shard.index; index < study.trial_count(); index += shard.count) {
    stop_if_interrupted();
    batch.push_back(runner.run(index));
    if (batch.size() == batch_size) {
      store.add(batch);
      batch.clear();
    }
    tick();
  }
  store.add(batch);
}

int64_t trials_in(const Study& study, const Shard& shard) {
  const int64_t count = study.trial_count();
  return shard.index >= count ? 0 : (count - shard.index + shard.count - 1) / shard.count;
}

// Runs a share of the trials in `jobs` processes, each with a store of its own, and joins them.
void run_jobs(const Study& study, const RunOptions& options, const OutputFolder& folder,
              Store& store) {
  const int64_t share_size = trials_in(study, options.shard);
  Progress progress(study.name, share_size, options.show_progress);
  const int jobs = static_cast<int>(std::clamp<int64_t>(share_size, 1, options.jobs));
  if (jobs == 1) {
    run_shard(study, options.shard, store, [&progress] { progress.advance(1); });
    return;
  }
  const auto job_file = [&folder](int job) { return folder / fmt::format("job-{}.sqlite", job); };
  const auto work = [&](int job, const Tick& tick) {
    const Shard share{options.shard.index + options.shard.count * job, options.shard.count * jobs};
    Store job_store = Store::create(job_file(job), meta_of(study, share));
    run_shard(study, share, job_store, tick);
  };
  run_in_processes(jobs, work, [&progress](int64_t n) { progress.advance(n); });
  for (int job = 0; job < jobs; ++job) {
    store.add_all_of(job_file(job));
    fs::remove(job_file(job));
  }
}

bool could_be_run(const TrialRecord& trial) {
  return !trial.observations.empty() || !trial.orientations.empty();
}

// Everything that is made from the trials, by a function from file name to path.
template <typename Folder>
RunResult write_results(const Study& study, const std::vector<TrialRecord>& trials,
                        const Meta& manifest, const Folder& folder) {
  RunResult result;
  result.trials = static_cast<int64_t>(trials.size());
  result.failed_trials = result.trials - std::count_if(trials.begin(), trials.end(), could_be_run);
  stop_if_interrupted();
  result.summary = summarise(study, trials);
  stop_if_interrupted();
  write_file(folder / "results.csv", to_csv(study, trials));
  write_file(folder / "summary.json", to_json(study, result.summary));
  const std::string timings = to_timings_csv(study, trials);
  if (!timings.empty()) write_file(folder / "timings.csv", timings);
  std::vector<FrameEvidence> frames;
  if (study.kind == StudyKind::kImages) {
    Renderer renderer;
    frames = gather_evidence(study, trials, renderer);
  }
  stop_if_interrupted();
  const ReportInput input{study, result.summary, trials, frames, manifest};
  write_file(folder / "report.html", render_report(input));
  result.figures_note = write_figures(folder / "figures", report_charts(input));
  return result;
}

std::string to_json_text(const Meta& manifest) {
  nlohmann::ordered_json json;
  for (const auto& [key, value] : manifest) json[key] = value;
  return json.dump(2) + "\n";
}

// The manifest of a run that is there already; what cannot be read is left out.
Meta read_manifest(const fs::path& file) {
  Meta manifest;
  std::ifstream stream(file);
  const auto json = nlohmann::json::parse(stream, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return manifest;
  for (const auto& [key, value] : json.items()) {
    if (value.is_string()) manifest[key] = value.get<std::string>();
  }
  return manifest;
}

Meta manifest_of(const Study& study, const std::string& command) {
  return {{"version", SIGHTLINE_VERSION},
          {"study", study.name},
          {"seed", fmt::format("{}", study.seed)},
          {"trials", fmt::format("{}", study.trial_count())},
          {"command", command},
          {"machine", machine()},
          {"started",
           fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::now()))}};
}

Study study_from_meta(const Meta& meta, const fs::path& file) {
  const auto text = meta.find("study_toml");
  if (text == meta.end()) {
    throw InputError(fmt::format("{}: holds no study", file.string()));
  }
  return read_study_text(text->second, file);
}

Shard shard_in(const Meta& meta, const fs::path& folder) {
  const auto found = meta.find("shard");
  if (found == meta.end()) throw InputError(fmt::format("{}: holds no shard", folder.string()));
  return read_shard(found->second, [](const char*) -> const char* { return nullptr; }).shard;
}

void require_same(const Meta& a, const Meta& b, const fs::path& first, const fs::path& other) {
  for (const char* key : {"version", "study", "seed", "trials", "study_toml"}) {
    const auto in_a = a.find(key);
    const auto in_b = b.find(key);
    if (in_a != a.end() && in_b != b.end() && in_a->second == in_b->second) continue;
    throw InputError(fmt::format("{}: differs from {} in its {}; shards must come from one study",
                                 other.string(), first.string(), key));
  }
}

}  // namespace

RunResult run_study(const Study& study, const RunOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  OutputFolder folder(options.out);
  Meta manifest = manifest_of(study, options.command);
  Store store = Store::create(folder / kStoreFile, meta_of(study, options.shard));
  run_jobs(study, options, folder, store);
  manifest["jobs"] = fmt::format("{}", options.jobs);
  manifest["shard"] = fmt::format("{}/{}", options.shard.index, options.shard.count);
  if (study.kind == StudyKind::kImages) manifest["renderer"] = Renderer().description();

  const RunResult result = write_results(study, store.trials(), manifest, folder);
  const double wall_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  manifest["wall_s"] = fmt::format("{:.3f}", wall_s);
  write_file(folder / "study.toml", study.toml);
  write_file(folder / "manifest.json", to_json_text(manifest));
  folder.commit();
  return result;
}

RunResult merge_runs(const std::vector<fs::path>& shards, const fs::path& out,
                     const std::string& command) {
  std::vector<Meta> metas;
  std::vector<TrialRecord> trials;
  std::map<int64_t, fs::path> folder_of;
  int64_t count = 0;
  for (const fs::path& folder : shards) {
    const Store store = Store::open(folder / kStoreFile);
    metas.push_back(store.meta());
    require_same(metas.front(), metas.back(), shards.front(), folder);
    const Shard shard = shard_in(metas.back(), folder);
    if (count != 0 && shard.count != count) {
      throw InputError(fmt::format("{}: is one of {} shards, {} is one of {}", folder.string(),
                                   shard.count, shards.front().string(), count));
    }
    count = shard.count;
    const auto [before, is_new] = folder_of.emplace(shard.index, folder);
    if (!is_new) {
      throw InputError(fmt::format("{} and {} are both shard {} of {}", before->second.string(),
                                   folder.string(), shard.index, count));
    }
    for (TrialRecord& trial : store.trials()) trials.push_back(std::move(trial));
  }
  for (int64_t index = 0; index < count; ++index) {
    if (!folder_of.contains(index)) {
      throw InputError(fmt::format("merge: shard {} of {} is missing", index, count));
    }
  }
  std::sort(trials.begin(), trials.end(),
            [](const TrialRecord& a, const TrialRecord& b) { return a.trial < b.trial; });

  const Study study = study_from_meta(metas.front(), shards.front() / kStoreFile);
  OutputFolder folder(out);
  Store store = Store::create(folder / kStoreFile, meta_of(study, Shard{}));
  store.add(trials);
  Meta manifest = manifest_of(study, command);
  manifest["shard"] = fmt::format("merged from {}", count);
  const RunResult result = write_results(study, trials, manifest, folder);
  write_file(folder / "study.toml", study.toml);
  write_file(folder / "manifest.json", to_json_text(manifest));
  folder.commit();
  return result;
}

RunResult rewrite_report(const fs::path& folder) {
  const fs::path file = folder / kStoreFile;
  const Store store = Store::open(file);
  const Study study = study_from_meta(store.meta(), file);
  return write_results(study, store.trials(), read_manifest(folder / "manifest.json"), folder);
}

}  // namespace sightline
