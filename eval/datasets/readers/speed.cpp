// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Sightings in the format of SPEED+ and SPEED (speed/layout.h).
#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/datasets/conventions.h"
#include "eval/datasets/ply_reader.h"
#include "eval/datasets/set_readers.h"
#include "eval/datasets/speed/layout.h"
#include "eval/output/json.h"
#include "scenes/camera/lens_numbers.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> lists_in(const fs::path& folder, std::span<const std::string_view> names) {
  std::vector<fs::path> lists;
  for (const std::string_view name : names) {
    fs::path list = plain_or_packed(folder / fmt::format("{}.json", name));
    if (fs::is_regular_file(list)) lists.push_back(std::move(list));
  }
  return lists;
}

// Whether a file begins as SPEED's lists do: they name the spacecraft of the mission PRISMA.
bool seems_list(const fs::path& file) {
  constexpr std::streamsize kBeginning = 4096;
  std::string text(kBeginning, '\0');
  try {
    open_input_file(file, kMostInputBytes)->read(text.data(), kBeginning);
  } catch (const InputError&) {
    return false;  // whatever it is, it is no list that can be read
  }
  return text.find(speed::kAttitudeOfSpeed) != std::string::npos;
}

// All lists of a set, whatever their names, as --split takes them: those in its folder and in the
// folders there, such as SPEED+'s domains and SHIRT's orbits.
std::set<std::string> all_lists(const fs::path& folder) {
  constexpr int kMostFiles = 200;  // to look into: a set of another format may have thousands
  std::set<std::string> lists;
  int looked_into = 0;
  std::error_code error;
  for (auto entry = fs::recursive_directory_iterator(folder, error);
       entry != fs::recursive_directory_iterator() && looked_into < kMostFiles;
       entry.increment(error)) {
    if (entry.depth() > 0 || entry->path().filename() == speed::kImagesFolder) {
      entry.disable_recursion_pending();
    }
    const fs::path unpacked = unpacked_name(entry->path());
    if (!entry->is_regular_file(error) || unpacked.extension() != ".json") continue;
    ++looked_into;
    if (!seems_list(entry->path())) continue;
    lists.insert(unpacked.lexically_relative(folder).replace_extension("").string());
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
  std::set<std::string> all = all_lists(source.folder);
  for (const fs::path& known : lists) all.insert(unpacked_name(known).stem().string());
  if (all.size() == 1) return plain_or_packed(source.folder / (*all.begin() + ".json"));
  throw InputError(fmt::format("{}: has {}.json; say --split which one is meant", folder,
                               fmt::join(all, ".json and ")));
}

// The domains of SPEED+ (synthetic/, lightbox/, sunlamp/) share the camera of the folder above.
fs::path camera_file(const fs::path& list) {
  const fs::path folder = fs::absolute(list).parent_path();
  for (const fs::path& place : {folder, folder.parent_path()}) {
    fs::path file = plain_or_packed(place / speed::kCameraFile);
    if (fs::exists(file)) return file;
  }
  throw InputError(fmt::format("{}: is missing", (folder / speed::kCameraFile).string()));
}

// The focal length along an axis in pixels. SPEED states it and the pixel's pitch in metres; who
// writes such a file anew often has both in millimetres, or it in pixels, which a pitch in metres
// or millimetres would make a number of pixels that no lens has.
double focus_px(const Json& camera, const char* focus, const char* pitch) {
  constexpr double kLongestLensM = 10, kLongestFocusPx = 5e4;
  const double given = number_in(camera, focus);
  if (!camera.contains(pitch)) return given;
  const double quotient = given / number_in(camera, pitch);
  return given > kLongestLensM && quotient > kLongestFocusPx ? given : quotient;
}

// Of the principal point; the picture's middle where the camera does not say.
double centre_px(const Json& camera, const char* centre, const char* size) {
  return camera.contains(centre) ? number_in(camera, centre) : number_in(camera, size) / 2;
}

Eigen::Matrix3d matrix_in(const Json& camera) {
  if (camera.contains("cameraMatrix")) {
    return matrix_from_rows(numbers_in(camera, "cameraMatrix", 9));
  }
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  k(0, 0) = focus_px(camera, "fx", "ppx");
  k(1, 1) = focus_px(camera, "fy", "ppy");
  k(0, 2) = centre_px(camera, "ccx", "Nu");
  k(1, 2) = centre_px(camera, "ccy", "Nv");
  return k;
}

// As OpenCV writes them, as a row, a column or a list; of a fisheye where fisheye_model says so.
Lens lens_in(const Json& camera) {
  const Json& value = value_in(camera, "distCoeffs");
  size_t count = 0;
  for (const Json& element : value) count += element.is_array() ? element.size() : 1;
  const std::vector<double> d = finite_numbers(value, "distCoeffs", count);
  const bool is_fisheye =
      camera.contains(speed::kFisheye) && whole_in(camera, speed::kFisheye) != 0;
  try {
    return is_fisheye ? lens_of(*find_lens_model("fisheye"), d) : lens_of_opencv(d);
  } catch (const InputError& error) {
    throw InputError(fmt::format("distCoeffs {}", error.what()));
  }
}

Camera read_camera(const fs::path& file) {
  Camera camera;
  with_json(file, [&camera](const Json& json) {
    camera = camera_from_matrix(matrix_in(json));
    camera.cx_px -= speed::kHalfPixel;
    camera.cy_px -= speed::kHalfPixel;
    if (json.contains("distCoeffs")) camera.lens = lens_in(json);
  });
  return camera;
}

// In images/ beside the list; in SPEED in a folder of the list's name there. Where it is in
// neither, where it should be.
fs::path picture_file(const fs::path& list, const std::string& name) {
  const fs::path given = fs::path(name).lexically_normal();
  if (given.is_absolute() || given.empty() || *given.begin() == "..") {
    throw InputError(fmt::format("names {}, which must lie within the set", name));
  }
  const fs::path images = list.parent_path() / speed::kImagesFolder;
  const fs::path beside = images / unpacked_name(list).stem() / name;
  return fs::is_regular_file(images / name) || !fs::is_regular_file(beside) ? images / name
                                                                            : beside;
}

// None where the numbers are no pose.
std::optional<Pose> stated_pose(const Json& entry) {
  const std::vector<double> q = numbers_or_nan_in(entry, first_key_in(entry, speed::kAttitudes), 4);
  const std::vector<double> r = numbers_or_nan_in(entry, first_key_in(entry, speed::kPositions), 3);
  const auto rotation = usable_rotation(Eigen::Quaterniond(q[0], q[1], q[2], q[3]));
  const Eigen::Vector3d translation(r[0], r[1], r[2]);
  require_near(translation, first_key_in(entry, speed::kPositions));
  if (!rotation || !translation.allFinite()) return std::nullopt;
  return Pose{*rotation, translation};
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
  if (!lists_in(source.folder, speed::kLists).empty() || !named_lists(source).empty()) return true;
  return source.split.empty() && !all_lists(source.folder).empty();
}

SetReading read_speed_sightings(const SightingSource& source) {
  const fs::path list = list_of(source);
  if (source.obj_id) {
    throw InputError(fmt::format("{}: is of one object, as SPEED+ is; no --object can be chosen",
                                 list.string()));
  }
  if (!source.sensor.empty()) {
    throw InputError(fmt::format("{}: is of one camera, as SPEED+ is; no --sensor can be chosen",
                                 list.string()));
  }
  if (!is_pinhole(source.lens)) {
    throw InputError("camera.distortion: is for BOP sets; SPEED+ has the lens in camera.json");
  }
  SetReading reading;
  const Camera camera = read_camera(camera_file(list));
  with_json(list, [&](const Json& entries) {
    if (!entries.is_array()) throw InputError("must be a list of images");
    for (const Json& entry : entries) {
      Sighting& sighting = reading.sightings.emplace_back();
      sighting.picture = picture_file(list, text_in(entry, speed::kPicture));
      sighting.im_id = static_cast<int64_t>(reading.sightings.size()) - 1;
      sighting.camera = camera;
      const std::optional<Pose> pose = stated_pose(entry);
      if (!fs::is_regular_file(sighting.picture)) {
        sighting.problem = EstimateOutcome::kPictureUnreadable;
      }
      if (!pose) sighting.problem = EstimateOutcome::kNoTruth;
      sighting.cam_from_target = pose.value_or(Pose{});
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
