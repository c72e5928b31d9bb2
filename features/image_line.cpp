// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/image_line.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace sightline {
namespace {

bool contains(const cv::Rect& window, const Eigen::Vector2d& pixel) {
  return pixel.x() >= window.x - 0.5 && pixel.y() >= window.y - 0.5 &&
         pixel.x() <= window.br().x - 0.5 && pixel.y() <= window.br().y - 0.5;
}

}  // namespace

ImageLine fit_line(std::vector<Eigen::Vector2d> edge_pixels, double least_sd_px) {
  ImageLine line;
  const double n = static_cast<double>(edge_pixels.size());
  for (const Eigen::Vector2d& pixel : edge_pixels) line.point += pixel / n;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& pixel : edge_pixels) {
    scatter += (pixel - line.point) * (pixel - line.point).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(scatter);
  line.direction = eigen.eigenvectors().col(1);
  line.rms_px = std::sqrt(std::max(0.0, eigen.eigenvalues()(0)) / n);
  line.edge_pixels = std::move(edge_pixels);
  const double sd = std::max(line.rms_px, least_sd_px);
  line.covariance.diagonal() << sd * sd / n, sd * sd / std::max(eigen.eigenvalues()(1), 1.0);
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

double offset_variance_px2(const ImageLine& line, const Eigen::Vector2d& pixel) {
  const double along = line.direction.dot(pixel - line.point);
  return line.covariance(0, 0) + 2 * along * line.covariance(0, 1) +
         along * along * line.covariance(1, 1);
}

void meet(double min_angle_deg, Observation& observation) {
  if (observation.lines.size() < 2) {
    observation.status = ObservationStatus::kTooFewEdgePixels;
    return;
  }
  const ImageLine& a = observation.lines[0];
  const ImageLine& b = observation.lines[1];
  const double sine =
      std::abs(a.direction.x() * b.direction.y() - a.direction.y() * b.direction.x());
  if (sine < std::sin(min_angle_deg * std::numbers::pi / 180)) {
    observation.status = ObservationStatus::kParallelLines;
    return;
  }
  // Rows of `normals` times the pixel equal the lines' offsets, so the pixel's covariance is that
  // of the two independent offsets carried through the inverse.
  Eigen::Matrix2d normals;
  normals << -a.direction.y(), a.direction.x(), -b.direction.y(), b.direction.x();
  const Eigen::Matrix2d inverse_normals = normals.inverse();
  const Eigen::Vector2d pixel =
      inverse_normals * Eigen::Vector2d(normals.row(0).dot(a.point.transpose()),
                                        normals.row(1).dot(b.point.transpose()));
  if (!contains(observation.window, pixel)) {
    observation.status = ObservationStatus::kOutsideWindow;
    return;
  }
  const Eigen::Vector2d variances(offset_variance_px2(a, pixel), offset_variance_px2(b, pixel));
  observation.status = ObservationStatus::kFound;
  observation.pixel = pixel;
  observation.covariance_px2 =
      inverse_normals * variances.asDiagonal() * inverse_normals.transpose();
}

}  // namespace sightline
