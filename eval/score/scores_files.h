// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What `sightline score` writes besides its page and targets.csv: two files and a table for the
// terminal.
#pragma once

#include <iosfwd>
#include <span>
#include <string>

#include "eval/score/score.h"
#include "eval/score/targets_file.h"

namespace sightline {

/// scores.json: the summary of all targets, then that of each object's.
std::string scores_json(const ScoredResults& scored);

/// errors.csv: a row a target and estimate of it that counts; a target without any has one row
/// without numbers.
void write_errors_csv(const ScoredResults& scored, std::ostream& out);

/// The scores.json of several methods: that of each, with its name, in a list.
std::string scores_json(std::span<const MethodScores> methods);

/// The summaries as a table: all targets, then each object's where there are several; of several
/// methods those of each.
std::string score_table(std::span<const MethodScores> methods);

}  // namespace sightline
