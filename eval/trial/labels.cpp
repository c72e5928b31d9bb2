// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/trial/labels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "eval/statistics/statistics.h"
#include "features/outline.h"

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

// How far a pixel is from the image of a straight edge, of which two points are given as rays. A
// lens bends the edge: the distance is that without it, in the pixels that the lens makes of it
// there.
double distance_px(const Camera& camera, const Eigen::Vector2d& pixel,
                   const std::array<Eigen::Vector2d, 2>& edge) {
  const auto ray = normalised_from_pixel(camera, pixel);
  if (!ray) return std::numeric_limits<double>::infinity();
  const Eigen::Vector2d focal(camera.fx_px, camera.fy_px);
  const Eigen::Vector2d along = focal.cwiseProduct(edge[1] - edge[0]);
  const Eigen::Vector2d normal = Eigen::Vector2d(-along.y(), along.x()).normalized();
  const double without_lens = normal.dot(focal.cwiseProduct(*ray - edge[0]));
  if (is_straight(camera)) return without_lens;
  const Eigen::Matrix2d lens = lens_jacobian(camera, *ray);
  return without_lens / (lens.inverse().transpose() * normal).norm();
}

// RMS distance of a line's edge pixels from the image of an edge.
double distance_px(const ImageLine& line, const Scene& scene, const Edge& edge) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Eigen::Vector3d begin = scene.cam_from_target * edge.begin_m;
  const Eigen::Vector3d end = scene.cam_from_target * edge.end_m;
  if (!(begin.z() > 0) || !(end.z() > 0) || line.edge_pixels.empty()) return kInfinity;
  const std::array<Eigen::Vector2d, 2> rays = {begin.hnormalized(), end.hnormalized()};
  if (!((rays[1] - rays[0]).norm() > 0)) return kInfinity;
  double sum = 0;
  for (const Eigen::Vector2d& pixel : line.edge_pixels) {
    const double distance = distance_px(scene.camera, pixel, rays);
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

// Why an observation is far from the truth. Where keypoints alone are known, nobody knows which
// pixels show the target: it is not said to be clutter.
ObservationLabel kind_of_error(const Observation& observation, const Scene& scene,
                               const Frame& frame, double line_px) {
  const bool has_mesh = scene.target->has_mesh();
  if (observation.lines.empty()) {
    return !has_mesh || shows_target(frame.body_ids, observation.pixel)
               ? ObservationLabel::kWrongPoint
               : ObservationLabel::kClutter;
  }
  const ImageLine* const line = wrong_line(observation, scene, line_px);
  if (line == nullptr) return ObservationLabel::kWrongIntersection;
  return !has_mesh || shows_target(frame.body_ids, line->edge_pixels) ? ObservationLabel::kWrongLine
                                                                      : ObservationLabel::kClutter;
}

// The median difference across these points of an outline; 0 of fewer than four.
double median_contrast(const std::vector<OutlineSample>& outline, const cv::Mat& image) {
  constexpr double kAsidePx = 3;
  constexpr size_t kFewest = 4;
  std::vector<double> differences;
  for (const OutlineSample& sample : outline) {
    const auto grey = [&](double side) -> double {
      const Eigen::Vector2d at = sample.pixel + side * kAsidePx * sample.normal;
      const cv::Point pixel(static_cast<int>(std::lround(at.x())),
                            static_cast<int>(std::lround(at.y())));
      if (!cv::Rect({0, 0}, image.size()).contains(pixel)) {
        return std::numeric_limits<double>::quiet_NaN();
      }
      return image.depth() == CV_8U ? image.at<uint8_t>(pixel) : image.at<uint16_t>(pixel);
    };
    const double difference = grey(1) - grey(-1);
    if (std::isfinite(difference)) differences.push_back(difference);
  }
  return differences.size() < kFewest ? 0 : std::abs(percentile(differences, 0.5));
}

std::vector<OutlineSample> outline_of(const PredictedEdge& edge) {
  std::vector<OutlineSample> outline;
  for (const PredictedEdge::Sample& sample : edge.samples) {
    outline.push_back(
        {edge.begin + sample.along_px * edge.direction + sample.offset_px * edge.normal,
         edge.normal, sample.borders_target});
  }
  return outline;
}

}  // namespace

LabelledObservation label(const Observation& observation, const Scene& scene, const Frame& frame,
                          const LabelLimits& limits) {
  const FeatureTruth& truth = frame.truth.target().features[observation.feature];
  LabelledObservation out;
  out.is_visible = truth.is_visible &&
                   (limits.least_contrast_grey == 0 || !scene.target->has_mesh() ||
                    contrast_grey(observation.feature, scene, frame) >= limits.least_contrast_grey);
  if (observation.status != ObservationStatus::kFound) {
    out.label = out.is_visible ? ObservationLabel::kMissing : ObservationLabel::kAbsent;
    return out;
  }
  const Eigen::Vector2d error = observation.pixel - truth.pixel;
  out.error_px = error.norm();
  out.error_sigmas = std::sqrt(error.dot(observation.covariance_px2.inverse() * error));
  out.is_outlier = out.error_px > limits.outlier_px || out.error_sigmas > limits.outlier_sigmas;
  if (!out.is_visible) {
    out.label = ObservationLabel::kHidden;
  } else if (!out.is_outlier) {
    out.label = ObservationLabel::kInlier;
  } else {
    out.label = kind_of_error(observation, scene, frame, limits.line_px);
  }
  return out;
}

double contrast_grey(int feature, const Scene& scene, const Frame& frame) {
  constexpr double kGapPx = 2.5;
  constexpr double kReachPx = 36;
  const PredictedView view = predict_features(*scene.target, std::array{feature}, scene.camera,
                                              PosePrior{scene.cam_from_target});
  const FeaturePrediction& prediction = view.features.front();
  if (!prediction.is_in_front) return 0;
  double contrast = std::numeric_limits<double>::infinity();
  if (prediction.kind == FeatureKind::kLineIntersection) {
    for (const int edge : prediction.edge) {
      const auto outline = outline_of(predict_edge(view, prediction, edge, {kGapPx, kReachPx}));
      contrast = std::min(contrast, median_contrast(outline, frame.image));
    }
  } else {
    contrast = median_contrast(predict_outline(view, prediction, kReachPx), frame.image);
  }
  return contrast * 255 / (std::exp2(scene.sensor.bits) - 1);
}

}  // namespace sightline
