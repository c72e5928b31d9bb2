// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The lines of hough_intersection, with Canny's thresholds set by the image's noise, each then
// refitted to the grey levels beside it as a straight blurred edge (features/blurred_edge.h), away
// from the corner, where the other edge bends it.
#include <algorithm>
#include <cmath>
#include <optional>

#include "features/blurred_edge.h"
#include "features/extractors/extractors.h"
#include "features/hough_lines.h"
#include "features/image_line.h"

namespace sightline {
namespace {

// Sobel's kernel, as Canny's, sums to 8, and sees of white noise smoothed by 1 px about what a
// Gaussian derivative of 1.2 px would: 8 x 0.139.
constexpr double kSobelNoise = 1.11;
constexpr double kLowNoises = 6;
constexpr double kHighNoises = 10;
constexpr double kLeastCanny = 8;   // where there is no noise: an edge of about three grey levels
constexpr double kBandPx = 3;       // of fit_blurred_edge
constexpr double kOffCornerPx = 3;  // of a band's pixel from the other line
constexpr double kOffEndPx = 1;     // from the last edge pixel
constexpr double kLeastStretchPx = 6;
constexpr double kFloorPx = 0.03;  // of a line's offset: what an even, straight edge is not

LineOptions canny_by_noise(LineOptions options, double noise_sd_grey) {
  const double noise = kSobelNoise * noise_sd_grey;
  options.canny_low = std::max(kLeastCanny, kLowNoises * noise);
  options.canny_high = std::max(1.5 * kLeastCanny, kHighNoises * noise);
  return options;
}

// The stretch of a line's edge pixels on the side of the corner to which `away` points.
std::optional<Stretch> stretch_of(const ImageLine& line, const ImageLine& other,
                                  const Eigen::Vector2d& corner, const Eigen::Vector2d& away) {
  const double sense = line.direction.dot(away) >= 0 ? 1 : -1;
  const double sine =
      std::abs(line.direction.x() * other.direction.y() - line.direction.y() * other.direction.x());
  const double cosine = std::abs(line.direction.dot(other.direction));
  const double gap_px = (kOffCornerPx + kBandPx * cosine) / sine;
  const double corner_px = line.direction.dot(corner - line.point);
  double first = std::numeric_limits<double>::infinity();
  double last = -first;
  for (const Eigen::Vector2d& pixel : line.edge_pixels) {
    const double from_corner = sense * (line.direction.dot(pixel - line.point) - corner_px);
    if (from_corner < 0) continue;
    first = std::min(first, from_corner);
    last = std::max(last, from_corner);
  }
  first = std::max(first, gap_px);
  last -= kOffEndPx;
  if (!(last - first >= kLeastStretchPx)) return std::nullopt;
  const double a = corner_px + sense * first;
  const double b = corner_px + sense * last;
  return Stretch{std::min(a, b), std::max(a, b)};
}

}  // namespace

void extract_hough_subpixel(const ExtractionInput& input, Observation& observation) {
  const LineOptions options =
      canny_by_noise(input.options.line, input.options.search.noise_sd_grey);
  observation.lines = strongest_lines(input, observation.window, options);
  meet(options.min_angle_deg, observation);
  if (observation.status != ObservationStatus::kFound) return;

  std::vector<ImageLine> refined;
  for (int i = 0; i < 2; ++i) {
    const ImageLine& line = observation.lines[i];
    const auto stretch = stretch_of(line, observation.lines[1 - i], observation.pixel,
                                    input.prediction.edge_direction[i]);
    auto fit =
        stretch ? fit_blurred_edge(input.image, line, *stretch, input.options.search.noise_sd_grey)
                : std::nullopt;
    if (fit) fit->covariance(0, 0) += kFloorPx * kFloorPx;
    if (fit) {
      observation.contrast_grey = refined.empty()
                                      ? fit->contrast_grey
                                      : std::min(observation.contrast_grey, fit->contrast_grey);
    }
    refined.push_back(fit ? std::move(*fit) : line);
  }
  observation.lines = std::move(refined);
  meet(options.min_angle_deg, observation);
}

}  // namespace sightline
