// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// A mode linearised, and its points sorted into inliers, outliers and those that may be either.
#pragma once

#include <cstddef>
#include <vector>

#include "pose/consensus/cloud.h"
#include "pose/consensus/mixture.h"

namespace sightline::consensus {

/// Sums of squares as a function of a step: squares + 2 gradient^T d + d^T hessian d.
struct Quadratic {
  Matrix6d hessian = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  double squares = 0;

  void add(const Row& row, double weight);
  double at(const Vector6d& step) const {
    return squares + 2 * gradient.dot(step) + step.dot(hessian * step);
  }
};

/// The points of a cloud at a pose.
struct LinearCloud {
  Pose cam_from_centred;
  std::vector<Row> rows;
  std::vector<double> squares;  ///< kNotSeen for a point that is not in front
  std::vector<char> is_seen;
};

void linearise(const Cloud& cloud, const Pose& cam_from_centred, LinearCloud& linear);

/// Indices of a cloud's points.
struct Sorted {
  std::vector<std::size_t> certain, doubtful, outliers;
  bool is_exhaustive =
      true;  ///< false: doubtful points were too many and went to their better side
};

/// Sorts the points by their probability in the mode and by their odds against a fit without them.
/// No more points than may be doubtful are all doubtful.
Sorted sort_by_doubt(const Cloud& cloud, const Mode& mode, const LinearCloud& linear,
                     std::size_t most_doubtful);

}  // namespace sightline::consensus
