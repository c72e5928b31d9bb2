// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/bop/read.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <set>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "eval/datasets/bop/layout.h"
#include "eval/datasets/conventions.h"
#include "eval/datasets/model_file.h"
#include "eval/datasets/pictures.h"
#include "eval/output/json.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr double kSymmetryStep = 0.01;  // of the diameter

using RowWise4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

int whole_number(const std::string& text) {
  int value = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size() && value >= 0) return value;
  throw InputError(fmt::format("'{}' is no id", text));
}

std::vector<Pose> discrete_symmetries(const Json& info) {
  std::vector<Pose> poses{Pose{}};
  if (!info.contains("symmetries_discrete")) return poses;
  for (const Json& symmetry : info["symmetries_discrete"]) {
    const auto values = symmetry.get<std::vector<double>>();
    if (values.size() != 16) throw InputError("symmetries_discrete must have 16 numbers each");
    const RowWise4 matrix = Eigen::Map<const RowWise4>(values.data());
    poses.push_back({matrix.topLeftCorner<3, 3>(), matrix.topRightCorner<3, 1>()});
  }
  return poses;
}

std::vector<Pose> continuous_symmetries(const Json& info) {
  std::vector<Pose> poses;
  if (!info.contains("symmetries_continuous")) return poses;
  const int steps = static_cast<int>(std::ceil(std::numbers::pi / kSymmetryStep));
  for (const Json& symmetry : info["symmetries_continuous"]) {
    const Eigen::Vector3d axis(numbers_in(symmetry, "axis", 3).data());
    const Eigen::Vector3d offset(numbers_in(symmetry, "offset", 3).data());
    if (axis.isZero()) throw InputError("symmetries_continuous has an axis of no length");
    for (int i = 0; i < steps; ++i) {
      const double angle_rad = 2 * std::numbers::pi * i / steps;
      const Eigen::Matrix3d rotation = rotation_from_vector(angle_rad * axis.normalized());
      poses.push_back({rotation, offset - rotation * offset});
    }
  }
  return poses;
}

std::vector<Pose> symmetries_of(const Json& info) {
  const std::vector<Pose> discrete = discrete_symmetries(info);
  const std::vector<Pose> continuous = continuous_symmetries(info);
  if (continuous.empty()) return discrete;
  std::vector<Pose> poses;
  for (const Pose& jump : discrete) {
    for (const Pose& turn : continuous) poses.push_back(turn * jump);
  }
  return poses;
}

std::map<int, BopModel> read_models(const fs::path& folder) {
  std::map<int, BopModel> models;
  with_json(folder / bop::kModelsInfoFile, [&](const Json& infos) {
    for (const auto& [key, info] : infos.items()) {
      BopModel& model = models[whole_number(key)];
      model.diameter_mm = info.at("diameter").get<double>();
      if (!(model.diameter_mm > 0)) throw InputError(fmt::format("{}: diameter must be > 0", key));
      model.symmetries = symmetries_of(info);
    }
  });
  for (auto& [id, model] : models) {
    model.mesh_mm = read_ply_as_it_is(folder / bop::model_file(id));
    model.points_mm.resize(3, static_cast<Eigen::Index>(model.mesh_mm.vertices.size()));
    for (size_t i = 0; i < model.mesh_mm.vertices.size(); ++i) {
      model.points_mm.col(static_cast<Eigen::Index>(i)) = model.mesh_mm.vertices[i];
    }
  }
  return models;
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
  throw InputError(fmt::format("{}: is no folder{}", named.string(),
                               split.empty() ? "; say --split which one is meant" : ""));
}

using ImageId = std::pair<int, int>;  // scene, image
using Targets = std::map<ImageId, std::map<int, int>>;

Targets read_targets(const fs::path& file) {
  Targets targets;
  with_json(file, [&](const Json& list) {
    for (const Json& target : list) {
      const int count = target.at("inst_count").get<int>();
      if (count < 1) throw InputError("inst_count must be 1 or more");
      const ImageId image{target.at("scene_id").get<int>(), target.at("im_id").get<int>()};
      targets[image][target.at("obj_id").get<int>()] = count;
    }
  });
  return targets;
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

int width_of(const BopImage& image) {
  for (const std::string_view kind : {bop::kColourFolder, bop::kGreyFolder, bop::kDepthFolder}) {
    const fs::path file = bop_picture(image.folder / kind, bop::image_name(image.im_id));
    const cv::Mat picture = file.empty() ? cv::Mat() : read_picture(file);
    if (!picture.empty()) return picture.cols;
  }
  throw InputError(fmt::format("{}: has no image {}, nor the set a {}, to tell the width",
                               image.folder.string(), image.im_id, bop::kCameraFile));
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
    for (const auto& [key, entries] : json.items()) {
      BopImage& image = images_[whole_number(key)];
      image.folder = folder_;
      image.scene_id = scene_id_;
      image.im_id = whole_number(key);
      for (const Json& entry : entries) {
        BopInstance instance{.obj_id = entry.at("obj_id").get<int>(), .cam_from_model = {}};
        instance.cam_from_model.rotation = matrix_from_rows(numbers_in(entry, "cam_R_m2c", 9));
        instance.cam_from_model.translation =
            Eigen::Map<const Eigen::Vector3d>(numbers_in(entry, "cam_t_m2c", 3).data());
        image.instances.push_back(instance);
      }
    }
  }

  void add_cameras(const Json& json) {
    for (auto& [im_id, image] : images_) {
      const Json& camera = json.at(fmt::to_string(im_id));
      image.k = matrix_from_rows(numbers_in(camera, "cam_K", 9));
      image.depth_scale = camera.value("depth_scale", 1.0);
      image.depth_file = bop_picture(folder_ / bop::kDepthFolder, bop::image_name(im_id));
    }
  }

  void add_info(const Json& json) {
    for (auto& [im_id, image] : images_) {
      const Json& infos = json.at(fmt::to_string(im_id));
      for (size_t i = 0; i < image.instances.size(); ++i) {
        image.instances[i].visible_fraction = infos.at(i).at("visib_fract").get<double>();
      }
    }
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

void require_instances(const BopImage& image) {
  for (const auto& [obj_id, count] : image.targets) {
    const auto there = std::count_if(image.instances.begin(), image.instances.end(),
                                     [id = obj_id](const auto& i) { return i.obj_id == id; });
    if (there >= count) continue;
    throw InputError(fmt::format("{}: asks for {} of object {} in scene {} image {}, which has {}",
                                 bop::kTargetsFile, count, obj_id, image.scene_id, image.im_id,
                                 there));
  }
}

void require_models(const BopImage& image, const std::map<int, BopModel>& models) {
  for (const auto& [obj_id, count] : image.targets) {
    if (models.contains(obj_id)) continue;
    throw InputError(fmt::format("{}: has no object {}, which scene {} image {} has",
                                 bop::kModelsInfoFile, obj_id, image.scene_id, image.im_id));
  }
}

fs::path models_folder(const fs::path& folder) {
  const fs::path evaluated = folder / bop::kEvaluatedModelsFolder;
  return fs::exists(evaluated) ? evaluated : folder / bop::kModelsFolder;
}

}  // namespace

fs::path bop_picture(const fs::path& folder, const std::string& name) {
  for (const char* extension : {"png", "jpg", "jpeg", "tif", "tiff", "bmp"}) {
    fs::path file = folder / (name + "." + extension);
    if (fs::exists(file)) return file;
  }
  return {};
}

fs::path bop_picture(const BopImage& image) {
  const std::string name = bop::image_name(image.im_id);
  const fs::path colour = bop_picture(image.folder / bop::kColourFolder, name);
  return colour.empty() ? bop_picture(image.folder / bop::kGreyFolder, name) : colour;
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

std::vector<Pose> bop_symmetries(const std::string& info) {
  return symmetries_of(Json::parse(info));
}

std::optional<BopBox> bop_model_box(const fs::path& folder, int obj_id) {
  const fs::path models = models_folder(folder);
  const fs::path infos_file = models / bop::kModelsInfoFile;
  std::optional<BopBox> box;
  if (fs::exists(infos_file)) {
    with_json(infos_file, [&](const Json& infos) {
      const auto info = infos.find(fmt::to_string(obj_id));
      if (info == infos.end() || !info->contains("min_x")) return;
      const auto vector = [&info](const std::string& name) {
        return Eigen::Vector3d(info->at(name + "_x"), info->at(name + "_y"), info->at(name + "_z"));
      };
      const Eigen::Vector3d min = vector("min");
      box = BopBox{{min, min + vector("size")}, infos_file};
    });
  }
  const fs::path model_file = models / bop::model_file(obj_id);
  if (box || !fs::exists(model_file)) return box;
  box = BopBox{{}, model_file};
  for (const Eigen::Vector3d& vertex : read_ply_as_it_is(model_file).vertices) {
    box->box_mm.extend(vertex);
  }
  return box;
}

std::vector<BopImage> read_bop_images(const fs::path& folder, const std::string& split) {
  if (!fs::is_directory(folder)) throw InputError(fmt::format("{}: is no folder", folder.string()));
  const fs::path scenes_folder = split_folder(folder, split);
  const fs::path list = folder / bop::kTargetsFile;
  const bool is_test = scenes_folder.filename().string().starts_with(bop::kTestSplit);
  const bool has_list = is_test && fs::exists(list);  // it is of no other split
  const Targets targets = has_list ? read_targets(list) : Targets{};
  std::set<int> scenes;
  if (!has_list) scenes = scenes_in(scenes_folder);
  for (const auto& [image, objects] : targets) scenes.insert(image.first);
  std::vector<BopImage> images;
  for (const int scene_id : scenes) {
    for (auto& [im_id, image] :
         SceneReader(scenes_folder / bop::scene_name(scene_id), scene_id).read()) {
      const auto wanted = targets.find({scene_id, im_id});
      if (has_list && wanted == targets.end()) continue;
      image.targets = has_list ? wanted->second : visible_objects(image);
      require_instances(image);
      if (!image.targets.empty()) images.push_back(std::move(image));
    }
  }
  const size_t asked = std::count_if(images.begin(), images.end(), [&](auto& i) {
    return targets.contains({i.scene_id, i.im_id});
  });
  if (asked < targets.size()) {
    throw InputError(
        fmt::format("{}: asks for images that {} has not", list.string(), bop::kSceneTruthFile));
  }
  if (images.empty()) {
    throw InputError(fmt::format("{}: has no image with a target", scenes_folder.string()));
  }
  return images;
}

BopDataset read_bop_dataset(const fs::path& folder, const std::string& split) {
  if (!fs::is_directory(folder)) throw InputError(fmt::format("{}: is no folder", folder.string()));
  BopDataset dataset{.models = read_models(models_folder(folder)),
                     .images = read_bop_images(folder, split)};
  int width_px = 0;
  if (fs::exists(folder / bop::kCameraFile)) {
    with_json(folder / bop::kCameraFile,
              [&](const Json& camera) { width_px = camera.value("width", 0); });
  }
  for (BopImage& image : dataset.images) {
    require_models(image, dataset.models);
    image.width_px = width_px > 0 ? width_px : width_of(image);
  }
  return dataset;
}

}  // namespace sightline
