// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Umeyama 1991, equations (40) to (42): the rotation of umeyama.cpp, and the scale
// c = tr(S diag(1, 1, +-1)) / sum w |x_a - mean|^2 of x_b = c R x_a + t. Needs points that are not
// collinear.

#include "pose/orientation/methods.h"

namespace sightline {

OrientationEstimate orient_by_umeyama_scaled(const PairMoments& moments) {
  const SvdRotation svd = rotation_by_svd(moments.cross, moments.rounding);
  if (svd.status != OrientationStatus::kOk) return {svd.status, {}};
  const double scale = svd.trace / moments.spread_a.trace();
  return estimate_about_means(moments, svd.rotation, scale);
}

}  // namespace sightline
