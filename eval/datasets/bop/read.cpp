// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/bop/read.h"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "eval/datasets/bop/layout.h"
#include "eval/datasets/bop/numbered.h"
#include "eval/datasets/conventions.h"
#include "eval/output/json.h"
#include "scenes/files/input_error.h"
#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// What a folder that has no scenes seems to be, where we know its format and do not read it.
std::string other_format(const fs::path& folder) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    const std::string form =
        name == "key_to_shard.json" || (name.starts_with("shard-") && name.ends_with(".tar"))
            ? "webdataset"
        : name.ends_with(".gt.json") ? "imagewise"
                                     : "";
    if (form.empty()) continue;
    return fmt::format(
        "; it is in BOP's {} format, of which the toolkit makes the scenewise one "
        "that is read here",
        form);
  }
  return "";
}

fs::path split_folder(const fs::path& folder, const std::string& split) {
  const fs::path named = folder / (split.empty() ? bop::kTestSplit : split);
  if (fs::is_directory(named)) return named;
  std::vector<fs::path> found;
  if (split.empty() && fs::is_directory(folder)) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      const bool is_test = entry.path().filename().string().starts_with(bop::kTestSplit);
      if (is_test && entry.is_directory()) found.push_back(entry.path());
    }
  }
  if (found.size() == 1) return found.front();
  const std::string form = other_format(folder);
  if (!form.empty()) throw InputError(fmt::format("{}: has no scenes{}", folder.string(), form));
  throw InputError(fmt::format("{}: is no folder{}", named.string(),
                               split.empty() ? "; say --split which one is meant" : ""));
}

using ImageId = std::pair<int, int>;  // scene, image
// How many instances of an object an image asks for; no objects: all that are visible.
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
      auto& objects = targets[{whole_in(target, "scene_id"), whole_in(target, "im_id")}];
      if (!target.contains("obj_id")) continue;
      const int count = target.contains("inst_count") ? whole_in(target, "inst_count") : 1;
      if (count < 1) throw InputError("inst_count must be 1 or more");
      objects[whole_in(target, "obj_id")] = count;
    }
  });
  return targets;
}

// The list of targets of a split, which is the test's alone; a note where there are two.
TargetList find_targets(const fs::path& folder, const fs::path& split,
                        std::vector<std::string>& notes) {
  if (!split.lexically_relative(folder).string().starts_with(bop::kTestSplit)) return {};
  const bool has_newer = fs::exists(folder / bop::kDetectionTargetsFile);
  if (fs::exists(folder / bop::kTargetsFile)) {
    if (has_newer) {
      notes.push_back(fmt::format("{}: is not used, since there is {}",
                                  (folder / bop::kDetectionTargetsFile).string(),
                                  bop::kTargetsFile));
    }
    return {folder / bop::kTargetsFile, read_targets(folder / bop::kTargetsFile)};
  }
  if (!has_newer) return {};
  return {folder / bop::kDetectionTargetsFile, read_targets(folder / bop::kDetectionTargetsFile)};
}

std::set<int> scenes_in(const fs::path& split) {
  std::set<int> scenes;
  for (const auto& entry : fs::directory_iterator(split)) {
    if (fs::exists(entry.path() / bop::kSceneTruthFile)) {
      scenes.insert(whole_number(entry.path().filename().string()));
    }
  }
  return scenes;
}

// A note where camera.json states a lens, which BOP's format has no place for.
void note_lens(const fs::path& folder, std::vector<std::string>& notes) {
  constexpr std::array kLens = {"distortion", "dist", "dist_coeffs", "distCoeffs", "k1"};
  const fs::path file = folder / bop::kCameraFile;
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

// The width of an image by the header of its picture; 0 where there is none that tells.
int width_of(const BopImage& image) {
  for (const std::string_view kind : {bop::kColourFolder, bop::kGreyFolder, bop::kDepthFolder}) {
    const auto size = picture_size(numbered_picture(image.folder / kind, {image.im_id}));
    if (size) return size->width;
  }
  return 0;
}

// Gives every image its width, which MSPD's thresholds are of: its own picture's, else that of the
// pictures beside it, else what camera.json says. Of a set that is no longer that of its
// camera.json (it was cropped, or scaled) the pictures count.
void set_widths(const fs::path& folder, BopDataset& dataset) {
  const fs::path camera_file = folder / bop::kCameraFile;
  int stated = 0;
  if (fs::exists(camera_file)) {
    with_json(camera_file, [&](const Json& camera) {
      if (camera.contains("width")) stated = whole_in(camera, "width");
    });
  }
  int last = 0;
  for (BopImage& image : dataset.images) {
    image.width_px = width_of(image);
    if (image.width_px > 0) last = image.width_px;
  }
  for (BopImage& image : dataset.images) {
    if (image.width_px == 0) image.width_px = last > 0 ? last : stated;
    if (image.width_px > 0) continue;
    throw InputError(fmt::format("{}: has no image {}, nor the set a {}, to tell the width",
                                 image.folder.string(), image.im_id, bop::kCameraFile));
  }
  if (stated > 0 && last > 0 && stated != last) {
    dataset.notes.push_back(
        fmt::format("{}: says that images are {} px wide, they are {}: that counts",
                    camera_file.string(), stated, last));
  }
}

// One scene's folder and what is to be read of it.
class SceneReader {
 public:
  SceneReader(fs::path folder, int scene_id) : folder_(std::move(folder)), scene_id_(scene_id) {}

  std::map<int, BopImage> read() {
    with_json(folder_ / bop::kSceneTruthFile, [this](const Json& json) { add_truth(json); });
    with_json(folder_ / bop::kSceneCameraFile, [this](const Json& json) { add_cameras(json); });
    if (fs::exists(folder_ / bop::kSceneInfoFile)) {
      with_json(folder_ / bop::kSceneInfoFile, [this](const Json& json) { add_info(json); });
    }
    return std::move(images_);
  }

 private:
  void add_truth(const Json& json) {
    const NumberedEntries truths(json);
    for (const auto& [im_id, entries] : truths.all()) {
      BopImage& image = images_[im_id];
      image.folder = folder_;
      image.scene_id = scene_id_;
      image.im_id = im_id;
      for (const Json& entry : *entries) image.instances.push_back(instance_of(entry));
    }
  }

  void add_cameras(const Json& json) {
    const NumberedEntries cameras(json);
    for (auto& [im_id, image] : images_) {
      const Json* const camera = cameras.find(im_id);
      if (camera == nullptr) {
        throw InputError(fmt::format("has no image {}, which {} has", im_id, bop::kSceneTruthFile));
      }
      read_camera(*camera, image);
      if (image.k.cwiseAbs().maxCoeff() > kGreatestPx) {
        throw InputError(
            fmt::format("image {}: its camera has a number beyond {:g} px", im_id, kGreatestPx));
      }
      if (camera->contains("depth_scale")) image.depth_scale = number_in(*camera, "depth_scale");
      image.depth_file = numbered_picture(folder_ / bop::kDepthFolder, {im_id});
    }
  }

  // What it does not tell of counts as wholly visible.
  void add_info(const Json& json) {
    const NumberedEntries all_infos(json);
    for (auto& [im_id, image] : images_) {
      const Json* const infos = all_infos.find(im_id);
      if (infos == nullptr) continue;
      if (!infos->is_array() || infos->size() < image.instances.size()) {
        throw InputError(fmt::format("tells of {} instances in image {}, of which {} has {}",
                                     infos->size(), im_id, bop::kSceneTruthFile,
                                     image.instances.size()));
      }
      for (size_t i = 0; i < image.instances.size(); ++i) {
        image.instances[i].visible_fraction = number_in(infos->at(i), "visib_fract");
      }
    }
  }

  // The camera's matrix or, as sets of 2024 have it, its model where that is a pinhole or a fisheye
  // of Kannala and Brandt: focal lengths, principal point and the lens's coefficients.
  static void read_camera(const Json& camera, BopImage& image) {
    if (!camera.is_object() || !camera.contains("cam_model")) {
      image.k = matrix_from_rows(numbers_in(camera, "cam_K", 9));
      return;
    }
    const Json& model = camera["cam_model"];
    const std::string type = text_in(model, "projection_model_type");
    const bool is_fisheye = type.ends_with("KANNALA_BRANDT_K3");
    if (!is_fisheye && !type.ends_with("PINHOLE") && !type.ends_with("LINEAR")) {
      throw InputError(
          fmt::format("image {}: its cam_model is {}, must be a pinhole or KANNALA_BRANDT_K3: "
                      "remove the lens from the pictures first",
                      image.im_id, type));
    }
    const size_t more = is_fisheye ? 4 : 0;
    const Json& params = value_in(model, "projection_params");
    const bool has_one_focus = params.is_array() && params.size() == 3 + more;
    auto p = finite_numbers(params, "projection_params", (has_one_focus ? 3 : 4) + more);
    if (has_one_focus) p.insert(p.begin(), p.front());
    image.k(0, 0) = p[0];
    image.k(1, 1) = p[1];
    image.k(0, 2) = p[2];
    image.k(1, 2) = p[3];
    if (is_fisheye) image.lens = KannalaBrandt{.k1 = p[4], .k2 = p[5], .k3 = p[6], .k4 = p[7]};
  }

  static BopInstance instance_of(const Json& entry) {
    BopInstance instance{.obj_id = whole_in(entry, "obj_id"), .cam_from_model = {}};
    const auto rotation =
        usable_rotation(matrix_from_rows(numbers_or_nan_in(entry, "cam_R_m2c", 9)));
    const auto t = numbers_or_nan_in(entry, "cam_t_m2c", 3);
    const Eigen::Vector3d translation(t[0], t[1], t[2]);
    require_near(kMetresPerMillimetre * translation, "cam_t_m2c");
    instance.has_pose = rotation && translation.allFinite();
    if (instance.has_pose) instance.cam_from_model = {*rotation, translation};
    return instance;
  }

  fs::path folder_;
  int scene_id_;
  std::map<int, BopImage> images_;
};

std::map<int, int> visible_objects(const BopImage& image) {
  std::map<int, int> counts;
  for (const BopInstance& instance : image.instances) {
    if (instance.visible_fraction >= bop::kLeastVisibleFraction) ++counts[instance.obj_id];
  }
  return counts;
}

void require_instances(const BopImage& image, const fs::path& list) {
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

// What scores poses projects by the camera's matrix alone.
void require_pinholes(const std::vector<BopImage>& images) {
  for (const BopImage& image : images) {
    if (is_pinhole(image.lens)) continue;
    throw InputError(fmt::format(
        "{}: image {}: its cam_model has a lens, must be a pinhole: remove the lens from the "
        "pictures first",
        (image.folder / bop::kSceneCameraFile).string(), image.im_id));
  }
}

}  // namespace

fs::path bop_picture(const BopImage& image) {
  const fs::path colour = numbered_picture(image.folder / bop::kColourFolder, {image.im_id});
  if (!colour.empty()) return colour;
  return numbered_picture(image.folder / bop::kGreyFolder, {image.im_id});
}

fs::path missing_bop_picture(const BopImage& image) {
  const bool is_grey = !fs::is_directory(image.folder / bop::kColourFolder) &&
                       fs::is_directory(image.folder / bop::kGreyFolder);
  return image.folder / (is_grey ? bop::kGreyFolder : bop::kColourFolder) /
         (bop::image_name(image.im_id) + ".png");
}

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

BopImages read_bop_images(const fs::path& folder, const std::string& split) {
  if (!fs::is_directory(folder)) throw InputError(fmt::format("{}: is no folder", folder.string()));
  const fs::path scenes_folder = split_folder(folder, split);
  BopImages read;
  const TargetList list = find_targets(folder, scenes_folder, read.notes);
  note_lens(folder, read.notes);
  std::set<int> scenes;
  if (!list.is_there()) scenes = scenes_in(scenes_folder);
  for (const auto& [image, objects] : list.targets) scenes.insert(image.first);
  std::vector<BopImage> asked;
  for (const int scene_id : scenes) {
    const fs::path scene = numbered_scene(scenes_folder, scene_id);
    for (auto& [im_id, image] : SceneReader(scene, scene_id).read()) {
      const auto wanted = list.targets.find({scene_id, im_id});
      if (list.is_there() && wanted == list.targets.end()) continue;
      const bool names_objects = list.is_there() && !wanted->second.empty();
      image.targets = names_objects ? wanted->second : visible_objects(image);
      require_instances(image, list.file);
      asked.push_back(std::move(image));
    }
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

BopDataset read_bop_dataset(const fs::path& folder, const std::string& split) {
  BopImages read = read_bop_images(folder, split);
  require_pinholes(read.images);
  std::set<int> objects;
  for (const BopImage& image : read.images) {
    for (const auto& [obj_id, count] : image.targets) objects.insert(obj_id);
  }
  BopDataset dataset{.models = read_bop_models(folder, objects),
                     .images = std::move(read.images),
                     .notes = std::move(read.notes)};
  set_widths(folder, dataset);
  return dataset;
}

}  // namespace sightline
