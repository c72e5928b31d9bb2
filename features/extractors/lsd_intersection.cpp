// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Line segments by LSD (Grompone von Gioi et al., PAMI 2010), as OpenCV has it. For each of the
// feature's edges the segments nearly parallel to it that lie on one line, the longest together; a
// least-squares line through them; the feature is where the two lines meet.
#include <algorithm>
#include <cmath>
#include <optional>

#include <opencv2/imgproc.hpp>

#include "features/extractors/extractors.h"
#include "features/image_line.h"
#include "pose/angles.h"

namespace sightline {
namespace {

// OpenCV's segments lie this far towards the image's origin, in u and in v. Measured; the test
// Lsd.ItsShiftIsCorrected holds what is left of it to less than 0.05 px.
constexpr double kShiftPx = 0.12;
constexpr double kOneLinePx = 1;      // of a segment's ends from the line it is joined to
constexpr double kSegmentSdPx = 0.2;  // of points along a segment: an upper estimate
constexpr int kBorderPx = 6;

struct LsdSegment {
  Eigen::Vector2d begin, end;

  Eigen::Vector2d direction() const { return (end - begin).normalized(); }
  double length_px() const { return (end - begin).norm(); }
};

std::vector<LsdSegment> segments_in(const cv::Mat& image, const cv::Rect& window) {
  const cv::Rect wide = cv::Rect(window.x - kBorderPx, window.y - kBorderPx,
                                 window.width + 2 * kBorderPx, window.height + 2 * kBorderPx) &
                        cv::Rect({0, 0}, image.size());
  std::vector<cv::Vec4f> found;
  cv::createLineSegmentDetector()->detect(image(wide), found);
  const Eigen::Vector2d origin(wide.x + kShiftPx, wide.y + kShiftPx);
  std::vector<LsdSegment> segments;
  for (const cv::Vec4f& s : found) {
    segments.push_back(
        {origin + Eigen::Vector2d(s[0], s[1]), origin + Eigen::Vector2d(s[2], s[3])});
  }
  return segments;
}

double distance_px(const LsdSegment& line, const Eigen::Vector2d& point) {
  const Eigen::Vector2d d = line.direction();
  return std::abs(d.x() * (point - line.begin).y() - d.y() * (point - line.begin).x());
}

// Points each pixel along the segments on one line with `seed`.
std::vector<Eigen::Vector2d> joined_to(const LsdSegment& seed,
                                       const std::vector<LsdSegment>& segments) {
  std::vector<Eigen::Vector2d> points;
  for (const LsdSegment& segment : segments) {
    if (std::max(distance_px(seed, segment.begin), distance_px(seed, segment.end)) > kOneLinePx) {
      continue;
    }
    const int steps = std::max(1, static_cast<int>(segment.length_px()));
    for (int i = 0; i <= steps; ++i) {
      points.push_back(segment.begin + i * (segment.end - segment.begin) / steps);
    }
  }
  return points;
}

std::optional<ImageLine> longest_line(const std::vector<LsdSegment>& segments,
                                      const Eigen::Vector2d& direction,
                                      const ExtractionInput& input) {
  const LineOptions& options = input.options.line;
  const double min_cosine = std::cos(options.direction_tolerance_deg * kDegree);
  std::vector<LsdSegment> parallel;
  for (const LsdSegment& segment : segments) {
    if (std::abs(segment.direction().dot(direction)) < min_cosine) continue;
    const Eigen::Vector2d normal(-segment.direction().y(), segment.direction().x());
    const bool is_near = !input.options.is_gated || distance_px(segment, input.prediction.pixel) <=
                                                        search_half_px(input, normal);
    if (is_near) parallel.push_back(segment);
  }
  std::vector<Eigen::Vector2d> longest;
  for (const LsdSegment& seed : parallel) {
    auto points = joined_to(seed, parallel);
    if (points.size() > longest.size()) longest = std::move(points);
  }
  if (static_cast<int>(longest.size()) < options.min_edge_pixels) return std::nullopt;
  // The points of a segment err together: they are worth two.
  ImageLine line = fit_line(std::move(longest), kSegmentSdPx);
  line.covariance *= static_cast<double>(line.edge_pixels.size()) / 2;
  return line;
}

}  // namespace

Observation extract_lsd_intersection(const ExtractionInput& input) {
  const std::vector<LsdSegment> segments = segments_in(input.image, input.window);
  std::vector<ImageLine> lines;
  for (const Eigen::Vector2d& direction : input.prediction.edge_direction) {
    auto line = longest_line(segments, direction, input);
    if (line) lines.push_back(std::move(*line));
  }
  return found_at_meeting(nothing_found(input), std::move(lines), input.options.line.min_angle_deg);
}

}  // namespace sightline
