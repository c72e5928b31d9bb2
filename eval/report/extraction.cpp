// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the images gave: how often each feature was found, how well, and why it was not.
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include <fmt/format.h>
#include <kainjow/mustache.hpp>

#include "eval/output/text.h"
#include "eval/report/figures.h"
#include "eval/statistics/statistics.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

// One table for all trials and, with several conditions, one for each: the same columns.
constexpr const char* kExtractionTemplate = R"html(
<div class="scroll" role="region" aria-label="Feature extraction, table" tabindex="0">
<table>
<caption><span>{{caption}}</span></caption>
<thead><tr><th scope="col">Feature</th><th scope="col">trials</th><th scope="col">visible</th>
<th scope="col">found</th><th scope="col">outliers among them</th><th scope="col">inlier RMS,
px</th>
<th scope="col">median error, px</th><th scope="col" class="text">why it was
missing</th></tr></thead>
<tbody>
{{#features}}
<tr><th
scope="row">{{name}}</th><td>{{trials}}</td><td>{{visible}}</td><td>{{found}}</td>
<td>{{outliers}}</td>
<td>{{rms}}</td><td>{{median}}</td><td class="text reasons">{{missing}}</td></tr>
{{/features}}
</tbody>
</table>
</div>
<p class="note">An outlier is a feature found farther than {{outlier_px}} px from the truth. Inlier
RMS is that
of a coordinate; the median is of the distances of all that were found. The extractors:
{{extractors}}.</p>
{{#has_conditions}}
<details>
<summary>The same for each condition</summary>
<div class="scroll" role="region" aria-label="Feature extraction by condition, table" tabindex="0">
<table>
<caption><span>Features by condition.</span></caption>
<thead><tr><th scope="col">Feature</th><th scope="col">visible</th><th scope="col">found</th>
<th scope="col">outliers among them</th><th scope="col">inlier RMS, px</th>
<th scope="col">median error, px</th></tr></thead>
{{#conditions}}
<tbody>
<tr class="groupname"><th scope="rowgroup" colspan="6">{{label}}</th></tr>
{{#features}}
<tr><th
scope="row">{{name}}</th><td>{{visible}}</td><td>{{found}}</td><td>{{outliers}}</td><td>{{rms}}</td>
<td>{{median}}</td></tr>
{{/features}}
</tbody>
{{/conditions}}
</table>
</div>
</details>
{{/has_conditions}}
)html";

// A feature over all trials, whatever their condition.
struct FeatureTotals {
  int64_t trials = 0;
  int64_t visible = 0;
  int64_t outliers = 0;
  double inlier_squares_px2 = 0;
  std::vector<double> errors_px;       // of the found ones
  std::map<std::string, int> missing;  // by reason
};

void add(FeatureTotals& totals, const ObservationRecord& observation) {
  ++totals.trials;
  if (observation.is_visible) ++totals.visible;
  if (!observation.is_found()) {
    ++totals.missing[words(to_string(observation.status))];
    return;
  }
  totals.errors_px.push_back(observation.error_px);
  if (observation.is_outlier) {
    ++totals.outliers;
  } else {
    totals.inlier_squares_px2 += observation.error_px * observation.error_px;
  }
}

std::vector<std::pair<std::string, FeatureTotals>> totals_of(const ReportInput& input) {
  std::vector<std::pair<std::string, FeatureTotals>> all;
  for (const int feature : input.study.features) {
    all.emplace_back(input.study.target->features[feature].name, FeatureTotals{});
  }
  for (const TrialRecord& trial : input.trials) {
    for (const ObservationRecord& observation : trial.observations()) {
      for (auto& [name, totals] : all) {
        if (name == observation.feature) add(totals, observation);
      }
    }
  }
  return all;
}

std::string reasons(const FeatureTotals& totals) {
  std::string text;
  for (const auto& [reason, count] : totals.missing) {
    text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", reason, count);
  }
  return text;
}

mustache::data row(const std::string& name, const FeatureTotals& totals) {
  const auto found = static_cast<int64_t>(totals.errors_px.size());
  const double inliers = static_cast<double>(found - totals.outliers);
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  const double rms = inliers > 0 ? std::sqrt(totals.inlier_squares_px2 / (2 * inliers)) : nothing;
  const double median = found > 0 ? percentile(totals.errors_px, 0.5) : nothing;
  return mustache::object{{"name", name},
                          {"trials", fmt::to_string(totals.trials)},
                          {"visible", count_of(totals.visible, totals.trials)},
                          {"found", count_of(found, totals.trials)},
                          {"outliers", count_of(totals.outliers, found)},
                          {"rms", measure(rms)},
                          {"median", measure(median)},
                          {"missing", reasons(totals)}};
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

std::string extractor_names(const ImageSetup& setup) {
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

}  // namespace

std::string extraction_figure(const ReportInput& input) {
  if (input.study.kind != StudyKind::kImages || input.study.features.empty()) return "";
  mustache::data features(mustache::data::type::list);
  for (const auto& [name, totals] : totals_of(input)) features << row(name, totals);
  return mustache::mustache(kExtractionTemplate)
      .render(mustache::object{
          {"caption", fmt::format("Features over {}.",
                                  counted(static_cast<int64_t>(input.trials.size()), "trial"))},
          {"features", features},
          {"outlier_px", fmt::to_string(input.study.setups.front().limits.outlier_px)},
          {"extractors", extractor_names(input.study.setups.front())},
          {"has_conditions", input.study.conditions.size() > 1},
          {"conditions", condition_groups(input)},
      });
}

}  // namespace sightline
