// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/report.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <kainjow/mustache.hpp>

#include "eval/report/chart_js.h"
#include "eval/report/figures.h"
#include "eval/report/means.h"
#include "eval/report/text.h"
#include "scenes/assets.h"
#include "scenes/input_error.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

// In the order of the page.
constexpr std::array kFigures = {
    ReportFigure{"answer", "Answer", answer_figure},
    ReportFigure{"sweep", "Errors by condition", sweep_figure, sweep_charts},
    ReportFigure{"table", "Pose errors", table_figure},
    ReportFigure{"cumulative", "Cumulative errors", nullptr, cumulative_charts},
    ReportFigure{"boxes", "Spread of the errors", nullptr, boxes_charts},
    ReportFigure{"paired", "Differences on the same trials", nullptr, paired_charts},
    ReportFigure{"angles", "Errors by attitude", nullptr, angles_charts},
    ReportFigure{"extraction", "Feature extraction", extraction_figure},
    ReportFigure{"frames", "Frames", frames_figure},
    ReportFigure{"provenance", "Provenance and definitions", provenance_figure},
};

std::filesystem::path page_file(const std::string& name) {
  return assets_folder() / "report" / name;
}

std::string read_page_file(const std::string& name) {
  std::ifstream file(page_file(name), std::ios::binary);
  if (!file) {
    throw InputError(
        fmt::format("{}: cannot read this part of the report's page (it comes with "
                    "the program; the variable SIGHTLINE_ASSETS moves the folder)",
                    page_file(name).string()));
  }
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<Chart> charts_of(const ReportFigure& figure, const ReportInput& input) {
  return figure.charts == nullptr ? std::vector<Chart>() : figure.charts(input);
}

mustache::data figure_sections(const ReportInput& input, std::vector<Chart>& all_charts) {
  mustache::data sections(mustache::data::type::list);
  for (const ReportFigure& figure : report_figures()) {
    std::vector<Chart> charts = charts_of(figure, input);
    std::string html = chart_places(charts);
    if (figure.html != nullptr) html += figure.html(input);
    std::move(charts.begin(), charts.end(), std::back_inserter(all_charts));
    if (html.empty()) continue;
    sections << mustache::object{
        {"name", std::string(figure.name)}, {"title", std::string(figure.title)}, {"html", html}};
  }
  return sections;
}

std::string version(const ReportInput& input) {
  const auto found = input.meta.find("version");
  return found == input.meta.end() ? "" : found->second;
}

}  // namespace

std::span<const ReportFigure> report_figures() {
  return kFigures;
}

std::vector<Chart> report_charts(const ReportInput& input) {
  std::vector<Chart> all;
  for (const ReportFigure& figure : report_figures()) {
    std::vector<Chart> charts = charts_of(figure, input);
    std::move(charts.begin(), charts.end(), std::back_inserter(all));
  }
  return all;
}

std::string render_report(const ReportInput& input) {
  mustache::mustache page(read_page_file("page.html"));
  if (!page.is_valid()) {
    throw InputError(fmt::format("{}: {}", page_file("page.html").string(), page.error_message()));
  }
  const Study& study = input.study;
  std::vector<Chart> charts;
  const mustache::data figures = figure_sections(input, charts);
  return page.render(mustache::object{
      {"css", read_page_file("page.css")},
      {"chart_js", chart_js()},
      {"chart_data", charts_json(charts)},
      {"js",
       read_page_file("page.js") + read_page_file("charts.js") + read_page_file("explorer.js")},
      {"title", study.title.empty() ? study.name : study.title},
      {"study", study.name},
      {"has_reference", !study.reference.empty()},
      {"reference", study.reference},
      {"trials", counted(trials_of(input.summary), "trial")},
      {"seed", fmt::to_string(study.seed)},
      {"has_version", !version(input).empty()},
      {"version", version(input)},
      {"figures", figures},
  });
}

}  // namespace sightline
