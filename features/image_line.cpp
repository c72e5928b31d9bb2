// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/image_line.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "pose/angles.h"

namespace sightline {

bool contains(const cv::Rect& window, const Eigen::Vector2d& pixel) {
  return pixel.x() >= window.x - 0.5 && pixel.y() >= window.y - 0.5 &&
         pixel.x() <= window.br().x - 0.5 && pixel.y() <= window.br().y - 0.5;
}

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

Stretch seen_stretch(const ImageLine& line) {
  if (line.edge_pixels.empty()) return {};
  const auto along_px = [&line](const Eigen::Vector2d& pixel) {
    return line.direction.dot(pixel - line.point);
  };
  Stretch stretch{along_px(line.edge_pixels.front()), along_px(line.edge_pixels.front())};
  for (const Eigen::Vector2d& pixel : line.edge_pixels) {
    stretch.from_px = std::min(stretch.from_px, along_px(pixel));
    stretch.to_px = std::max(stretch.to_px, along_px(pixel));
  }
  return stretch;
}

Eigen::Vector2d seen_middle(const ImageLine& line) {
  const Stretch stretch = seen_stretch(line);
  return line.point + (stretch.from_px + stretch.to_px) / 2 * line.direction;
}

void add_noise_at_ends(double sd_px, ImageLine& line) {
  const double half_px = std::max(1.0, seen_stretch(line).half_length_px());
  const double middle_px = line.direction.dot(seen_middle(line) - line.point);
  const double variance_px2 = sd_px * sd_px / 2;  // at the middle, which is the mean of both ends
  const double of_slope = variance_px2 / (half_px * half_px);
  Eigen::Matrix2d noise;
  noise << variance_px2 + middle_px * middle_px * of_slope, -middle_px * of_slope,
      -middle_px * of_slope, of_slope;
  line.covariance += noise;
}

LineObservation line_observation(const EdgeLine& found, const TargetFeature& feature) {
  const Edge& edge = feature.edges[static_cast<size_t>(found.edge)];
  return {edge.begin_m, edge.end_m, found.line.point, found.line.direction, found.line.covariance};
}

double offset_variance_px2(const ImageLine& line, const Eigen::Vector2d& pixel) {
  const double along = line.direction.dot(pixel - line.point);
  return line.covariance(0, 0) + 2 * along * line.covariance(0, 1) +
         along * along * line.covariance(1, 1);
}

std::optional<ImageLine> beyond_offset_at(const ImageLine& line, const Eigen::Vector2d& pixel,
                                          double most_px) {
  const Eigen::Matrix2d& c = line.covariance;
  const double along = line.direction.dot(pixel - line.point);
  // The offsets at `along` and at `place` have the covariance c00 + (along + place) c01 + along
  // place c11.
  const double place = -(c(0, 0) + along * c(0, 1)) / (c(0, 1) + along * c(1, 1));
  if (!(std::abs(place) <= most_px)) return std::nullopt;
  ImageLine beyond = line;
  beyond.point = line.point + place * line.direction;
  const double variance_px2 = offset_variance_px2(line, beyond.point);
  beyond.covariance =
      Eigen::Vector2d(variance_px2, std::numeric_limits<double>::infinity()).asDiagonal();
  return beyond;
}

std::optional<Meeting> meeting_of(std::span<const ImageLine> lines, double min_angle_deg) {
  double greatest_sine = 0;
  for (size_t i = 0; i < lines.size(); ++i) {
    for (size_t j = i + 1; j < lines.size(); ++j) {
      const Eigen::Vector2d& a = lines[i].direction;
      const Eigen::Vector2d& b = lines[j].direction;
      greatest_sine = std::max(greatest_sine, std::abs(a.x() * b.y() - a.y() * b.x()));
    }
  }
  if (greatest_sine < std::sin(min_angle_deg * kDegree)) return std::nullopt;
  // A line's variance depends on where it is asked for, so twice: the first time at its own point.
  // Two lines meet where they meet, whatever their weights.
  Meeting meeting;
  for (int round = 0; round < 2; ++round) {
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    const auto weight_of = [&](const ImageLine& line) {
      return 1 / (round == 0 ? line.covariance(0, 0) : offset_variance_px2(line, meeting.pixel));
    };
    for (const ImageLine& line : lines) {
      const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
      information += weight_of(line) * normal * normal.transpose();
      sum += weight_of(line) * normal * normal.dot(line.point);
    }
    meeting.covariance_px2 = information.inverse();
    meeting.pixel = meeting.covariance_px2 * sum;
  }
  for (const ImageLine& line : lines) {
    const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
    const double distance_px = normal.dot(line.point - meeting.pixel);
    meeting.squares += distance_px * distance_px / offset_variance_px2(line, meeting.pixel);
  }
  return meeting;
}

Observation found_at_meeting(Observation observation, std::vector<ImageLine> lines,
                             double min_angle_deg) {
  observation.lines = std::move(lines);
  if (observation.lines.size() < 2) {
    observation.status = ObservationStatus::kTooFewEdgePixels;
    return observation;
  }
  const auto meeting = meeting_of(observation.lines, min_angle_deg);
  if (!meeting) {
    observation.status = ObservationStatus::kParallelLines;
    return observation;
  }
  if (!contains(observation.window, meeting->pixel)) {
    observation.status = ObservationStatus::kOutsideWindow;
    return observation;
  }
  // Lines that miss each other by more than their sigmas err by more (Birge, Phys. Rev. 40, 1932).
  const double to_spare = static_cast<double>(observation.lines.size()) - 2;
  const double excess = to_spare > 0 ? std::max(1.0, meeting->squares / to_spare) : 1;
  observation.status = ObservationStatus::kFound;
  observation.pixel = meeting->pixel;
  observation.covariance_px2 = excess * meeting->covariance_px2;
  return observation;
}

double weakest_contrast_grey(std::span<const ImageLine> lines) {
  double weakest = std::numeric_limits<double>::infinity();
  for (const ImageLine& line : lines) weakest = std::min(weakest, line.contrast_grey);
  return weakest;
}

}  // namespace sightline
