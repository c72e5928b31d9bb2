// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The wing corners of the ORPE paper (section 4): in the window, Canny edges; Hough lines; for each
// of the feature's two edges the line with the most votes within a tolerance of the direction that
// the prior pose predicts; a least-squares line through the edge pixels that agree with it; the
// feature is where the two lines meet.
// The paper does not say how it tells the two lines apart; the predicted directions do it here. The
// nearest wrong edge of like direction can win the vote (a trailing edge for a leading edge): that
// is the outlier the paper is about.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include "features/extractors/extractors.h"

namespace sightline {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kSmoothingSigmaPx = 1.0;     // before Canny
constexpr double kHoughDistancePx = 1.5;      // of an edge pixel from the Hough line it votes for
constexpr double kRefitDistancePx = 1.0;      // of an edge pixel from the fitted line
constexpr double kEdgeQuantisationPx = 0.29;  // 1/sqrt(12): Canny gives whole pixels

struct HoughLine {
  double distance_px;  // of the origin, along the normal
  Eigen::Vector2d normal;
};

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

// The least-squares line (orthogonal distances) through pixels.
ImageLine fit_line(std::vector<Eigen::Vector2d> pixels) {
  ImageLine line;
  const double n = static_cast<double>(pixels.size());
  for (const Eigen::Vector2d& pixel : pixels) line.point += pixel / n;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& pixel : pixels) {
    scatter += (pixel - line.point) * (pixel - line.point).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(scatter);
  line.direction = eigen.eigenvectors().col(1);
  line.rms_px = std::sqrt(std::max(0.0, eigen.eigenvalues()(0)) / n);
  line.edge_pixels = std::move(pixels);
  return line;
}

std::vector<Eigen::Vector2d> pixels_near(const std::vector<Eigen::Vector2d>& pixels,
                                         const Eigen::Vector2d& point,
                                         const Eigen::Vector2d& normal, double distance_px) {
  std::vector<Eigen::Vector2d> near;
  for (const Eigen::Vector2d& pixel : pixels) {
    if (std::abs(normal.dot(pixel - point)) <= distance_px) near.push_back(pixel);
  }
  return near;
}

// The strongest line along a predicted direction, fitted to the edge pixels that agree.
std::optional<ImageLine> find_line(const std::vector<HoughLine>& lines,
                                   const std::vector<Eigen::Vector2d>& edge_pixels,
                                   const Eigen::Vector2d& direction, const LineOptions& options) {
  const double max_sine = std::sin(options.direction_tolerance_deg * kDegree);
  const auto strongest = std::find_if(lines.begin(), lines.end(), [&](const HoughLine& line) {
    return std::abs(line.normal.dot(direction)) <= max_sine;
  });
  if (strongest == lines.end()) return std::nullopt;

  const Eigen::Vector2d on_line = strongest->distance_px * strongest->normal;
  auto agreeing = pixels_near(edge_pixels, on_line, strongest->normal, kHoughDistancePx);
  if (static_cast<int>(agreeing.size()) < options.min_edge_pixels) return std::nullopt;
  ImageLine line = fit_line(std::move(agreeing));
  const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
  agreeing = pixels_near(edge_pixels, line.point, normal, kRefitDistancePx);
  if (static_cast<int>(agreeing.size()) < options.min_edge_pixels) return std::nullopt;
  return fit_line(std::move(agreeing));
}

// Variance of a line's offset along its normal at a point: that of a fitted straight line.
double offset_variance_px2(const ImageLine& line, const Eigen::Vector2d& at) {
  const double n = static_cast<double>(line.edge_pixels.size());
  double spread = 0;
  for (const Eigen::Vector2d& pixel : line.edge_pixels) {
    const double along = line.direction.dot(pixel - line.point);
    spread += along * along;
  }
  const double sd = std::max(line.rms_px, kEdgeQuantisationPx);
  const double along = line.direction.dot(at - line.point);
  return sd * sd * (1 / n + along * along / std::max(spread, 1.0));
}

struct Intersection {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance_px2;
};

// Rows of `normals` times the pixel equal the lines' offsets, so the pixel's covariance is that of
// the two independent offsets carried through the inverse.
Intersection intersect(const ImageLine& a, const ImageLine& b) {
  Eigen::Matrix2d normals;
  normals << -a.direction.y(), a.direction.x(), -b.direction.y(), b.direction.x();
  const Eigen::Matrix2d inverse_normals = normals.inverse();
  Intersection out;
  out.pixel = inverse_normals * Eigen::Vector2d(normals.row(0).dot(a.point.transpose()),
                                                normals.row(1).dot(b.point.transpose()));
  const Eigen::Vector2d variances(offset_variance_px2(a, out.pixel),
                                  offset_variance_px2(b, out.pixel));
  out.covariance_px2 = inverse_normals * variances.asDiagonal() * inverse_normals.transpose();
  return out;
}

bool contains(const cv::Rect& window, const Eigen::Vector2d& pixel) {
  return pixel.x() >= window.x - 0.5 && pixel.y() >= window.y - 0.5 &&
         pixel.x() <= window.br().x - 0.5 && pixel.y() <= window.br().y - 0.5;
}

}  // namespace

void extract_hough_intersection(const cv::Mat& image, const FeaturePrediction& prediction,
                                const ExtractorOptions& options, Observation& observation) {
  const cv::Rect& window = observation.window;
  const cv::Mat edges = canny_edges(image, window, options.line);
  const auto edge_pixels = pixels_of(edges, window);
  const auto lines = hough_lines(edges, window, options.line.min_votes);
  for (const Eigen::Vector2d& direction : prediction.edge_direction) {
    auto line = find_line(lines, edge_pixels, direction, options.line);
    if (line) observation.lines.push_back(std::move(*line));
  }
  if (observation.lines.size() < 2) {
    observation.status = ObservationStatus::kTooFewEdgePixels;
    return;
  }
  const ImageLine& a = observation.lines[0];
  const ImageLine& b = observation.lines[1];
  const double sine =
      std::abs(a.direction.x() * b.direction.y() - a.direction.y() * b.direction.x());
  if (sine < std::sin(options.line.min_angle_deg * kDegree)) {
    observation.status = ObservationStatus::kParallelLines;
    return;
  }
  const Intersection meeting = intersect(a, b);
  if (!contains(window, meeting.pixel)) {
    observation.status = ObservationStatus::kOutsideWindow;
    return;
  }
  observation.status = ObservationStatus::kFound;
  observation.pixel = meeting.pixel;
  observation.covariance_px2 = meeting.covariance_px2;
}

}  // namespace sightline
