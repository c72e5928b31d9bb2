// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/page.h"

#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <kainjow/mustache.hpp>

#include "eval/report/chart_js.h"
#include "scenes/files/assets.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

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

}  // namespace

std::string render_page(const Page& page) {
  mustache::mustache text(read_page_file("page.html"));
  if (!text.is_valid()) {
    throw InputError(fmt::format("{}: {}", page_file("page.html").string(), text.error_message()));
  }
  mustache::data sections(mustache::data::type::list);
  std::vector<Chart> charts;
  for (const PageSection& section : page.sections) {
    const std::string html = chart_places(section.charts) + section.html;
    if (html.empty()) continue;
    charts.insert(charts.end(), section.charts.begin(), section.charts.end());
    sections << mustache::object{{"name", section.name}, {"title", section.title}, {"html", html}};
  }
  return text.render(mustache::object{
      {"css", read_page_file("page.css")},
      {"chart_js", chart_js()},
      {"chart_data", charts_json(charts)},
      {"js",
       read_page_file("page.js") + read_page_file("charts.js") + read_page_file("explorer.js")},
      {"title", page.title},
      {"given", page.given_html},
      {"has_warning", !page.warning.empty()},
      {"warning", page.warning},
      {"figures", sections},
  });
}

}  // namespace sightline
