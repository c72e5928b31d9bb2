// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Matched points of which some are wrong, and how an answer is measured against the truth.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include <Eigen/LU>

#include "pose/robust_alignment.h"
#include "tests/pose/orientation/clouds.h"

namespace sightline {

struct WrongPairsLaw {
  int pairs = 20;
  int outliers = 0;
  double sigma_m = 0.1;  ///< of each coordinate of b
  double side_m = 10;    ///< the cloud is uniform in a cube
  double scale = 1;
};

/// Inliers first, then outliers, which are uniform in the cube of b.
struct WrongPairs {
  Points in_a;
  Points in_b;
  Pose b_from_a;
  double scale = 1;
  double sigma_m = 0;
  std::vector<int> outliers;

  MatchedPoints points() const { return {in_a, in_b}; }
  std::size_t inliers() const { return in_a.size() - outliers.size(); }
};

inline WrongPairs draw_wrong_pairs(const WrongPairsLaw& law, Draw& draw) {
  WrongPairs pairs;
  pairs.b_from_a = {draw.rotation(), draw.in_box(100)};
  pairs.scale = law.scale;
  pairs.sigma_m = law.sigma_m;
  for (int i = 0; i < law.pairs; ++i) {
    const Eigen::Vector3d x_in_a = draw.in_box(law.side_m / 2);
    pairs.in_a.push_back(x_in_a);
    if (i < law.pairs - law.outliers) {
      const Eigen::Vector3d exact = law.scale * (pairs.b_from_a.rotation * x_in_a);
      pairs.in_b.push_back(exact + pairs.b_from_a.translation + law.sigma_m * draw.vector());
    } else {
      pairs.in_b.push_back(pairs.b_from_a.translation + law.scale * draw.in_box(law.side_m / 2));
      pairs.outliers.push_back(i);
    }
  }
  return pairs;
}

/// What least squares makes of the true inliers: no method can do better.
inline Alignment oracle_of(const WrongPairs& pairs, bool estimates_scale = false) {
  const std::span in_a = std::span(pairs.in_a).first(pairs.inliers());
  const std::span in_b = std::span(pairs.in_b).first(pairs.inliers());
  return align<double>(*find_orientation_method(estimates_scale ? "umeyama_scaled" : "fast"), in_a,
                       in_b, {}, pairs.sigma_m);
}

/// (w, dt) that takes the truth to a pose.
inline Vector6d error_of(const Pose& pose, const Pose& truth) {
  Vector6d error;
  error << vector_from_rotation(pose.rotation * truth.rotation.transpose()),
      pose.translation - truth.translation;
  return error;
}

/// e^T covariance^-1 e.
inline double squared_error(const Pose& pose, const Pose& truth, const Matrix6d& covariance) {
  const Vector6d error = error_of(pose, truth);
  return error.dot(covariance.inverse() * error);
}

}  // namespace sightline
