// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <opencv2/core/types.hpp>

#include "eval/records/records.h"
#include "eval/report/chart.h"
#include "eval/study/study.h"
#include "eval/summary/summary.h"
#include "eval/trial/image_trial.h"

namespace sightline {

/// The target's outline in a pose, closed polygons in pixels (eval/report/outline.h).
using Outline = std::vector<std::vector<Eigen::Vector2d>>;

/// The part of an image that a report shows, as a PNG in a data: URL. Empty where a trial could not
/// be imaged.
struct FramePicture {
  std::string png_url;
  cv::Rect pixels;    ///< of the image, that it shows
  int reduction = 1;  ///< pixels of the image to one of the picture, each way
  cv::Size image;
};

/// A registration's model and what it leaves of the image, as PNGs in data: URLs, and the part of
/// the image that they cover.
struct ResidualPicture {
  std::string solver;
  std::string model_url, residual_url;
  cv::Rect pixels;
};

/// One frame as the report shows it: the run's record of a trial, whose numbers are stated, the
/// same trial run again for its picture (its images are let go), and the target's outline as each
/// solver's pose in that picture (by the solver's name; absent where it failed) would draw it.
/// Chosen by gather_evidence (eval/report/evidence.h).
struct FrameEvidence {
  std::string caption;  ///< "pose 1, draw 1" or "worst of ORPE"; says if the two records differ
  TrialRecord stored;
  Trial trial;
  FramePicture picture;
  std::map<std::string, Outline> outlines;
  std::optional<ResidualPicture> residual = {};  ///< of the first registration that has a pose
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
  /// The figure's HTML (may hold inline SVG), null where it has none; empty where it does not apply
  /// to the study.
  std::string (*html)(const ReportInput& input);
  /// What stands above it; null where it has none; empty where none applies.
  std::vector<Chart> (*charts)(const ReportInput& input) = nullptr;
};

std::span<const ReportFigure> report_figures();

/// The charts of all figures, in the order of the page.
std::vector<Chart> report_charts(const ReportInput& input);

/// The whole page: one self-contained HTML file that opens from disk without a network.
std::string render_report(const ReportInput& input);

}  // namespace sightline
