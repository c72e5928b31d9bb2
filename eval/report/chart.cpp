// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/chart.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "eval/output/html.h"

namespace sightline {
namespace {

using nlohmann::ordered_json;

constexpr double kLogFactor = 30;
constexpr double kZeroFraction = 1e-3;

// Five digits: beyond what a screen can show, and most of a page's bytes are such numbers.
ordered_json number(double value) {
  if (!std::isfinite(value)) return nullptr;
  return std::strtod(fmt::format("{:.5g}", value).c_str(), nullptr);
}

void add_numbers(ordered_json& object, const char* key, const std::vector<double>& values) {
  if (values.empty()) return;
  ordered_json& list = object[key] = ordered_json::array();
  for (const double value : values) list.push_back(number(value));
}

ordered_json json_of(const ChartAxis& axis) {
  ordered_json json = {{"label", axis.label}, {"log", axis.is_log}};
  if (!std::isnan(axis.low)) json["low"] = axis.low;
  if (!std::isnan(axis.high)) json["high"] = axis.high;
  if (!axis.names.empty()) json["names"] = axis.names;
  return json;
}

ordered_json json_of(const ChartSeries& series) {
  ordered_json json = {{"label", series.label}, {"style", series.style}};
  if (series.is_from_paper) json["paper"] = true;
  add_numbers(json, "x", series.x);
  add_numbers(json, "y", series.y);
  add_numbers(json, "low", series.low);
  add_numbers(json, "high", series.high);
  add_numbers(json, "least", series.least);
  add_numbers(json, "most", series.most);
  add_numbers(json, "value", series.value);
  add_numbers(json, "count", series.count);
  return json;
}

ordered_json json_of(const Chart& chart) {
  ordered_json json = {
      {"id", chart.id},         {"group", chart.group},
      {"option", chart.option}, {"kind", kChartKindNames[static_cast<size_t>(chart.kind)]},
      {"title", chart.title},   {"x", json_of(chart.x)},
      {"y", json_of(chart.y)}};
  if (chart.cell_size[0] > 0) {
    json["value"] = json_of(chart.value);
    json["cell"] = {number(chart.cell_size[0]), number(chart.cell_size[1])};
  }
  json["series"] = ordered_json::array();
  for (const ChartSeries& series : chart.series) json["series"].push_back(json_of(series));
  return json;
}

std::string spoken(const Chart& chart) {
  const std::string_view x = chart.x.label;
  return fmt::format("Chart: {}{}{}. Its data follow as a table.", chart.title,
                     x.empty() ? "" : ", against ", x);
}

}  // namespace

void choose_scale(ChartAxis& axis, std::span<const double> values) {
  double most = 0;
  for (const double value : values) {
    if (value < 0) return;
    if (std::isfinite(value)) most = std::max(most, value);
  }
  double least = most;
  for (const double value : values) {
    if (value > kZeroFraction * most) least = std::min(least, value);
  }
  if (!(most > kLogFactor * least)) return;
  axis.is_log = true;
  axis.low = std::pow(10, std::floor(std::log10(least)));
}

void choose_sweep_scale(ChartAxis& axis, std::span<const double> places) {
  choose_scale(axis, places);
  if (!axis.is_log) return;
  // The axis finds its end itself: a power of ten may lie far below.
  axis.low = std::numeric_limits<double>::quiet_NaN();
  axis.is_log = std::ranges::all_of(places, [](double place) { return place > 0; });
}

void choose_y_scale(Chart& chart) {
  std::vector<double> values;
  for (const ChartSeries& series : chart.series) {
    for (const auto* part : {&series.y, &series.low, &series.high, &series.least, &series.most}) {
      values.insert(values.end(), part->begin(), part->end());
    }
  }
  choose_scale(chart.y, values);
}

std::string charts_json(std::span<const Chart> charts) {
  ordered_json json = {{"hues", {{"light", kHuesOnWhite}, {"dark", kHuesOnDark}}},
                       {"cells", kCellColours},
                       {"charts", ordered_json::array()}};
  for (const Chart& chart : charts) json["charts"].push_back(json_of(chart));
  return script_json(json.dump());
}

std::string chart_places(std::span<const Chart> charts) {
  std::string html;
  std::set<std::string> seen;
  for (const Chart& chart : charts) {
    if (!seen.insert(chart.group).second) continue;
    html += fmt::format(
        R"html(<figure class="chart" data-group="{}"><figcaption>{}</figcaption>
<div class="plot"><canvas role="img" aria-label="{}"></canvas></div>
{}</figure>
)html",
        chart.group, escape_html(chart.title), escape_html(spoken(chart)),
        chart.note.empty() ? ""
                           : fmt::format("<p class=\"note\">{}</p>\n", escape_html(chart.note)));
  }
  return html.empty() ? "" : "<div class=\"charts\">\n" + html + "</div>\n";
}

}  // namespace sightline
