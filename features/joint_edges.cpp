// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/joint_edges.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "features/image_line.h"
#include "features/model_lines.h"
#include "features/outline_search.h"

namespace sightline {
namespace {

// A line's offset at one of its ends, linear in small changes of the pose.
struct LinearOffset {
  double residual_px;
  Vector6d jacobian;
  double variance_px2;
};

struct LinearLine {
  std::array<LinearOffset, 2> ends;
  double weight_px2;
};

// A way of taking lines.
struct Hypothesis {
  Vector6d change = Vector6d::Zero();  // of the pose, that explains the lines taken
  Matrix6d covariance = Matrix6d::Zero();
  double log_probability = 0;
  int taken = 0;
};

std::optional<LinearLine> linear_at(const Pose& pose, const LineCandidate& line) {
  LinearLine linear{{}, line.weight_px2};
  for (size_t i = 0; i < line.ends.size(); ++i) {
    const auto at = edge_residual(line.ends[i], pose);
    if (!at) return std::nullopt;
    linear.ends[i] = {at->residual_px, at->jacobian.transpose(), line.ends[i].variance_px2};
  }
  return linear;
}

// Of the lines that have residuals at a pose.
std::vector<LinearLine> linear_at(const Pose& pose, const StretchCandidates& stretch) {
  std::vector<LinearLine> lines;
  for (const LineCandidate& candidate : stretch) {
    const auto line = linear_at(pose, candidate);
    if (line) lines.push_back(*line);
  }
  return lines;
}

// The Kalman filter's step, with the probability of what was measured.
void measure(const LinearOffset& offset, Hypothesis& hypothesis) {
  const Vector6d gain = hypothesis.covariance * offset.jacobian;
  const double variance_px2 = offset.jacobian.dot(gain) + offset.variance_px2;
  const double innovation_px = -offset.residual_px - offset.jacobian.dot(hypothesis.change);
  hypothesis.log_probability -= 0.5 * (innovation_px * innovation_px / variance_px2 +
                                       std::log(2 * std::numbers::pi * variance_px2));
  hypothesis.change += innovation_px / variance_px2 * gain;
  hypothesis.covariance -= gain * gain.transpose() / variance_px2;
}

// How probable it is that the edge's own line is among those found.
constexpr double kIsFound = 0.7;

Hypothesis with_line(Hypothesis hypothesis, const LinearLine& line) {
  hypothesis.log_probability += std::log(kIsFound * line.weight_px2);
  for (const LinearOffset& end : line.ends) measure(end, hypothesis);
  ++hypothesis.taken;
  return hypothesis;
}

void keep_most_probable(std::vector<Hypothesis>& hypotheses) {
  constexpr size_t kMost = 100;
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [](const Hypothesis& a, const Hypothesis& b) {
                     return a.log_probability > b.log_probability;
                   });
  if (hypotheses.size() > kMost) hypotheses.erase(hypotheses.begin() + kMost, hypotheses.end());
}

// The most probable way, residuals being linear about a pose.
Hypothesis most_probable(std::span<const StretchCandidates> stretches, const PosePrior& prior,
                         const Pose& about) {
  std::vector<Hypothesis> hypotheses{
      {change_between(about, prior.cam_from_target), prior.covariance}};
  for (const StretchCandidates& stretch : stretches) {
    const std::vector<LinearLine> lines = linear_at(about, stretch);
    if (lines.empty()) continue;
    std::vector<Hypothesis> next;
    next.reserve(hypotheses.size() * (lines.size() + 1));
    for (const Hypothesis& hypothesis : hypotheses) {
      for (const LinearLine& line : lines) next.push_back(with_line(hypothesis, line));
      next.push_back(hypothesis);
      next.back().log_probability += std::log(1 - kIsFound);
    }
    keep_most_probable(next);
    hypotheses = std::move(next);
  }
  return hypotheses.front();
}

bool is_alike(const cv::Mat& image, const Eigen::Vector2d& pixel, double grey, double most) {
  const int u = static_cast<int>(std::lround(pixel.x()));
  const int v = static_cast<int>(std::lround(pixel.y()));
  if (u < 0 || v < 0 || u >= image.cols || v >= image.rows) return false;
  return std::abs(image.at<uint8_t>(v, u) - grey) <= most;
}

// Print has the target on both sides, the outline has the background on one: how much more probable
// what lies beyond the line is of an outline.
double odds_of_beyond(const ExtractionInput& input, const FoundLine& found) {
  constexpr double kBeyondPx = 3.5;
  constexpr double kOdds = 5;
  if (!found.outward || !input.background_grey || found.line.edge_pixels.empty()) return 1;
  const double most_grey = 3 * input.options.search.noise_sd_grey + 6;
  const auto alike = std::ranges::count_if(found.line.edge_pixels, [&](const auto& pixel) {
    return is_alike(input.image, pixel + kBeyondPx * *found.outward, *input.background_grey,
                    most_grey);
  });
  const double share =
      static_cast<double>(alike) / static_cast<double>(found.line.edge_pixels.size());
  return std::pow(kOdds, 2 * share - 1);
}

// The area, px^2, over which the offsets at both ends may lie of lines that are found.
double searched_px2(const ExtractionInput& input, const ImageLine& line, double length_px) {
  const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
  const double width_px = 2 * search_half_px(input, normal);
  return width_px * std::min(width_px, 2 * input.options.search.max_slope * length_px);
}

std::optional<LineCandidate> candidate_of(const ExtractionInput& input, const FoundLine& found) {
  constexpr double kEndPx = 0.3;  // the standard deviation of what the line's fit does not know of
  const ImageLine& line = found.line;
  const Stretch seen = seen_stretch(line);
  const double length_px = seen.to_px - seen.from_px;
  if (!(length_px > 0)) return std::nullopt;
  const LineObservation observed =
      line_observation({found.edge, line}, input.view.target->features[input.prediction.feature]);
  LineCandidate candidate;
  candidate.weight_px2 =
      found.support * odds_of_beyond(input, found) * searched_px2(input, line, length_px);
  for (size_t i = 0; i < candidate.ends.size(); ++i) {
    const double along_px = i == 0 ? seen.from_px : seen.to_px;
    const auto end = edge_point_at(observed, input.view.camera, along_px);
    if (!end) return std::nullopt;
    candidate.ends[i] = *end;
    candidate.ends[i].variance_px2 =
        kEndPx * kEndPx + offset_variance_px2(line, line.point + along_px * line.direction);
  }
  return candidate;
}

}  // namespace

std::vector<StretchCandidates> line_candidates(const ExtractionInput& input) {
  const cv::Rect window =
      window_around(input.prediction.pixel, search_window_half_px(input), input.image.size());
  const auto model = find_model_lines(input, window);
  std::vector<StretchCandidates> stretches;
  if (!model) return stretches;
  for (const std::vector<FoundLine>& lines : model->of_edge) {
    StretchCandidates& stretch = stretches.emplace_back();
    for (const FoundLine& line : lines) {
      const auto candidate = candidate_of(input, line);
      if (candidate) stretch.push_back(*candidate);
    }
  }
  return stretches;
}

std::optional<PosePrior> jointly_explained(std::span<const StretchCandidates> stretches,
                                           const PosePrior& prior) {
  constexpr int kFewest = 3;
  constexpr int kRounds = 2;  // the second about the pose that the first found
  PosePrior pose = prior;
  for (int round = 0; round < kRounds; ++round) {
    const Hypothesis best = most_probable(stretches, prior, pose.cam_from_target);
    if (best.taken < kFewest) return std::nullopt;
    pose = {retract(pose.cam_from_target, best.change), best.covariance};
  }
  return pose;
}

}  // namespace sightline
