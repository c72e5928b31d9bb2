// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/run/run.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <map>
#include <optional>
#include <string_view>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/utsname.h>

#include "eval/output/output_folder.h"
#include "eval/report/evidence.h"
#include "eval/report/gnuplot.h"
#include "eval/report/report.h"
#include "eval/results/results_csv.h"
#include "eval/results/store.h"
#include "eval/summary/summary_json.h"
#include "eval/trial/image_trial.h"
#include "eval/trial/numeric_trial.h"
#include "eval/trial/orientation_trial.h"
#include "eval/work/interrupt.h"
#include "eval/work/progress.h"
#include "eval/work/shares.h"
#include "renderer/renderer.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using Meta = std::map<std::string, std::string>;

constexpr const char* kOutliersFile = "outliers.json";
// The charts of single trials (cumulative curves, boxes, paired differences) and the frames are of
// studies up to this size; a trial takes some kilobytes.
constexpr int64_t kMostTrialsDrawn = 100'000;
constexpr const char* kStoreFile = "results.sqlite";
constexpr const char* kReportFile = "report.html";
constexpr std::string_view kJobPrefix = "job-";
// What a batch may hold and take, so that a run that is killed loses little.
constexpr size_t kMostTrialsABatch = 1000;
constexpr std::chrono::seconds kLongestBatch{1};

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

// Who draws, as --gl says it: pixels depend on it.
std::string name_of(GlChoice gl) {
  return std::string(gl_choice_names()[static_cast<size_t>(gl)]);
}

// What identifies a run: kept in its store, so that merge can tell what belongs together.
Meta meta_of(const Study& study, const Shard& shard, const std::string& gl) {
  return {{"version", SIGHTLINE_VERSION},
          {"study", study.name},
          {"study_toml", study.toml},
          {"seed", fmt::format("{}", study.seed)},
          {"trials", fmt::format("{}", study.trial_count())},
          {"gl", gl},
          {"shard", fmt::format("{}/{}", shard.index, shard.count)}};
}

// Runs trials of any kind of study. Only images need a renderer. One is made in the process that
// uses it: graphics libraries do not survive a fork.
class TrialRunner {
 public:
  TrialRunner(const Study& study, const RendererOptions& renderer) : study_(study) {
    if (study.kind == StudyKind::kImages) renderer_.emplace(renderer);
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

// Runs the trials of a shard that are not done yet.
void run_shard(const Study& study, const Shard& shard, const RendererOptions& renderer,
               const std::vector<bool>& done, Store& store, const Tick& tick) {
  using Clock = std::chrono::steady_clock;
  TrialRunner runner(study, renderer);
  std::vector<TrialRecord> batch;
  Clock::time_point batch_start = Clock::now();
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
  store.add(batch);
}

// The stores of the processes that share a run's work.
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

// Moves the trials of all job stores into the run's own. One transaction takes a whole store over,
// so that one whose first trial is there has been before, by a run that was killed right then.
void join_jobs(const fs::path& staging, Store& store) {
  for (const fs::path& file : job_files(staging)) {
    const std::optional<int64_t> first = Store::open(file).first_trial();
    if (first && !store.holds(*first)) store.add_all_of(file);
    fs::remove(file);
  }
}

// Runs what is not done of a share of the trials in `jobs` processes, each with a store of its own,
// and joins them. Returns how many trials were done before.
int64_t run_jobs(const Study& study, const RunOptions& options, const OutputFolder& folder,
                 Store& store) {
  join_jobs(folder.staging(), store);
  const std::vector<bool> done = store.held(study.trial_count());
  const int64_t done_before = store.size();
  const ShardWork shard_work{
      .label = study.name,
      .shard = options.shard,
      .to_do = size_of(options.shard, study.trial_count()) - done_before,
      .jobs = options.jobs,
      .show_progress = options.show_progress,
  };
  run_shares(shard_work, [&](int job, const Shard& share, const Tick& tick) {
    if (shard_work.processes() == 1)
      return run_shard(study, share, options.renderer, done, store, tick);
    Store job_store = Store::create(folder / fmt::format("{}{}.sqlite", kJobPrefix, job),
                                    meta_of(study, share, name_of(options.renderer.gl)));
    run_shard(study, share, options.renderer, done, job_store, tick);
  });
  join_jobs(folder.staging(), store);
  return done_before;
}

bool could_be_run(const TrialRecord& trial) {
  return !trial.observations().empty() || !trial.orientations().empty();
}

// A manifest as the report shows it.
Meta as_texts(const Json& manifest) {
  Meta texts;
  if (!manifest.is_object()) return texts;
  for (const auto& [key, value] : manifest.items()) {
    texts[key] = value.is_string() ? value.get<std::string>() : value.dump();
  }
  return texts;
}

// The trials of a store one by one, counted: `result` knows them all after one pass.
TrialSource counted_trials(const Store& store, RunResult& result) {
  return [&](const TrialVisitor& visit) {
    result.trials = 0;
    result.failed_trials = 0;
    store.for_each([&](const TrialRecord& trial) {
      stop_if_interrupted();
      ++result.trials;
      result.failed_trials += !could_be_run(trial);
      visit(trial);
    });
  };
}

// What a store's trials say.
RunResult summarise_store(const Study& study, const Store& store) {
  RunResult result;
  result.summary = summarise(study, counted_trials(store, result));
  return result;
}

// Everything that is made from the trials, by a function from file name to path.
template <typename Folder>
RunResult write_results(const Study& study, const Store& store, const Json& manifest,
                        const Folder& folder) {
  RunResult result = summarise_store(study, store);
  const TrialSource source = counted_trials(store, result);
  write_file(folder / "results.csv", [&](std::ostream& out) { write_csv(study, source, out); });
  write_file(folder / "summary.json", to_json(study, result.summary));
  if (study.takes_times()) {
    write_file(folder / "timings.csv",
               [&](std::ostream& out) { write_timings_csv(study, source, out); });
  }
  // What is shown of single trials needs them all at once.
  std::vector<TrialRecord> trials;
  if (store.size() <= kMostTrialsDrawn) trials = store.trials();
  std::vector<FrameEvidence> frames;
  if (study.kind == StudyKind::kImages) {
    write_file(folder / kOutliersFile, to_json(outlier_model_of(trials), study.name));
    Renderer renderer;
    frames = gather_evidence(study, trials, renderer);
  }
  stop_if_interrupted();
  const ReportInput input{study, result.summary, trials, frames, as_texts(manifest)};
  write_file(folder / kReportFile, render_report(input));
  result.figures_note = write_figures(folder / "figures", report_charts(input));
  return result;
}

// The manifest of a run that is there already; what cannot be read is left out.
Json read_manifest(const fs::path& file) {
  std::ifstream stream(file);
  return Json::parse(stream, nullptr, /*allow_exceptions=*/false);
}

void write_manifest(const Json& manifest, const OutputFolder& folder) {
  write_file(folder / "manifest.json", manifest.dump(2) + "\n");
}

Json manifest_of(const Study& study, const std::string& command) {
  return {{"version", SIGHTLINE_VERSION},
          {"study", study.name},
          {"seed", study.seed},
          {"trials", study.trial_count()},
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
  for (const char* key : {"version", "study", "seed", "trials", "gl", "study_toml"}) {
    const auto in_a = a.find(key);
    const auto in_b = b.find(key);
    if (in_a != a.end() && in_b != b.end() && in_a->second == in_b->second) continue;
    throw InputError(fmt::format("{}: differs from {} in its {}; shards must come from one study",
                                 other.string(), first.string(), key));
  }
}

// Refuses to continue a run that is not the one which is asked for.
void require_same_run(const Meta& there, const Meta& asked, const fs::path& file) {
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

void refuse_finished_trials(OutputFolder& folder, const fs::path& out) {
  const int64_t count = finished_trials(folder.staging());
  if (count == 0) return;
  folder.keep();
  throw InputError(
      fmt::format("--out {}: an ended run left {} finished trial{} in {}; continue it with "
                  "--resume, or remove that folder",
                  out.string(), count, count == 1 ? "" : "s", folder.staging().string()));
}

// The store of the run: a new one, or what an ended run left.
Store store_for(OutputFolder& folder, const RunOptions& options, const Meta& meta) {
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

// To be called where the work fails: keeps what is finished, and returns the words for that.
std::string keep_finished(OutputFolder& folder) {
  const int64_t count = finished_trials(folder.staging());
  folder.keep(count > 0);
  if (count == 0) return "";
  return fmt::format("; {} finished trial{} kept for --resume", count,
                     count == 1 ? " is" : "s are");
}

// A run that is complete, of which nothing is left to do; none where there is no such run.
std::optional<RunResult> complete_run(const Study& study, const RunOptions& options) {
  const fs::path file = options.out / kStoreFile;
  std::error_code none;  // who may not look will hear so when the folder is to be written
  if (!fs::exists(file, none) || !fs::exists(options.out / kReportFile, none)) return std::nullopt;
  const Store store = Store::open(file);
  require_same_run(store.meta(), meta_of(study, options.shard, name_of(options.renderer.gl)),
                   options.out);
  RunResult result = summarise_store(study, store);
  result.resumed_trials = result.trials;
  return result;
}

RunResult run_into(OutputFolder& folder, Store& store, const Study& study,
                   const RunOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  Json manifest = manifest_of(study, options.command);
  const int64_t resumed_trials = run_jobs(study, options, folder, store);
  manifest["jobs"] = options.jobs;
  manifest["shard"] = fmt::format("{}/{}", options.shard.index, options.shard.count);
  if (resumed_trials > 0) manifest["resumed_trials"] = resumed_trials;
  if (study.kind == StudyKind::kImages && !study.sightings) {
    manifest["renderer"] = Renderer(options.renderer).description();
  }

  RunResult result = write_results(study, store, manifest, folder);
  result.resumed_trials = resumed_trials;
  const auto wall = std::chrono::steady_clock::now() - start;
  manifest["wall_s"] = std::chrono::duration_cast<std::chrono::milliseconds>(wall).count() / 1e3;
  write_file(folder / "study.toml", study.toml);
  write_manifest(manifest, folder);
  folder.commit();
  return result;
}

// Shards may be there and yet lack trials, which would be missing from every mean.
void require_every_trial(const Study& study, const Store& store, int64_t shards,
                         const std::map<int64_t, fs::path>& folder_of) {
  const std::vector<bool> held = store.held(study.trial_count());
  const auto gap = std::find(held.begin(), held.end(), false);
  if (gap == held.end()) return;
  const int64_t trial = gap - held.begin();
  const auto missing = std::count(held.begin(), held.end(), false);
  throw InputError(fmt::format("{}: lacks trial {}{}; must hold every trial of shard {} of {}",
                               folder_of.at(trial % shards).string(), trial,
                               missing > 1 ? fmt::format(" ({} are missing in all)", missing) : "",
                               trial % shards, shards));
}

}  // namespace

RunResult run_study(const Study& study, const RunOptions& options) {
  if (options.is_resumed) {
    if (const std::optional<RunResult> result = complete_run(study, options)) return *result;
  }
  OutputFolder folder(options.out, OutputFolder::Leftovers::kKeep);
  Store store =
      store_for(folder, options, meta_of(study, options.shard, name_of(options.renderer.gl)));
  try {
    return run_into(folder, store, study, options);
  } catch (const Interrupted&) {
    if (!options.is_resumed) throw;
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
  Store store = Store::create(folder / kStoreFile,
                              meta_of(study, options.shard, name_of(options.renderer.gl)));
  run_jobs(study, options, folder, store);
  return summarise_store(study, store).summary;
}

RunResult merge_runs(const std::vector<fs::path>& shards, const fs::path& out,
                     const std::string& command) {
  std::vector<Meta> metas;
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
  }
  for (int64_t index = 0; index < count; ++index) {
    if (!folder_of.contains(index)) {
      throw InputError(fmt::format("merge: shard {} of {} is missing", index, count));
    }
  }

  const Study study = study_from_meta(metas.front(), shards.front() / kStoreFile);
  OutputFolder folder(out, OutputFolder::Leftovers::kKeep);
  refuse_finished_trials(folder, out);
  folder.clear();
  Store store = Store::create(folder / kStoreFile, meta_of(study, Shard{}, metas.front().at("gl")));
  for (const fs::path& shard : shards) {
    stop_if_interrupted();
    store.add_all_of(shard / kStoreFile);
  }
  require_every_trial(study, store, count, folder_of);
  Json manifest = manifest_of(study, command);
  manifest["shard"] = fmt::format("merged from {}", count);
  const RunResult result = write_results(study, store, manifest, folder);
  write_file(folder / "study.toml", study.toml);
  write_manifest(manifest, folder);
  folder.commit();
  return result;
}

RunResult rewrite_report(const fs::path& folder) {
  const fs::path file = folder / kStoreFile;
  const Store store = Store::open(file);
  const Study study = study_from_meta(store.meta(), file);
  return write_results(study, store, read_manifest(folder / "manifest.json"), folder);
}

}  // namespace sightline
