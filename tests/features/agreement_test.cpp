// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/agreement.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

namespace sightline {
namespace {

const Eigen::Vector2d kFeature(50, 40);
const cv::Rect kWindow(0, 0, 100, 100);

ImageLine line_through(const Eigen::Vector2d& point, double angle_rad) {
  ImageLine line;
  line.point = point;
  line.direction = {std::cos(angle_rad), std::sin(angle_rad)};
  line.covariance.diagonal() << 0.01, 1e-6;
  return line;
}

using LinesOfEdge = std::vector<std::vector<ImageLine>>;

// Every line has the same support, and lines meet by least squares.
std::vector<Agreement> agreements_of(const LinesOfEdge& lines_of, double same_px,
                                     const cv::Rect& window = kWindow) {
  FeaturePrediction prediction;
  prediction.pixel = kFeature;
  prediction.covariance_px2 = 4 * Eigen::Matrix2d::Identity();
  AgreementRules rules;
  rules.prior_information = prior_information(prediction, 0);
  rules.same_px = same_px;
  rules.meeting = [&](std::span<const LinePick> picks) {
    std::vector<ImageLine> lines;
    for (const LinePick& pick : picks) lines.push_back(lines_of[pick.edge][pick.line]);
    return meeting_of(lines, kLeastMeetingDeg);
  };
  rules.support = [](const LinePick&, const Eigen::Vector2d&) { return 1.0; };
  std::vector<size_t> counts;
  for (const auto& lines : lines_of) counts.push_back(lines.size());
  return find_agreements(counts, prediction, window, rules);
}

std::string words(const Agreement& agreement) {
  std::string text;
  for (const LinePick& pick : agreement.picks) {
    text += std::to_string(pick.edge) + ":" + std::to_string(pick.line) + " ";
  }
  return text;
}

// Three edges, of which two have a wrong line 5 px beside the right one as well.
LinesOfEdge three_edges() {
  return {{line_through(kFeature + Eigen::Vector2d(0, 5), 0), line_through(kFeature, 0)},
          {line_through(kFeature, 1)},
          {line_through(kFeature, 2), line_through(kFeature + Eigen::Vector2d(5, 0), 2)}};
}

TEST(Agreement, TheRightLinesOfThreeEdgesAgree) {
  const auto found = agreements_of(three_edges(), 1);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(words(found.front()), "0:1 1:0 2:0 ");
  EXPECT_LT((found.front().pixel - kFeature).norm(), 1e-9);
  EXPECT_NEAR(found.front().value, 3, 1e-9);
}

TEST(Agreement, BestFirstAndFew) {
  const auto found = agreements_of(three_edges(), 0);
  ASSERT_EQ(found.size(), 4u);
  for (size_t i = 1; i < found.size(); ++i) EXPECT_LE(found[i].value, found[i - 1].value);
}

TEST(Agreement, OfThoseOnOnePointTheBestIsKept) {
  const auto found = agreements_of(three_edges(), 1);
  for (size_t i = 0; i < found.size(); ++i) {
    for (size_t k = 0; k < i; ++k) EXPECT_GE((found[i].pixel - found[k].pixel).norm(), 1);
  }
  // Any two of the three right lines agree on the same point, and are kept where all are.
  size_t on_feature = 0;
  for (const Agreement& agreement : agreements_of(three_edges(), 0)) {
    on_feature += (agreement.pixel - kFeature).norm() < 1e-6;
  }
  EXPECT_GT(on_feature, 1u);
}

TEST(Agreement, LinesThatMissEachOtherDoNotAgree) {
  LinesOfEdge lines = three_edges();
  for (auto& of_edge : lines) of_edge.resize(1, ImageLine());  // leaves the wrong line of the first
  for (const Agreement& agreement : agreements_of(lines, 0)) {
    EXPECT_EQ(agreement.picks.size(), 2u) << words(agreement);
  }
}

TEST(Agreement, OneEdgeOrParallelLinesOrAPointOutsideAreNone) {
  EXPECT_TRUE(agreements_of({}, 0).empty());
  EXPECT_TRUE(agreements_of({{line_through(kFeature, 0), line_through(kFeature, 1)}}, 0).empty());
  EXPECT_TRUE(
      agreements_of({{line_through(kFeature, 0)}, {line_through(kFeature, 0.02)}}, 0).empty());
  EXPECT_TRUE(agreements_of(three_edges(), 0, {0, 0, 20, 20}).empty());
}

}  // namespace
}  // namespace sightline
