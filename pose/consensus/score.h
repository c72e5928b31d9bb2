// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// How well a pose explains the points, before anything is fitted.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "pose/consensus/cloud.h"

namespace sightline::consensus {

/// What a pose scores, and the size of the noise with which a fit from it should begin. Where the
/// noise is not known there is a second score, of small radii alone: a good pose that few points
/// meet precisely may have a low score among poses that many points meet roughly.
struct Score {
  double total = -std::numeric_limits<double>::infinity();
  double scale = 0;
  double tight_total = -std::numeric_limits<double>::infinity();
  double tight_scale = 0;
};

/// Agreement where the noise is not known counts as significant within a fiftieth of the image's
/// width, as a part of its area: data that are absurd agree more roughly.
inline constexpr double kWidestSignificant = 1e-3;
/// Squared distances below it, as parts of the image's area, are rounding.
inline constexpr double kLeastSquare = 1e-13;

/// The divergence of Bernoulli laws of chances p and q.
double bernoulli_divergence(double p, double q);

/// The improbability, as a logarithm, above which agreement of some of n points with the best of
/// the poses of so many triples, at the best of all radii, is more than chance: so much has one of
/// a hundred clouds without any pose.
double least_log_improbability(double triples, double n);

/// Scores poses by at most kMostScored points. Holds a reference to the cloud and the room to work.
///
/// Noise known: the sum over points of max(0, ln(A / (2 pi sigma^2)) - 2.2 - 2 ln(1 + r^2 / (3
/// sigma^2))), the log odds of an inlier against an outlier, with Student's tails in the place of
/// Gauss' because the pose of three points errs too.
///
/// Noise not known: how improbable it is that k of n points lie within t of a pose by chance, at
/// the radius where that is most improbable: max over t of (n - 3) KL((k - 3) / (n - 3) | a), a =
/// pi t^2 / A, after Moisan and Stival, "A probabilistic criterion to detect rigid point matches",
/// IJCV 57(3), 2004, with the Chernoff bound of the binomial tail.
class Scorer {
 public:
  explicit Scorer(const Cloud& cloud) : cloud_(cloud) {}

  Score score(const Pose& pose);

  /// The score for noise that is not known, by all points, whether it is known or not; of radii
  /// that noise can explain: from one to five deviations of noise that is known.
  double log_improbability(const Pose& pose);

 private:
  void fill(const Pose& pose, std::size_t count);
  Score known_noise() const;
  Score any_noise(double least_square, double widest) const;

  const Cloud& cloud_;
  std::size_t count_ = 0;
  std::vector<float> squares_;  ///< whitened
};

}  // namespace sightline::consensus
