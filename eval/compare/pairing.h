// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "eval/output/json.h"
#include "eval/records/records.h"
#include "eval/summary/quantities.h"

namespace sightline {

/// The mean errors that are compared.
inline const std::array kComparedErrors = {quantity("geodesic_deg"), quantity("t_error_percent")};

/// One of the two runs that are compared.
struct ComparedRun {
  std::filesystem::path path;
  Json summary;                                ///< its summary.json
  std::optional<std::filesystem::path> store;  ///< its trials; none of a summary.json alone
  std::vector<std::string> conditions;         ///< their names, by index
};

/// Reads a run's folder or a summary.json alone. Throws InputError for what is neither.
ComparedRun read_compared_run(const std::filesystem::path& path);

/// A condition of summary.json in words: "noise_px 0.5, outliers 1"; "all" of one without values.
std::string condition_name(const Json& condition);

/// A condition's name and a solver.
using CellKey = std::pair<std::string, std::string>;

/// What the trials of both runs say of one cell, trial by trial.
struct PairedCell {
  std::array<std::vector<double>, kComparedErrors.size()> base;         ///< errors, capped
  std::array<std::vector<double>, kComparedErrors.size()> differences;  ///< new minus base
  std::vector<double> failures;                                         ///< -1, 0 or 1
  int64_t base_failures = 0;
  int64_t now_failures = 0;
};

struct Pairs {
  std::map<CellKey, PairedCell> cells;
  int64_t count = 0;
  int64_t left_out = 0;  ///< of the base's up to the new run's last: a whole run has them all
  std::string why_not;   ///< in words, where there are none
};

/// Pairs the trials of the same number, where both runs have their trials and these are the same
/// draws (condition and true pose).
Pairs pair_trials(const ComparedRun& base, const ComparedRun& now);

}  // namespace sightline
