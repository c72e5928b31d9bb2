// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/score/scored_set.h"

#include <optional>
#include <set>
#include <string_view>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "eval/datasets/conventions.h"
#include "eval/datasets/pictures.h"
#include "eval/datasets/ply_reader.h"
#include "eval/datasets/set_readers.h"
#include "eval/datasets/speed/layout.h"
#include "eval/datasets/speed/results_csv.h"
#include "eval/output/json.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"
#include "scenes/mesh/diameter.h"
#include "scenes/picture/picture_file.h"

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

// All pictures of a set in SPEED+'s format have one camera, and so one size.
int width_of_first(const std::vector<Sighting>& sightings) {
  for (const Sighting& sighting : sightings) {
    if (const auto size = picture_size(sighting.picture)) return size->width;
  }
  throw InputError(fmt::format("{}: cannot be read as a picture, nor any other of the set",
                               sightings.front().picture.string()));
}

ScoredSet read_speed(const SetReader& reader, const SightingSource& source) {
  const SetReading reading = reader.read(source);
  ScoredSet set;
  set.dataset.models[kObject] = speed_model(reading.model_file);
  const int width_px = width_of_first(reading.sightings);
  std::set<fs::path> pictures;
  for (const Sighting& sighting : reading.sightings) {
    BopImage& image = set.dataset.images.emplace_back();
    image.folder = source.folder;
    image.im_id = sighting.im_id;
    image.width_px = width_px;
    image.k = matrix_of(sighting.camera);
    const Pose& pose = sighting.cam_from_target;
    image.instances.push_back(
        {.obj_id = kObject,
         .cam_from_model = {pose.rotation, kMillimetresPerMetre * pose.translation},
         .has_pose = sighting.problem != EstimateOutcome::kNoTruth});
    image.targets[kObject] = 1;
    set.im_id_of_picture.add(sighting.picture, static_cast<int>(sighting.im_id));
    if (pictures.insert(sighting.picture.lexically_normal()).second) continue;
    throw InputError(
        fmt::format("{}: is listed twice, so that nobody knows which pose an estimate is of",
                    sighting.picture.string()));
  }
  const std::string note =
      note_on_links(source.folder, std::vector<fs::path>(pictures.begin(), pictures.end()));
  if (!note.empty()) set.dataset.notes.push_back(note);
  return set;
}

// An estimate as BOP's are, by its picture's number; that of a picture which the set has not is of
// no image.
BopEstimate bop_estimate(const SpeedEstimate& estimate, const std::optional<int>& im_id) {
  constexpr int kNoImage = -1;
  const Pose& pose = estimate.cam_from_model;
  return {.scene_id = 0,
          .im_id = im_id.value_or(kNoImage),
          .obj_id = kObject,
          .score = 1,
          .cam_from_model = {pose.rotation, kMillimetresPerMetre * pose.translation},
          .line = estimate.line,
          .problem = estimate.problem};
}

std::vector<SpeedEstimate> read_speed_list(const fs::path& file) {
  std::vector<SpeedEstimate> estimates;
  std::set<std::string> seen;
  with_json(file, [&](const Json& list) {
    for (const Json& entry : list) {
      const std::vector<double> q =
          numbers_or_nan_in(entry, first_key_in(entry, speed::kAttitudes), 4);
      const std::vector<double> r_m =
          numbers_or_nan_in(entry, first_key_in(entry, speed::kPositions), 3);
      SpeedEstimate estimate;
      estimate.picture = text_in(entry, speed::kPicture);
      estimate.line = static_cast<int>(estimates.size());
      set_pose({q[0], q[1], q[2], q[3]}, {r_m[0], r_m[1], r_m[2]}, estimate);
      if (!seen.insert(estimate.picture).second) {
        throw InputError(fmt::format("element {} names a picture that was named before: {}",
                                     estimates.size(), estimate.picture));
      }
      estimates.push_back(std::move(estimate));
    }
    if (estimates.empty()) throw InputError("has no estimates");
  });
  return estimates;
}

std::vector<BopEstimate> of_set(const fs::path& file, const ScoredSet& set,
                                const std::vector<SpeedEstimate>& estimates) {
  const auto im_ids = pictures_of(estimates, set.im_id_of_picture, file);
  std::vector<BopEstimate> of_set;
  bool has_any = false;
  for (size_t i = 0; i < estimates.size(); ++i) {
    of_set.push_back(bop_estimate(estimates[i], im_ids[i]));
    has_any |= im_ids[i].has_value();
  }
  if (has_any) return of_set;
  throw InputError(fmt::format("{}: the set has none of its pictures, the first of which is '{}'",
                               file.string(), estimates.front().picture));
}

}  // namespace

ScoredSet read_scored_set(const fs::path& folder, const std::string& split,
                          const std::string& sensor) {
  if (!fs::is_directory(folder)) throw InputError(fmt::format("{}: is no folder", folder.string()));
  SightingSource source;
  source.folder = folder;
  source.split = split;
  source.sensor = sensor;
  const SetReader& reader = set_reader_of(source);
  if (reader.name == "speed") return read_speed(reader, source);
  return {read_bop_dataset(folder, split, sensor), {}};
}

std::vector<BopEstimate> read_estimates(const fs::path& file, const ScoredSet& set) {
  std::string first;
  read_bounded_line(*open_input_file(file, kMostInputBytes), first);
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (first.starts_with(kByteOrderMark)) first.erase(0, kByteOrderMark.size());
  const bool is_of_bop = !set.is_speed() || first.starts_with("scene_id");
  const bool is_list = input_ending(file) == ".json";
  if (is_of_bop && is_list) {
    throw InputError(fmt::format(
        "{}: is a list as SPEED+ has, which knows images by their pictures; the data set is "
        "BOP's, and needs a results CSV",
        file.string()));
  }
  if (is_of_bop) return read_bop_results(file);
  return of_set(file, set, is_list ? read_speed_list(file) : read_speed_results(file));
}

}  // namespace sightline
