// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/doors/external_extractor.h"

#include <filesystem>
#include <memory>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "eval/doors/process_json.h"
#include "eval/output/output_folder.h"
#include "scenes/files/input_error.h"
#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// The file of a question's image: the data set's own, or one that is removed with this.
class ImageFile {
 public:
  ImageFile(const ExtractorQuestion& asked, const ExternalProcess& process) {
    if (!asked.picture.empty()) {
      path_ = fs::absolute(asked.picture).lexically_normal();
      return;
    }
    is_own_ = true;
    path_ = process.scratch() /
            fmt::format("{}-{}-{}.png", process.name(), process.job(), asked.trial.trial);
    write_file(path_, png_bytes(asked.image));
  }
  ~ImageFile() {
    std::error_code ignored;
    if (is_own_) fs::remove(path_, ignored);
  }
  ImageFile(const ImageFile&) = delete;
  ImageFile& operator=(const ImageFile&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
  bool is_own_ = false;
};

std::vector<std::string> feature_names(const PredictedView& view) {
  std::vector<std::string> names;
  for (const FeaturePrediction& prediction : view.features) {
    names.push_back(view.target->features[static_cast<size_t>(prediction.feature)].name);
  }
  return names;
}

Json question_of(const ExtractorQuestion& asked, const fs::path& image) {
  const PredictedView& view = asked.view;
  Json question = question_about("extract", asked.trial);
  question["image"] = image.string();
  question["white"] = asked.white;
  question["camera"] = json_of(view.camera);
  question["prior"] = json_of(view.cam_from_target);
  Json& features = question["features"] = Json::array();
  for (const FeaturePrediction& prediction : view.features) {
    const TargetFeature& feature = view.target->features[static_cast<size_t>(prediction.feature)];
    Json& entry = features.emplace_back();
    entry["name"] = feature.name;
    entry["point_m"] = json_of_point(feature.position_m);
    if (!prediction.is_in_front) continue;
    entry["pixel"] = json_of_point(prediction.pixel);
    entry["covariance_px2"] = json_of(prediction.covariance_px2);
    entry["is_hidden"] = prediction.is_hidden;
  }
  return question;
}

void read_observation(const Json& given, double sigma_px, Observation& observation) {
  observation.status = ObservationStatus::kFound;
  observation.pixel = {number_at(given, "u"), number_at(given, "v")};
  if (given.contains("covariance_px2")) {
    observation.covariance_px2 = covariance_at(given, "covariance_px2", 2);
    return;
  }
  const double sigma = given.contains("sigma_px") ? number_at(given, "sigma_px") : sigma_px;
  if (!(sigma > 0)) throw BadAnswer("has a sigma_px that is not positive");
  observation.covariance_px2 = sigma * sigma * Eigen::Matrix2d::Identity();
}

std::vector<Observation> observations_in(const Json& answer, double sigma_px,
                                         const PredictedView& view) {
  const std::vector<std::string> names = feature_names(view);
  std::vector<Observation> observations = missing_observations(view);
  if (!answer.contains("observations") || !answer["observations"].is_array()) {
    throw BadAnswer("has no array of observations");
  }
  for (const Json& given : answer["observations"]) {
    const std::string name = given.at("feature").get<std::string>();
    Observation& observation = observations[place_of(name, names)];
    if (observation.status == ObservationStatus::kFound) {
      throw BadAnswer(fmt::format("has the feature '{}' twice", name));
    }
    read_observation(given, sigma_px, observation);
  }
  return observations;
}

}  // namespace

std::vector<Key> keys_of(ExtractorProcessSource& source) {
  std::vector<Key> keys = keys_of(static_cast<ProcessSource&>(source));
  for (Key& key : keys) {
    key.table = "external.extractor";
    if (key.name == "name") key.meaning = "of the extractor that the process is";
  }
  keys.push_back({.table = "external.extractor",
                  .name = "sigma_px",
                  .value = &source.sigma_px,
                  .allowed = {1e-6, 1e6},
                  .unit = "px",
                  .meaning = "standard deviation, each coordinate, of observations that state "
                             "none"});
  return keys;
}

TrialExtractor external_extractor(const ExtractorProcessSource& source) {
  TrialExtractor extractor;
  extractor.name = source.name;
  extractor.summary = fmt::format("the process: {}", source.command);
  extractor.process = std::make_shared<ExternalProcess>(source, "extractor");
  extractor.extract = [process = extractor.process,
                       sigma_px = source.sigma_px](const ExtractorQuestion& asked) {
    const ImageFile image(asked, *process);
    ExtractorAnswer out;
    const EstimateOutcome outcome =
        process->ask(question_of(asked, image.path()), asked.trial.trial, [&](const Json& answer) {
          out.observations = observations_in(answer, sigma_px, asked.view);
          return EstimateOutcome::kOk;
        });
    if (outcome != EstimateOutcome::kOk) out.problem = outcome;
    return out;
  };
  return extractor;
}

}  // namespace sightline
