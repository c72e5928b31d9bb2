// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the folder of a run holds, by name; what identifies a run; and what an ended run left for
// another to continue.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "eval/output/output_folder.h"
#include "eval/results/store.h"
#include "eval/run/run.h"
#include "eval/study/study.h"
#include "eval/work/shard.h"

namespace sightline {

inline constexpr const char* kStoreFile = "results.sqlite";
inline constexpr const char* kReportFile = "report.html";
inline constexpr const char* kOutliersFile = "outliers.json";
/// The stores of a run's processes, until they are joined: "job-0.sqlite", ...
inline constexpr std::string_view kJobPrefix = "job-";

/// Keys and values of a store that say which run it is of.
using RunMeta = std::map<std::string, std::string>;

/// What identifies a run: kept in its store, so that merge can tell what belongs together.
RunMeta meta_of(const Study& study, const Shard& shard, GlChoice gl);
RunMeta meta_of(const Study& study, const RunOptions& options);

/// The study that a store is of. Throws InputError, naming `file`, where it says none.
Study study_from_meta(const RunMeta& meta, const std::filesystem::path& file);

/// Refuses, by an InputError, to continue a run that is not the one which is asked for.
void require_same_run(const RunMeta& there, const RunMeta& asked,
                      const std::filesystem::path& file);

/// The stores of the processes that share a run's work.
std::vector<std::filesystem::path> job_files(const std::filesystem::path& staging);

/// Refuses, by an InputError, to write where an ended run left finished trials, and keeps them.
void refuse_finished_trials(OutputFolder& folder, const std::filesystem::path& out);

/// The store of the run: a new one, or what an ended run left.
Store store_for(OutputFolder& folder, const RunOptions& options, const RunMeta& meta);

/// To be called where the work fails: keeps what is finished, and returns the words for that.
std::string keep_finished(OutputFolder& folder);

}  // namespace sightline
