// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "eval/compare/measures.h"
#include "eval/compare/run_numbers.h"
#include "eval/output/json.h"

namespace sightline {

/// In place of a solver: what the images of a condition gave, whatever the solver.
inline constexpr const char* kFeatures = "features";

/// One of the two runs that are compared.
struct ComparedRun {
  std::filesystem::path path;
  Json summary;                                ///< its summary.json
  std::optional<std::filesystem::path> store;  ///< its trials; none of a summary.json alone
  std::optional<std::string> toml;             ///< its study as run, where that is known
  std::vector<std::string> conditions;         ///< their names, by index

  Subject subject() const;
};

/// Reads a run's folder or a summary.json alone. Throws InputError for what is neither.
ComparedRun read_compared_run(const std::filesystem::path& path);

/// A condition of summary.json in words: "noise_px 0.5, outliers 1"; "all" of one without values.
std::string condition_name(const Json& condition);

/// A condition's name and a solver.
using CellKey = std::pair<std::string, std::string>;

/// What each pair of trials of a cell has of one number.
struct PairedNumber {
  std::vector<Share> base;
  std::vector<Share> now;
};

/// What the trials of both runs say of one cell, by the number's name.
using PairedCell = std::map<std::string, PairedNumber>;

struct Pairs {
  std::map<CellKey, PairedCell> cells;
  int64_t count = 0;
  int64_t left_out = 0;  ///< of the base's up to the new run's last: a whole run has them all
  std::string why_not;   ///< in words, where there are none
};

/// Pairs the trials of the same number, where both runs have their trials and these are the same
/// draws (condition and true pose), and takes from them what the measures need.
Pairs pair_trials(const ComparedRun& base, const ComparedRun& now,
                  std::span<const Measure> measures);

}  // namespace sightline
