// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/study/seen_edges.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "scenes/target/same_edge.h"

namespace sightline {
namespace {

// The image of an edge, taken as straight between its ends.
struct ImagedEdge {
  double length_px;
  Eigen::Vector2d direction;  // away from where it begins
};

std::optional<ImagedEdge> imaged(const Edge& edge, const Camera& camera, const Pose& pose) {
  const auto begin = project(camera, pose * edge.begin_m);
  const auto end = project(camera, pose * edge.end_m);
  if (!begin || !end || *begin == *end) return std::nullopt;
  const double length_px = (*end - *begin).norm();
  return ImagedEdge{length_px, (*end - *begin) / length_px};
}

}  // namespace

const Edge& edge_of(const Target& target, const OwnEdge& own) {
  return target.features[own.feature].edges[static_cast<size_t>(own.edge)];
}

std::vector<Key> keys_of(SeenEdges& edges) {
  using Observed = SeenEdges::Observed;
  return {
      {"edges",
       "observed",
       choice(edges.observed, {{"nothing", Observed::kNothing},
                               {"points", Observed::kPoints},
                               {"lines", Observed::kLines},
                               {"both", Observed::kBoth}}),
       {},
       "",
       "of a numeric study, what its edge pixels become, whose noise then is noise.pixel_px: "
       "points where lines meet, lines, or both, no edge pixel twice, each with its covariance; "
       "nothing: features are points with that noise"},
      {"edges",
       "reach_px",
       &edges.reach_px,
       {4, 1000},
       "px",
       "of a numeric study: how far along its edges a point is found"}};
}

std::vector<OwnEdge> different_edges(const Target& target, std::span<const int> features) {
  std::vector<OwnEdge> different;
  for (const int feature : features) {
    const std::vector<Edge>& own = target.features[feature].edges;
    for (size_t i = 0; i < own.size(); ++i) {
      const auto is_own = [&](const OwnEdge& other) {
        return is_same_edge(edge_of(target, other), own[i]);
      };
      if (std::ranges::any_of(different, is_own)) continue;
      different.push_back({feature, static_cast<int>(i)});
    }
  }
  return different;
}

std::vector<SeenEdge> seen_lines(const SeenEdges& edges, const Target& target,
                                 std::span<const int> features, const Camera& camera,
                                 const Pose& cam_from_target) {
  constexpr double kFewestPx = 8;
  std::vector<SeenEdge> seen;
  if (!edges.has_lines()) return seen;
  for (const OwnEdge& own : different_edges(target, features)) {
    const auto image = imaged(edge_of(target, own), camera, cam_from_target);
    if (!image) continue;
    const double used_px = edges.has_points() ? 2 * edges.reach_px : 0;
    const double length_px = image->length_px - used_px;
    if (length_px >= kFewestPx) seen.push_back({own, length_px});
  }
  return seen;
}

std::optional<Eigen::Matrix2d> corner_covariance_px2(const SeenEdges& edges,
                                                     const TargetFeature& feature,
                                                     const Camera& camera,
                                                     const Pose& cam_from_target, double sigma_px) {
  constexpr double kLeastSine = 0.05;  // of the angle between two lines
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  double greatest_sine = 0;
  std::vector<Eigen::Vector2d> directions;
  for (const Edge& edge : feature.edges) {
    const auto image = imaged(edge, camera, cam_from_target);
    if (!image) return std::nullopt;
    // Of an edge that two features share, each has its half.
    const double length_px = std::min(edges.reach_px, image->length_px / 2);
    const Eigen::Vector2d normal(-image->direction.y(), image->direction.x());
    information += length_px / (4 * sigma_px * sigma_px) * normal * normal.transpose();
    for (const Eigen::Vector2d& other : directions) {
      greatest_sine = std::max(greatest_sine, std::abs(other.dot(normal)));
    }
    directions.push_back(image->direction);
  }
  if (!(greatest_sine > kLeastSine)) return std::nullopt;
  return Eigen::Matrix2d(information.inverse());
}

}  // namespace sightline
