// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/silhouette.h"

#include <algorithm>
#include <numeric>
#include <optional>

#include <Eigen/LU>

#include "eval/statistics.h"
#include "features/outline.h"
#include "scenes/random.h"

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

std::optional<double> offset_px(const PredictedView& view, const FeaturePrediction& prediction) {
  if (!prediction.is_in_front || prediction.is_hidden) return std::nullopt;
  switch (prediction.kind) {
    case FeatureKind::kLineIntersection:
      return offset_of_intersection(view, prediction);
    case FeatureKind::kCorner: {
      std::optional<double> nearest;
      for (const OutlineSample& sample : predict_outline(view, prediction, kReachPx)) {
        const double distance_px = (sample.pixel - prediction.pixel).norm();
        if (!nearest || distance_px < *nearest) nearest = distance_px;
      }
      return nearest;
    }
    case FeatureKind::kContour:
      return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

std::vector<SilhouetteOffset> silhouette_offsets(const Target& target) {
  constexpr double kRangeInSizes = 30;
  constexpr int kImagePx = 512;
  const Bounds box = bounds(target.mesh);
  const double size_m = (box.max_m - box.min_m).norm();
  const Eigen::Vector3d centre_m = (box.min_m + box.max_m) / 2;
  const double range_m = kRangeInSizes * size_m;
  const Camera camera = centred_camera(kImagePx, kImagePx, kRangeInSizes * kSilhouetteSizePx);
  std::vector<int> features(target.features.size());
  std::iota(features.begin(), features.end(), 0);

  std::vector<std::vector<double>> offsets_px(features.size());
  for (int i = 0; i < kSilhouetteViews; ++i) {
    RandomStream stream(1, "silhouette", static_cast<uint64_t>(i));
    Pose pose{stream.rotation(), Eigen::Vector3d::Zero()};
    pose.translation = Eigen::Vector3d(0, 0, range_m) - pose.rotation * centre_m;
    const PredictedView view = predict_features(target, features, camera, PosePrior{pose});
    for (size_t f = 0; f < features.size(); ++f) {
      const auto offset = offset_px(view, view.features[f]);
      if (offset) offsets_px[f].push_back(*offset);
    }
  }

  const double metres_per_px = size_m / kSilhouetteSizePx;
  std::vector<SilhouetteOffset> out;
  for (const std::vector<double>& of_feature : offsets_px) {
    SilhouetteOffset offset;
    offset.views = static_cast<int>(of_feature.size());
    if (offset.views > 0) {
      offset.median_px = percentile(of_feature, 0.5);
      offset.greatest_px = *std::max_element(of_feature.begin(), of_feature.end());
      offset.median_m = metres_per_px * offset.median_px;
      offset.greatest_m = metres_per_px * offset.greatest_px;
    }
    out.push_back(offset);
  }
  return out;
}

}  // namespace sightline
