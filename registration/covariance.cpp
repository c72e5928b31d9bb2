// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/covariance.h"

#include <algorithm>
#include <map>
#include <utility>

#include "registration/symmetric.h"

namespace sightline {
namespace {

constexpr int kClusterBlocks = 3;  // of a side: what errs together in a coarse mesh or a shadow

// The sum over clusters of the outer products of their scores, which noise alone makes the
// information.
Eigen::MatrixXd disagreement(const BlockRows& rows, const Solution& solution) {
  Eigen::Matrix<double, kUnknowns + 1, 1> of_columns;
  of_columns << -solution.change, 1;
  std::map<std::pair<int, int>, Eigen::VectorXd> scores;
  for (size_t b = 0; b < rows.blocks.size(); ++b) {
    const int id = rows.blocks[b].id;
    const std::pair<int, int> cluster(id % rows.blocks_across / kClusterBlocks,
                                      id / rows.blocks_across / kClusterBlocks);
    const auto place = scores.try_emplace(cluster, Eigen::VectorXd::Zero(kUnknowns)).first;
    place->second += (solution.blocks[b].system * of_columns).head(kUnknowns);
  }
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(kUnknowns, kUnknowns);
  for (const auto& [cluster, score] : scores) sum += score * score.transpose();
  const auto clusters = static_cast<double>(scores.size());
  return sum * (clusters / std::max(1.0, clusters - kUnknowns));
}

// Clusters of 36 px show but a part of what errs together over the whole of a shadow, a highlight
// or a coarse mesh. Measured with shadows, highlights, stripes, unknown albedos and a quarter of
// the mesh (docs/registration.md): what clusters show is then a third of what is there.
double enlargement(double cluster_factor, double lost) {
  constexpr double kUnseen = 3;
  // Of the factor, and of the pixels that the model does not explain: noise alone stays below.
  const double by_clusters = std::clamp((cluster_factor - 1.2) / 0.3, 0.0, 1.0);
  const double by_lost = std::clamp((lost - 0.002) / 0.001, 0.0, 1.0);
  const double model_is_wrong = std::max(by_clusters, by_lost);
  return std::max(1.0, cluster_factor) * (1 + (kUnseen - 1) * model_is_wrong);
}

}  // namespace

PoseSpread pose_spread(const BlockRows& rows, const Solution& solution, const FitQuality& quality) {
  const auto inverse = inverse_of(solution.information);
  PoseSpread spread;
  if (!inverse) return spread;
  const Eigen::MatrixXd own = inverse->topLeftCorner(6, 6) * std::max(1.0, quality.chi2);
  const Eigen::MatrixXd sandwich = *inverse * disagreement(rows, solution) * *inverse;
  if (const auto own_information = inverse_of(own)) {
    spread.cluster_factor = (*own_information * sandwich.topLeftCorner(6, 6)).trace() / 6;
  }
  spread.covariance = own * enlargement(spread.cluster_factor, quality.lost);
  return spread;
}

}  // namespace sightline
