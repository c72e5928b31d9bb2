// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The two edges of the feature as the prior pose shows them on the mesh: where they are to be seen,
// every pixel along them, the peaks of the image's gradient along the normal, of the polarity that
// target and background give. The peaks vote for an offset and a slope of the line; robust least
// squares fits it; the feature is where the two lines meet. Offsets are against the outline of the
// mesh itself, so that a rounded edge does no harm.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "features/extractors/extractors.h"
#include "features/image_line.h"
#include "features/outline_search.h"

namespace sightline {
namespace {

constexpr double kGapPx = 2.5;  // kept off an edge's ends, where the next edge bends the gradient
constexpr double kMinSupport = 0.4;  // of the samples must have a peak on the line
constexpr size_t kFewestSamples = 4;
constexpr std::array kRoundsPx = {1.8, 1.3, 1.0, 0.8};  // of a peak from the line, round by round
// Neighbouring samples share what smoothing and blur spread: so many are worth one.
constexpr double kSamplesOfOne = 3;
constexpr double kLeastScatterPx = 0.05;
constexpr double kOtherPartPx = 0.8;  // more sigma for an edge against another part of the target

struct SamplePeaks {
  double along_px;
  EdgePeaks peaks;
};

// offset + slope (along - pivot), against the prediction.
struct Line {
  double offset_px = 0;
  double slope = 0;
};

std::vector<OutlineSample> samples_of(const PredictedEdge& edge) {
  std::vector<OutlineSample> samples;
  samples.reserve(edge.samples.size());
  for (const PredictedEdge::Sample& sample : edge.samples) {
    samples.push_back(
        {edge.begin + sample.along_px * edge.direction + sample.offset_px * edge.normal,
         edge.normal, sample.borders_target});
  }
  return samples;
}

// The line with the most votes, counted in cells of half a pixel and their neighbours.
Line voted(const std::vector<SamplePeaks>& samples, double pivot_px, double half_px,
           double max_slope) {
  constexpr double kCellPx = 0.5;
  constexpr int kSlopes = 6;  // to either side
  const int half_cells = static_cast<int>(std::ceil(half_px / kCellPx)) + 1;
  const int cells = 2 * half_cells + 1;
  std::vector<float> votes(cells);
  Line best;
  float most = 0;
  for (int i = -kSlopes; i <= kSlopes; ++i) {
    const double slope = max_slope * i / kSlopes;
    std::fill(votes.begin(), votes.end(), 0.F);
    for (const SamplePeaks& sample : samples) {
      for (const EdgePeak& peak : sample.peaks) {
        const double offset_px = peak.offset_px - slope * (sample.along_px - pivot_px);
        const int cell = half_cells + static_cast<int>(std::lround(offset_px / kCellPx));
        if (cell >= 0 && cell < cells) votes[cell] += 1;
      }
    }
    for (int cell = 1; cell + 1 < cells; ++cell) {
      // Of equal counts the better centred, then the lesser slope.
      const float count = votes[cell - 1] + 1.01F * votes[cell] + votes[cell + 1] -
                          1e-3F * static_cast<float>(std::abs(i));
      if (count <= most) continue;
      most = count;
      best = {(cell - half_cells) * kCellPx, slope};
    }
  }
  return best;
}

struct FittedLine {
  Line line;
  double rms_px = 0;
  Eigen::Matrix2d covariance;
  std::vector<std::pair<double, double>> points;  // along, offset
  double gradient = 0;                            // mean height of the peaks
};

std::optional<FittedLine> fitted(const std::vector<SamplePeaks>& samples, double pivot_px,
                                 Line line, double max_slope) {
  FittedLine fit;
  const double slope_sd = max_slope / 2;
  for (const double round_px : kRoundsPx) {
    fit.points.clear();
    fit.gradient = 0;
    double n = 0, st = 0, stt = 0, so = 0, sto = 0;
    for (const SamplePeaks& sample : samples) {
      const double t = sample.along_px - pivot_px;
      const double expected_px = line.offset_px + line.slope * t;
      const EdgePeak* nearest = nullptr;
      double nearest_px = round_px;
      for (const EdgePeak& peak : sample.peaks) {
        const double distance_px = std::abs(peak.offset_px - expected_px);
        if (distance_px > nearest_px) continue;
        nearest_px = distance_px;
        nearest = &peak;
      }
      if (nearest == nullptr) continue;
      fit.points.emplace_back(t, nearest->offset_px);
      fit.gradient += std::abs(nearest->gradient);
      n += 1;
      st += t;
      stt += t * t;
      so += nearest->offset_px;
      sto += t * nearest->offset_px;
    }
    if (n < kFewestSamples || n < kMinSupport * static_cast<double>(samples.size())) {
      return std::nullopt;
    }
    // The slope is known beforehand to slope_sd; a point to about a fifth of a pixel, three of them
    // worth one.
    constexpr double kPointPx = 0.2;
    const double known = kSamplesOfOne * kPointPx * kPointPx / (slope_sd * slope_sd);
    const double determinant = n * (stt + known) - st * st;
    line.slope = (n * sto - st * so) / determinant;
    line.offset_px = (so - line.slope * st) / n;
    fit.line = line;
    fit.covariance << (stt + known) / determinant, -st / determinant, -st / determinant,
        n / determinant;
  }
  double squares = 0;
  for (const auto& [t, offset_px] : fit.points) {
    const double residual = offset_px - line.offset_px - line.slope * t;
    squares += residual * residual;
  }
  const double n = static_cast<double>(fit.points.size());
  fit.gradient /= n;
  fit.rms_px = std::sqrt(squares / n);
  const double sd = std::max(fit.rms_px, kLeastScatterPx);
  fit.covariance *= kSamplesOfOne * sd * sd;
  if (std::abs(line.slope) > 1.5 * max_slope) return std::nullopt;
  return fit;
}

// What the fit does not know of, measured on airliners under many lights. Shading across a rounded
// edge moves its image: inwards and by more the darker its limb, against a darker background; less
// against a brighter one.
double floor_px(bool is_soft, double contrast_grey, int polarity) {
  constexpr double kMostPx = 1.5;
  if (!is_soft) return std::min(kMostPx, std::hypot(0.012, 1.7 / contrast_grey));
  const double against_bright = 2.4 / std::sqrt(contrast_grey);
  const double against_dark = 170 / std::pow(contrast_grey, 1.5);
  if (polarity > 0) return std::min(kMostPx, against_bright);
  return std::min(kMostPx, against_dark);
}

// True where mostly another part of the target is behind the outline, whose own edges are near.
bool borders_other_part(const PredictedEdge& edge) {
  const auto bordering = std::count_if(edge.samples.begin(), edge.samples.end(),
                                       [](const auto& sample) { return sample.borders_target; });
  return !edge.is_crease && 2 * bordering > static_cast<std::ptrdiff_t>(edge.samples.size());
}

std::optional<ImageLine> find_line(const ExtractionInput& input, const GradientWindow& gradients,
                                   const PredictedEdge& edge,
                                   const std::vector<OutlineSample>& samples, int polarity) {
  const SearchOptions& options = input.options.search;
  const double half_px = search_half_px(input, edge.normal);
  const double threshold = gradient_threshold(options);
  std::vector<SamplePeaks> peaks;
  peaks.reserve(samples.size());
  for (size_t i = 0; i < samples.size(); ++i) {
    const OutlineSample& sample = samples[i];
    peaks.push_back(
        {edge.samples[i].along_px, find_peaks(gradients, sample.pixel, edge.normal, half_px,
                                              sample.borders_target ? 0 : polarity, threshold)});
  }
  const double pivot_px = (edge.samples.front().along_px + edge.samples.back().along_px) / 2;
  const double max_slope = is_prior_good(input) ? options.good_max_slope : options.max_slope;
  const Line start = voted(peaks, pivot_px, half_px, max_slope);
  const auto fit = fitted(peaks, pivot_px, start, max_slope);
  if (!fit) return std::nullopt;
  const double contrast_grey = fit->gradient / kGradientOfUnitEdge;
  ImageLine line;
  line.point = edge.begin + pivot_px * edge.direction + fit->line.offset_px * edge.normal;
  line.direction = (edge.direction + fit->line.slope * edge.normal).normalized();
  line.rms_px = fit->rms_px;
  line.contrast_grey = contrast_grey;
  line.covariance = fit->covariance;
  const double floor = options.floor_scale * floor_px(edge.is_soft, contrast_grey, polarity) +
                       (borders_other_part(edge) ? kOtherPartPx : 0);
  line.covariance(0, 0) += floor * floor;
  // ImageLine counts offsets along its direction turned by a right angle.
  const bool is_turned =
      edge.normal.dot(Eigen::Vector2d(-edge.direction.y(), edge.direction.x())) < 0;
  if (is_turned) line.covariance(0, 1) = line.covariance(1, 0) = -line.covariance(0, 1);
  for (const auto& [t, offset_px] : fit->points) {
    line.edge_pixels.push_back(edge.begin + (pivot_px + t) * edge.direction +
                               offset_px * edge.normal);
  }
  return line;
}

}  // namespace

void extract_model_edges(const ExtractionInput& input, Observation& observation) {
  observation.window =
      window_around(input.prediction.pixel, search_window_half_px(input), input.image.size());
  if (observation.window.empty()) {
    observation.status = ObservationStatus::kOutsideImage;
    return;
  }
  const SearchOptions& options = input.options.search;
  const double reach_px = is_prior_good(input) ? options.good_reach_px : options.reach_px;
  std::array<PredictedEdge, 2> edges;
  std::array<std::vector<OutlineSample>, 2> samples;
  std::vector<OutlineSample> all;
  for (int i = 0; i < 2; ++i) {
    edges[i] = predict_edge(input.view, input.prediction, i, kGapPx, reach_px);
    samples[i] = samples_of(edges[i]);
    if (samples[i].size() < kFewestSamples) {
      observation.status = ObservationStatus::kNoOutline;
      return;
    }
    all.insert(all.end(), samples[i].begin(), samples[i].end());
  }
  const GradientWindow gradients = gradients_around(input, all);
  const int polarity = outline_polarity(input, all);
  for (int i = 0; i < 2; ++i) {
    auto line = find_line(input, gradients, edges[i], samples[i], polarity);
    if (!line) continue;
    observation.contrast_grey = observation.lines.empty()
                                    ? line->contrast_grey
                                    : std::min(observation.contrast_grey, line->contrast_grey);
    observation.lines.push_back(std::move(*line));
  }
  meet(input.options.line.min_angle_deg, observation);
}

}  // namespace sightline
