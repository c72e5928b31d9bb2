// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// How far the target's outline lies beside the features that were looked for, as the study saw
// them.
#include "eval/target/silhouette.h"

#include <algorithm>
#include <limits>
#include <vector>

#include <fmt/format.h>
#include <kainjow/mustache.hpp>

#include "eval/output/text.h"
#include "eval/report/figures.h"
#include "scenes/random/random.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

constexpr const char* kSilhouetteTemplate = R"html(
<div class="scroll" role="region" aria-label="Outline beside the features, table" tabindex="0">
<table>
<caption><span>{{caption}}</span></caption>
<thead><tr><th scope="col">Feature</th><th scope="col">median, px</th><th scope="col">median, m</th>
<th scope="col">greatest, px</th><th scope="col">greatest, m</th><th scope="col">views</th>
<th scope="col" class="text">kind</th></tr></thead>
<tbody>
{{#features}}
<tr><th scope="row">{{name}}</th><td>{{median_px}}</td><td>{{median_m}}</td><td>{{greatest_px}}</td>
<td>{{greatest_m}}</td><td>{{views}}</td><td class="kind">{{kind}}</td></tr>
{{/features}}
</tbody>
</table>
</div>
<p class="note">A rounded edge is seen beside the crease that a feature lies on: the outline of the
mesh misses the feature’s true position by so much, before anything is extracted. Of a line
intersection it is where the outlines of its two edges meet, of a corner the nearest point of its
outline; a contour is no point of one. Views are those that show it{{random}}.</p>
)html";

// The true poses, each trial's camera before them: of all trials, or of some at random, so that no
// condition is left out.
std::vector<TargetView> views_of(const ReportInput& input) {
  std::vector<const TrialRecord*> left;
  for (const TrialRecord& trial : input.trials) {
    if (!trial.observations().empty()) left.push_back(&trial);  // else it was not imaged
  }
  RandomStream stream(input.study.seed, "report/silhouettes", 0);
  std::vector<TargetView> views;
  while (!left.empty() && views.size() < kSilhouetteViews) {
    const auto at = static_cast<size_t>(stream.uniform() * static_cast<double>(left.size()));
    std::swap(left[at], left.back());
    const TrialRecord& trial = *left.back();
    views.push_back(
        {input.study.camera_of(trial.condition, trial.trial), trial.true_cam_from_target});
    left.pop_back();
  }
  return views;
}

mustache::data row(const TargetFeature& feature, const SilhouetteOffset& offset) {
  constexpr int kDecimalsOfPx = 3;
  constexpr int kDecimalsOfM = 4;
  const auto shown = [&](double value, int decimals) {
    return fixed(offset.views > 0 ? value : std::numeric_limits<double>::quiet_NaN(), decimals);
  };
  return mustache::object{{"name", feature.name},
                          {"kind", words(to_string(feature.kind))},
                          {"views", fmt::to_string(offset.views)},
                          {"median_px", shown(offset.median_px, kDecimalsOfPx)},
                          {"median_m", shown(offset.median_m, kDecimalsOfM)},
                          {"greatest_px", shown(offset.greatest_px, kDecimalsOfPx)},
                          {"greatest_m", shown(offset.greatest_m, kDecimalsOfM)}};
}

}  // namespace

std::string silhouette_figure(const ReportInput& input) {
  const Study& study = input.study;
  if (study.kind != StudyKind::kImages) return "";
  const std::vector<TargetView> views = views_of(input);
  const std::vector<SilhouetteOffset> offsets =
      silhouette_offsets(*study.target, study.features, views);
  const bool is_seen = std::any_of(offsets.begin(), offsets.end(),
                                   [](const SilhouetteOffset& offset) { return offset.views > 0; });
  if (!is_seen) return "";
  mustache::data features(mustache::data::type::list);
  for (size_t i = 0; i < offsets.size(); ++i) {
    features << row(study.target->features[study.features[i]], offsets[i]);
  }
  const bool is_some = views.size() < input.trials.size();
  const std::string all = counted(static_cast<int64_t>(input.trials.size()), "trial");
  const std::string some = fmt::format("{} of {}", views.size(), all);
  return mustache::mustache(kSilhouetteTemplate)
      .render(mustache::object{
          {"caption", fmt::format("The outline beside each feature, at the true poses of {}.",
                                  is_some ? some : all)},
          {"features", features},
          {"random",
           is_some && views.size() == kSilhouetteViews ? ", of poses chosen at random" : ""},
      });
}

}  // namespace sightline
