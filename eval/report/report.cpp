// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/report.h"

#include <array>
#include <iterator>

#include <fmt/format.h>

#include "eval/output/html.h"
#include "eval/output/numbers.h"
#include "eval/report/figures.h"
#include "eval/report/means.h"
#include "eval/report/page.h"
#include "eval/tables/result_table.h"

namespace sightline {
namespace {

// In the order of the page.
constexpr std::array kFigures = {
    ReportFigure{"answer", "Answer", answer_figure},
    ReportFigure{"sweep", "Errors by condition", sweep_figure, sweep_charts},
    ReportFigure{"table", "Pose errors", table_figure},
    ReportFigure{"cumulative", "Cumulative errors", nullptr, cumulative_charts},
    ReportFigure{"boxes", "Spread of the errors", nullptr, boxes_charts},
    ReportFigure{"paired", "Differences on the same trials", nullptr, paired_charts},
    ReportFigure{"angles", "Errors by attitude", nullptr, angles_charts},
    ReportFigure{"ladder", "From the image to the pose", ladder_figure},
    ReportFigure{"diagnosis", "What the solvers said themselves", diagnosis_figure},
    ReportFigure{"extraction", "Feature extraction", extraction_figure},
    ReportFigure{"silhouette", "Outline beside the features", silhouette_figure},
    ReportFigure{"frames", "Frames", frames_figure},
    ReportFigure{"provenance", "Provenance and definitions", provenance_figure},
};

std::vector<Chart> charts_of(const ReportFigure& figure, const ReportInput& input) {
  return figure.charts == nullptr ? std::vector<Chart>() : figure.charts(input);
}

// "Study x (Table 1): 400 trials, seed 1, version 0.1."
std::string given_html(const ReportInput& input) {
  const Study& study = input.study;
  const auto version = input.meta.find("version");
  return fmt::format(
      "Study <code>{}</code>{}: {}, seed {}{}.", escape_html(study.name),
      study.reference.empty() ? "" : fmt::format(" ({})", escape_html(study.reference)),
      counted(trials_of(input.summary), "trial"), study.seed,
      version == input.meta.end() ? "" : ", version " + escape_html(version->second));
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
  const Study& study = input.study;
  Page page{study.title.empty() ? study.name : study.title,
            given_html(input),
            repeat_warning(input.summary),
            {}};
  for (const ReportFigure& figure : report_figures()) {
    page.sections.push_back({std::string(figure.name), std::string(figure.title),
                             figure.html == nullptr ? "" : figure.html(input),
                             charts_of(figure, input)});
  }
  return render_page(page);
}

}  // namespace sightline
