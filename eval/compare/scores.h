// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "eval/compare/compare.h"

namespace sightline {

/// Whether a path is what `score` leaves: its folder, or a targets.csv (any .csv) alone.
bool is_of_scores(const std::filesystem::path& path);

/// Compares the scores of two sets of estimates target by target, as compare_runs does with trials:
/// a method with the one of its name or, where both have one alone, with that; all targets
/// together ("all") and, where there are several objects, those of each. Throws InputError for what
/// cannot be read, and for scores of another data set.
Comparison compare_scores(const std::filesystem::path& base, const std::filesystem::path& now,
                          double tolerance, const std::vector<std::string>& measures);

}  // namespace sightline
