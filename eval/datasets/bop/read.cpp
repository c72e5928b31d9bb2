// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/bop/read.h"

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/datasets/bop/layout.h"
#include "eval/datasets/bop/scenes.h"
#include "eval/datasets/conventions.h"
#include "eval/datasets/pictures.h"
#include "eval/output/json.h"
#include "eval/output/numbers.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"
#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// Throws where a folder is of BOP's webdataset format, which is an imagewise set in archives.
void refuse_shards(const fs::path& folder) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    const bool is_shard = name.starts_with("shard-") && name.ends_with(".tar");
    if (!is_shard && name != "key_to_shard.json") continue;
    throw InputError(fmt::format(
        "{}: is in BOP's webdataset format: unpack all its shards into one folder (tar -xf "
        "shard-000000.tar and so on), whose files are then read",
        folder.string()));
  }
}

// Which folders a --split could name.
std::string advice_on_split(const fs::path& folder) {
  std::set<std::string> splits;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (!entry.is_directory(error)) continue;
    if (has_scenes(entry.path()) || is_imagewise(entry.path())) {
      splits.insert(entry.path().filename().string());
    }
  }
  if (!splits.empty()) return fmt::format("; say --split {}", fmt::join(splits, " or "));
  return has_scenes(folder) ? "; it is a split itself: name the folder of the set, above it" : "";
}

fs::path split_folder(const fs::path& folder, const std::string& split) {
  const fs::path named = folder / (split.empty() ? bop::kTestSplit : split);
  if (fs::is_directory(named)) return named;
  if (split.empty() && is_imagewise(folder)) return folder;
  std::vector<fs::path> found;
  if (split.empty() && fs::is_directory(folder)) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      const bool is_test = entry.path().filename().string().starts_with(bop::kTestSplit);
      if (is_test && entry.is_directory()) found.push_back(entry.path());
    }
  }
  if (found.size() == 1) return found.front();
  refuse_shards(folder);
  throw InputError(fmt::format("{}: is no folder{}", named.string(), advice_on_split(folder)));
}

using ImageId = std::pair<int, int64_t>;  // scene, image
// How many instances of an object an image asks for, 0 as well; no objects: all that are visible.
using Targets = std::map<ImageId, std::map<int, int>>;

// A list of targets, or none.
struct TargetList {
  fs::path file;
  Targets targets;
  bool is_there() const { return !file.empty(); }
};

Targets read_targets(const fs::path& file) {
  Targets targets;
  with_json(file, [&](const Json& list) {
    if (!list.is_array()) throw InputError("must be a list of targets");
    for (const Json& target : list) {
      auto& objects = targets[{whole_in(target, "scene_id"), wide_whole_in(target, "im_id")}];
      if (!target.contains("obj_id")) continue;
      const int count = target.contains("inst_count") ? whole_in(target, "inst_count") : 1;
      if (count < 0) throw InputError("inst_count must be 0 or more");
      objects[whole_in(target, "obj_id")] = count;
    }
  });
  return targets;
}

// The list of targets of a split, which is the test's alone; a note where there are two.
TargetList find_targets(const fs::path& folder, const fs::path& split,
                        std::vector<std::string>& notes) {
  const bool is_of_test =
      split == folder || split.lexically_relative(folder).string().starts_with(bop::kTestSplit);
  if (!is_of_test) return {};
  const fs::path list = plain_or_packed(folder / bop::kTargetsFile);
  const fs::path newer = plain_or_packed(folder / bop::kDetectionTargetsFile);
  if (fs::exists(list)) {
    if (fs::exists(newer)) {
      notes.push_back(fmt::format("{}: is not used, since there is {}", newer.string(),
                                  list.filename().string()));
    }
    return {list, read_targets(list)};
  }
  if (!fs::exists(newer)) return {};
  return {newer, read_targets(newer)};
}

// A note where camera.json states a lens, which BOP's format has no place for.
void note_lens(const fs::path& folder, std::vector<std::string>& notes) {
  constexpr std::array kLens = {"distortion", "dist", "dist_coeffs", "distCoeffs", "k1"};
  const fs::path file = plain_or_packed(folder / bop::kCameraFile);
  if (!fs::exists(file)) return;
  with_json(file, [&](const Json& camera) {
    const std::string key = first_key_in(camera, kLens);
    if (!camera.is_object() || !camera.contains(key)) return;
    notes.push_back(
        fmt::format("{}: its {} is not used; an evaluation takes a lens by --set "
                    "camera.distortion",
                    file.string(), key));
  });
}

// What camera.json says of the whole set, where there is one.
struct SetCamera {
  fs::path file;
  int width_px = 0;
  std::optional<double> depth_scale;
};

SetCamera read_set_camera(const fs::path& folder) {
  SetCamera camera{.file = plain_or_packed(folder / bop::kCameraFile), .depth_scale = {}};
  if (!fs::exists(camera.file)) return camera;
  with_json(camera.file, [&camera](const Json& json) {
    if (json.contains("width")) camera.width_px = whole_in(json, "width");
    if (json.contains("depth_scale")) camera.depth_scale = number_in(json, "depth_scale");
  });
  return camera;
}

// The size of an image by the header of its picture; none where there is none that tells.
std::optional<cv::Size> size_of(const BopImage& image) {
  const auto size = picture_size(bop_picture(image));
  return size ? size : picture_size(image.depth_file);
}

// Gives every image its width, which MSPD's thresholds are of: its own picture's, else that of the
// pictures beside it, else what camera.json says. Of a set that is no longer that of its
// camera.json (it was cropped, or scaled) the pictures count.
void set_sizes(const SetCamera& camera, BopDataset& dataset) {
  int last = 0;
  for (BopImage& image : dataset.images) {
    const cv::Size size = size_of(image).value_or(cv::Size());
    image.width_px = size.width;
    image.height_px = size.height;
    if (image.width_px > 0) last = image.width_px;
  }
  for (BopImage& image : dataset.images) {
    if (image.width_px == 0) image.width_px = last > 0 ? last : camera.width_px;
    if (image.width_px > 0) continue;
    throw InputError(fmt::format("{}: has no image {}, nor the set a {}, to tell the width",
                                 image.folder.string(), image.im_id, bop::kCameraFile));
  }
  if (camera.width_px > 0 && last > 0 && camera.width_px != last) {
    dataset.notes.push_back(
        fmt::format("{}: says that images are {} px wide, they are {}: that counts",
                    camera.file.string(), camera.width_px, last));
  }
}

// Gives every image that has depth and does not state its scale that of camera.json.
void set_depth_scales(const SetCamera& camera, BopDataset& dataset) {
  int64_t without = 0;
  for (BopImage& image : dataset.images) {
    if (image.states_depth_scale || image.depth_file.empty()) continue;
    ++without;
    image.depth_scale = camera.depth_scale.value_or(image.depth_scale);
  }
  if (without == 0) return;
  dataset.notes.push_back(
      fmt::format("{} with depth but no depth_scale: {} mm counts, {}", counted(without, "image"),
                  camera.depth_scale.value_or(BopImage{}.depth_scale),
                  camera.depth_scale ? "by " + camera.file.string() : "as nothing else is stated"));
}

std::map<int, int> visible_objects(const BopImage& image) {
  std::map<int, int> counts;
  for (const BopInstance& instance : image.instances) {
    if (instance.visible_fraction >= bop::kLeastVisibleFraction) ++counts[instance.obj_id];
  }
  return counts;
}

void require_instances(const BopImage& image, const fs::path& list) {
  for (const BopInstance& instance : image.instances) {
    if (instance.problem.empty() || !image.targets.contains(instance.obj_id)) continue;
    throw InputError(fmt::format("{}: {}", bop_truth_file(image).string(), instance.problem));
  }
  for (const auto& [obj_id, count] : image.targets) {
    const auto there = std::count_if(image.instances.begin(), image.instances.end(),
                                     [id = obj_id](const auto& i) { return i.obj_id == id; });
    if (there >= count) continue;
    throw InputError(fmt::format("{}: asks for {} of object {} in scene {} image {}, which has {}",
                                 list.string(), count, obj_id, image.scene_id, image.im_id, there));
  }
}

void require_all_asked(const TargetList& list, const std::vector<BopImage>& images) {
  std::set<ImageId> there;
  for (const BopImage& image : images) there.insert({image.scene_id, image.im_id});
  for (const auto& [image, objects] : list.targets) {
    if (there.contains(image)) continue;
    throw InputError(fmt::format("{}: asks for scene {} image {}, which {} has not",
                                 list.file.string(), image.first, image.second,
                                 bop::kSceneTruthFile));
  }
}

// The images of a split, those on the list where there is one, without targets.
std::vector<BopImage> images_of(const fs::path& split, const std::string& sensor,
                                const TargetList& list, std::vector<std::string>& notes) {
  const auto is_asked = [&list](int scene_id, int64_t im_id) {
    return !list.is_there() || list.targets.contains({scene_id, im_id});
  };
  if (is_imagewise(split)) {
    if (sensor.empty()) return read_imagewise(split, is_asked);
    throw InputError(
        fmt::format("{}: has its files image by image and no sensors; no --sensor "
                    "can be chosen",
                    split.string()));
  }
  refuse_shards(split);
  std::set<int> of_list;
  for (const auto& [image, objects] : list.targets) of_list.insert(image.first);
  const std::vector<int> scenes =
      list.is_there() ? std::vector<int>(of_list.begin(), of_list.end()) : scenes_in(split, notes);
  return read_scenewise(split, scenes, sensor, is_asked, notes);
}

// What scores poses projects by the camera's matrix alone, and measures by the depth.
void require_cameras(const std::vector<BopImage>& images) {
  for (const BopImage& image : images) {
    if (!image.depth_file.empty() && !(image.depth_scale > 0)) {
      throw InputError(fmt::format("{}: image {}: depth_scale is {}, must be above 0",
                                   bop_camera_file(image).string(), image.im_id,
                                   image.depth_scale));
    }
    if (is_pinhole(bop_camera(image).lens)) continue;
    throw InputError(fmt::format(
        "{}: image {}: its cam_model has a lens, must be a pinhole: remove the lens from the "
        "pictures first",
        bop_camera_file(image).string(), image.im_id));
  }
}

// A note where models_info.json states a diameter that the model cannot have: by a tenth and more
// below its box's longest side, or above the box's diagonal.
void note_diameter(int obj_id, const BopModel& model, std::vector<std::string>& notes) {
  if (model.points_mm.cols() == 0) return;
  const Eigen::Vector3d sides =
      model.points_mm.rowwise().maxCoeff() - model.points_mm.rowwise().minCoeff();
  constexpr double kTolerance = 0.1;
  if (model.diameter_mm >= (1 - kTolerance) * sides.maxCoeff() &&
      model.diameter_mm <= (1 + kTolerance) * sides.norm()) {
    return;
  }
  notes.push_back(fmt::format(
      "{}: says that object {} has a diameter of {:g} mm, its model is "
      "{:g} x {:g} x {:g}: what is stated counts",
      bop::kModelsInfoFile, obj_id, model.diameter_mm, sides.x(), sides.y(), sides.z()));
}

// Whether some of a model is in front of the camera, which stands outside of its box, by a
// hundredth of its size at least. Of one without points its origin counts.
bool is_in_front(const BopModel& model, const Pose& cam_from_model) {
  if (model.points_mm.cols() == 0) return cam_from_model.translation.z() > 0;
  const Eigen::AlignedBox3d box(model.points_mm.rowwise().minCoeff(),
                                model.points_mm.rowwise().maxCoeff());
  const Eigen::Vector3d camera = inverse(cam_from_model).translation;
  const double farthest_mm = (cam_from_model.rotation.row(2) * model.points_mm).maxCoeff() +
                             cam_from_model.translation.z();
  return box.exteriorDistance(camera) > 0.01 * box.diagonal().norm() && farthest_mm > 0;
}

// Against a truth in metres every estimate would be wrong. That a camera stands within an object,
// or sees what is behind it, is no truth either.
void require_any_in_front(const fs::path& folder, const BopDataset& dataset) {
  int poses = 0;
  for (const BopImage& image : dataset.images) {
    for (const BopInstance& instance : image.instances) {
      if (!instance.has_pose || !image.targets.contains(instance.obj_id)) continue;
      if (is_in_front(dataset.models.at(instance.obj_id), instance.cam_from_model)) return;
      ++poses;
    }
  }
  if (poses == 0) return;
  throw InputError(fmt::format(
      "{}: none of its {} true poses has the object in front of the camera, and the camera outside "
      "of it (translations must be in mm)",
      folder.string(), poses));
}

}  // namespace

std::vector<int> asked_instances(const BopImage& image, int obj_id) {
  const auto asked = image.targets.find(obj_id);
  if (asked == image.targets.end()) return {};
  std::vector<int> instances;
  for (size_t i = 0; i < image.instances.size(); ++i) {
    if (image.instances[i].obj_id == obj_id) instances.push_back(static_cast<int>(i));
  }
  std::stable_sort(instances.begin(), instances.end(), [&image](int a, int b) {
    return image.instances[a].visible_fraction > image.instances[b].visible_fraction;
  });
  instances.resize(std::min(instances.size(), static_cast<size_t>(asked->second)));
  return instances;
}

BopImages read_bop_images(const fs::path& folder, const std::string& split,
                          const std::string& sensor) {
  if (!fs::is_directory(folder)) throw InputError(fmt::format("{}: is no folder", folder.string()));
  const fs::path scenes_folder = split_folder(folder, split);
  BopImages read;
  const TargetList list = find_targets(folder, scenes_folder, read.notes);
  note_lens(folder, read.notes);
  std::vector<BopImage> asked = images_of(scenes_folder, sensor, list, read.notes);
  for (BopImage& image : asked) {
    const auto wanted = list.targets.find({image.scene_id, image.im_id});
    const bool names_objects = list.is_there() && !wanted->second.empty();
    image.targets = names_objects ? wanted->second : visible_objects(image);
    std::erase_if(image.targets, [](const auto& target) { return target.second == 0; });
    require_instances(image, list.file);
  }
  require_all_asked(list, asked);
  for (BopImage& image : asked) {
    if (!image.targets.empty()) read.images.push_back(std::move(image));
  }
  if (read.images.empty()) {
    throw InputError(fmt::format("{}: has no image with a target", scenes_folder.string()));
  }
  return read;
}

BopDataset read_bop_dataset(const fs::path& folder, const std::string& split,
                            const std::string& sensor) {
  BopImages read = read_bop_images(folder, split, sensor);
  BopDataset dataset{
      .models = {}, .images = std::move(read.images), .notes = std::move(read.notes)};
  const SetCamera camera = read_set_camera(folder);
  set_depth_scales(camera, dataset);
  require_cameras(dataset.images);
  std::set<int> objects;
  for (const BopImage& image : dataset.images) {
    for (const auto& [obj_id, count] : image.targets) objects.insert(obj_id);
  }
  dataset.models = read_bop_models(folder, objects);
  if (bop_models_info(folder).empty()) {
    dataset.notes.push_back(
        fmt::format("{}: has no {}: diameters are measured, and no object has symmetries",
                    folder.string(), bop::kModelsInfoFile));
  }
  require_any_in_front(folder, dataset);
  for (const auto& [obj_id, model] : dataset.models) note_diameter(obj_id, model, dataset.notes);
  set_sizes(camera, dataset);
  std::vector<fs::path> pictures;
  for (const BopImage& image : dataset.images) pictures.push_back(bop_picture(image));
  std::erase(pictures, fs::path());
  const std::string note = note_on_links(folder, pictures);
  if (!note.empty()) dataset.notes.push_back(note);
  return dataset;
}

}  // namespace sightline
