// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/score/scored_set.h"

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <set>
#include <span>
#include <string_view>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "eval/datasets/conventions.h"
#include "eval/datasets/model_file.h"
#include "eval/datasets/pictures.h"
#include "eval/datasets/set_readers.h"
#include "eval/datasets/speed/layout.h"
#include "eval/output/json.h"
#include "scenes/files/input_error.h"
#include "scenes/mesh/diameter.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr int kObject = 1;  // of a set in SPEED+'s format

Eigen::Matrix3d matrix_of(const Camera& camera) {
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  k(0, 0) = camera.fx_px;
  k(1, 1) = camera.fy_px;
  k(0, 2) = camera.cx_px;
  k(1, 2) = camera.cy_px;
  return k;
}

BopModel speed_model(const fs::path& file) {
  BopModel model;
  model.points_mm.resize(3, 0);
  model.symmetries = {Pose{}};
  if (!fs::exists(file)) return model;
  model.mesh_mm = read_ply_as_it_is(file);
  const std::vector<Eigen::Vector3d>& vertices = model.mesh_mm.vertices;
  model.points_mm.resize(3, static_cast<Eigen::Index>(vertices.size()));
  for (size_t i = 0; i < vertices.size(); ++i) {
    model.points_mm.col(static_cast<Eigen::Index>(i)) = vertices[i];
  }
  model.diameter_mm = diameter(vertices);
  return model;
}

ScoredSet read_speed(const SetReader& reader, const SightingSource& source) {
  const SetReading reading = reader.read(source);
  ScoredSet set;
  set.dataset.models[kObject] = speed_model(reading.model_file);
  const cv::Mat first = read_picture(reading.sightings.front().picture);
  if (first.empty()) {
    throw InputError(
        fmt::format("{}: cannot be read as a picture", reading.sightings.front().picture.string()));
  }
  for (const Sighting& sighting : reading.sightings) {
    BopImage& image = set.dataset.images.emplace_back();
    image.folder = source.folder;
    image.im_id = sighting.im_id;
    image.width_px = first.cols;
    image.k = matrix_of(sighting.camera);
    const Pose& pose = sighting.cam_from_target;
    image.instances.push_back(
        {.obj_id = kObject,
         .cam_from_model = {pose.rotation, kMillimetresPerMetre * pose.translation}});
    image.targets[kObject] = 1;
    set.im_id_of_picture[sighting.picture.filename().string()] = sighting.im_id;
  }
  return set;
}

// What SPEED+'s files say of one picture; `where` names the row for errors.
BopEstimate speed_estimate(const std::string& where, const std::string& picture,
                           std::span<const double> q, std::span<const double> r_m,
                           const ScoredSet& set) {
  constexpr double kLengthTolerance = 1e-2;  // what few printed digits leave
  const auto image = set.im_id_of_picture.find(fs::path(picture).filename().string());
  if (image == set.im_id_of_picture.end()) {
    throw InputError(fmt::format("{}: the set has no picture '{}'", where, picture));
  }
  const Eigen::Quaterniond quaternion(q[0], q[1], q[2], q[3]);
  if (!(std::abs(quaternion.norm() - 1) <= kLengthTolerance)) {
    throw InputError(fmt::format("{}: the quaternion has the length {}, must have length 1", where,
                                 quaternion.norm()));
  }
  return {.scene_id = 0,
          .im_id = image->second,
          .obj_id = kObject,
          .score = 1,
          .cam_from_model = {quaternion.normalized().toRotationMatrix(),
                             kMillimetresPerMetre * Eigen::Vector3d(r_m[0], r_m[1], r_m[2])}};
}

std::vector<double> numbers_of(const Json& entry, std::span<const char* const> keys, size_t count) {
  for (const char* key : keys) {
    if (entry.contains(key)) return numbers_in(entry, key, count);
  }
  throw InputError(fmt::format("has no {}", keys.front()));
}

std::vector<BopEstimate> read_speed_list(const fs::path& file, const ScoredSet& set) {
  constexpr std::array kAttitudes = {speed::kAttitude, speed::kAttitudeOfSpeed};
  constexpr std::array kPositions = {speed::kPosition, "r_Vo2To_vbs"};
  std::vector<BopEstimate> estimates;
  with_json(file, [&](const Json& list) {
    for (const Json& entry : list) {
      const std::string where = fmt::format("element {}", estimates.size());
      const std::string picture = entry.at(speed::kPicture).get<std::string>();
      const std::vector<double> attitude = numbers_of(entry, kAttitudes, 4);
      const std::vector<double> position_m = numbers_of(entry, kPositions, 3);
      BopEstimate estimate = speed_estimate(where, picture, attitude, position_m, set);
      estimate.line = static_cast<int>(estimates.size());
      estimates.push_back(estimate);
    }
  });
  return estimates;
}

std::vector<std::string> trimmed_fields(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char c : line) {
    if (c == ',') {
      fields.emplace_back();
    } else if (c != ' ' && c != '\t' && c != '\r') {
      fields.back() += c;
    }
  }
  return fields;
}

std::vector<BopEstimate> read_speed_csv(const fs::path& file, const ScoredSet& set) {
  constexpr size_t kFieldsOfALine = 8;
  std::ifstream stream(file);
  std::vector<BopEstimate> estimates;
  std::string text;
  for (int number = 1; std::getline(stream, text); ++number) {
    const std::vector<std::string> fields = trimmed_fields(text);
    const bool is_head = number == 1 && fields[0] == "filename";
    if (is_head || fields == std::vector<std::string>{""}) continue;
    const std::string where = fmt::format("{}: line {}", file.string(), number);
    if (fields.size() != kFieldsOfALine) {
      throw InputError(fmt::format("{}: has {} fields, must have {}: filename,q0,q1,q2,q3,x,y,z",
                                   where, fields.size(), kFieldsOfALine));
    }
    std::vector<double> values;
    for (size_t i = 1; i < kFieldsOfALine; ++i) {
      const std::string& field = fields[i];
      double& value = values.emplace_back();
      const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
      if (error != std::errc() || end != field.data() + field.size() || !std::isfinite(value)) {
        throw InputError(fmt::format("{}: has '{}', must be a finite number", where, field));
      }
    }
    BopEstimate estimate = speed_estimate(where, fields[0], std::span(values).first(4),
                                          std::span(values).subspan(4), set);
    estimate.line = number;
    estimates.push_back(estimate);
  }
  return estimates;
}

// Such files have one estimate of a picture.
void require_one_each(const fs::path& file, std::span<const BopEstimate> estimates) {
  std::set<int> images;
  for (const BopEstimate& estimate : estimates) {
    if (images.insert(estimate.im_id).second) continue;
    throw InputError(fmt::format("{}: {} names a picture that was named before", file.string(),
                                 file.extension() == ".json"
                                     ? fmt::format("element {}", estimate.line)
                                     : fmt::format("line {}", estimate.line)));
  }
}

}  // namespace

ScoredSet read_scored_set(const fs::path& folder, const std::string& split) {
  if (!fs::is_directory(folder)) throw InputError(fmt::format("{}: is no folder", folder.string()));
  SightingSource source;
  source.folder = folder;
  source.split = split;
  const SetReader& reader = set_reader_of(source);
  if (reader.name == "speed") return read_speed(reader, source);
  return {read_bop_dataset(folder, split), {}};
}

std::vector<BopEstimate> read_estimates(const fs::path& file, const ScoredSet& set) {
  std::ifstream stream(file);
  if (!stream || fs::is_directory(file)) {
    throw InputError(fmt::format("{}: cannot be read", file.string()));
  }
  std::string first;
  std::getline(stream, first);
  const bool is_of_bop = !set.is_speed() || first.starts_with("scene_id");
  if (is_of_bop && file.extension() == ".json") {
    throw InputError(fmt::format(
        "{}: is a list as SPEED+ has, which knows images by their pictures; the data set is "
        "BOP's, and needs a results CSV",
        file.string()));
  }
  if (is_of_bop) return read_bop_results(file);
  const std::vector<BopEstimate> estimates =
      file.extension() == ".json" ? read_speed_list(file, set) : read_speed_csv(file, set);
  require_one_each(file, estimates);
  return estimates;
}

}  // namespace sightline
