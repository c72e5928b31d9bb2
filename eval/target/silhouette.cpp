// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/target/silhouette.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/LU>

#include "eval/statistics/statistics.h"
#include "features/outline.h"
#include "scenes/random/random.h"

namespace sightline {
namespace {

// As model_edges looks at an edge.
constexpr double kGapPx = 2.5;
constexpr double kReachPx = 36;
constexpr double kLeastSine = 0.2;  // between two edges that still meet in a point

// A straight outline: normal . x = offset.
struct OutlineLine {
  Eigen::Vector2d normal;
  double offset_px;
};

// The line through the outline of an edge by least squares; none where too little is to be seen.
std::optional<OutlineLine> outline_line(const PredictedEdge& edge) {
  constexpr double kFewest = 4;
  double n = 0, st = 0, stt = 0, so = 0, sto = 0;
  for (const PredictedEdge::Sample& sample : edge.samples) {
    n += 1;
    st += sample.along_px;
    stt += sample.along_px * sample.along_px;
    so += sample.offset_px;
    sto += sample.along_px * sample.offset_px;
  }
  if (n < kFewest) return std::nullopt;
  const double slope = (n * sto - st * so) / (n * stt - st * st);
  const double at_feature_px = (so - slope * st) / n;
  const Eigen::Vector2d normal = (edge.normal - slope * edge.direction).normalized();
  return OutlineLine{normal, normal.dot(edge.begin + at_feature_px * edge.normal)};
}

std::optional<double> offset_of_intersection(const PredictedView& view,
                                             const FeaturePrediction& prediction) {
  const auto a =
      outline_line(predict_edge(view, prediction, prediction.edge[0], {kGapPx, kReachPx}));
  const auto b =
      outline_line(predict_edge(view, prediction, prediction.edge[1], {kGapPx, kReachPx}));
  if (!a || !b) return std::nullopt;
  Eigen::Matrix2d normals;
  normals << a->normal.transpose(), b->normal.transpose();
  if (std::abs(normals.determinant()) < kLeastSine) return std::nullopt;
  const Eigen::Vector2d meeting = normals.inverse() * Eigen::Vector2d(a->offset_px, b->offset_px);
  return (meeting - prediction.pixel).norm();
}

// Of a pixel from the outline at a sample: it is straight up to the next one on either side.
double distance_from(const OutlineSample& sample, const Eigen::Vector2d& pixel) {
  constexpr double kApartPx = 1;
  const Eigen::Vector2d away = pixel - sample.pixel;
  const double across_px = away.dot(sample.normal);
  const double along_px = away.x() * sample.normal.y() - away.y() * sample.normal.x();
  return std::hypot(across_px, std::max(0.0, std::abs(along_px) - kApartPx));
}

std::optional<double> offset_px(const PredictedView& view, const FeaturePrediction& prediction) {
  if (!prediction.is_in_front || prediction.is_hidden) return std::nullopt;
  switch (prediction.kind) {
    case FeatureKind::kLineIntersection:
      return offset_of_intersection(view, prediction);
    case FeatureKind::kCorner: {
      std::optional<double> nearest;
      for (const OutlineSample& sample : predict_outline(view, prediction, kReachPx)) {
        const double distance_px = distance_from(sample, prediction.pixel);
        if (!nearest || distance_px < *nearest) nearest = distance_px;
      }
      return nearest;
    }
    case FeatureKind::kContour:
      return std::nullopt;
  }
  return std::nullopt;
}

// Of one feature, a number for each view that shows it.
struct Offsets {
  std::vector<double> px, m;
};

SilhouetteOffset summary_of(const Offsets& offsets) {
  if (offsets.px.empty()) return {};
  return {.views = static_cast<int>(offsets.px.size()),
          .median_px = percentile(offsets.px, 0.5),
          .greatest_px = *std::max_element(offsets.px.begin(), offsets.px.end()),
          .median_m = percentile(offsets.m, 0.5),
          .greatest_m = *std::max_element(offsets.m.begin(), offsets.m.end())};
}

}  // namespace

std::vector<TargetView> views_all_round(const Target& target) {
  constexpr double kRangeInSizes = 30;
  constexpr int kImagePx = 512;
  const Bounds box = bounds(target.mesh);
  const Eigen::Vector3d centre_m = (box.min_m + box.max_m) / 2;
  const double range_m = kRangeInSizes * (box.max_m - box.min_m).norm();
  const Camera camera = centred_camera(kImagePx, kImagePx, kRangeInSizes * kSilhouetteSizePx);
  std::vector<TargetView> views;
  for (int i = 0; i < kSilhouetteViews; ++i) {
    RandomStream stream(1, "silhouette", static_cast<uint64_t>(i));
    Pose pose{stream.rotation(), Eigen::Vector3d::Zero()};
    pose.translation = Eigen::Vector3d(0, 0, range_m) - pose.rotation * centre_m;
    views.push_back({camera, pose});
  }
  return views;
}

std::vector<SilhouetteOffset> silhouette_offsets(const Target& target,
                                                 std::span<const int> features,
                                                 std::span<const TargetView> views) {
  std::vector<Offsets> offsets(features.size());
  for (const TargetView& view : views) {
    const PredictedView predicted =
        predict_features(target, features, view.camera, PosePrior{view.cam_from_target});
    for (size_t f = 0; f < features.size(); ++f) {
      const auto offset = offset_px(predicted, predicted.features[f]);
      if (!offset) continue;
      const Eigen::Vector3d& position_m = target.features[features[f]].position_m;
      const double depth_m = (view.cam_from_target * position_m).z();
      offsets[f].px.push_back(*offset);
      offsets[f].m.push_back(*offset * depth_m / view.camera.fx_px);
    }
  }
  std::vector<SilhouetteOffset> summaries;
  for (const Offsets& of_feature : offsets) summaries.push_back(summary_of(of_feature));
  return summaries;
}

}  // namespace sightline
