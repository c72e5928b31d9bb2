// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "eval/run/run.h"

namespace sightline {

/// Joins the folders of shards into one, as if one process had run the study. Throws InputError for
/// shards of different studies, versions or counts, and for missing and double shards.
RunResult merge_runs(const std::vector<std::filesystem::path>& shards,
                     const std::filesystem::path& out, const std::string& command);

}  // namespace sightline
