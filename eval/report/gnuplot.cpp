// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/gnuplot.h"

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/output/output_folder.h"
#include "eval/output/plain_text.h"
#include "scenes/files/child_process.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kInk = "#1d2126";

// In single quotes, where gnuplot takes all but the quote and the end of the line as it stands:
// what follows a line's end would be a command. Scripts switch off its markup.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : plain_line(text)) {
    out += c;
    if (c == '\'') out += c;
  }
  out += '\'';
  return out;
}

std::string gnuplot_number(double value) {
  return std::isfinite(value) ? fmt::format("{:.10g}", value) : "NaN";
}

struct Column {
  const char* name;
  std::vector<double> ChartSeries::*values;
};

constexpr Column kColumns[] = {{"x", &ChartSeries::x},         {"y", &ChartSeries::y},
                               {"low", &ChartSeries::low},     {"high", &ChartSeries::high},
                               {"least", &ChartSeries::least}, {"most", &ChartSeries::most},
                               {"value", &ChartSeries::value}, {"trials", &ChartSeries::count}};

std::string axis_script(const char* name, const ChartAxis& axis) {
  std::string script = fmt::format("set {}label {}\n", name, quoted(axis.label));
  if (axis.is_log) script += fmt::format("set logscale {}\n", name);
  if (!axis.names.empty()) {
    std::vector<std::string> places;
    for (size_t i = 0; i < axis.names.size(); ++i) {
      places.push_back(fmt::format("{} {}", quoted(axis.names[i]), i));
    }
    script +=
        fmt::format("set {}tics rotate by -30 ({})\nset {}range [-0.5:{}]\n", name,
                    fmt::join(places, ", "), name, static_cast<double>(axis.names.size()) - 0.5);
  } else if (!std::isnan(axis.low) || !std::isnan(axis.high)) {
    script += fmt::format("set {}range [{}:{}]\n", name,
                          std::isnan(axis.low) ? "*" : gnuplot_number(axis.low),
                          std::isnan(axis.high) ? "*" : gnuplot_number(axis.high));
  }
  return script;
}

std::string_view colour_of(const ChartSeries& series) {
  return series.style < 0 ? kInk : kHuesOnWhite[series.style % kHues];
}

// What tells apart series of one hue.
int turn_of(const ChartSeries& series) {
  return series.style < 0 ? 1 : series.style / static_cast<int>(kHues);
}

std::string line_style(const ChartSeries& series) {
  return fmt::format("dt {} lw 1.5 lc rgb '{}'", turn_of(series) + 1, colour_of(series));
}

std::string mark_style(const ChartSeries& series) {
  constexpr int kMarks[] = {7, 9, 5, 13};
  constexpr int kHollow = 6;
  return fmt::format("pt {} ps 0.5", series.is_from_paper ? kHollow : kMarks[turn_of(series) % 4]);
}

std::string point_style(const ChartSeries& series) {
  return fmt::format("{} lc rgb '{}'", mark_style(series), colour_of(series));
}

std::string title_of(const ChartSeries& series) {
  return "title " + quoted(series.label);
}

using Clauses = std::vector<std::string>;

// The clauses that draw a series of each kind; `data` is its block.

Clauses draw_lines(const Chart&, const ChartSeries& series, const std::string& data) {
  Clauses parts;
  if (!series.low.empty()) {
    parts.push_back(fmt::format(
        "{} using 1:3:4 with filledcurves fs transparent solid 0.15 noborder lc rgb '{}' notitle",
        data, colour_of(series)));
  }
  parts.push_back(fmt::format("{} using 1:2 with linespoints {} {} {}", data, line_style(series),
                              mark_style(series), title_of(series)));
  return parts;
}

Clauses draw_points(const Chart&, const ChartSeries& series, const std::string& data) {
  const char* how = series.low.empty() ? "1:2 with points" : "1:2:3:4 with yerrorbars";
  return {fmt::format("{} using {} {} {}", data, how, point_style(series), title_of(series))};
}

Clauses draw_steps(const Chart&, const ChartSeries& series, const std::string& data) {
  return {fmt::format("{} using 1:2 with steps {} {}", data, line_style(series), title_of(series))};
}

Clauses draw_boxes(const Chart&, const ChartSeries& series, const std::string& data) {
  const std::string colour = fmt::format("lc rgb '{}'", colour_of(series));
  return {fmt::format("{0} using 1:3:5:6:4 with candlesticks whiskerbars 0.5 {1} fs transparent "
                      "solid 0.25 border {1} notitle",
                      data, colour),
          fmt::format("{} using 1:2:2:2:2 with candlesticks {} lw 2 notitle", data, colour)};
}

Clauses draw_cells(const Chart& chart, const ChartSeries&, const std::string& data) {
  return {fmt::format(
      "{} using 1:2:($1-{}):($1+{}):($2-{}):($2+{}):7 with boxxyerror fs solid noborder lc "
      "palette notitle",
      data, chart.cell_size[0] / 2, chart.cell_size[0] / 2, chart.cell_size[1] / 2,
      chart.cell_size[1] / 2)};
}

std::string colour_script(const Chart& chart) {
  Clauses colours;
  for (size_t i = 0; i < kCellColours.size(); ++i) {
    colours.push_back(fmt::format("{} '{}'", i, kCellColours[i]));
  }
  return fmt::format("set palette defined ({})\nset style data boxxyerror\n",
                     fmt::join(colours, ", ")) +
         axis_script("cb", chart.value);
}

// How gnuplot draws a kind of chart.
struct KindDrawing {
  bool has_key;  // or else names on an axis, and places half as wide as those
  Clauses (*clauses)(const Chart& chart, const ChartSeries& series, const std::string& data);
  std::string (*further_settings)(const Chart& chart) = nullptr;
};

// In the order of ChartKind.
constexpr std::array<KindDrawing, kChartKindNames.size()> kDrawings = {
    {{true, draw_lines},
     {true, draw_points},
     {true, draw_steps},
     {false, draw_boxes},
     {false, draw_cells, colour_script}}};

// Runs gnuplot over scripts in a folder; its exit code.
int run_gnuplot(const fs::path& folder, std::span<const Chart> charts) {
  std::vector<std::string> arguments = {"gnuplot"};
  for (const Chart& chart : charts) arguments.push_back(chart.id + ".gp");
  return run_program(std::move(arguments), folder);
}

}  // namespace

std::string gnuplot_data(const Chart& chart) {
  std::string text;
  for (const ChartSeries& series : chart.series) {
    text += fmt::format("{}# {}{}\n#", text.empty() ? "" : "\n\n", plain_line(series.label),
                        series.is_from_paper ? " (paper)" : "");
    for (const Column& column : kColumns) text += fmt::format(" {}", column.name);
    text += '\n';
    for (size_t i = 0; i < series.x.size(); ++i) {
      const char* separator = "";
      for (const Column& column : kColumns) {
        const std::vector<double>& values = series.*column.values;
        text += separator;
        text += values.empty() ? "NaN" : gnuplot_number(values[i]);
        separator = " ";
      }
      text += '\n';
    }
  }
  return text;
}

std::string gnuplot_script(const Chart& chart) {
  const KindDrawing& drawing = kDrawings[static_cast<size_t>(chart.kind)];
  std::string script = fmt::format(
      "# Draws {0}.svg from {0}.dat: gnuplot {0}.gp\nreset\nset encoding utf8\n"
      "set terminal svg size 640,420 noenhanced font 'Helvetica,Arial,sans-serif,13' "
      "background '#ffffff'\nset output '{0}.svg'\nset title {1}\nset border 3\n"
      "set tics nomirror out\nset grid lc rgb '#d9dad4'\n",
      chart.id,
      quoted(chart.option.empty() ? chart.title : chart.title + " (" + chart.option + ")"));
  script += drawing.has_key ? "set key outside right noenhanced\n" : "set boxwidth 0.5\n";
  script += axis_script("x", chart.x) + axis_script("y", chart.y);
  if (drawing.further_settings != nullptr) script += drawing.further_settings(chart);
  std::vector<std::string> all;
  for (size_t i = 0; i < chart.series.size(); ++i) {
    const std::string data = fmt::format("'{}.dat' index {}", chart.id, i);
    for (std::string& clause : drawing.clauses(chart, chart.series[i], data)) {
      all.push_back(std::move(clause));
    }
  }
  return script + fmt::format("plot {}\nset output\n", fmt::join(all, ", \\\n  "));
}

std::string write_figures(const fs::path& folder, std::span<const Chart> charts) {
  if (charts.empty()) return "";
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw InputError(fmt::format("{}: cannot be written ({})", folder.string(), error.message()));
  }
  for (const Chart& chart : charts) {
    fs::remove(folder / (chart.id + ".svg"), error);  // gnuplot would write through a link
    write_file(folder / (chart.id + ".dat"), gnuplot_data(chart));
    write_file(folder / (chart.id + ".gp"), gnuplot_script(chart));
  }
  const std::string name = plain_line(folder.string());
  switch (run_gnuplot(folder, charts)) {
    case 0:
      return "";
    case kProgramNotFound:
      return fmt::format("gnuplot is not installed: {} holds scripts and data, but no .svg", name);
    default:
      return fmt::format("gnuplot failed: {} holds scripts and data, and not every .svg", name);
  }
}

}  // namespace sightline
