// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/edge_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

namespace sightline {
namespace {

constexpr double kFarPx = 100;      // stands for the offset of an edge that is not there
constexpr double kMostGapPx = 1.5;  // between samples that follow one another
constexpr double kMostJumpPx = 1;   // of the offset of the same edge, from a sample to the next
constexpr size_t kOffJump = 3;      // samples left out where another edge begins or ends beside

// The offsets, to the left and to the right, of the nearest edges beside one sample of an edge.
using Offsets = std::array<double, 2>;

// A sample of an edge. It has no offsets where an edge runs across so near that it bends this one.
struct Row {
  double along_px;
  std::optional<Offsets> beside;
};

double distance_px(const EdgeSegment& segment, const Eigen::Vector2d& place) {
  const Eigen::Vector2d along = segment.end - segment.begin;
  const double t = std::clamp((place - segment.begin).dot(along) / along.squaredNorm(), 0.0, 1.0);
  const Eigen::Vector2d nearest_point = segment.begin + t * along;
  return (nearest_point - place).norm();
}

std::optional<Offsets> neighbours_at(const std::vector<EdgeSegment>& segments,
                                     const Eigen::Vector2d& place,
                                     const Eigen::Vector2d& direction) {
  constexpr double kMostSlope = 0.75;  // of an edge that runs beside, not across
  const Eigen::Vector2d normal(-direction.y(), direction.x());
  Offsets nearest{-kFarPx, kFarPx};
  for (const EdgeSegment& segment : segments) {
    const double from = direction.dot(segment.begin - place);
    const double to = direction.dot(segment.end - place);
    const double from_across = normal.dot(segment.begin - place);
    const double to_across = normal.dot(segment.end - place);
    if (std::abs(to_across - from_across) > kMostSlope * std::abs(to - from)) {
      if (distance_px(segment, place) < kOffCornerPx) return std::nullopt;
      continue;
    }
    if (from * to > 0) continue;
    const double t = from / (from - to);
    const double across = from_across + t * (to_across - from_across);
    double& side = nearest[across > 0];
    if (std::abs(across) < std::abs(side)) side = across;
  }
  return nearest;
}

// True where other edges run beside a sample than beside the one before it.
bool is_jump(const Row& before, const Row& after) {
  if (after.along_px - before.along_px > kMostGapPx) return true;
  if (!before.beside || !after.beside) return true;
  for (int side = 0; side < 2; ++side) {
    const double a = (*before.beside)[side];
    const double b = (*after.beside)[side];
    const bool matters = std::min(std::abs(a), std::abs(b)) < kApartPx;
    if (matters && std::abs(b - a) > kMostJumpPx) return true;
  }
  return false;
}

// Of the rows the longest stretch without a jump.
std::span<const Row> longest_even(std::span<const Row> rows) {
  std::span<const Row> longest;
  size_t first = 0;
  for (size_t i = 1; i <= rows.size(); ++i) {
    if (i < rows.size() && !is_jump(rows[i - 1], rows[i])) continue;
    // Where the edge beside changes, its end is blurred.
    const size_t begin = first == 0 ? first : first + kOffJump;
    const size_t end = i == rows.size() ? i : i - std::min(i, kOffJump);
    first = i;
    if (end <= begin || end - begin <= longest.size() || !rows[begin].beside) continue;
    longest = rows.subspan(begin, end - begin);
  }
  return longest;
}

// The edge on one side of a stretch; none where it is too far to matter.
std::optional<EdgeBeside> beside(std::span<const Row> rows, int side, double sd_px) {
  double nearest_px = kFarPx;
  std::vector<double> offsets;
  for (const Row& row : rows) {
    offsets.push_back((*row.beside)[side]);
    nearest_px = std::min(nearest_px, std::abs(offsets.back()));
  }
  if (!(nearest_px < kApartPx)) return std::nullopt;
  return EdgeBeside{std::move(offsets), sd_px};
}

}  // namespace

EdgeRun longest_even_run(const PredictedView& view, const FeaturePrediction& prediction, int edge,
                         const PredictedEdge& predicted, double length_px) {
  const auto segments =
      edges_beside(view, prediction, edge, predicted.samples.back().along_px + kApartPx);
  std::vector<Row> rows;
  for (const PredictedEdge::Sample& sample : predicted.samples) {
    if (sample.along_px < kOffCornerPx || sample.along_px > length_px - kOffCornerPx) continue;
    rows.push_back({sample.along_px,
                    neighbours_at(segments, predicted.begin + sample.along_px * predicted.direction,
                                  predicted.direction)});
  }
  const std::span<const Row> longest = longest_even(rows);
  if (longest.size() < 2) return {};
  EdgeRun run{longest.front().along_px, longest.back().along_px, {}};
  // A wrong prior moves and turns both edges together, and changes the distance between them less.
  const double beside_sd_px = std::clamp(0.3 * predicted_sd_px(prediction), 0.3, 1.5);
  for (const int side : {0, 1}) {
    auto edge_beside = beside(longest, side, beside_sd_px);
    if (edge_beside) run.beside.push_back(std::move(*edge_beside));
  }
  return run;
}

EdgeRun longest_unbroken_run(const PredictedEdge& predicted) {
  const std::vector<PredictedEdge::Sample>& samples = predicted.samples;
  EdgeRun longest;
  size_t first = 0;
  for (size_t i = 1; i <= samples.size(); ++i) {
    if (i < samples.size() && samples[i].along_px - samples[i - 1].along_px < kMostGapPx) continue;
    const EdgeRun run{samples[first].along_px, samples[i - 1].along_px, {}};
    if (run.length_px() > longest.length_px()) longest = run;
    first = i;
  }
  return longest;
}

}  // namespace sightline
