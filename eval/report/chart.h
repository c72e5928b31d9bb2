// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

/// How a chart's points are drawn. A further kind has a name here, a drawing in gnuplot.cpp (for
/// the figures) and one in assets/report/charts.js (for the page).
enum class ChartKind {
  kLines,   ///< joined, with a band from low to high
  kPoints,  ///< each with a bar from low to high
  kSteps,   ///< joined by steps: a cumulative curve
  kBoxes,   ///< a box from low to high with a line at y, whiskers from least to most
  kCells,   ///< rectangles of the chart's cell size about (x, y), coloured by value
};
/// What the page's script calls them, in the same order.
inline constexpr std::array<std::string_view, 5> kChartKindNames = {"lines", "points", "steps",
                                                                    "boxes", "cells"};

struct ChartAxis {
  std::string label;
  bool is_log = false;
  /// The ends; NaN: as the data ask for.
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::string> names = {};  ///< of the places 0, 1, ... of an axis of words
};

/// One solver's part of a chart. All vectors that are not empty are as long as x; NaN where there
/// is nothing.
struct ChartSeries {
  /// A style of its own for the bound, in ink.
  static constexpr int kInk = -1;

  std::string label;
  int style = kInk;                    ///< the solver's place in the study: the same in every chart
  bool is_from_paper = false;          ///< printed figures, as hollow marks
  std::vector<double> x = {}, y = {};  ///< what is drawn
  std::vector<double> low = {}, high = {};
  std::vector<double> least = {}, most = {};
  std::vector<double> value = {};
  std::vector<double> count = {};  ///< trials behind a point
};

/// A chart as data, which the page (by Chart.js) and the figures for papers (by gnuplot) draw.
struct Chart {
  std::string id;      ///< its file in figures/: letters, digits, hyphens
  std::string group;   ///< charts of one group stand in one place, of which a reader chooses one
  std::string option;  ///< what he chooses it by; empty where the group has one
  ChartKind kind = ChartKind::kLines;
  std::string title;
  std::string note;
  ChartAxis x, y;
  ChartAxis value;                    ///< of the colours of cells
  std::array<double, 2> cell_size{};  ///< zero of charts without cells
  std::vector<ChartSeries> series;
};

/// Okabe and Ito's hues, which the colour-blind can tell apart, for white and for dark paper. From
/// the seventh series on they come again with other dashes and marks.
inline constexpr size_t kHues = 6;
inline constexpr std::array<std::string_view, kHues> kHuesOnWhite = {
    "#00805d", "#b0418a", "#a87900", "#0072b2", "#d55e00", "#5b4bb7"};
inline constexpr std::array<std::string_view, kHues> kHuesOnDark = {
    "#3ddbaa", "#e48fc1", "#f7d046", "#6cc7f5", "#ff8a5c", "#c3b5ff"};
/// From least to most of what cells show (viridis, after S. van der Walt and N. Smith).
inline constexpr std::array<std::string_view, 5> kCellColours = {"#440154", "#3b528b", "#21918c",
                                                                 "#5ec962", "#fde725"};

/// Makes an axis logarithmic where the values on it ask for it by their range: all positive, and
/// over a factor of 30. Values below a thousandth of the greatest (errors without noise) count
/// as zero: they do not ask for anything, and lie under the axis where it is logarithmic.
void choose_scale(ChartAxis& axis, std::span<const double> values);

/// The same of the places that a sweep has on its axis, all of which must lie on it: logarithmic
/// only where none of them is zero, and with ends for all.
void choose_sweep_scale(ChartAxis& axis, std::span<const double> places);

/// The same for a chart's y, from all that it draws.
void choose_y_scale(Chart& chart);

/// All charts and the colours as JSON that can stand in a <script> element; five digits.
std::string charts_json(std::span<const Chart> charts);

/// The places of a page for charts: one a group, in order, empty until the page's script has drawn
/// them.
std::string chart_places(std::span<const Chart> charts);

}  // namespace sightline
