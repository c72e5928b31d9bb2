// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/labels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/LU>

namespace sightline {
namespace {

// Evidence this near to a pixel of the target is the target's: the width of a blurred edge.
constexpr int kNearPx = 2;

// True where pixels of the main target lie near and none of another body does.
bool shows_target(const cv::Mat& body_ids, const Eigen::Vector2d& pixel) {
  const cv::Rect around(static_cast<int>(std::lround(pixel.x())) - kNearPx,
                        static_cast<int>(std::lround(pixel.y())) - kNearPx, 2 * kNearPx + 1,
                        2 * kNearPx + 1);
  const cv::Rect inside = around & cv::Rect({0, 0}, body_ids.size());
  bool has_target = false;
  for (int v = inside.y; v < inside.br().y; ++v) {
    for (int u = inside.x; u < inside.br().x; ++u) {
      const int id = body_ids.at<uint8_t>(v, u);
      if (id > 1) return false;
      has_target = has_target || id == 1;
    }
  }
  return has_target;
}

bool shows_target(const cv::Mat& body_ids, const std::vector<Eigen::Vector2d>& pixels) {
  const auto count = std::count_if(pixels.begin(), pixels.end(), [&](const Eigen::Vector2d& pixel) {
    return shows_target(body_ids, pixel);
  });
  return 2 * static_cast<size_t>(count) >= pixels.size();
}

// RMS distance of a line's edge pixels from the image of a straight edge, which a lens may bend: it
// is taken as straight over the length of the line, which is short.
double distance_px(const ImageLine& line, const Scene& scene, const Edge& edge) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto begin = project(scene.camera, scene.cam_from_target * edge.begin_m);
  const auto end = project(scene.camera, scene.cam_from_target * edge.end_m);
  if (!begin || !end || line.edge_pixels.empty()) return kInfinity;
  const Eigen::Vector2d along = *end - *begin;
  if (!(along.norm() > 0)) return kInfinity;
  const Eigen::Vector2d normal = Eigen::Vector2d(-along.y(), along.x()).normalized();
  double sum = 0;
  for (const Eigen::Vector2d& pixel : line.edge_pixels) {
    const double distance = normal.dot(pixel - *begin);
    sum += distance * distance;
  }
  return std::sqrt(sum / static_cast<double>(line.edge_pixels.size()));
}

// The first line that is no edge of the feature, or the image of an edge that another line has
// already; null when all are right.
const ImageLine* wrong_line(const Observation& observation, const Scene& scene, double line_px) {
  const auto& edges = scene.target->features[observation.feature].edges;
  std::vector<bool> is_taken(edges.size(), false);
  for (const ImageLine& line : observation.lines) {
    size_t nearest = edges.size();
    double nearest_px = line_px;
    for (size_t e = 0; e < edges.size(); ++e) {
      const double distance = distance_px(line, scene, edges[e]);
      if (is_taken[e] || distance > nearest_px) continue;
      nearest = e;
      nearest_px = distance;
    }
    if (nearest == edges.size()) return &line;
    is_taken[nearest] = true;
  }
  return nullptr;
}

// Why an observation is far from the truth.
ObservationLabel kind_of_error(const Observation& observation, const Scene& scene,
                               const Frame& frame, double line_px) {
  if (observation.lines.empty()) {
    return shows_target(frame.body_ids, observation.pixel) ? ObservationLabel::kWrongPoint
                                                           : ObservationLabel::kClutter;
  }
  const ImageLine* const line = wrong_line(observation, scene, line_px);
  if (line == nullptr) return ObservationLabel::kWrongIntersection;
  return shows_target(frame.body_ids, line->edge_pixels) ? ObservationLabel::kWrongLine
                                                         : ObservationLabel::kClutter;
}

}  // namespace

std::string_view to_string(ObservationLabel label) {
  constexpr std::array<std::string_view, 8> kWords = {
      "inlier",  "wrong line", "wrong intersection", "wrong point", "clutter", "hidden",
      "missing", "absent"};
  return kWords[static_cast<size_t>(label)];
}

LabelledObservation label(const Observation& observation, const Scene& scene, const Frame& frame,
                          const LabelLimits& limits) {
  const FeatureTruth& truth = frame.truth.target().features[observation.feature];
  LabelledObservation out;
  if (observation.status != ObservationStatus::kFound) {
    out.label = truth.is_visible ? ObservationLabel::kMissing : ObservationLabel::kAbsent;
    return out;
  }
  const Eigen::Vector2d error = observation.pixel - truth.pixel;
  out.error_px = error.norm();
  out.error_sigmas = std::sqrt(error.dot(observation.covariance_px2.inverse() * error));
  out.is_outlier = out.error_px > limits.outlier_px || out.error_sigmas > limits.outlier_sigmas;
  if (!truth.is_visible) {
    out.label = ObservationLabel::kHidden;
  } else if (!out.is_outlier) {
    out.label = ObservationLabel::kInlier;
  } else {
    out.label = kind_of_error(observation, scene, frame, limits.line_px);
  }
  return out;
}

}  // namespace sightline
