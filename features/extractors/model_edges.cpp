// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The lines along the feature's edges as the mesh shows them (features/model_lines.h). Those are
// taken that agree on one point and have the most support; around that point each line of a sharp
// edge is fitted once more to the grey levels, and the feature is where they meet. Of a target made
// of flat facets all that is seen around the feature is fitted as a whole, begun where lines agree
// (features/facet_fit.h); where that explains the image down to the noise, the feature is where it
// says.
#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "features/agreement.h"
#include "features/extractors/extractors.h"
#include "features/facet_fit.h"
#include "features/image_line.h"
#include "features/model_lines.h"
#include "features/outline_search.h"

namespace sightline {
namespace {

constexpr double kMaxSdPx = 0.8;      // in its worst direction of a feature at a small angle
constexpr double kReachPx = 30;       // of what is fitted to the facets' grey levels
constexpr double kGoodReachPx = 60;   // the same where the prior has been improved
constexpr double kFarReachPx = 80;    // of features that are not known well by that
constexpr size_t kFewestSamples = 4;  // of a line that is shown
// The standard deviation of what a facets' fit does not know of: a lower estimate, of a cube drawn
// without error. With it errors are 1.1 of their own sigmas in
// sightline study feature-localisation --trials 1000 --set 'sweep={}' --set extraction.passes=2
constexpr double kFacetFloorPx = 0.012;

// True where lines meet at a small angle that are not known well enough for it.
bool is_loose(const ExtractionInput& input, const Observation& observation) {
  if (meeting_of(observation.lines, input.options.line.min_angle_deg)) return false;
  return !(worst_sd_px(observation.covariance_px2) <= kMaxSdPx);
}

bool is_known(const FacetFit& fit) {
  return worst_sd_px(fit.covariance_px2) <= kMaxSdPx;
}

// The prior's pose with the feature moved to that pixel, at its depth.
Pose moved_to(const ExtractionInput& input, const Eigen::Vector2d& pixel) {
  Pose pose = input.view.cam_from_target;
  const Eigen::Vector3d point =
      pose * input.view.target->features[input.prediction.feature].position_m;
  const auto there = normalised_from_pixel(input.view.camera, pixel);
  if (there) pose.translation.head<2>() += point.z() * *there - point.head<2>();
  return pose;
}

// Turned about the feature.
Pose turned(const ExtractionInput& input, const Pose& pose, const Eigen::Vector3d& turn_rad) {
  const Eigen::Vector3d& position_m =
      input.view.target->features[input.prediction.feature].position_m;
  Pose out;
  out.rotation = rotation_from_vector(turn_rad) * pose.rotation;
  out.translation = pose * position_m - out.rotation * position_m;
  return out;
}

// The feature's edges as they are to be seen at a pose.
std::vector<ImageLine> lines_at(const ExtractionInput& input, const Eigen::Vector2d& pixel,
                                const Pose& cam_from_target) {
  constexpr double kOffCornerPx = 1;
  PredictedView view = input.view;
  view.cam_from_target = cam_from_target;
  FeaturePrediction prediction = input.prediction;
  prediction.pixel = pixel;
  std::vector<ImageLine> lines;
  const size_t count = view.target->features[prediction.feature].edges.size();
  for (size_t i = 0; i < count; ++i) {
    const PredictedEdge edge =
        predict_edge(view, prediction, static_cast<int>(i), {kOffCornerPx, kReachPx});
    if (edge.samples.size() < kFewestSamples) continue;
    ImageLine line;
    line.direction = edge.direction;
    for (const PredictedEdge::Sample& sample : edge.samples) {
      line.edge_pixels.push_back(edge.begin + sample.along_px * edge.direction);
      line.point += line.edge_pixels.back() / static_cast<double>(edge.samples.size());
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

// Poses from which a fit may find the feature: the prior's with the feature at each of the pixels;
// where the prior is not good, turned as well, since edges seen nearly along one another look
// otherwise then.
std::vector<Pose> starts_at(const ExtractionInput& input,
                            const std::vector<Eigen::Vector2d>& pixels) {
  constexpr double kTurnRad = 0.04;
  std::vector<Eigen::Vector3d> turns{Eigen::Vector3d::Zero()};
  if (!input.options.is_gated) {
    for (const double side : {1.0, -1.0}) {
      for (const int axis : {0, 1}) turns.push_back(side * kTurnRad * Eigen::Vector3d::Unit(axis));
    }
  }
  std::vector<Pose> starts;
  for (const Eigen::Vector3d& turn : turns) {
    for (const Eigen::Vector2d& pixel : pixels) {
      starts.push_back(turned(input, moved_to(input, pixel), turn));
    }
  }
  return starts;
}

// Where the target is made of flat facets, these explain the grey levels around the feature, with
// edges too near to each other for a line of their own. Begun at the first start, then at the most
// promising others, until one does so down to the noise and knows where the feature is; failing
// that one that does not know. None where no start explains it.
std::optional<FacetFit> explained(const ExtractionInput& input, const cv::Rect& window,
                                  std::span<const Pose> starts) {
  constexpr double kMostOverNoise = 1.15;
  constexpr double kMostOverGrey = 0.7;
  constexpr size_t kMostFits = 2;
  const double noise_sd = input.options.search.noise_sd_grey;
  FacetPatch patch{
      input.image,       input.view.target->facets,
      input.view.camera, input.view.target->features[input.prediction.feature].position_m,
      kReachPx,          noise_sd};
  const auto fit_at = [&](const Pose& start, double reach_px) -> std::optional<FacetFit> {
    patch.reach_px = reach_px;
    const auto fit = fit_facets(patch, start);
    if (!fit || fit->rms_grey > kMostOverNoise * noise_sd + kMostOverGrey) return std::nullopt;
    return contains(window, fit->pixel) ? fit : std::nullopt;
  };
  std::optional<FacetFit> loose;
  const auto known_at = [&](const Pose& start) -> std::optional<FacetFit> {
    const auto fit = fit_at(start, input.options.is_gated ? kGoodReachPx : kReachPx);
    if (!fit || is_known(*fit)) return fit;
    const auto farther = fit_at(fit->cam_from_target, kFarReachPx);
    if (farther && is_known(*farther)) return farther;
    if (!loose) loose = fit;
    return std::nullopt;
  };
  if (const auto fit = known_at(starts.front())) return fit;
  if (starts.size() > 1) {
    patch.reach_px = kReachPx;
    for (const Pose& start : most_alike(patch, starts.subspan(1), kMostFits)) {
      if (const auto fit = known_at(start)) return fit;
    }
  }
  return loose;
}

// The observation as a facets' fit explains it. Such a fit measures no contrast.
Observation explained_by(const ExtractionInput& input, const FacetFit& fit,
                         Observation observation) {
  observation.lines = lines_at(input, fit.pixel, fit.cam_from_target);
  observation.pixel = fit.pixel;
  observation.covariance_px2 =
      fit.covariance_px2 + kFacetFloorPx * kFacetFloorPx * Eigen::Matrix2d::Identity();
  observation.status =
      is_known(fit) ? ObservationStatus::kFound : ObservationStatus::kParallelLines;
  return observation;
}

// The lines that agree best; where none agree, the best of each edge.
std::vector<FoundLine> best_lines(const ModelLines& model) {
  std::vector<FoundLine> best;
  if (!model.agreements.empty()) {
    for (const LinePick& pick : model.agreements.front().picks) {
      best.push_back(model.of_edge[pick.edge][pick.line]);
    }
    return best;
  }
  for (const std::vector<FoundLine>& lines : model.of_edge) {
    if (!lines.empty()) best.push_back(lines.front());
  }
  return best;
}

// The standard deviation, px, at either end of a line of what its fit does not know of, where it
// made no feature: mostly that is because another edge runs beside it, which draws it aside. An
// upper estimate, of the lines of sightline study boeing-any-side --set extraction.use_lines=true
constexpr double kAlonePx = 0.4;
// The same of a rounded edge, whose outline turns with the light.
constexpr double kSoftPx = 0.2;

// What the lines say of their edges: all that they say where they did not make a feature, and what
// they say beyond it where they did. A line that few samples of its edge support is left out.
std::vector<EdgeLine> edge_lines_of(const ExtractionInput& input,
                                    const std::vector<FoundLine>& found,
                                    const Observation& observation) {
  constexpr double kLeastSupport = 0.6;
  // From the middle of its edge pixels, how far off a line's slope still counts. Where the image is
  // looked at through a lens (StraightWindow was none), an edge is straight no farther than it was
  // seen.
  const double most_px = is_pinhole(input.view.camera.lens) ? 400 : 20;
  std::vector<EdgeLine> edge_lines;
  for (size_t i = 0; i < found.size(); ++i) {
    if (found[i].support < kLeastSupport) continue;
    std::optional<ImageLine> line = observation.lines[i];
    if (observation.status == ObservationStatus::kFound) {
      if (found[i].is_soft) add_noise_at_ends(kSoftPx, *line);
      line = beyond_offset_at(*line, observation.pixel, most_px);
    } else {
      add_noise_at_ends(kAlonePx, *line);
    }
    if (line) edge_lines.push_back({found[i].edge, std::move(*line)});
  }
  return edge_lines;
}

// What the only edge that is to be seen says.
std::vector<EdgeLine> only_line(const ExtractionInput& input, const ModelLines& model) {
  Observation alone;
  for (const FoundLine& found : best_lines(model)) alone.lines.push_back(found.line);
  return edge_lines_of(input, best_lines(model), alone);
}

// The observation found where the best lines meet, each refitted around the place where they met
// before; or with the reason why they do not meet.
Observation intersected(const ExtractionInput& input, const ModelLines& model,
                        Observation observation) {
  const std::vector<FoundLine> found = best_lines(model);
  std::vector<ImageLine> lines;
  for (const FoundLine& line : found) lines.push_back(line.line);
  observation = found_at_meeting(std::move(observation), std::move(lines), kLeastMeetingDeg);
  if (observation.status != ObservationStatus::kFound) {
    observation.edge_lines = edge_lines_of(input, found, observation);
    return observation;
  }
  lines = observation.lines;
  for (size_t i = 0; i < found.size(); ++i) {
    auto line = refitted(input, found[i], observation.pixel, model.polarity);
    if (!line) continue;
    line->edge_pixels = std::move(lines[i].edge_pixels);
    lines[i] = std::move(*line);
  }
  observation = found_at_meeting(std::move(observation), std::move(lines), kLeastMeetingDeg);
  observation.contrast_grey = weakest_contrast_grey(observation.lines);
  if (observation.status == ObservationStatus::kFound && is_loose(input, observation)) {
    observation.status = ObservationStatus::kParallelLines;
  }
  observation.edge_lines = edge_lines_of(input, found, observation);
  return observation;
}

bool has_facets(const ExtractionInput& input) {
  return input.view.target != nullptr && !input.view.target->facets.empty();
}

// The facets' fit, begun where lines agree; before a line is looked for, because the prior has
// already been improved, or where none agree, where the feature is predicted.
std::optional<FacetFit> facets_fit(const ExtractionInput& input, const cv::Rect& window,
                                   const std::vector<Agreement>& agreements) {
  if (!has_facets(input)) return std::nullopt;
  std::vector<Eigen::Vector2d> pixels;
  for (const Agreement& agreement : agreements) pixels.push_back(agreement.pixel);
  if (pixels.empty()) pixels.push_back(input.prediction.pixel);
  return explained(input, window, starts_at(input, pixels));
}

// What one search finds.
struct Searched {
  Observation observation;
  bool is_explained = false;  // by the facets
};

Searched search(const ExtractionInput& input) {
  Observation observation = nothing_found(input);
  observation.window =
      window_around(input.prediction.pixel, search_window_half_px(input), input.image.size());
  if (observation.window.empty()) {
    observation.status = ObservationStatus::kOutsideImage;
    return {std::move(observation)};
  }
  std::optional<FacetFit> fit;
  if (input.options.is_gated) fit = facets_fit(input, observation.window, {});
  std::optional<ModelLines> model;
  if (!fit) {
    model = find_model_lines(input, observation.window);
    fit =
        facets_fit(input, observation.window, model ? model->agreements : std::vector<Agreement>());
  }
  if (fit) return {explained_by(input, *fit, std::move(observation)), true};
  if (model && model->of_edge.size() >= 2) {
    return {intersected(input, *model, std::move(observation))};
  }
  observation.status = ObservationStatus::kNoOutline;
  if (model) observation.edge_lines = only_line(input, *model);
  return {std::move(observation)};
}

}  // namespace

Observation extract_model_edges(const ExtractionInput& input) {
  constexpr double kWiderSigmas = 4;
  Searched near = search(input);
  if (near.is_explained || near.observation.status == ObservationStatus::kFound ||
      input.options.is_gated || !has_facets(input)) {
    return std::move(near.observation);
  }
  // Farther from the prior more is met that looks alike, so that only what is explained counts.
  ExtractorOptions options = input.options;
  options.search.sigmas = kWiderSigmas;
  Searched wide = search(
      {input.image, input.view, input.prediction, options, input.window, input.background_grey});
  if (!wide.is_explained) return std::move(near.observation);
  wide.observation.contrast_grey = near.observation.contrast_grey;
  return std::move(wide.observation);
}

}  // namespace sightline
