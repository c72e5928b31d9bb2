// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "pose/consensus/cloud.h"
#include "pose/consensus/mixture.h"

namespace sightline::consensus {

/// The squared distance of a pose from a mode, in the mode's own standard deviations.
double squared_distance(const Mode& mode, const Pose& pose);

/// Different poses that explain the points, the likeliest first; at most kMostModes of them. A mode
/// that is near another takes its place where it is likelier, and is dropped where it is not.
class ModeList {
 public:
  static constexpr std::size_t kMostModes = 6;

  void add(Mode mode);
  bool is_empty() const { return modes_.empty(); }
  const Mode& best() const { return modes_.front(); }
  const std::vector<Mode>& all() const { return modes_; }

 private:
  std::vector<Mode> modes_;
};

/// Where the inliers of a mode lie nearly in a plane: its mirror pose, the other minimum that the
/// image of a plane has: (I - 2 v v^T) R (I - 2 n n^T), n the plane's normal, v the ray to the
/// inliers' centroid, which stays where it is.
std::optional<Pose> mirrored(const Cloud& cloud, const Mode& mode);

}  // namespace sightline::consensus
