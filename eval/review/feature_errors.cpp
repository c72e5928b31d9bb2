// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/review/feature_errors.h"

#include <numeric>

#include "eval/statistics/statistics.h"
#include "eval/target/silhouette.h"
#include "eval/target/target_report.h"
#include "features/extractor.h"
#include "renderer/renderer.h"
#include "scenes/random/random.h"

namespace sightline {
namespace {

constexpr double kNoiseGrey = 3;
constexpr PriorError kPrior = {
    .attitude_deg = kReviewAttitudeDeg, .range_fraction = 0.0025, .lateral_px = 0.75};

Scene review_scene(const std::shared_ptr<const Target>& target, const TargetView& view,
                   RandomStream& stream) {
  Scene scene = picture_scene(target, {0, 0, 0});
  scene.camera = view.camera;
  scene.cam_from_target = view.cam_from_target;
  scene.sensor.read_noise_grey = kNoiseGrey;
  // From within some 45 degrees of the camera.
  scene.light.to_light_in_cam =
      Eigen::Vector3d(stream.uniform(-0.7, 0.7), stream.uniform(-0.7, 0.7), -1).normalized();
  return scene;
}

ExtractorChoice review_extractors() {
  ExtractorChoice choice{.corner = find_feature_extractor("shi_tomasi_nearest")};
  choice.line_intersection = choice.contour = find_feature_extractor("edges_else_contour");
  return choice;
}

}  // namespace

std::vector<FeatureError> feature_errors(const std::shared_ptr<const Target>& target) {
  std::vector<int> features(target->features.size());
  std::iota(features.begin(), features.end(), 0);
  std::vector<FeatureError> errors(features.size());
  std::vector<std::vector<double>> error_px(features.size());
  const ExtractorChoice choice = review_extractors();
  Renderer renderer;
  const std::vector<TargetView> views = views_all_round(*target);
  for (int v = 0; v < kReviewViews; ++v) {
    RandomStream stream(1, "review", static_cast<uint64_t>(v));
    const Scene scene = review_scene(target, views[v], stream);
    const Pose prior = draw_prior(scene.cam_from_target, scene.camera, kPrior, stream);
    const cv::Mat image = renderer.render(scene, RandomStream(1, "review_noise", v)).image;
    const PredictedView predicted =
        predict_features(*target, features, scene.camera, prior_of(prior, scene.camera, kPrior));
    for (const Observation& seen : extract_features(image, 255, predicted, choice, {})) {
      FeatureError& error = errors[seen.feature];
      const TargetFeature& feature = target->features[seen.feature];
      if (is_self_hidden(*target, feature, scene.cam_from_target)) continue;
      ++error.shown;
      if (seen.status != ObservationStatus::kFound) continue;
      ++error.found;
      const auto truth = project(scene.camera, scene.cam_from_target * feature.position_m);
      error_px[seen.feature].push_back((seen.pixel - *truth).norm());
    }
  }
  for (size_t i = 0; i < errors.size(); ++i) {
    errors[i].visible_fraction = static_cast<double>(errors[i].shown) / kReviewViews;
    if (error_px[i].empty()) continue;
    errors[i].median_px = percentile(error_px[i], 0.5);
    errors[i].p90_px = percentile(error_px[i], 0.9);
  }
  return errors;
}

}  // namespace sightline
