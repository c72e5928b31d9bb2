// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which of many lines belong together. In the image there may be several lines where one edge of
// the target is expected: the shadow beside it, the next edge of the wing, clutter. A wrong line
// seldom passes through the feature, so the right ones are those that agree on a point. All ways
// of taking one line or none for each edge are tried, and the best few are given. How lines meet
// and what speaks for a line is the extractor's to say.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/types.hpp>

#include "features/image_line.h"
#include "features/prediction.h"

namespace sightline {

/// The least angle between the lines that a feature is found by. Lines at a small angle fix it
/// badly, which its covariance then says.
inline constexpr double kLeastMeetingDeg = 2;

/// One line of one edge, both as indices: which edge, and which of the lines found for it.
struct LinePick {
  size_t edge;
  size_t line;
};

/// Two or more lines, of different edges, that meet in one point.
struct Agreement {
  std::vector<LinePick> picks;
  Eigen::Vector2d pixel;  ///< the point
  double value;           ///< what speaks for it: the lines' support, less what the prior holds
                          ///< against the point
};

/// How an extractor judges lines that might agree.
struct AgreementRules {
  /// The point on which the picked lines agree best and by how much they miss it; none where they
  /// are parallel.
  std::function<std::optional<Meeting>(std::span<const LinePick> picks)> meeting;
  /// From 0 to about 1, what speaks for a line if the feature is at that pixel.
  std::function<double(const LinePick& pick, const Eigen::Vector2d& pixel)> support;
  /// The inverse of a covariance, 1/px^2: how surely the feature is where it is predicted.
  Eigen::Matrix2d prior_information = Eigen::Matrix2d::Zero();
  /// Of agreements on points nearer to each other than this only the best is kept.
  double same_px = 0;
};

/// The inverse of the prediction's covariance with `slack_px2` added to both its variances.
Eigen::Matrix2d prior_information(const FeaturePrediction& prediction, double slack_px2);

/// The best few agreements on a point in the window, best first; empty where no lines agree.
/// `lines_of_edge` holds how many lines were found for each edge. The number of ways tried is the
/// product of these numbers, each plus one: callers keep both edges and lines few.
std::vector<Agreement> find_agreements(std::span<const size_t> lines_of_edge,
                                       const FeaturePrediction& prediction, const cv::Rect& window,
                                       const AgreementRules& rules);

}  // namespace sightline
