// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/hough_lines.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <opencv2/imgproc.hpp>

#include "features/image_line.h"
#include "pose/angles.h"

namespace sightline {
namespace {

constexpr double kSmoothingSigmaPx = 1.0;  // before Canny
constexpr double kHoughDistancePx = 1.5;   // of an edge pixel from the Hough line it votes for
constexpr double kRefitDistancePx = 1.0;   // of an edge pixel from the fitted line

cv::Mat canny_edges(const cv::Mat& image, const cv::Rect& window, const LineOptions& options) {
  // Smooth with a border of the image around the window, so that its rim makes no edges.
  constexpr int kBorderPx = 6;
  const cv::Rect wide = cv::Rect(window.x - kBorderPx, window.y - kBorderPx,
                                 window.width + 2 * kBorderPx, window.height + 2 * kBorderPx) &
                        cv::Rect({0, 0}, image.size());
  cv::Mat smooth, edges;
  cv::GaussianBlur(image(wide), smooth, {}, kSmoothingSigmaPx);
  cv::Canny(smooth, edges, options.canny_low, options.canny_high, 3, /*L2gradient=*/true);
  return edges(cv::Rect(window.tl() - wide.tl(), window.size())).clone();
}

std::vector<Eigen::Vector2d> pixels_of(const cv::Mat& edges, const cv::Rect& window) {
  std::vector<Eigen::Vector2d> pixels;
  for (int v = 0; v < edges.rows; ++v) {
    for (int u = 0; u < edges.cols; ++u) {
      if (edges.at<uint8_t>(v, u) != 0) pixels.emplace_back(window.x + u, window.y + v);
    }
  }
  return pixels;
}

// Lines with enough votes, most votes first, in image coordinates.
std::vector<HoughLine> hough_lines(const cv::Mat& edges, const cv::Rect& window, int min_votes) {
  std::vector<cv::Vec2f> found;
  cv::HoughLines(edges, found, /*rho=*/1, /*theta=*/kDegree, min_votes);
  const Eigen::Vector2d origin(window.x, window.y);
  std::vector<HoughLine> lines;
  for (const cv::Vec2f& line : found) {
    const Eigen::Vector2d normal(std::cos(line[1]), std::sin(line[1]));
    lines.push_back({line[0] + normal.dot(origin), normal});
  }
  return lines;
}

// The edge pixels that agree with a Hough line, then with the line fitted to them.
std::optional<ImageLine> fitted(const HoughLine& line,
                                const std::vector<Eigen::Vector2d>& edge_pixels,
                                const LineOptions& options) {
  const Eigen::Vector2d on_line = line.distance_px * line.normal;
  auto agreeing = pixels_near(edge_pixels, on_line, line.normal, kHoughDistancePx);
  if (static_cast<int>(agreeing.size()) < options.min_edge_pixels) return std::nullopt;
  const ImageLine first = fit_line(std::move(agreeing), kEdgeQuantisationPx);
  const Eigen::Vector2d normal(-first.direction.y(), first.direction.x());
  agreeing = pixels_near(edge_pixels, first.point, normal, kRefitDistancePx);
  if (static_cast<int>(agreeing.size()) < options.min_edge_pixels) return std::nullopt;
  return fit_line(std::move(agreeing), kEdgeQuantisationPx);
}

bool is_candidate(const HoughLine& line, const Eigen::Vector2d& direction,
                  const ExtractionInput& input, const LineOptions& options) {
  const double max_sine = std::sin(options.direction_tolerance_deg * kDegree);
  if (std::abs(line.normal.dot(direction)) > max_sine) return false;
  if (!input.options.is_gated) return true;
  const double off_px = std::abs(line.normal.dot(input.prediction.pixel) - line.distance_px);
  return off_px <= search_half_px(input, line.normal);
}

// True where two lines share most of the edge pixels of the one that has fewer.
bool is_same(const ImageLine& a, const ImageLine& b) {
  const bool is_a_shorter = a.edge_pixels.size() < b.edge_pixels.size();
  const ImageLine& longer = is_a_shorter ? b : a;
  const ImageLine& shorter = is_a_shorter ? a : b;
  const Eigen::Vector2d normal(-longer.direction.y(), longer.direction.x());
  const auto shared = pixels_near(shorter.edge_pixels, longer.point, normal, kRefitDistancePx);
  return 10 * shared.size() > 8 * shorter.edge_pixels.size();
}

}  // namespace

HoughTransform hough_transform(const cv::Mat& image, const cv::Rect& window,
                               const LineOptions& options) {
  const cv::Mat edges = canny_edges(image, window, options);
  return {pixels_of(edges, window), hough_lines(edges, window, options.min_votes)};
}

std::vector<ImageLine> lines_along(const Eigen::Vector2d& direction, const HoughTransform& hough,
                                   const ExtractionInput& input, const LineOptions& options,
                                   size_t most) {
  std::vector<ImageLine> found;
  for (const HoughLine& line : hough.lines) {
    if (!is_candidate(line, direction, input, options)) continue;
    auto fit = fitted(line, hough.edge_pixels, options);
    if (!fit && found.empty()) return found;
    const bool is_new =
        fit && std::none_of(found.begin(), found.end(),
                            [&](const ImageLine& other) { return is_same(*fit, other); });
    if (is_new) found.push_back(std::move(*fit));
    if (found.size() >= most) return found;
  }
  return found;
}

}  // namespace sightline
