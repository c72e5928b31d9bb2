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
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/LU>

#include "features/agreement.h"
#include "features/blurred_edge.h"
#include "features/edge_run.h"
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
constexpr double kLeastCanny = 8;  // where there is no noise: an edge of about three grey levels
constexpr double kOffEndPx = 1;    // of a refit from the last edge pixel
constexpr double kLeastStretchPx = 4;  // of a refit
// The standard deviation, px, of what the fit of an even, straight edge does not know of, and that
// of a rounded edge: a lower estimate, of a cube drawn without error, and an upper one. With the
// first errors are 1.1 of their own sigmas in sightline study feature-localisation --trials 1000
// --set 'sweep={}' --set extraction.line_intersection=hough_subpixel --set extraction.passes=2
constexpr double kFloorPx = 0.007;
constexpr double kSoftFloorPx = 0.3;
constexpr size_t kMostEdges = 4;  // of a feature: all combinations of their lines are tried
constexpr size_t kMostLines = 5;  // that an edge may have
constexpr double kMaxLooseSdPx = 1.7;  // in its worst direction of a feature at a small angle

LineOptions canny_by_noise(LineOptions options, double noise_sd_grey) {
  const double noise = kSobelNoise * noise_sd_grey;
  options.canny_low = std::max(kLeastCanny, kLowNoises * noise);
  options.canny_high = std::max(1.5 * kLeastCanny, kHighNoises * noise);
  return options;
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// True where the prediction tells edges apart that blur into one.
bool is_known(const FeaturePrediction& prediction) {
  return predicted_sd_px(prediction) < 1;
}

// One of the feature's edges in the image.
struct SoughtEdge {
  Eigen::Vector2d direction;  // unit vector, away from the feature
  double length_px;           // that is to be seen in the window
  EdgeRun run;                // empty where it is not even, or not known
  double floor_px = kFloorPx;
};

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

// The feature's edges that the mesh shows in the window, longest first.
std::vector<SoughtEdge> shown_edges(const ExtractionInput& input) {
  constexpr double kGapPx = 1;  // kept off their ends
  constexpr double kReachPx = 80;
  constexpr double kKnownReachPx = 160;
  constexpr double kLeastSeenPx = 3;
  const EdgeStretch all{kGapPx, is_known(input.prediction) ? kKnownReachPx : kReachPx,
                        /*apart_px=*/0};
  const FeaturePrediction& prediction = input.prediction;
  std::vector<SoughtEdge> shown;
  if (input.view.target == nullptr) return shown;
  const auto& own = input.view.target->features[prediction.feature].edges;
  for (int i = 0; i < static_cast<int>(own.size()); ++i) {
    const PredictedEdge edge = predict_edge(input.view, prediction, i, all);
    if (edge.samples.empty()) continue;
    const double end_px = edge.samples.back().along_px;
    const double in_window_px =
        std::min(end_px, reach_px(input.window, prediction.pixel, edge.direction));
    if (in_window_px < kLeastSeenPx) continue;
    shown.push_back({edge.direction, in_window_px, {}, edge.is_soft ? kSoftFloorPx : kFloorPx});
    if (edge.is_soft) continue;
    shown.back().run = longest_even_run(input.view, prediction, i, edge, end_px + kGapPx);
  }
  std::stable_sort(shown.begin(), shown.end(), [](const SoughtEdge& a, const SoughtEdge& b) {
    return a.length_px > b.length_px;
  });
  return shown;
}

// Of the edges that are shown the longest; where no two are shown, or there is no mesh, the two
// that the prediction says are seen best.
std::vector<SoughtEdge> sought_edges(const ExtractionInput& input) {
  std::vector<SoughtEdge> sought = shown_edges(input);
  if (sought.size() > kMostEdges) sought.erase(sought.begin() + kMostEdges, sought.end());
  if (sought.size() >= 2) return sought;
  sought.clear();
  for (const Eigen::Vector2d& direction : input.prediction.edge_direction) {
    sought.push_back(
        {direction, reach_px(input.window, input.prediction.pixel, direction), {}, kFloorPx});
  }
  return sought;
}

// Of a Hough line what may be that edge: its edge pixels on the edge's side of the feature, and a
// direction, away from the feature, between theirs and the predicted one.
std::optional<ImageLine> as_edge(const ImageLine& line, const SoughtEdge& edge,
                                 const ExtractionInput& input, const LineOptions& options) {
  constexpr double kLeastSlopeSd = 0.01;
  constexpr double kMostSlopeSd = 0.075;
  const FeaturePrediction& prediction = input.prediction;
  const double margin_px = search_half_px(input, edge.direction);
  std::vector<Eigen::Vector2d> pixels;
  for (const Eigen::Vector2d& pixel : line.edge_pixels) {
    const double along_px = edge.direction.dot(pixel - prediction.pixel);
    if (along_px > -margin_px && along_px < edge.length_px + margin_px) pixels.push_back(pixel);
  }
  if (static_cast<int>(pixels.size()) < options.min_edge_pixels) return std::nullopt;
  ImageLine own = fit_line(std::move(pixels), kEdgeQuantisationPx);
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

// What was found along each of the edges that were sought.
struct Candidates {
  std::vector<SoughtEdge> edges;
  std::vector<std::vector<ImageLine>> lines_of;  // of each edge

  const SoughtEdge& edge(const LinePick& pick) const { return edges[pick.edge]; }
  const ImageLine& line(const LinePick& pick) const { return lines_of[pick.edge][pick.line]; }
};

Candidates candidates_in(const ExtractionInput& input) {
  const LineOptions options =
      canny_by_noise(input.options.line, input.options.search.noise_sd_grey);
  const HoughTransform hough = hough_transform(input.image, input.window, options);
  Candidates found{sought_edges(input), {}};
  for (const SoughtEdge& edge : found.edges) {
    found.lines_of.emplace_back();
    for (const ImageLine& line : lines_along(edge.direction, hough, input, options, kMostLines)) {
      auto own = as_edge(line, edge, input, options);
      if (own) found.lines_of.back().push_back(std::move(*own));
    }
  }
  return found;
}

// The point of least squares of lines and prior. Lines are weighed by their variance abreast of the
// prediction, since the point is not known yet.
Meeting meeting_with_prior(const ExtractionInput& input, const Candidates& found,
                           std::span<const LinePick> picks,
                           const Eigen::Matrix2d& prior_information) {
  const Eigen::Vector2d& predicted = input.prediction.pixel;
  Eigen::Matrix2d information = prior_information;
  Eigen::Vector2d sum = prior_information * predicted;
  for (const LinePick& pick : picks) {
    const ImageLine& line = found.line(pick);
    const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
    const double weight =
        1 / (offset_variance_px2(line, predicted) + slack_px2(input, found.edge(pick)));
    information += weight * normal * normal.transpose();
    sum += weight * normal * normal.dot(line.point);
  }
  Meeting meeting;
  meeting.covariance_px2 = information.inverse();
  meeting.pixel = meeting.covariance_px2 * sum;
  for (const LinePick& pick : picks) {
    const ImageLine& line = found.line(pick);
    const double off_px = cross(line.direction, line.point - meeting.pixel);
    meeting.squares +=
        off_px * off_px /
        (offset_variance_px2(line, meeting.pixel) + slack_px2(input, found.edge(pick)));
  }
  return meeting;
}

std::vector<Agreement> agreements_of(const ExtractionInput& input, const Candidates& found) {
  constexpr double kPriorSlackPx2 = 0.05;
  std::vector<size_t> lines_of_edge;
  for (const std::vector<ImageLine>& lines : found.lines_of) lines_of_edge.push_back(lines.size());
  AgreementRules rules;
  rules.prior_information = prior_information(input.prediction, kPriorSlackPx2);
  rules.meeting = [&](std::span<const LinePick> picks) {
    return meeting_with_prior(input, found, picks, rules.prior_information);
  };
  rules.support = [&](const LinePick& pick, const Eigen::Vector2d& pixel) {
    return support(found.edge(pick), found.line(pick), pixel);
  };
  return find_agreements(lines_of_edge, input.prediction, input.window, rules);
}

// The line fitted to the grey levels along its edge together with what is beside it.
std::optional<ImageLine> refitted(const ExtractionInput& input, const SoughtEdge& edge,
                                  const ImageLine& found, const Eigen::Vector2d& corner) {
  const double first_px = is_known(input.prediction) ? 40 : 12;
  const EdgeRun& run = edge.run;
  if (!(run.length_px() >= kLeastStretchPx)) return std::nullopt;
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

// The stretch of a line, from where the others with it leave the band of its fit to its last edge
// pixel; px from the corner.
Stretch stretch_of_pixels(const Candidates& found, const Agreement& agreement, const LinePick& own,
                          double corner_px) {
  const ImageLine& line = found.line(own);
  double first = std::numeric_limits<double>::infinity();
  double last = -first;
  for (const Eigen::Vector2d& pixel : line.edge_pixels) {
    const double from_corner = line.direction.dot(pixel - line.point) - corner_px;
    if (from_corner < 0) continue;
    first = std::min(first, from_corner);
    last = std::max(last, from_corner);
  }
  double gap_px = 0;
  for (const LinePick& pick : agreement.picks) {
    if (pick.edge == own.edge) continue;
    const ImageLine& other = found.line(pick);
    const double sine = std::abs(cross(line.direction, other.direction));
    const double cosine = std::abs(line.direction.dot(other.direction));
    gap_px = std::max(gap_px, (kBlurredBandPx + kBlurredBandPx * cosine) / sine);
  }
  return {std::max(first, gap_px), last - kOffEndPx};
}

// The line fitted to the grey levels along the stretch of its edge pixels that is off the others:
// where no mesh says more.
std::optional<ImageLine> refitted_along_pixels(const ExtractionInput& input,
                                               const Candidates& found, const Agreement& agreement,
                                               const LinePick& own) {
  const ImageLine& line = found.line(own);
  const double corner_px = line.direction.dot(agreement.pixel - line.point);
  const Stretch stretch = stretch_of_pixels(found, agreement, own, corner_px);
  if (!(stretch.to_px - stretch.from_px >= kLeastStretchPx)) return std::nullopt;
  return fit_blurred_edge(input.image, line,
                          {corner_px + stretch.from_px, corner_px + stretch.to_px},
                          input.options.search.noise_sd_grey);
}

// The lines that agree, refitted, and how many cannot be: these are among them only if fewer than
// two can.
struct Refitted {
  std::vector<ImageLine> lines;
  size_t missing = 0;
};

Refitted refitted_lines(const ExtractionInput& input, const Candidates& found,
                        const Agreement& agreement) {
  Refitted refitted_ones;
  std::vector<ImageLine> others;
  for (const LinePick& pick : agreement.picks) {
    const SoughtEdge& edge = found.edge(pick);
    auto fit = refitted(input, edge, found.line(pick), agreement.pixel);
    if (!fit && edge.run.beside.empty()) {
      fit = refitted_along_pixels(input, found, agreement, pick);
    }
    if (!fit) {
      others.push_back(found.line(pick));
      continue;
    }
    fit->covariance(0, 0) += edge.floor_px * edge.floor_px;
    fit->edge_pixels = found.line(pick).edge_pixels;
    refitted_ones.lines.push_back(std::move(*fit));
  }
  refitted_ones.missing = others.size();
  if (refitted_ones.lines.size() < 2) {
    std::move(others.begin(), others.end(), std::back_inserter(refitted_ones.lines));
  }
  return refitted_ones;
}

// Of the agreements the best along all of whose lines blurred edges lie: lines without one are the
// wrong ones. Where there is no such agreement, the best.
std::vector<ImageLine> best_lines(const ExtractionInput& input, const Candidates& found,
                                  const std::vector<Agreement>& agreements) {
  Refitted best = refitted_lines(input, found, agreements.front());
  for (size_t i = 1; i < agreements.size() && best.missing > 0; ++i) {
    Refitted next = refitted_lines(input, found, agreements[i]);
    if (next.missing == 0) best = std::move(next);
  }
  return std::move(best.lines);
}

// A point that the prior all but excludes may be another feature's: it is known no better than so
// far that the prior is within three sigmas.
Eigen::Matrix2d doubted_by_prior(const FeaturePrediction& prediction,
                                 const Observation& observation) {
  constexpr double kMostSigmas = 3;
  constexpr double kLeastPriorPx = 0.3;  // a pose found before errs by more than it says
  const Eigen::Vector2d off = observation.pixel - prediction.pixel;
  const Eigen::Matrix2d covariance = prediction.covariance_px2 + observation.covariance_px2 +
                                     kLeastPriorPx * kLeastPriorPx * Eigen::Matrix2d::Identity();
  const bool is_likely = off.dot(covariance.inverse() * off) < kMostSigmas * kMostSigmas;
  if (is_likely) return observation.covariance_px2;
  return observation.covariance_px2 + off * off.transpose() / (kMostSigmas * kMostSigmas);
}

}  // namespace

Observation extract_hough_subpixel(const ExtractionInput& input) {
  const Candidates found = candidates_in(input);
  const std::vector<Agreement> agreements = agreements_of(input, found);
  if (agreements.empty()) {
    Observation observation = nothing_found(input);
    observation.status = ObservationStatus::kTooFewEdgePixels;
    return observation;
  }
  Observation observation = found_at_meeting(
      nothing_found(input), best_lines(input, found, agreements), kLeastMeetingDeg);
  if (observation.status != ObservationStatus::kFound) return observation;
  observation.contrast_grey = weakest_contrast_grey(observation.lines);
  // Lines meet at a small angle that are not known well enough for it.
  const bool is_loose = !(worst_sd_px(observation.covariance_px2) <= kMaxLooseSdPx);
  if (is_loose) observation.status = ObservationStatus::kParallelLines;
  observation.covariance_px2 = doubted_by_prior(input.prediction, observation);
  return observation;
}

}  // namespace sightline
