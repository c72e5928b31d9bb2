// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/agreement.h"

#include <algorithm>

#include <Eigen/LU>

namespace sightline {
namespace {

// How far lines may miss the point they agree on: the sum of squares, each distance in its own
// standard deviations. Nine is three sigmas of a third line.
constexpr double kMostSquares = 9;
// What a point far from the prediction costs, for each square of its distance in sigmas: a point
// three sigmas off must have a quarter of an edge's support more.
constexpr double kPriorWeight = 0.03;
constexpr size_t kMostAgreements = 4;  // that are given

// One way of taking a line or none for each edge, written as one number: its digits, of the base
// "lines of that edge, plus one", are 0 for none or one more than the line's index.
std::vector<LinePick> picks_of(size_t combination, std::span<const size_t> lines_of_edge) {
  std::vector<LinePick> picks;
  for (size_t edge = 0; edge < lines_of_edge.size(); ++edge) {
    const size_t base = lines_of_edge[edge] + 1;
    const size_t digit = combination % base;
    combination /= base;
    if (digit > 0) picks.push_back({edge, digit - 1});
  }
  return picks;
}

// The agreement of these lines; none where they do not agree on a point in the window.
std::optional<Agreement> agreement_of(std::vector<LinePick> picks,
                                      const FeaturePrediction& prediction, const cv::Rect& window,
                                      const AgreementRules& rules) {
  if (picks.size() < 2) return std::nullopt;
  const auto meeting = rules.meeting(picks);
  if (!meeting || !(meeting->squares <= kMostSquares)) return std::nullopt;
  if (!contains(window, meeting->pixel)) return std::nullopt;
  double value = 0;
  for (const LinePick& pick : picks) value += rules.support(pick, meeting->pixel);
  const Eigen::Vector2d off = meeting->pixel - prediction.pixel;
  value -= kPriorWeight * off.dot(rules.prior_information * off);
  return Agreement{std::move(picks), meeting->pixel, value};
}

}  // namespace

Eigen::Matrix2d prior_information(const FeaturePrediction& prediction, double slack_px2) {
  return (prediction.covariance_px2 + slack_px2 * Eigen::Matrix2d::Identity()).inverse();
}

std::vector<Agreement> find_agreements(std::span<const size_t> lines_of_edge,
                                       const FeaturePrediction& prediction, const cv::Rect& window,
                                       const AgreementRules& rules) {
  size_t combinations = 1;
  for (const size_t lines : lines_of_edge) combinations *= lines + 1;
  std::vector<Agreement> all;
  for (size_t combination = 1; combination < combinations; ++combination) {
    auto agreement = agreement_of(picks_of(combination, lines_of_edge), prediction, window, rules);
    if (agreement) all.push_back(std::move(*agreement));
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Agreement& a, const Agreement& b) { return a.value > b.value; });
  std::vector<Agreement> best;
  for (Agreement& agreement : all) {
    const bool is_known = std::any_of(best.begin(), best.end(), [&](const Agreement& better) {
      return (better.pixel - agreement.pixel).norm() < rules.same_px;
    });
    if (is_known) continue;
    best.push_back(std::move(agreement));
    if (best.size() == kMostAgreements) break;
  }
  return best;
}

}  // namespace sightline
