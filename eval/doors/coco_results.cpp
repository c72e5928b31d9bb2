// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The format: https://cocodataset.org/#format-results, "keypoint detection": an array of
// {image_id, category_id, keypoints: [x, y, score, ...], score}.
#include "eval/doors/coco_results.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/output/json.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

// One detection, its keypoints by the index of the target's feature.
struct Detection {
  PictureName picture;
  int category = 0;
  double score = 0;
  size_t place = 0;                                        // in the file's array, from 0
  std::vector<std::pair<int, Eigen::Vector2d>> keypoints;  // as the file counts pixels
};

// Which picture an id means, and which features a category's keypoints are.
struct Annotations {
  std::map<int64_t, PictureName> pictures;
  std::map<int64_t, std::vector<int>> features;  // -1: a keypoint that is no feature
};

[[noreturn]] void fail(size_t place, const std::string& reason) {
  throw InputError(fmt::format("detection {} {}", place + 1, reason));
}

int64_t whole_in(const Json& json, const char* key, size_t place) {
  if (!json.is_object() || !json.contains(key) || !json[key].is_number_integer()) {
    fail(place, fmt::format("has no {}, must have a whole number", key));
  }
  return json[key].get<int64_t>();
}

// The picture whose path ends in that of an annotation.
std::optional<PictureName> picture_named(const std::string& name, const ShownPictures& pictures) {
  for (const ShownTarget& shown : pictures.all()) {
    if (shown.image == name) return shown.picture;
    if (shown.image.size() > name.size() && shown.image.ends_with("/" + name)) return shown.picture;
  }
  return std::nullopt;
}

std::vector<int> features_named(const std::vector<std::string>& names, const Target& target) {
  std::vector<int> features;
  for (const std::string& name : names) {
    const auto found =
        std::find_if(target.features.begin(), target.features.end(),
                     [&](const TargetFeature& feature) { return feature.name == name; });
    features.push_back(
        found == target.features.end() ? -1 : static_cast<int>(found - target.features.begin()));
  }
  return features;
}

Annotations read_annotations(const std::filesystem::path& file, const ShownPictures& pictures) {
  Annotations annotations;
  with_json(file, [&](const Json& json) {
    for (const Json& image : json.at("images")) {
      const auto picture = picture_named(image.at("file_name").get<std::string>(), pictures);
      if (picture) annotations.pictures[image.at("id").get<int64_t>()] = *picture;
    }
    for (const Json& category : json.at("categories")) {
      if (!category.contains("keypoints")) continue;
      annotations.features[category.at("id").get<int64_t>()] =
          features_named(category["keypoints"].get<std::vector<std::string>>(), pictures.target());
    }
  });
  if (annotations.pictures.empty()) {
    throw InputError(fmt::format("{}: names no picture of the set", file.string()));
  }
  return annotations;
}

std::vector<int> all_features(const Target& target) {
  std::vector<int> all(target.features.size());
  for (size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  return all;
}

PictureName picture_of(int64_t image_id, const ShownPictures& pictures, size_t place) {
  const std::vector<int> scenes = pictures.scenes();
  if (scenes.size() > 1) {
    fail(place, fmt::format("has image_id {}, which may be of any of {} scenes: the key `images` "
                            "must name annotations that say it",
                            image_id, scenes.size()));
  }
  if (image_id < 0) {
    fail(place, fmt::format("has image_id {}, must be a whole number from 0", image_id));
  }
  const PictureName picture{scenes.empty() ? 0 : scenes.front(), image_id};
  const std::string why_not = pictures.why_not(picture);
  if (!why_not.empty()) fail(place, why_not);
  return picture;
}

std::vector<double> numbers_of(const Json& keypoints, size_t place, size_t count) {
  const bool is_right = keypoints.is_array() && keypoints.size() == 3 * count &&
                        std::all_of(keypoints.begin(), keypoints.end(), [](const Json& number) {
                          return number.is_number() || number.is_null();
                        });
  if (!is_right) {
    fail(place, fmt::format("has {} values of keypoints, must have x, y, score of each of {}",
                            keypoints.is_array() ? keypoints.size() : 0, count));
  }
  std::vector<double> numbers;
  for (const Json& number : keypoints) {  // null is what was no number, and so no keypoint
    numbers.push_back(number.is_null() ? std::numeric_limits<double>::quiet_NaN()
                                       : number.get<double>());
  }
  return numbers;
}

Detection read_detection(const Json& json, size_t place, const std::optional<Annotations>& known,
                         const ObservationSource& source, const ShownPictures& pictures) {
  Detection detection;
  detection.place = place;
  const int64_t image_id = whole_in(json, "image_id", place);
  if (known && !known->pictures.contains(image_id)) {
    fail(place, fmt::format("has image_id {}, which {} does not name", image_id,
                            source.images.filename().string()));
  }
  detection.picture = known ? known->pictures.at(image_id) : picture_of(image_id, pictures, place);
  const int64_t category = whole_in(json, "category_id", place);
  detection.category = static_cast<int>(category);
  if (json.contains("score") && json["score"].is_number()) detection.score = json["score"];
  const std::vector<int> features = known && known->features.contains(category)
                                        ? known->features.at(category)
                                        : all_features(pictures.target());
  const Json none;
  const std::vector<double> numbers =
      numbers_of(json.contains("keypoints") ? json["keypoints"] : none, place, features.size());
  for (size_t i = 0; i < features.size(); ++i) {
    const double score = numbers[3 * i + 2];
    if (features[i] < 0 || !(score > 0) || score < source.least_confidence) continue;
    const Eigen::Vector2d pixel(numbers[3 * i], numbers[3 * i + 1]);
    if (pixel.allFinite()) detection.keypoints.emplace_back(features[i], pixel);
  }
  return detection;
}

// The mean distance of the keypoints from where the instance has them, px.
double distance_px(const Detection& detection, const ShownTarget& shown, PixelOrigin origin,
                   const Target& target) {
  double sum = 0;
  for (const auto& [feature, given] : detection.keypoints) {
    const auto truth = true_pixel(shown, target.features[static_cast<size_t>(feature)]);
    if (!truth) return std::numeric_limits<double>::infinity();
    sum += (pixel_of(given, origin, shown.camera) - *truth).norm();
  }
  return sum / std::max<double>(1, static_cast<double>(detection.keypoints.size()));
}

// The instance, nearest of those that no surer detection was given to; null where none is left.
const ShownTarget* instance_for(const Detection& detection, const ShownPictures& pictures,
                                PixelOrigin origin, const std::set<const ShownTarget*>& taken) {
  const ShownTarget* nearest = nullptr;
  double nearest_px = std::numeric_limits<double>::infinity();
  for (const ShownTarget& shown : pictures.in(detection.picture)) {
    if (taken.contains(&shown)) continue;
    const double distance = distance_px(detection, shown, origin, pictures.target());
    if (nearest != nullptr && distance >= nearest_px) continue;
    nearest = &shown;
    nearest_px = distance;
  }
  return nearest;
}

GivenObservations assign(std::vector<Detection> detections, const ObservationSource& source,
                         const ShownPictures& pictures) {
  std::stable_sort(detections.begin(), detections.end(),
                   [](const Detection& a, const Detection& b) { return a.score > b.score; });
  GivenObservations given;
  std::set<const ShownTarget*> taken;
  for (const Detection& detection : detections) {
    const ShownTarget* const shown = instance_for(detection, pictures, source.pixels, taken);
    if (shown == nullptr) continue;
    taken.insert(shown);
    GivenFeatures& features = given[{shown->picture.scene_id, shown->picture.im_id, shown->gt_id}];
    for (const auto& [feature, pixel] : detection.keypoints) {
      features[feature] = {pixel_of(pixel, source.pixels, shown->camera), std::nullopt};
    }
  }
  return given;
}

void require_one_category(const std::vector<Detection>& detections) {
  for (const Detection& detection : detections) {
    if (detection.category == detections.front().category) continue;
    fail(detection.place, fmt::format("is of category {}, the first of category {}: all must be of "
                                      "the target's",
                                      detection.category, detections.front().category));
  }
}

}  // namespace

Eigen::Vector2d pixel_of(const Eigen::Vector2d& given, PixelOrigin origin, const Camera& camera) {
  constexpr double kHalfPixel = 0.5;
  switch (origin) {
    case PixelOrigin::kCentres:
      return given;
    case PixelOrigin::kCorners:
      return given - Eigen::Vector2d::Constant(kHalfPixel);
    case PixelOrigin::kNormalised:
      return given.cwiseProduct(Eigen::Vector2d(camera.width_px, camera.height_px)) -
             Eigen::Vector2d::Constant(kHalfPixel);
  }
  return given;
}

GivenObservations read_coco_results(const ObservationSource& source,
                                    const ShownPictures& pictures) {
  std::optional<Annotations> annotations;
  if (!source.images.empty()) annotations = read_annotations(source.images, pictures);
  std::vector<Detection> detections;
  with_json(source.file, [&](const Json& json) {
    if (!json.is_array()) throw InputError("must be an array of detections, as COCO's results are");
    for (size_t i = 0; i < json.size(); ++i) {
      detections.push_back(read_detection(json[i], i, annotations, source, pictures));
    }
    require_one_category(detections);
  });
  return assign(std::move(detections), source, pictures);
}

}  // namespace sightline
