// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/doors/observation_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "eval/doors/coco_results.h"
#include "eval/output/csv_reader.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"

namespace sightline {
namespace {

const std::vector<std::string> kRequired = {"scene_id", "im_id", "feature", "u", "v"};
const std::vector<std::string> kVariances = {"var_uu", "var_uv", "var_vv"};
constexpr Interval kSigmas{1e-6, 1e6};  // px
constexpr double kFarthestPx = 1e9;

void require_known_columns(const CsvReader& csv) {
  std::vector<std::string> known = kRequired;
  known.insert(known.end(), {"gt_id", "sigma", "confidence"});
  known.insert(known.end(), kVariances.begin(), kVariances.end());
  csv.require_columns(kRequired, known);
  const auto has = [&csv](const std::string& column) { return csv.has_column(column); };
  const bool has_any = std::any_of(kVariances.begin(), kVariances.end(), has);
  const bool has_all = std::all_of(kVariances.begin(), kVariances.end(), has);
  if (has_any && (!has_all || csv.has_column("sigma"))) {
    csv.fail("must name either sigma or all of var_uu, var_uv, var_vv");
  }
}

std::optional<Eigen::Matrix2d> covariance_in(const CsvReader& csv) {
  if (csv.has_column("sigma")) {
    if (csv.is_empty("sigma")) return std::nullopt;
    const double sigma_px = csv.number("sigma", kSigmas);
    return Eigen::Matrix2d(sigma_px * sigma_px * Eigen::Matrix2d::Identity());
  }
  if (!csv.has_column("var_uu") || csv.is_empty("var_uu")) return std::nullopt;
  Eigen::Matrix2d covariance;
  const double uv = csv.number("var_uv");
  covariance << csv.number("var_uu"), uv, uv, csv.number("var_vv");
  if (covariance(0, 0) > 0 && covariance.determinant() > 0) return covariance;
  csv.fail(fmt::format("has var_uu {}, var_uv {}, var_vv {}, which are no covariance",
                       covariance(0, 0), uv, covariance(1, 1)));
}

int feature_of(const CsvReader& csv, const Target& target) {
  const std::string_view name = csv.text("feature");
  std::vector<std::string> known;
  for (size_t i = 0; i < target.features.size(); ++i) {
    if (target.features[i].name == name) return static_cast<int>(i);
    known.push_back(target.features[i].name);
  }
  csv.fail(fmt::format("has a feature '{}'{}", name, suggestion(name, known)));
}

// The instance that a row is of; null where its picture does not show the target.
const ShownTarget* shown_by(const CsvReader& csv, const ShownPictures& pictures) {
  const PictureName picture{csv.integer("scene_id"), csv.wide_integer("im_id")};
  if (picture.scene_id < 0 || picture.im_id < 0) return nullptr;  // of no picture
  const std::string why_not = pictures.why_not(picture);
  if (!why_not.empty()) csv.fail(why_not);
  const auto shown = pictures.in(picture);
  if (csv.has_column("gt_id")) {
    const int gt_id = csv.whole("gt_id");
    const auto found = std::find_if(shown.begin(), shown.end(),
                                    [gt_id](const ShownTarget& s) { return s.gt_id == gt_id; });
    return found == shown.end() ? nullptr : &*found;
  }
  if (shown.size() > 1) {
    csv.fail(
        fmt::format("is about image {} of scene {}, which shows the target {} times: a column "
                    "gt_id must say which",
                    picture.im_id, picture.scene_id, shown.size()));
  }
  return shown.empty() ? nullptr : &shown.front();
}

// Where a row says that the feature is; none where it says of it that it was not found, by numbers
// that are no place in any picture.
std::optional<Eigen::Vector2d> place_in(const CsvReader& csv) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector2d uv(csv.number_or("u", kNone), csv.number_or("v", kNone));
  if (!(uv.cwiseAbs().maxCoeff() <= kFarthestPx) || !uv.allFinite()) return std::nullopt;
  return uv;
}

// Whether the numbers that weigh a row are finite: it counts as not found otherwise.
bool has_finite_weights(const CsvReader& csv) {
  constexpr std::array kWeights = {"sigma", "var_uu", "var_uv", "var_vv", "confidence"};
  return std::all_of(kWeights.begin(), kWeights.end(), [&csv](const char* column) {
    return !csv.has_column(column) || std::isfinite(csv.number_or(column, 0));
  });
}

GivenObservations read_csv(const ObservationSource& source, const ShownPictures& pictures) {
  CsvReader csv(source.file);
  require_known_columns(csv);
  GivenObservations given;
  while (csv.next()) {
    const int feature = feature_of(csv, pictures.target());
    const ShownTarget* const shown = shown_by(csv, pictures);
    const auto uv = place_in(csv);
    if (!uv || !has_finite_weights(csv)) continue;
    const auto covariance = covariance_in(csv);
    const bool is_sure =
        !csv.has_column("confidence") || csv.number("confidence") >= source.least_confidence;
    if (shown == nullptr || !is_sure) continue;
    GivenFeatures& features = given[{shown->picture.scene_id, shown->picture.im_id, shown->gt_id}];
    const GivenObservation observation{pixel_of(*uv, source.pixels, shown->camera), covariance};
    if (!features.emplace(feature, observation).second) {
      csv.fail(fmt::format("has '{}' of image {} of scene {} a second time", csv.text("feature"),
                           shown->picture.im_id, shown->picture.scene_id));
    }
  }
  return given;
}

// The squared distances from the truth of all observations without a covariance.
std::vector<double> squared_errors_px2(const GivenObservations& given,
                                       const ShownPictures& pictures) {
  std::vector<double> squares;
  for (const ShownTarget& shown : pictures.all()) {
    const auto found = given.find({shown.picture.scene_id, shown.picture.im_id, shown.gt_id});
    if (found == given.end()) continue;
    for (const auto& [feature, observation] : found->second) {
      if (observation.covariance_px2) continue;
      const auto truth =
          true_pixel(shown, pictures.target().features[static_cast<size_t>(feature)]);
      if (truth) squares.push_back((observation.pixel - *truth).squaredNorm());
    }
  }
  return squares;
}

ExtractorAnswer answer(const GivenObservations& given, double sigma_px,
                       const ExtractorQuestion& question) {
  ExtractorAnswer out{missing_observations(question.view), {}};
  const TrialName& trial = question.trial;
  const auto found = given.find({trial.scene_id, trial.im_id, trial.gt_id});
  if (found == given.end()) return out;
  for (Observation& observation : out.observations) {
    const auto feature = found->second.find(observation.feature);
    if (feature == found->second.end()) continue;
    observation.status = ObservationStatus::kFound;
    observation.pixel = feature->second.pixel;
    observation.covariance_px2 = feature->second.covariance_px2.value_or(
        Eigen::Matrix2d(sigma_px * sigma_px * Eigen::Matrix2d::Identity()));
  }
  return out;
}

}  // namespace

std::vector<Key> keys_of(ObservationSource& source) {
  const std::string table = "observations";
  return {
      {.table = table,
       .name = "name",
       .value = &source.name,
       .allowed = {},
       .unit = "",
       .meaning = "of the extractor that the file stands for",
       .is_required = true},
      {.table = table,
       .name = "file",
       .value = &source.file,
       .allowed = {},
       .unit = "",
       .meaning = "observations of somebody's extractor: CSV, or COCO keypoint results",
       .is_required = true},
      {.table = table,
       .name = "format",
       .value = choice(source.format, {{"by_ending", ObservationFormat::kByEnding},
                                       {"csv", ObservationFormat::kCsv},
                                       {"coco", ObservationFormat::kCoco}}),
       .allowed = {},
       .unit = "",
       .meaning = "of the file; a name that ends in .json is taken for COCO's"},
      {.table = table,
       .name = "pixels",
       .value = choice(source.pixels, {{"centres", PixelOrigin::kCentres},
                                       {"corners", PixelOrigin::kCorners},
                                       {"normalised", PixelOrigin::kNormalised}}),
       .allowed = {},
       .unit = "",
       .meaning = "where (0, 0) is: at the top-left pixel's centre, as here and in COCO's "
                  "keypoints, or at its corner; normalised: from the corner, over the picture's "
                  "width and height, as YOLO-pose writes"},
      {.table = table,
       .name = "images",
       .value = &source.images,
       .allowed = {},
       .unit = "",
       .meaning = "COCO annotations whose `images` say which picture an image_id is, and whose "
                  "`categories` say which keypoint is which feature",
       .if_absent = "image_id is im_id, keypoints are all features in the target's order"},
      {.table = table,
       .name = "least_confidence",
       .value = &source.least_confidence,
       .allowed = {-1e9, 1e9},
       .unit = "",
       .meaning = "observations of a smaller confidence do not count"},
  };
}

GivenObservations read_observations(const ObservationSource& source,
                                    const ShownPictures& pictures) {
  const bool is_coco =
      source.format == ObservationFormat::kCoco ||
      (source.format == ObservationFormat::kByEnding && input_ending(source.file) == ".json");
  return is_coco ? read_coco_results(source, pictures) : read_csv(source, pictures);
}

double inlier_sigma_px(std::vector<double> squared_errors_px2) {
  if (squared_errors_px2.empty()) return 0;
  constexpr double kInlierSigmas = 3.0349;  // within which 99 of 100 Gaussian observations lie
  constexpr int kMostRounds = 50;
  constexpr double kConverged = 1e-9;
  const auto middle = squared_errors_px2.begin() + squared_errors_px2.size() / 2;
  std::nth_element(squared_errors_px2.begin(), middle, squared_errors_px2.end());
  // The squared distance is exponential with mean 2 sigma^2: its median is 2 ln 2 sigma^2.
  double variance = *middle / (2 * std::log(2.0));
  // Its mean below c^2 sigma^2 is 2 sigma^2 (1 - (c^2 / 2) e / (1 - e)), e = exp(-c^2 / 2).
  const double half = kInlierSigmas * kInlierSigmas / 2;
  const double beyond = std::exp(-half);
  const double kept = 2 * (1 - half * beyond / (1 - beyond));
  for (int round = 0; round < kMostRounds && variance > 0; ++round) {
    double sum = 0;
    int count = 0;
    for (const double square : squared_errors_px2) {
      if (square > 2 * half * variance) continue;
      sum += square;
      ++count;
    }
    const double better = count > 0 ? sum / count / kept : variance;
    const bool is_done = std::abs(better - variance) <= kConverged * variance;
    variance = better;
    if (is_done) break;
  }
  return std::sqrt(variance);
}

TrialExtractor recorded_extractor(const ObservationSource& source, const ShownPictures& pictures) {
  constexpr double kLeastSigmaPx = 1e-3;  // of observations that are the truth itself
  auto given = std::make_shared<const GivenObservations>(read_observations(source, pictures));
  const std::vector<double> squares = squared_errors_px2(*given, pictures);
  const double sigma_px = std::max(inlier_sigma_px(squares), kLeastSigmaPx);
  TrialExtractor extractor;
  extractor.name = source.name;
  extractor.summary = fmt::format("observations from {}", source.file.filename().string());
  if (!squares.empty()) {
    extractor.summary += fmt::format(
        ", whose noise, which it does not state, is estimated from its own inliers: {:.3g} px",
        sigma_px);
  }
  extractor.extract = [given = std::move(given), sigma_px](const ExtractorQuestion& question) {
    return answer(*given, sigma_px, question);
  };
  return extractor;
}

}  // namespace sightline
