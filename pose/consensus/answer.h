// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// What a mode says in the end: its pose as a mean over the sets of inliers that are probable, its
// covariance with the doubt about the set in it, and the probability of each point.
#pragma once

#include <vector>

#include "pose/consensus/cloud.h"
#include "pose/consensus/mixture.h"

namespace sightline::consensus {

struct Answer {
  Pose cam_from_centred;  ///< the mean
  Pose most_probable;     ///< that of the most probable set
  Matrix6d covariance = Matrix6d::Zero();
  double log_evidence = 0;            ///< comparable between modes of one cloud
  double variance = 0;                ///< of an inlier's residual
  std::vector<double> probabilities;  ///< of each point to be an inlier
  std::vector<bool> is_inlier;        ///< in the most probable set
  double set_probability = 0;         ///< of that set
  /// How probable the sets are whose poses are far from that of the most probable one, as that one
  /// sees it (kFarDistance2), and the pose of the most probable of them.
  double far_share = 0;
  Pose far_cam_from_centred;
};

/// Points are doubtful when their probability, in the mode or with the point itself left out of the
/// fit, is neither above 0.9995 nor below 0.001. Where no more than kMostDoubtful are, every subset
/// of them is tried: the weighed 6x6 problem is solved with these points as inliers and the others
/// at the outliers' law, and the set is weighed by its likelihood, the pose and (where it is not
/// known) the noise integrated out (Laplace), under the Beta prior of mixture.h. The covariance is
/// the second moment about the mean: that within sets, with the mean variance of the noise, plus
/// that between them.
///
/// Of five and six inliers each is left out once, as an outlier that may be anywhere: where the
/// others alone lead far away, that set is linearised at its own pose. It counts in the covariance,
/// the probabilities and the far share; the mean, the evidence and the most probable set are those
/// of the linear model.
///
/// Where more are doubtful, no single one matters: the pose is the mode's, and the covariance the
/// inverse of its observed information, sum w J^T J / s^2 - sum w (1 - w) J^T r r^T J / s^4.
///
/// False where the mode does not determine a pose.
bool answer_of(const Cloud& cloud, const Mode& mode, Answer& answer);

inline constexpr std::size_t kMostDoubtful = 9;
/// Squared, in standard deviations: the 99.9 % quantile of chi-square of six degrees.
inline constexpr double kFarDistance2 = 22.46;

}  // namespace sightline::consensus
