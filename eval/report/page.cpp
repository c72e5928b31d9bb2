// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/page.h"

#include <kainjow/mustache.hpp>

#include "eval/report/page_text.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

}  // namespace

std::string render_page(const Page& page) {
  mustache::data sections(mustache::data::type::list);
  std::vector<Chart> charts;
  for (const PageSection& section : page.sections) {
    const std::string html = chart_places(section.charts) + section.html;
    if (html.empty()) continue;
    charts.insert(charts.end(), section.charts.begin(), section.charts.end());
    sections << mustache::object{{"name", section.name}, {"title", section.title}, {"html", html}};
  }
  mustache::mustache text(page_text("page.mustache"));
  return text.render(mustache::object{
      {"css", page_text("page.css")},
      {"chart_js", page_text("chart_licence.js") + page_text("chart.js")},
      {"chart_data", charts_json(charts)},
      {"js", page_text("page.js") + page_text("charts.js") + page_text("explorer.js")},
      {"title", page.title},
      {"given", page.given_html},
      {"has_warning", !page.warning.empty()},
      {"warning", page.warning},
      {"figures", sections},
  });
}

}  // namespace sightline
