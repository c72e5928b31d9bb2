// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/extractor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "features/extractors/extractors.h"
#include "features/joint_edges.h"
#include "features/shared_edges.h"
#include "features/straight_window.h"

namespace sightline {
namespace {

constexpr std::array kCatalogue = {
    FeatureExtractor{"hough_intersection",
                     "Canny, Hough, least-squares lines, their intersection (the ORPE paper's)",
                     true, extract_hough_intersection},
    FeatureExtractor{"hough_subpixel",
                     "the Hough lines of every edge to be seen, refitted to the grey levels", true,
                     extract_hough_subpixel},
    FeatureExtractor{"lsd_intersection", "line segments by LSD, joined, their intersection", true,
                     extract_lsd_intersection},
    FeatureExtractor{
        "model_edges",
        "the edges that the mesh should show, searched along their normals; flat facets "
        "as a whole",
        true, extract_model_edges, /*needs_mesh=*/true},
    FeatureExtractor{"contour", "the outline that the mesh should show, shifted onto the image's",
                     false, extract_contour, /*needs_mesh=*/true},
    FeatureExtractor{"edges_else_contour",
                     "model_edges where two edges are to be seen, else contour", false,
                     extract_edges_else_contour, /*needs_mesh=*/true},
    FeatureExtractor{"shi_tomasi_nearest",
                     "of the Shi-Tomasi corners the one nearest the window's centre (the paper's)",
                     false, extract_shi_tomasi_nearest},
    FeatureExtractor{"harris_subpixel",
                     "of the Harris corners the one nearest the window's centre, refined", false,
                     extract_harris_subpixel},
};

// The median grey level on a coarse grid outside the target's predicted box. None where little of
// the image is outside.
std::optional<double> background_level(const cv::Mat& image, const PredictedView& view) {
  constexpr int kStepPx = 8;
  constexpr double kMarginPx = 24;
  constexpr size_t kFewest = 32;
  if (view.target == nullptr || view.target->mesh.vertices.empty()) return std::nullopt;
  const Bounds box = bounds(view.target->mesh);
  Eigen::AlignedBox2d target;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d point((corner & 1 ? box.max_m : box.min_m).x(),
                                (corner & 2 ? box.max_m : box.min_m).y(),
                                (corner & 4 ? box.max_m : box.min_m).z());
    const auto pixel = project(view.camera, view.cam_from_target * point);
    if (!pixel) return std::nullopt;
    target.extend(*pixel);
  }
  const Eigen::Vector2d from = target.min().array() - kMarginPx;
  const Eigen::Vector2d to = target.max().array() + kMarginPx;
  std::vector<uint8_t> greys;
  for (int v = kStepPx / 2; v < image.rows; v += kStepPx) {
    for (int u = kStepPx / 2; u < image.cols; u += kStepPx) {
      const bool is_on_target = u > from.x() && u < to.x() && v > from.y() && v < to.y();
      if (!is_on_target) greys.push_back(image.at<uint8_t>(v, u));
    }
  }
  if (greys.size() < kFewest) return std::nullopt;
  std::nth_element(greys.begin(), greys.begin() + greys.size() / 2, greys.end());
  return greys[greys.size() / 2];
}

// What extractors look at.
struct Channel {
  cv::Mat image;  // CV_8U
  std::optional<double> background_grey;
};

// The grey of an image, then its colours if it has any.
std::vector<cv::Mat> grey_and_colours(const cv::Mat& image) {
  if (image.channels() == 1) return {image};
  std::vector<cv::Mat> channels(1);
  cv::cvtColor(image, channels.front(), cv::COLOR_BGR2GRAY);
  std::vector<cv::Mat> colours;
  cv::split(image, colours);
  channels.insert(channels.end(), colours.begin(), colours.end());
  return channels;
}

// The channel in which a prediction's window varies most, a colour's noise being larger than that
// of the grey made of all three.
const Channel& channel_of_contrast(const std::vector<Channel>& channels,
                                   const FeaturePrediction& prediction,
                                   const ExtractorOptions& options) {
  const double noise_of_grey = std::hypot(0.114, 0.587, 0.299);  // of a colour's
  const cv::Rect window =
      prediction.is_in_front
          ? window_around(prediction.pixel, options.window_half_px, channels.front().image.size())
          : cv::Rect();
  if (channels.size() == 1 || window.empty()) return channels.front();
  size_t best = 0;
  double most = 0;
  for (size_t i = 0; i < channels.size(); ++i) {
    cv::Scalar mean, sd;
    cv::meanStdDev(channels[i].image(window), mean, sd);
    const double contrast = i == 0 ? sd[0] / noise_of_grey : sd[0];
    if (contrast > most) {
      most = contrast;
      best = i;
    }
  }
  return channels[best];
}

// Why a window is not worth looking at; kFound where it is.
ObservationStatus why_not_look(const cv::Mat& window) {
  constexpr int kLeastPx = 5;
  constexpr uint8_t kWhite = 255;
  if (std::min(window.rows, window.cols) < kLeastPx) return ObservationStatus::kWindowTooSmall;
  double least = 0;
  double greatest = 0;
  cv::minMaxLoc(window, &least, &greatest);
  if (least < greatest) return ObservationStatus::kFound;
  return least == kWhite ? ObservationStatus::kSaturated : ObservationStatus::kEmptyWindow;
}

bool is_within_search(const ExtractionInput& input, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d off = pixel - input.prediction.pixel;
  const double distance_px = off.norm();
  return distance_px == 0 || distance_px <= search_half_px(input, off / distance_px);
}

// An observation that is decided before any extractor looks.
Observation unseen(const FeaturePrediction& prediction, const cv::Rect& window,
                   ObservationStatus why) {
  Observation observation;
  observation.feature = prediction.feature;
  observation.predicted_px = prediction.pixel;
  observation.window = window;
  observation.status = why;
  return observation;
}

// The feature's surroundings without what a lens bends there, if it bends any.
std::optional<StraightWindow> straight_about(const ExtractionInput& input) {
  // As far as most extractors look along an edge and across it, and what their filters reach
  // beyond. hough_subpixel's edges, of up to 160 px, are taken no farther.
  constexpr int kReachPx = 104;
  constexpr int kFilterPx = 8;
  const int half_px = std::max(kReachPx, input.options.window_half_px + kFilterPx);
  return StraightWindow::about(input.prediction.pixel, input.view.camera, input.image, half_px);
}

// What the extractor finds; of one that looks for straight edges or outlines, in an image in which
// no lens bends them.
Observation extracted(const ExtractionInput& input, const FeatureExtractor& extractor) {
  if (!extractor.needs_edges && !extractor.needs_mesh) return extractor.extract(input);
  const Eigen::Vector2d& pixel = input.prediction.pixel;
  const auto straight = straight_about(input);
  if (!straight) return extractor.extract(input);
  const PredictedView view = straight->view_of(input.view, input.prediction);
  const FeaturePrediction& prediction = view.features.front();
  const cv::Rect window =
      window_around(prediction.pixel, input.options.window_half_px, straight->image().size());
  // So near to the border that the turned window is mostly beyond it, the bent image is what is
  // left.
  if (window.empty()) return extractor.extract(input);
  const ObservationStatus why_not = why_not_look(straight->image()(window));
  if (why_not != ObservationStatus::kFound) return unseen(input.prediction, input.window, why_not);
  Observation found = straight->in_image(extractor.extract(
      {straight->image(), view, prediction, input.options, window, input.background_grey}));
  const int looked_px = std::max(found.window.width, found.window.height) / 2;
  found.predicted_px = pixel;
  found.window = window_around(pixel, looked_px, input.image.size());
  if (found.window.empty()) found.window = input.window;
  return found;
}

Observation observe(const cv::Mat& image, const PredictedView& view,
                    const FeaturePrediction& prediction, const FeatureExtractor& extractor,
                    const ExtractorOptions& options, std::optional<double> background_grey) {
  const cv::Rect window =
      prediction.is_in_front ? window_around(prediction.pixel, options.window_half_px, image.size())
                             : cv::Rect();
  if (window.empty()) return unseen(prediction, window, ObservationStatus::kOutsideImage);
  if (prediction.is_hidden) return unseen(prediction, window, ObservationStatus::kHidden);
  const ObservationStatus why_not = why_not_look(image(window));
  if (why_not != ObservationStatus::kFound) return unseen(prediction, window, why_not);
  const ExtractionInput input{image, view, prediction, options, window, background_grey};
  Observation observation = extracted(input, extractor);
  if (options.is_gated && observation.status == ObservationStatus::kFound &&
      !is_within_search(input, observation.pixel)) {
    observation.status = ObservationStatus::kOutsideWindow;
    observation.edge_lines.clear();  // they were laid through it
  }
  return observation;
}

bool matches_edges_jointly(const PredictedView& view, const ExtractorOptions& options) {
  if (options.is_gated || view.target == nullptr || view.covariance.isZero(0)) return false;
  if (options.joint_edges != JointEdges::kTextured) return options.joint_edges == JointEdges::kOn;
  return !view.target->mesh.coats.empty();
}

bool looks_for_model_edges(const FeaturePrediction& prediction, const ExtractorChoice& choice) {
  const auto extract = choice.of(prediction.kind).extract;
  return prediction.kind == FeatureKind::kLineIntersection &&
         (extract == extract_model_edges || extract == extract_edges_else_contour);
}

// The lines along a feature's edges, in an image in which no lens bends them.
std::vector<StretchCandidates> straight_candidates(const ExtractionInput& input) {
  const auto straight = straight_about(input);
  if (!straight) return line_candidates(input);
  const PredictedView view = straight->view_of(input.view, input.prediction);
  return line_candidates({straight->image(), view, view.features.front(), input.options,
                          input.window, input.background_grey});
}

// How edges are looked for around the pose that was matched jointly. It is known to a few tenths of
// a pixel: the print's borders beside the edges may stay outside, and between there is so little
// else that fainter edges are looked for, such as those of the print's dark squares.
ExtractorOptions about_matched(ExtractorOptions options) {
  options.is_gated = true;
  options.search.least_half_px = 2.5;
  options.search.threshold_noises *= 0.6;
  return options;
}

// The view from the pose with which the lines along all edges agree, if they do with one.
std::optional<PredictedView> jointly_matched(const std::vector<Channel>& channels,
                                             const PredictedView& view,
                                             const ExtractorChoice& choice,
                                             const ExtractorOptions& options) {
  std::vector<StretchCandidates> stretches;
  std::vector<int> features;
  for (const FeaturePrediction& prediction : view.features) {
    features.push_back(prediction.feature);
    if (!looks_for_model_edges(prediction, choice)) continue;
    if (!prediction.is_in_front || prediction.is_hidden) continue;
    const Channel& channel = channel_of_contrast(channels, prediction, options);
    const cv::Rect window =
        window_around(prediction.pixel, options.window_half_px, channel.image.size());
    if (window.empty()) continue;
    std::vector<StretchCandidates> own = straight_candidates(
        {channel.image, view, prediction, options, window, channel.background_grey});
    std::ranges::move(own, std::back_inserter(stretches));
  }
  const auto pose = jointly_explained(stretches, {view.cam_from_target, view.covariance});
  if (!pose) return std::nullopt;
  return predict_features(*view.target, features, view.camera, *pose);
}

}  // namespace

Observation nothing_found(const ExtractionInput& input) {
  return unseen(input.prediction, input.window, ObservationStatus::kNoCorner);
}

double search_half_px(const ExtractionInput& input, const Eigen::Vector2d& direction) {
  const SearchOptions& options = input.options.search;
  const double variance = direction.dot(input.prediction.covariance_px2 * direction);
  return std::clamp(options.sigmas * std::sqrt(variance) + options.margin_px, options.least_half_px,
                    options.most_half_px);
}

std::span<const FeatureExtractor> feature_extractors() {
  return kCatalogue;
}

const FeatureExtractor* find_feature_extractor(std::string_view name) {
  for (const FeatureExtractor& extractor : kCatalogue) {
    if (extractor.name == name) return &extractor;
  }
  return nullptr;
}

void ExtractorChoice::choose(const FeatureExtractor& extractor) {
  if (extractor.finds(FeatureKind::kLineIntersection)) line_intersection = &extractor;
  if (extractor.finds(FeatureKind::kCorner)) corner = &extractor;
  if (extractor.finds(FeatureKind::kContour)) contour = &extractor;
}

const FeatureExtractor& ExtractorChoice::of(FeatureKind kind) const {
  switch (kind) {
    case FeatureKind::kLineIntersection:
      return *line_intersection;
    case FeatureKind::kCorner:
      return *corner;
    case FeatureKind::kContour:
      return contour != nullptr ? *contour : *corner;
  }
  return *corner;
}

std::vector<Observation> extract_features(const cv::Mat& image, double white,
                                          const PredictedView& view, const ExtractorChoice& choice,
                                          const ExtractorOptions& options) {
  cv::Mat scaled = image;
  if (image.depth() != CV_8U || white != 255) image.convertTo(scaled, CV_8U, 255 / white);
  std::vector<Channel> channels;
  for (const cv::Mat& channel : grey_and_colours(scaled)) {
    channels.push_back({channel, background_level(channel, view)});
  }
  std::optional<PredictedView> matched;
  if (matches_edges_jointly(view, options)) {
    matched = jointly_matched(channels, view, choice, options);
  }
  const ExtractorOptions gated = about_matched(options);
  std::vector<Observation> observations;
  for (size_t i = 0; i < view.features.size(); ++i) {
    // The other extractors see what they would see without: they are compared with each other.
    const bool is_matched = matched && looks_for_model_edges(view.features[i], choice);
    const PredictedView& looked_at = is_matched ? *matched : view;
    const FeaturePrediction& prediction = looked_at.features[i];
    const Channel& channel = channel_of_contrast(channels, prediction, options);
    observations.push_back(observe(channel.image, looked_at, prediction, choice.of(prediction.kind),
                                   is_matched ? gated : options, channel.background_grey));
  }
  if (view.target != nullptr) drop_shared_lines(*view.target, observations);
  return observations;
}

}  // namespace sightline
