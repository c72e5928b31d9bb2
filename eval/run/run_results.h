// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is made from the trials of a run once they are all there.
#pragma once

#include <filesystem>

#include <nlohmann/json.hpp>

#include "eval/results/store.h"
#include "eval/run/run.h"
#include "eval/study/study.h"

namespace sightline {

/// What a store's trials say.
RunResult summarise_store(const Study& study, const Store& store);

/// Writes everything that is made from the trials into a folder: results.csv, summary.json,
/// timings.csv where times are taken, outliers.json of a study of images, the report, the figures.
RunResult write_results(const Study& study, const Store& store, const nlohmann::json& manifest,
                        const std::filesystem::path& folder);

}  // namespace sightline
