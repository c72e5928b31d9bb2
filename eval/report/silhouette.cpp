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

#include "eval/output/numbers.h"
#include "eval/output/words.h"
#include "eval/report/figures.h"
#include "eval/report/page_text.h"
#include "scenes/random/random.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

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
    views.push_back({input.study.camera_of(trial.trial), trial.true_cam_from_target});
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
  if (input.study.images() == nullptr) return "";
  const ImageStudy& study = *input.study.images();
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
  return mustache::mustache(page_text("silhouette.mustache"))
      .render(mustache::object{
          {"caption", fmt::format("The outline beside each feature, at the true poses of {}.",
                                  is_some ? some : all)},
          {"features", features},
          {"random",
           is_some && views.size() == kSilhouetteViews ? ", of poses chosen at random" : ""},
      });
}

}  // namespace sightline
