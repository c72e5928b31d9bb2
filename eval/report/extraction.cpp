// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the images gave: how often each feature was found, how well, and why it was not.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <kainjow/mustache.hpp>

#include "eval/output/numbers.h"
#include "eval/output/words.h"
#include "eval/report/figures.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

std::string reasons(const FeatureSummary& feature) {
  std::string text;
  for (const auto& [status, count] : feature.missing) {
    text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", words(status), count);
  }
  return text;
}

// A feature over all trials, whatever their condition.
mustache::data total_row(const FeatureSummary& feature) {
  return mustache::object{{"name", feature.feature},
                          {"trials", fmt::to_string(feature.trials)},
                          {"visible", count_of(feature.visible, feature.trials)},
                          {"found", count_of(feature.found, feature.trials)},
                          {"outliers", count_of(feature.outliers, feature.found)},
                          {"rms", measure(feature.inlier_rms_px)},
                          {"median", measure(feature.median_px)},
                          {"missing", reasons(feature)}};
}

mustache::data row(const FeatureSummary& feature) {
  return mustache::object{{"name", feature.feature},
                          {"visible", fmt::to_string(feature.visible)},
                          {"found", fmt::to_string(feature.found)},
                          {"outliers", count_of(feature.outliers, feature.found)},
                          {"rms", measure(feature.inlier_rms_px)},
                          {"median", measure(feature.median_px)}};
}

mustache::data condition_groups(const ReportInput& input) {
  mustache::data groups(mustache::data::type::list);
  const int conditions = static_cast<int>(input.study.conditions.size());
  for (int condition = 0; condition < conditions; ++condition) {
    mustache::data features(mustache::data::type::list);
    for (const FeatureSummary& feature : input.summary.features) {
      if (feature.condition == condition) features << row(feature);
    }
    groups << mustache::object{{"label", input.study.conditions[condition].label},
                               {"features", features}};
  }
  return groups;
}

// The program's own extractors of a set-up.
std::string own_extractors(const ImageSetup& setup) {
  std::string text;
  const auto add = [&](const FeatureExtractor* extractor, const char* what) {
    if (extractor == nullptr) return;
    text += fmt::format("{}{} ({}) for {}", text.empty() ? "" : ", ", extractor->name,
                        extractor->summary, what);
  };
  add(setup.extractors.line_intersection, "line intersections");
  add(setup.extractors.corner, "corners");
  add(setup.extractors.contour, "contours");
  if (text.empty()) return "none";
  if (setup.passes > 1) text += fmt::format("; {} passes", setup.passes);
  if (setup.bias_removal != BiasRemoval::kOff) {
    const bool is_light_known = setup.bias_removal == BiasRemoval::kKnownLight;
    const size_t all = setup.scene.target->mesh.triangles.size();
    const size_t kept = setup.bias_target->mesh.triangles.size();
    text += fmt::format(
        ". Of each the error that it makes on a rendering of the target at the pose found, {} of "
        "its {} triangles and {} light, was subtracted{}",
        kept, all, is_light_known ? "the true" : "a wrong",
        is_light_known && kept == all
            ? ": an inverse crime, which no real image allows to this degree"
            : "");
  }
  return text;
}

// Who found the features: the extractors of the first set-up, and all guests.
std::string extractor_names(const ImageStudy& images) {
  std::vector<std::string> texts;
  for (const ImageSetup& setup : images.setups) {
    if (!setup.guest && &setup != &images.setups.front()) continue;
    std::string text = setup.guest ? fmt::format("{} ({})", setup.guest->name, setup.guest->summary)
                                   : own_extractors(setup);
    if (std::find(texts.begin(), texts.end(), text) == texts.end()) {
      texts.push_back(std::move(text));
    }
  }
  return fmt::to_string(fmt::join(texts, "; "));
}

// What the lines along edges are, over all conditions; empty where there are none.
std::string text_of_lines(const ReportInput& input) {
  LineCounts all;
  for (size_t i = 0; i < input.study.conditions.size(); ++i) {
    if (input.summary.extraction) all.add(input.summary.extraction->lines(static_cast<int>(i)));
  }
  if (all.lines == 0) return "";
  const double share = static_cast<double>(all.right) / static_cast<double>(all.lines);
  return fmt::format(
      "Solvers that use lines were also given {} along edges, of which {} % lie on the image of "
      "their "
      "edge; the error of these is {} of their own sigmas, RMS.",
      counted(all.lines, "line"), number_text(100 * share, 1), number_text(all.rms_sigmas(), 2));
}

}  // namespace

std::string extraction_figure(const ReportInput& input) {
  const ImageStudy* const images = input.study.images();
  if (images == nullptr || images->features.empty()) return "";
  mustache::data features(mustache::data::type::list);
  if (const auto& extraction = input.summary.extraction) {
    for (const std::string& feature : extraction->features()) {
      features << total_row(extraction->over_all_trials(feature));
    }
  }
  return mustache::mustache(page_text("extraction.mustache"))
      .render(mustache::object{
          {"caption", fmt::format("Features over {}.", counted(trials_of(input.summary), "trial"))},
          {"features", features},
          {"outlier_px", outlier_limit_px(*images)},
          {"extractors", extractor_names(*images)},
          {"lines", text_of_lines(input)},
          {"has_conditions", input.study.conditions.size() > 1},
          {"conditions", condition_groups(input)},
      });
}

}  // namespace sightline
