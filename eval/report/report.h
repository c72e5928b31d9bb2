// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "eval/records.h"
#include "eval/study.h"
#include "eval/summary.h"
#include "eval/trial.h"

namespace sightline {

/// The target's outline in a pose, closed polygons in pixels (eval/report/outline.h).
using Outline = std::vector<std::vector<Eigen::Vector2d>>;

/// One frame as the report shows it: the run's record of a trial, whose numbers are stated, the
/// same trial run again for its picture, and the target's outline as each solver's pose in that
/// picture (by the solver's name; absent where it failed) would draw it. Chosen by gather_evidence
/// (eval/report/evidence.h).
struct FrameEvidence {
  std::string caption;  ///< "pose 1, draw 1" or "worst of ORPE"; says if the two records differ
  TrialRecord stored;
  Trial trial;
  std::map<std::string, Outline> outlines;
};

/// All that a figure may draw.
struct ReportInput {
  const Study& study;
  const Summary& summary;
  std::span<const TrialRecord> trials;  ///< of a study with images; of others none
  std::span<const FrameEvidence> frames;
  std::map<std::string, std::string> meta;  ///< version, seed, command, machine: the manifest
};

/// A figure of the report. To add one: write eval/report/<name>.cpp with a function of this
/// signature, declare it in eval/report/figures.h, give it a line in the catalogue
/// (eval/report/report.cpp). Everything that a page loads stands in the page: no addresses.
struct ReportFigure {
  std::string_view name;  ///< its anchor in the page
  std::string_view title;
  /// The figure's HTML (may hold inline SVG); empty where it does not apply to the study.
  std::string (*html)(const ReportInput& input);
};

std::span<const ReportFigure> report_figures();

/// The whole page: one self-contained HTML file that opens from disk without a network. Throws
/// InputError when assets/report/ cannot be read.
std::string render_report(const ReportInput& input);

}  // namespace sightline
