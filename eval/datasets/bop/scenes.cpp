// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/bop/scenes.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/datasets/bop/layout.h"
#include "eval/datasets/bop/numbered.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// ---- imagewise

// The key of an image whose truth is in a file of that name; empty of another file.
std::string key_of(const fs::path& file) {
  const std::string name = unpacked_name(file.filename()).string();
  const bool is_hidden = name.starts_with('.');  // as other systems leave copies beside files
  if (is_hidden || !name.ends_with(bop::kImageTruthFile)) return "";
  return name.substr(0, name.size() - bop::kImageTruthFile.size());
}

BopImage image_of_key(const fs::path& folder, const std::string& key) {
  BopImage image;
  image.folder = folder;
  image.key = key;
  const size_t line = key.find('_');
  const bool has_scene = line != std::string::npos;
  const auto scene_id = has_scene ? scene_number_of(key.substr(0, line)) : std::optional(0);
  const auto im_id = number_of(has_scene ? key.substr(line + 1) : key);
  if (!scene_id || !im_id) {
    throw InputError(
        fmt::format("{}: its name must begin with the numbers of scene and image, as 000001_000017",
                    (folder / key).string() + std::string(bop::kImageTruthFile)));
  }
  image.scene_id = *scene_id;
  image.im_id = *im_id;
  return image;
}

void read_files_of(BopImage& image) {
  const fs::path beginning = image.folder / image.key;
  const auto file = [&](std::string_view ending) {
    return plain_or_packed(beginning.string() + std::string(ending));
  };
  with_json(file(bop::kImageTruthFile), [&](const Json& json) { add_bop_truth(json, image); });
  with_json(bop_camera_file(image), [&](const Json& json) { add_bop_camera(json, image); });
  if (const fs::path infos = file(".gt_info.json"); fs::exists(infos)) {
    with_json(infos, [&](const Json& json) {
      add_bop_visibility(json, image.key + std::string(bop::kImageTruthFile), image);
    });
  }
  image.depth_file = bop_picture_of_kind(image, bop::kDepthFolder);
}

// ---- scenewise

// The sensors of a scene by the names of its files of truth; one without a name of scene_gt.json.
std::set<std::string> sensors_of(const fs::path& scene) {
  constexpr std::string_view kBefore = "scene_gt_";
  constexpr std::string_view kBehind = ".json";
  std::set<std::string> sensors;
  const bool has_unnamed = fs::exists(plain_or_packed(scene / bop::kSceneTruthFile));
  if (has_unnamed) sensors.insert("");
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(scene, error)) {
    const std::string name = unpacked_name(entry.path().filename()).string();
    if (!name.starts_with(kBefore) || !name.ends_with(kBehind)) continue;
    if (name.size() <= kBefore.size() + kBehind.size()) continue;
    const std::string sensor =
        name.substr(kBefore.size(), name.size() - kBefore.size() - kBehind.size());
    if (sensor.starts_with("info") || sensor.starts_with("coco")) continue;
    // Beside a truth without a name another may be but a copy of it.
    const bool has_camera =
        fs::exists(plain_or_packed(scene / bop::of_sensor(bop::kSceneCameraFile, sensor)));
    if (has_camera || !has_unnamed) sensors.insert(sensor);
  }
  return sensors;
}

// The one without a name, or that BOP evaluates in HOT3D (Aria, Quest 3), IPD, XYZ-IBD and
// ITODD-MV, else the first.
std::string usual_of(const std::set<std::string>& sensors) {
  if (sensors.contains("")) return "";
  for (const char* evaluated : {"rgb", "gray1", "photoneo", "xyz", "3dlong"}) {
    if (sensors.contains(evaluated)) return evaluated;
  }
  return sensors.empty() ? "" : *sensors.begin();
}

// One scene's folder and what is to be read of it; of images that nobody asks for, nothing.
class SceneReader {
 public:
  SceneReader(fs::path folder, std::string sensor, int scene_id, const AskedImages& is_asked)
      : folder_(std::move(folder)),
        sensor_(std::move(sensor)),
        scene_id_(scene_id),
        is_asked_(is_asked) {}

  std::map<int64_t, BopImage> read() {
    with_json(file(bop::kSceneTruthFile), [this](const Json& json) { add_truth(json); });
    with_json(file(bop::kSceneCameraFile), [this](const Json& json) { add_cameras(json); });
    if (fs::exists(file(bop::kSceneInfoFile))) {
      with_json(file(bop::kSceneInfoFile), [this](const Json& json) { add_info(json); });
    }
    return std::move(images_);
  }

 private:
  fs::path file(std::string_view name) const {
    return plain_or_packed(folder_ / bop::of_sensor(name, sensor_));
  }

  void add_truth(const Json& json) {
    const NumberedEntries truths(json);
    for (const auto& [im_id, entries] : truths.all()) {
      if (!is_asked_(scene_id_, im_id)) continue;
      BopImage& image = images_[im_id];
      image.folder = folder_;
      image.sensor = sensor_;
      image.scene_id = scene_id_;
      image.im_id = im_id;
      add_bop_truth(*entries, image);
    }
  }

  void add_cameras(const Json& json) {
    const NumberedEntries cameras(json);
    for (auto& [im_id, image] : images_) {
      const Json* const camera = cameras.find(im_id);
      if (camera == nullptr && image.instances.empty()) continue;  // nothing can be asked of it
      if (camera == nullptr) {
        throw InputError(fmt::format("has no image {}, which {} has", im_id, truth_name()));
      }
      add_bop_camera(*camera, image);
      image.depth_file = bop_picture_of_kind(image, bop::kDepthFolder);
    }
  }

  // What it does not tell of counts as wholly visible.
  void add_info(const Json& json) {
    const NumberedEntries all_infos(json);
    for (auto& [im_id, image] : images_) {
      const Json* const infos = all_infos.find(im_id);
      if (infos != nullptr) add_bop_visibility(*infos, truth_name(), image);
    }
  }

  std::string truth_name() const { return bop::of_sensor(bop::kSceneTruthFile, sensor_); }

  fs::path folder_;
  std::string sensor_;
  int scene_id_;
  const AskedImages& is_asked_;
  std::map<int64_t, BopImage> images_;
};

// A line on what of the scene is not read.
std::string note_on_others(const fs::path& scene, const std::set<std::string>& sensors,
                           const std::string& read) {
  std::set<std::string> others = sensors;
  others.erase(read);
  return fmt::format("{}: has several sensors; that of {} is read, not {}: --sensor chooses",
                     scene.string(), bop::of_sensor(bop::kSceneTruthFile, read),
                     fmt::join(others, ", "));
}

[[noreturn]] void fail_as_no_sensor(const fs::path& scene, const std::string& sensor,
                                    std::set<std::string> sensors) {
  sensors.erase("");
  throw InputError(
      fmt::format("{}: has no sensor '{}': there is no {}{}", scene.string(), sensor,
                  bop::of_sensor(bop::kSceneTruthFile, sensor),
                  sensors.empty() ? ", and none of another sensor: leave --sensor out"
                                  : fmt::format("; its sensors are {}", fmt::join(sensors, ", "))));
}

}  // namespace

bool is_imagewise(const fs::path& folder) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (!key_of(entry.path()).empty()) return true;
  }
  return false;
}

std::vector<BopImage> read_imagewise(const fs::path& folder, const AskedImages& is_asked) {
  std::map<std::pair<int, int64_t>, BopImage> images;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string key = key_of(entry.path());
    if (key.empty()) continue;
    BopImage image = image_of_key(folder, key);
    if (!is_asked(image.scene_id, image.im_id)) continue;
    const std::pair id{image.scene_id, image.im_id};
    const auto [place, is_new] = images.emplace(id, std::move(image));
    if (is_new || place->second.key == key) continue;  // packed and unpacked side by side
    throw InputError(fmt::format("{}: has scene {} image {} twice, as {} and {}", folder.string(),
                                 id.first, id.second, place->second.key, key));
  }
  std::vector<BopImage> read;
  for (auto& [id, image] : images) {
    read_files_of(image);
    read.push_back(std::move(image));
  }
  return read;
}

bool has_scenes(const fs::path& folder) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (!sensors_of(entry.path()).empty()) return true;
  }
  return false;
}

std::vector<int> scenes_in(const fs::path& split, std::vector<std::string>& notes) {
  std::set<int> scenes;
  std::set<std::string> others;
  for (const auto& entry : fs::directory_iterator(split)) {
    if (sensors_of(entry.path()).empty()) continue;
    const std::string name = entry.path().filename().string();
    if (const auto scene_id = scene_number_of(name)) {
      scenes.insert(*scene_id);
    } else {
      others.insert(name);
    }
  }
  if (others.empty()) return {scenes.begin(), scenes.end()};
  const std::string not_read = fmt::format("{}: not read as scenes, whose names are numbers: {}",
                                           split.string(), fmt::join(others, ", "));
  if (scenes.empty()) throw InputError(not_read);
  notes.push_back(not_read);
  return {scenes.begin(), scenes.end()};
}

std::vector<BopImage> read_scenewise(const fs::path& split, const std::vector<int>& scenes,
                                     const std::string& sensor, const AskedImages& is_asked,
                                     std::vector<std::string>& notes) {
  std::vector<BopImage> read;
  bool has_note = false;
  for (const int scene_id : scenes) {
    const fs::path folder = numbered_scene(split, scene_id);
    const std::set<std::string> sensors = sensors_of(folder);
    if (!sensor.empty() && !sensors.contains(sensor)) fail_as_no_sensor(folder, sensor, sensors);
    const std::string read_one = sensor.empty() ? usual_of(sensors) : sensor;
    if (sensor.empty() && sensors.size() > 1 && !std::exchange(has_note, true)) {
      notes.push_back(note_on_others(folder, sensors, read_one));
    }
    for (auto& [im_id, image] : SceneReader(folder, read_one, scene_id, is_asked).read()) {
      read.push_back(std::move(image));
    }
  }
  return read;
}

}  // namespace sightline
