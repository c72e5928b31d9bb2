// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Sightings in the format of SPEED+ and SPEED (speed/layout.h).
#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include <fmt/format.h>

#include "eval/datasets/conventions.h"
#include "eval/datasets/model_file.h"
#include "eval/datasets/set_readers.h"
#include "eval/datasets/speed/layout.h"
#include "eval/output/json.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> lists_in(const fs::path& folder, std::span<const std::string_view> names) {
  std::vector<fs::path> lists;
  for (const std::string_view name : names) {
    fs::path list = folder / fmt::format("{}.json", name);
    if (fs::is_regular_file(list)) lists.push_back(std::move(list));
  }
  return lists;
}

// The list that the source names, if it names one and it is there.
std::vector<fs::path> named_lists(const SightingSource& source) {
  if (source.split.empty()) return {};
  return lists_in(source.folder, std::array{std::string_view(source.split)});
}

// The list that is meant.
fs::path list_of(const SightingSource& source) {
  const std::string folder = source.folder.string();
  if (!source.split.empty()) {
    const auto lists = named_lists(source);
    if (!lists.empty()) return lists.front();
    throw InputError(fmt::format("{}: has no {}.json", folder, source.split));
  }
  const auto lists = lists_in(source.folder, speed::kLists);
  if (lists.size() == 1) return lists.front();
  throw InputError(fmt::format("{}: has {} and {}; say --split which one is meant", folder,
                               lists[0].filename().string(), lists[1].filename().string()));
}

// The domains of SPEED+ (synthetic/, lightbox/, sunlamp/) share the camera of the folder above.
fs::path camera_file(const fs::path& list) {
  const fs::path folder = fs::absolute(list).parent_path();
  for (const fs::path& place : {folder, folder.parent_path()}) {
    if (fs::exists(place / speed::kCameraFile)) return place / speed::kCameraFile;
  }
  throw InputError(fmt::format("{}: is missing", (folder / speed::kCameraFile).string()));
}

Eigen::Matrix3d matrix_in(const Json& camera) {
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  if (camera.contains("cameraMatrix")) {
    const Json& rows = camera["cameraMatrix"];
    for (size_t i = 0; i < 9; ++i) k(i / 3, i % 3) = rows.at(i / 3).at(i % 3).get<double>();
    return k;
  }
  k(0, 0) = camera.at("fx").get<double>() / camera.at("ppx").get<double>();
  k(1, 1) = camera.at("fy").get<double>() / camera.at("ppy").get<double>();
  k(0, 2) = camera.at("Nu").get<double>() / 2;
  k(1, 2) = camera.at("Nv").get<double>() / 2;
  return k;
}

Camera read_camera(const fs::path& file) {
  Camera camera;
  with_json(file, [&camera](const Json& json) {
    camera = camera_from_matrix(matrix_in(json));
    camera.cx_px -= speed::kHalfPixel;
    camera.cy_px -= speed::kHalfPixel;
    if (!json.contains("distCoeffs")) return;
    const std::vector<double> d = numbers_in(json, "distCoeffs", 5);
    camera.distortion = {.k1 = d[0], .k2 = d[1], .p1 = d[2], .p2 = d[3], .k3 = d[4]};
  });
  return camera;
}

// In images/ beside the list; in SPEED in a folder of the list's name there.
fs::path picture_file(const fs::path& list, const std::string& name) {
  const fs::path given = fs::path(name).lexically_normal();
  if (given.is_absolute() || given.empty() || *given.begin() == "..") {
    throw InputError(fmt::format("names {}, which must lie within the set", name));
  }
  const fs::path images = list.parent_path() / speed::kImagesFolder;
  for (const fs::path& folder : {images, images / list.stem()}) {
    if (fs::is_regular_file(folder / name)) return folder / name;
  }
  throw InputError(fmt::format("names {}, which is not in {}", name, images.string()));
}

Pose stated_pose(const Json& entry) {
  const std::string key =
      entry.contains(speed::kAttitude) ? speed::kAttitude : speed::kAttitudeOfSpeed;
  const std::vector<double> q = numbers_in(entry, key, 4);
  const std::vector<double> r = numbers_in(entry, speed::kPosition, 3);
  return {rotation_of_printed(Eigen::Quaterniond(q[0], q[1], q[2], q[3]), key),
          Eigen::Vector3d(r[0], r[1], r[2])};
}

// Sightline's own sets have the model beside them, in the target's frame.
void add_model(const fs::path& folder, SetReading& reading) {
  reading.model_file = folder / speed::kModelFile;
  if (!fs::exists(reading.model_file)) return;
  reading.model_box_m.emplace();
  for (const Eigen::Vector3d& vertex : read_ply_as_it_is(reading.model_file).vertices) {
    reading.model_box_m->extend(kMetresPerMillimetre * vertex);
  }
}

// Whether the folder has a list as SPEED+ has them.
bool is_speed_set(const SightingSource& source) {
  return !lists_in(source.folder, speed::kLists).empty() || !named_lists(source).empty();
}

SetReading read_speed_sightings(const SightingSource& source) {
  const fs::path list = list_of(source);
  if (source.obj_id) {
    throw InputError(fmt::format("{}: is of one object, as SPEED+ is; no --object can be chosen",
                                 list.string()));
  }
  if (!source.distortion.is_zero()) {
    throw InputError("camera.distortion: is for BOP sets; SPEED+ has it in camera.json");
  }
  SetReading reading;
  const Camera camera = read_camera(camera_file(list));
  with_json(list, [&](const Json& entries) {
    for (const Json& entry : entries) {
      Sighting& sighting = reading.sightings.emplace_back();
      sighting.picture = picture_file(list, entry.at(speed::kPicture).get<std::string>());
      sighting.im_id = static_cast<int>(reading.sightings.size()) - 1;
      sighting.camera = camera;
      sighting.cam_from_target = stated_pose(entry);
    }
    if (reading.sightings.empty()) throw InputError("lists no image");
  });
  add_model(list.parent_path(), reading);
  return reading;
}

}  // namespace

SetReader speed_reader() {
  return {.name = "speed", .is_of = is_speed_set, .read = read_speed_sightings};
}

}  // namespace sightline
