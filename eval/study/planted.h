// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The outliers that a numeric study plants among its exact observations.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "eval/study/outlier_model.h"
#include "scenes/scene/keys.h"
#include "scenes/target/target.h"

namespace sightline {

/// How a numeric study displaces the points that it makes outliers, on top of their noise.
enum class OutlierLaw {
  kUniform,    ///< in a uniform direction, by a size uniform in the range
  kFixed,      ///< in a uniform direction, by the upper end of the range
  kClustered,  ///< all of a trial by one displacement, drawn as kUniform
  kTailed,     ///< in a uniform direction, by a size whose density falls with its square
  kSwapped,    ///< pairs of points that mirror each other in y = 0 exchange their pixels
  kModel,      ///< as measured in a trial of an image study, drawn from its outliers.json
};

struct PlantedOutliers {
  OutlierLaw law = OutlierLaw::kUniform;
  Range size_px{15, 30};
  double rate = 0;  ///< of the points beyond their stated number, how probable each is displaced
  std::shared_ptr<const OutlierModel> model;  ///< of kModel
  /// Lines that are wrong: across each, either of its ends is displaced by a size of the law, to
  /// either side. A trial with fewer lines has no right one.
  int lines = 0;
};

/// The keys of [outliers], but for how many outliers a trial has.
std::vector<Key> keys_of(PlantedOutliers& planted);

/// Pairs of these features (indices into the target's) that mirror each other in the target's plane
/// y = 0, port and starboard; a pair names them by their places in `features`.
std::vector<std::pair<int, int>> mirrored_pairs(const Target& target,
                                                std::span<const int> features);

/// Why the law cannot make so many of these features, and of lines so many as it says, outliers, in
/// words for the user; empty when it can.
std::string why_not_plantable(const PlantedOutliers& law, int outliers, const Target& target,
                              std::span<const int> features);

}  // namespace sightline
