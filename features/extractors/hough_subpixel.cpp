// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Canny's edges and Hough's lines as in hough_intersection, with thresholds set by the image's
// noise, for each of the feature's edges that the prior pose shows on the mesh. Each edge may have
// several such lines: those are taken that agree with each other and the prior on one point, have
// the most of their edges' length, and lie along blurred edges. For each is refitted to the grey
// levels beside it (features/blurred_edge.h), away from the corner, where other edges bend it,
// along all of its edge that the mesh shows to be even, inside the window and out of it; edges that
// run so near beside it that they blur into one, as those of a face seen edge-on, are fitted with
// it. The feature is where the lines meet.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "features/blurred_edge.h"
#include "features/extractors/extractors.h"
#include "features/hough_lines.h"
#include "features/image_line.h"
#include "features/outline.h"

namespace sightline {
namespace {

// Sobel's kernel, as Canny's, sums to 8, and sees of white noise smoothed by 1 px about what a
// Gaussian derivative of 1.2 px would: 8 x 0.139.
constexpr double kSobelNoise = 1.11;
constexpr double kLowNoises = 4;
constexpr double kHighNoises = 6;
constexpr double kLeastCanny = 8;   // where there is no noise: an edge of about three grey levels
constexpr double kBandPx = 3;       // of fit_blurred_edge
constexpr double kOffCornerPx = 4;  // of a refit, where other edges bend this one
constexpr double kOffEndPx = 1;     // from the last edge pixel
constexpr double kLeastStretchPx = 4;  // of a refit
constexpr double kFloorPx = 0.007;     // of a line's offset: what an even, straight edge is not
constexpr double kSoftFloorPx = 0.3;   // the same of a rounded edge
constexpr size_t kMostEdges = 4;       // of a feature: all combinations of their lines are tried
constexpr size_t kMostLines = 5;       // that an edge may have
constexpr double kMostSquares = 9;     // of lines that agree on a point
constexpr double kLeastAngleDeg = 2;   // between two lines
constexpr double kMaxSdPx = 1.7;       // in its worst direction of a feature at a small angle

LineOptions canny_by_noise(LineOptions options, double noise_sd_grey) {
  const double noise = kSobelNoise * noise_sd_grey;
  options.canny_low = std::max(kLeastCanny, kLowNoises * noise);
  options.canny_high = std::max(1.5 * kLeastCanny, kHighNoises * noise);
  return options;
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// What an edge is fitted along: samples of it a pixel apart, and the offset of the nearest other
// edge of the mesh on either side of it there.
struct Run {
  double from_px = 0;  // from the feature
  double to_px = 0;
  std::vector<EdgeBeside> beside;
};

// The standard deviation of a predicted pixel, in one coordinate.
double predicted_sd_px(const FeaturePrediction& prediction) {
  return std::sqrt(prediction.covariance_px2.trace() / 2);
}

// True where the prediction tells edges apart that blur into one.
bool is_known(const FeaturePrediction& prediction) {
  return predicted_sd_px(prediction) < 1;
}

// One of the feature's edges in the image.
struct SoughtEdge {
  int index;                  // into the feature's
  Eigen::Vector2d direction;  // unit vector, away from the feature
  double length_px;           // that is to be seen in the window
  Run run;                    // empty where it is not even, or not known
  double floor_px = kFloorPx;
};

constexpr double kApartPx = 6;  // edges farther apart do not matter to each other
constexpr double kFarPx = 100;  // stands for an edge that is not there

// The offsets of the nearest edges at a place along an edge, to its left and right, or none where
// an edge runs across so near that it bends this one.
std::optional<std::array<double, 2>> neighbours_at(const std::vector<EdgeSegment>& segments,
                                                   const Eigen::Vector2d& place,
                                                   const Eigen::Vector2d& direction) {
  constexpr double kMostSlope = 0.75;
  const Eigen::Vector2d normal(-direction.y(), direction.x());
  std::array<double, 2> nearest{-kFarPx, kFarPx};
  for (const EdgeSegment& segment : segments) {
    const double from = direction.dot(segment.begin - place);
    const double to = direction.dot(segment.end - place);
    const double from_across = normal.dot(segment.begin - place);
    const double to_across = normal.dot(segment.end - place);
    if (std::abs(to_across - from_across) > kMostSlope * std::abs(to - from)) {
      const Eigen::Vector2d along = segment.end - segment.begin;
      const double t =
          std::clamp((place - segment.begin).dot(along) / along.squaredNorm(), 0.0, 1.0);
      const Eigen::Vector2d nearest_point = segment.begin + t * along;
      if ((nearest_point - place).norm() < kOffCornerPx) return std::nullopt;
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

// The longest run of an edge along which the same edges are beside it.
Run longest_run(const ExtractionInput& input, int index, const PredictedEdge& edge,
                double length_px) {
  constexpr double kMostJumpPx = 1;
  constexpr size_t kOffJump = 3;  // samples
  const auto segments =
      edges_beside(input.view, input.prediction, index, edge.samples.back().along_px + kApartPx);
  struct Row {
    double along_px;
    std::optional<std::array<double, 2>> beside;
  };
  std::vector<Row> rows;
  for (const PredictedEdge::Sample& sample : edge.samples) {
    if (sample.along_px < kOffCornerPx || sample.along_px > length_px - kOffCornerPx) continue;
    rows.push_back(
        {sample.along_px,
         neighbours_at(segments, edge.begin + sample.along_px * edge.direction, edge.direction)});
  }
  const auto is_jump = [&](const Row& a, const Row& b) {
    if (b.along_px - a.along_px > 1.5) return true;
    if (!a.beside || !b.beside) return true;
    for (int side = 0; side < 2; ++side) {
      const double before = (*a.beside)[side];
      const double after = (*b.beside)[side];
      const bool matters = std::min(std::abs(before), std::abs(after)) < kApartPx;
      if (matters && std::abs(after - before) > kMostJumpPx) return true;
    }
    return false;
  };
  size_t longest_first = 0, longest_size = 0;
  size_t first = 0;
  for (size_t i = 1; i <= rows.size(); ++i) {
    if (i < rows.size() && !is_jump(rows[i - 1], rows[i])) continue;
    // Where the edge beside changes, its end is blurred.
    const size_t begin = first == 0 ? first : first + kOffJump;
    const size_t end = i == rows.size() ? i : i - std::min(i, kOffJump);
    first = i;
    if (end <= begin || end - begin <= longest_size || !rows[begin].beside) continue;
    longest_first = begin;
    longest_size = end - begin;
  }
  Run run;
  if (longest_size < 2) return run;
  // What turns and moves the whole changes the distance between two edges less.
  const double beside_sd_px = std::clamp(0.3 * predicted_sd_px(input.prediction), 0.3, 1.5);
  run.from_px = rows[longest_first].along_px;
  run.to_px = rows[longest_first + longest_size - 1].along_px;
  for (int side = 0; side < 2; ++side) {
    double nearest_px = kFarPx;
    std::vector<double> offsets;
    for (size_t i = 0; i < longest_size; ++i) {
      offsets.push_back((*rows[longest_first + i].beside)[side]);
      nearest_px = std::min(nearest_px, std::abs(offsets.back()));
    }
    if (nearest_px < kApartPx) run.beside.push_back({std::move(offsets), beside_sd_px});
  }
  return run;
}

// How far a ray stays in a window.
double reach_px(const cv::Rect& window, const Eigen::Vector2d& from, const Eigen::Vector2d& way) {
  double reach = std::numeric_limits<double>::infinity();
  const Eigen::Vector2d least(window.x, window.y);
  const Eigen::Vector2d most(window.br().x - 1, window.br().y - 1);
  for (int axis = 0; axis < 2; ++axis) {
    if (way[axis] == 0) continue;
    reach = std::min(reach, ((way[axis] > 0 ? most : least)[axis] - from[axis]) / way[axis]);
  }
  return std::max(0.0, reach);
}

// The feature's edges that are to be seen, the longest; without a mesh its best seen two.
std::vector<SoughtEdge> sought_edges(const ExtractionInput& input, const cv::Rect& window) {
  constexpr double kGapPx = 1;
  constexpr double kReachPx = 80;
  constexpr double kKnownReachPx = 160;
  constexpr double kLeastSeenPx = 3;
  const EdgeStretch all{kGapPx, is_known(input.prediction) ? kKnownReachPx : kReachPx,
                        /*apart_px=*/0};
  const FeaturePrediction& prediction = input.prediction;
  std::vector<SoughtEdge> sought;
  if (input.view.target != nullptr) {
    const auto& own = input.view.target->features[prediction.feature].edges;
    for (int i = 0; i < static_cast<int>(own.size()); ++i) {
      const PredictedEdge edge = predict_edge(input.view, prediction, i, all);
      if (edge.samples.empty()) continue;
      const double end_px = edge.samples.back().along_px;
      const double in_window_px =
          std::min(end_px, reach_px(window, prediction.pixel, edge.direction));
      if (in_window_px < kLeastSeenPx) continue;
      sought.push_back(
          {i, edge.direction, in_window_px, {}, edge.is_soft ? kSoftFloorPx : kFloorPx});
      if (!edge.is_soft) sought.back().run = longest_run(input, i, edge, end_px + kGapPx);
    }
  }
  std::stable_sort(sought.begin(), sought.end(), [](const SoughtEdge& a, const SoughtEdge& b) {
    return a.length_px > b.length_px;
  });
  if (sought.size() > kMostEdges) sought.erase(sought.begin() + kMostEdges, sought.end());
  if (sought.size() >= 2) return sought;
  sought.clear();
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d& direction = prediction.edge_direction[i];
    sought.push_back({prediction.edge[i],
                      direction,
                      reach_px(window, prediction.pixel, direction),
                      {},
                      kFloorPx});
  }
  return sought;
}

// Of a Hough line what may be that edge: its edge pixels on the edge's side of the feature, and a
// direction, away from the feature, between theirs and the predicted one.
std::optional<ImageLine> as_edge(const ImageLine& line, const SoughtEdge& edge,
                                 const ExtractionInput& input, const LineOptions& options) {
  constexpr double kLeastSlopeSd = 0.01;
  constexpr double kMostSlopeSd = 0.075;
  constexpr double kQuantisationPx = 0.29;
  const FeaturePrediction& prediction = input.prediction;
  const double margin_px = search_half_px(input, edge.direction);
  std::vector<Eigen::Vector2d> pixels;
  for (const Eigen::Vector2d& pixel : line.edge_pixels) {
    const double along_px = edge.direction.dot(pixel - prediction.pixel);
    if (along_px > -margin_px && along_px < edge.length_px + margin_px) pixels.push_back(pixel);
  }
  if (static_cast<int>(pixels.size()) < options.min_edge_pixels) return std::nullopt;
  ImageLine own = fit_line(std::move(pixels), kQuantisationPx);
  if (own.direction.dot(edge.direction) < 0) own.direction = -own.direction;
  const double slope = cross(own.direction, edge.direction);
  const double slope_sd =
      std::clamp(2 * predicted_sd_px(prediction) / edge.length_px, kLeastSlopeSd, kMostSlopeSd);
  const double gain = own.covariance(1, 1) / (own.covariance(1, 1) + slope_sd * slope_sd);
  const Eigen::Vector2d normal(-own.direction.y(), own.direction.x());
  own.direction = (own.direction + gain * slope * normal).normalized();
  own.covariance(1, 1) *= 1 - gain;
  return own;
}

// Lines of which each is one edge's, and the point on which they and the prior agree.
struct Choice {
  std::vector<const SoughtEdge*> edges;
  std::vector<const ImageLine*> lines;
  Eigen::Vector2d corner = Eigen::Vector2d::Zero();
  double value = 0;
};

// Of a line through edge pixels near a corner not yet known. Of edges that blur into one it may be
// any.
double slack_px2(const ExtractionInput& input, const SoughtEdge& edge) {
  constexpr double kLinePx = 0.5;
  const bool is_blurred = !edge.run.beside.empty() && is_known(input.prediction);
  return is_blurred ? kApartPx * kApartPx : kLinePx * kLinePx;
}

// The share of an edge's length that has edge pixels on a line, once it begins at a pixel: one on
// the line counts whole, one a pixel off not at all.
double support(const SoughtEdge& edge, const ImageLine& line, const Eigen::Vector2d& begin) {
  constexpr double kBeforePx = 1;
  double sum = 0;
  for (const Eigen::Vector2d& pixel : line.edge_pixels) {
    const double along_px = line.direction.dot(pixel - begin);
    if (along_px < -kBeforePx || along_px > edge.length_px + kBeforePx) continue;
    const double off_px = cross(line.direction, pixel - line.point);
    sum += std::max(0.0, 1 - off_px * off_px);
  }
  const double most = edge.length_px * edge.direction.cwiseAbs().maxCoeff();
  return std::min(1.0, sum / most);
}

// Of every edge one line or none, such that two or more agree on one point in the window: first
// those with the most support, less what the prior holds against the point.
std::vector<Choice> agreeing(const ExtractionInput& input, const cv::Rect& window,
                             const std::vector<SoughtEdge>& edges,
                             const std::vector<std::vector<ImageLine>>& lines_of) {
  constexpr double kPriorSlackPx2 = 0.05;
  constexpr double kPriorWeight = 0.03;
  constexpr size_t kMostChoices = 4;
  const Eigen::Vector2d& predicted = input.prediction.pixel;
  const Eigen::Matrix2d prior_information =
      (input.prediction.covariance_px2 + kPriorSlackPx2 * Eigen::Matrix2d::Identity()).inverse();
  size_t combinations = 1;
  for (const auto& candidates : lines_of) combinations *= candidates.size() + 1;
  std::vector<Choice> choices;
  for (size_t combination = 1; combination < combinations; ++combination) {
    Choice choice;
    size_t rest = combination;
    for (size_t edge = 0; edge < edges.size(); ++edge) {
      const size_t pick = rest % (lines_of[edge].size() + 1);
      rest /= lines_of[edge].size() + 1;
      if (pick == 0) continue;
      choice.edges.push_back(&edges[edge]);
      choice.lines.push_back(&lines_of[edge][pick - 1]);
    }
    if (choice.lines.size() < 2) continue;
    Eigen::Matrix2d information = prior_information;
    Eigen::Vector2d sum = prior_information * predicted;
    for (size_t i = 0; i < choice.lines.size(); ++i) {
      const ImageLine& line = *choice.lines[i];
      const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
      const double weight =
          1 / (offset_variance_px2(line, predicted) + slack_px2(input, *choice.edges[i]));
      information += weight * normal * normal.transpose();
      sum += weight * normal * normal.dot(line.point);
    }
    choice.corner = information.inverse() * sum;
    if (!contains(window, choice.corner)) continue;
    const Eigen::Vector2d off = choice.corner - predicted;
    choice.value = -kPriorWeight * off.dot(prior_information * off);
    double squares = 0;
    for (size_t i = 0; i < choice.lines.size(); ++i) {
      const ImageLine& line = *choice.lines[i];
      const double off_px = cross(line.direction, line.point - choice.corner);
      squares += off_px * off_px /
                 (offset_variance_px2(line, choice.corner) + slack_px2(input, *choice.edges[i]));
      choice.value += support(*choice.edges[i], line, choice.corner);
    }
    if (squares <= kMostSquares) choices.push_back(std::move(choice));
  }
  const auto is_better = [](const Choice& a, const Choice& b) { return a.value > b.value; };
  const size_t most = std::min(kMostChoices, choices.size());
  std::partial_sort(choices.begin(), choices.begin() + most, choices.end(), is_better);
  choices.resize(most);
  return choices;
}

// The line fitted to the grey levels along its edge together with what is beside it.
std::optional<ImageLine> refitted(const ExtractionInput& input, const SoughtEdge& edge,
                                  const ImageLine& found, const Eigen::Vector2d& corner) {
  const double first_px = is_known(input.prediction) ? 40 : 12;
  const Run& run = edge.run;
  if (!(run.to_px - run.from_px >= kLeastStretchPx)) return std::nullopt;
  std::optional<ImageLine> line = found;
  if (!run.beside.empty() && is_known(input.prediction)) {
    line->point = corner;
    line->direction = edge.direction;
  }
  // The far end only once the near one has told where it is.
  for (double to_px = run.from_px + first_px;; to_px *= 3) {
    to_px = std::min(to_px, run.to_px);
    const double corner_px = line->direction.dot(corner - line->point);
    line = fit_blurred_edge(input.image, *line, {corner_px + run.from_px, corner_px + to_px},
                            input.options.search.noise_sd_grey, run.beside);
    if (!line || to_px == run.to_px) return line;
  }
}

// The line fitted to the grey levels along the stretch of its edge pixels that is off the others:
// where no mesh says more.
std::optional<ImageLine> refitted_along_pixels(const ExtractionInput& input, const Choice& found,
                                               size_t which) {
  const ImageLine& line = *found.lines[which];
  double gap_px = 0;
  for (const ImageLine* other : found.lines) {
    if (other == &line) continue;
    const double sine = std::abs(cross(line.direction, other->direction));
    const double cosine = std::abs(line.direction.dot(other->direction));
    gap_px = std::max(gap_px, (kBandPx + kBandPx * cosine) / sine);
  }
  const double corner_px = line.direction.dot(found.corner - line.point);
  double first = std::numeric_limits<double>::infinity();
  double last = -first;
  for (const Eigen::Vector2d& pixel : line.edge_pixels) {
    const double from_corner = line.direction.dot(pixel - line.point) - corner_px;
    if (from_corner < 0) continue;
    first = std::min(first, from_corner);
    last = std::max(last, from_corner);
  }
  first = std::max(first, gap_px);
  last -= kOffEndPx;
  if (!(last - first >= kLeastStretchPx)) return std::nullopt;
  return fit_blurred_edge(input.image, line, {corner_px + first, corner_px + last},
                          input.options.search.noise_sd_grey);
}

// The lines of a choice, refitted, and how many cannot be: these are among them only if fewer than
// two can.
struct Refitted {
  std::vector<ImageLine> lines;
  size_t missing = 0;
};

Refitted refitted_lines(const ExtractionInput& input, const Choice& choice) {
  Refitted refitted_ones;
  std::vector<ImageLine> others;
  for (size_t i = 0; i < choice.lines.size(); ++i) {
    const SoughtEdge& edge = *choice.edges[i];
    auto fit = refitted(input, edge, *choice.lines[i], choice.corner);
    if (!fit && edge.run.beside.empty()) fit = refitted_along_pixels(input, choice, i);
    if (!fit) {
      others.push_back(*choice.lines[i]);
      continue;
    }
    fit->covariance(0, 0) += edge.floor_px * edge.floor_px;
    fit->edge_pixels = choice.lines[i]->edge_pixels;
    refitted_ones.lines.push_back(std::move(*fit));
  }
  refitted_ones.missing = others.size();
  if (refitted_ones.lines.size() < 2) {
    std::move(others.begin(), others.end(), std::back_inserter(refitted_ones.lines));
  }
  return refitted_ones;
}

// A point that the prior all but excludes may be another feature's: it is known no better than so
// far that the prior is within three sigmas.
void doubt_by_prior(const FeaturePrediction& prediction, Observation& observation) {
  constexpr double kMostSigmas = 3;
  constexpr double kLeastPriorPx = 0.3;  // a pose found before errs by more than it says
  const Eigen::Vector2d off = observation.pixel - prediction.pixel;
  const Eigen::Matrix2d covariance = prediction.covariance_px2 + observation.covariance_px2 +
                                     kLeastPriorPx * kLeastPriorPx * Eigen::Matrix2d::Identity();
  if (off.dot(covariance.inverse() * off) < kMostSigmas * kMostSigmas) return;
  observation.covariance_px2 += off * off.transpose() / (kMostSigmas * kMostSigmas);
}

// True where lines meet at a small angle that are not known well enough for it.
bool is_loose(const Observation& observation) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(observation.covariance_px2);
  return !(eigen.eigenvalues()[1] <= kMaxSdPx * kMaxSdPx);
}

}  // namespace

void extract_hough_subpixel(const ExtractionInput& input, Observation& observation) {
  const LineOptions options =
      canny_by_noise(input.options.line, input.options.search.noise_sd_grey);
  const HoughTransform hough = hough_transform(input.image, observation.window, options);
  const std::vector<SoughtEdge> edges = sought_edges(input, observation.window);
  std::vector<std::vector<ImageLine>> lines_of;
  for (const SoughtEdge& edge : edges) {
    lines_of.emplace_back();
    for (const ImageLine& line : lines_along(edge.direction, hough, input, options, kMostLines)) {
      auto own = as_edge(line, edge, input, options);
      if (own) lines_of.back().push_back(std::move(*own));
    }
  }
  const std::vector<Choice> choices = agreeing(input, observation.window, edges, lines_of);
  if (choices.empty()) {
    observation.status = ObservationStatus::kTooFewEdgePixels;
    return;
  }
  // Lines that no blurred edge lies along are the wrong ones.
  for (const Choice& choice : choices) {
    Refitted refitted = refitted_lines(input, choice);
    if (&choice != &choices.front() && refitted.missing > 0) continue;
    observation.lines = std::move(refitted.lines);
    if (refitted.missing == 0) break;
  }
  meet(kLeastAngleDeg, observation);
  if (observation.status != ObservationStatus::kFound) return;
  observation.contrast_grey = std::numeric_limits<double>::infinity();
  for (const ImageLine& line : observation.lines) {
    observation.contrast_grey = std::min(observation.contrast_grey, line.contrast_grey);
  }
  if (is_loose(observation)) observation.status = ObservationStatus::kParallelLines;
  doubt_by_prior(input.prediction, observation);
}

}  // namespace sightline
