// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "eval/report/chart.h"

namespace sightline {

/// A chart's numbers: a block a series, two empty lines between, a comment naming the columns.
std::string gnuplot_data(const Chart& chart);

/// The script that draws a chart's data file (<id>.dat) as <id>.svg, run in their folder.
std::string gnuplot_script(const Chart& chart);

/// Writes data and script of every chart into a folder, which it makes, and runs gnuplot over them.
/// Returns what a user should know, one line, where there is no gnuplot or it fails: scripts and
/// data stand then all the same. Empty otherwise. Throws InputError when the folder cannot be
/// written.
std::string write_figures(const std::filesystem::path& folder, std::span<const Chart> charts);

}  // namespace sightline
