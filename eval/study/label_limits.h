// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>
#include <vector>

#include "scenes/scene/keys.h"

namespace sightline {

/// Where right ends. An observation is an outlier beyond either of the first two.
struct LabelLimits {
  double outlier_px = 5;  ///< from the true pixel
  /// In units of the observation's own covariance (Mahalanobis distance).
  double outlier_sigmas = std::numeric_limits<double>::infinity();
  double line_px = 3;  ///< RMS of a line's edge pixels about the true edge
  /// A feature whose edges have less contrast in the image counts as not to be seen, grey levels of
  /// 255; 0: every feature does that nothing hides.
  double least_contrast_grey = 0;
};

/// Their keys, which stand in [extraction].
std::vector<Key> keys_of(LabelLimits& limits);

}  // namespace sightline
