// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "eval/study/study.h"
#include "eval/summary/summary.h"

namespace sightline {

/// The study's result as a table for the terminal, UTF-8, at most 100 columns wide, one row a
/// condition. A block each for theta_error and T_error: every solver's mean with its interval, the
/// paper's figures beside it where it prints any (else the median), and the Cramér-Rao bound; then
/// how the solvers dealt with outliers, and what the extraction gave. Solvers that do not fit
/// beside each other stand in further blocks. Of a study without images the tables of its sweep
/// (eval/tables/sweep_table.h) stand instead. What does not apply or is not finite is '-'; means
/// over conditions are of those that have trials.
std::string to_table(const Study& study, const Summary& summary);

/// What a reader must know of trials that are an earlier one again; empty where none is.
std::string repeat_warning(const Summary& summary);

}  // namespace sightline
