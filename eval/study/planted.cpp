// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/study/planted.h"

#include <fmt/format.h>

namespace sightline {

std::vector<Key> keys_of(PlantedOutliers& planted) {
  return {
      {"outliers",
       "law",
       choice(planted.law, {{"uniform", OutlierLaw::kUniform},
                            {"fixed", OutlierLaw::kFixed},
                            {"clustered", OutlierLaw::kClustered},
                            {"tailed", OutlierLaw::kTailed},
                            {"swapped", OutlierLaw::kSwapped}}),
       {},
       "",
       "how outliers are displaced: in a uniform direction by a size of the range or by its upper "
       "end, all of a trial alike, by a size whose density falls with its square (most are small, "
       "some are huge), or by exchange with their mirror images"},
      {"outliers",
       "size_px",
       LowHigh{&planted.size_px},
       {0, 1e6},
       "px",
       "sizes of the displacements"},
      {"outliers",
       "rate",
       &planted.rate,
       {0, 1},
       "",
       "of a numeric study: how probable it is that a point beyond outliers.count is displaced "
       "too"},
      {"outliers",
       "lines",
       &planted.lines,
       {0, 1000},
       "",
       "of a numeric study with edges.observed = \"lines\" or \"both\": wrong lines of a trial, "
       "each displaced across itself at either end by a size of the law, to either side"},
      {"outliers",
       "model",
       Described{"none", "a text"},
       {},
       "",
       "outliers.json of an image study, whose failures are replayed instead"},
  };
}

std::vector<std::pair<int, int>> mirrored_pairs(const Target& target,
                                                std::span<const int> features) {
  // Mirrored points of a target's file agree to its printed digits.
  constexpr double kMirrorToleranceM = 1e-5;
  std::vector<std::pair<int, int>> pairs;
  const int count = static_cast<int>(features.size());
  const auto position_of = [&](int place) -> const Eigen::Vector3d& {
    return target.features[features[place]].position_m;
  };
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d mirrored = position_of(i).cwiseProduct(Eigen::Vector3d(1, -1, 1));
    for (int j = i + 1; j < count; ++j) {
      if ((position_of(j) - mirrored).norm() < kMirrorToleranceM) pairs.emplace_back(i, j);
    }
  }
  return pairs;
}

std::string why_not_plantable(const PlantedOutliers& law, int outliers, const Target& target,
                              std::span<const int> features) {
  if (law.law == OutlierLaw::kTailed && !(law.size_px.min > 0)) {
    return "is \"tailed\", whose size_px must begin above 0";
  }
  const bool has_sizes = law.law == OutlierLaw::kUniform || law.law == OutlierLaw::kFixed ||
                         law.law == OutlierLaw::kTailed;
  if (law.lines > 0 && !has_sizes) {
    return "must be \"uniform\", \"fixed\" or \"tailed\" where outliers.lines is above 0";
  }
  if (law.law != OutlierLaw::kSwapped) return "";
  if (law.rate > 0) return "is \"swapped\", which makes outliers in pairs: outliers.rate must be 0";
  if (outliers % 2 != 0) {
    return fmt::format(
        "is \"swapped\", which makes outliers in pairs: their number is {}, must be "
        "even",
        outliers);
  }
  const size_t points = 2 * mirrored_pairs(target, features).size();
  if (static_cast<size_t>(outliers) <= points) return "";
  return fmt::format(
      "is \"swapped\", but only {} of the features mirror each other in y = 0, too few for {} "
      "outliers",
      points, outliers);
}

}  // namespace sightline
