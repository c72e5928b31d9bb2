// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/covariance.h"

#include <algorithm>
#include <map>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace sightline {
namespace {

constexpr int kClusterBlocks = 3;  // of a side: what errs together in a coarse mesh or a shadow

// The sum over clusters of the outer products of their scores, which noise alone makes the
// information.
UnknownsMatrix disagreement(const BlockRows& rows, const Solution& solution) {
  Eigen::Matrix<double, kUnknowns + 1, 1> of_columns;
  of_columns << -solution.change, 1;
  std::map<std::pair<int, int>, Unknowns> scores;
  for (size_t b = 0; b < rows.blocks.size(); ++b) {
    const int id = rows.blocks[b].id;
    const std::pair<int, int> cluster(id % rows.blocks_across / kClusterBlocks,
                                      id / rows.blocks_across / kClusterBlocks);
    const auto place = scores.try_emplace(cluster, Unknowns::Zero()).first;
    place->second += (solution.blocks[b].system * of_columns).head<kUnknowns>();
  }
  UnknownsMatrix sum = UnknownsMatrix::Zero();
  for (const auto& [cluster, score] : scores) sum += score * score.transpose();
  const auto clusters = static_cast<double>(scores.size());
  return sum * (clusters / std::max(1.0, clusters - kUnknowns));
}

}  // namespace

PoseSpread pose_spread(const BlockRows& rows, const Solution& solution) {
  const UnknownsMatrix inverse = solution.information.inverse();
  PoseSpread spread;
  spread.covariance = inverse.topLeftCorner<6, 6>();
  spread.covariance *= std::max(1.0, solution.chi2);
  const UnknownsMatrix sandwich = inverse * disagreement(rows, solution) * inverse;
  spread.cluster_factor =
      (spread.covariance.inverse() * sandwich.topLeftCorner<6, 6>()).trace() / 6;
  spread.covariance *= std::max(1.0, spread.cluster_factor);
  return spread;
}

}  // namespace sightline
