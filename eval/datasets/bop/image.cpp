// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/bop/image.h"

#include <array>
#include <utility>

#include <fmt/format.h>

#include "eval/datasets/bop/layout.h"
#include "eval/datasets/bop/numbered.h"
#include "eval/datasets/conventions.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

void read_pose(const Json& entry, BopInstance& instance) {
  const auto rotation = usable_rotation(matrix_from_rows(numbers_or_nan_in(entry, "cam_R_m2c", 9)));
  const auto t = numbers_or_nan_in(entry, "cam_t_m2c", 3);
  const Eigen::Vector3d translation(t[0], t[1], t[2]);
  require_near(kMetresPerMillimetre * translation, "cam_t_m2c");
  instance.has_pose = rotation && translation.allFinite();
  if (instance.has_pose) instance.cam_from_model = {*rotation, translation};
}

BopInstance instance_of(const Json& entry) {
  BopInstance instance{.obj_id = whole_in(entry, "obj_id"), .cam_from_model = {}};
  try {
    read_pose(entry, instance);
  } catch (const InputError& error) {
    instance.has_pose = false;
    instance.problem = error.what();
  }
  return instance;
}

void set_camera_model(const Json& model, BopImage& image) {
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

// The folder of a scene's pictures of a kind, of the image's sensor where the scene has several.
fs::path folder_of_kind(const BopImage& image, std::string_view kind) {
  return image.folder / bop::of_sensor(kind, image.sensor);
}

}  // namespace

void add_bop_camera(const Json& camera, BopImage& image) {
  if (camera.is_object() && camera.contains("cam_model")) {
    if (camera.contains("cam_K")) {
      throw InputError(fmt::format("image {}: has both cam_K and cam_model, must have one of them",
                                   image.im_id));
    }
    set_camera_model(camera["cam_model"], image);
  } else {
    image.k = matrix_from_rows(numbers_in(camera, "cam_K", 9));
  }
  if (image.k.cwiseAbs().maxCoeff() > kGreatestPx) {
    throw InputError(
        fmt::format("image {}: its camera has a number beyond {:g} px", image.im_id, kGreatestPx));
  }
  image.states_depth_scale = camera.contains("depth_scale");
  if (image.states_depth_scale) image.depth_scale = number_in(camera, "depth_scale");
}

void add_bop_truth(const Json& entries, BopImage& image) {
  for (const Json& entry : entries) image.instances.push_back(instance_of(entry));
}

void add_bop_visibility(const Json& infos, const std::string& truth_file, BopImage& image) {
  if (!infos.is_array() || infos.size() < image.instances.size()) {
    throw InputError(fmt::format("tells of {} instances in image {}, of which {} has {}",
                                 infos.size(), image.im_id, truth_file, image.instances.size()));
  }
  for (size_t i = 0; i < image.instances.size(); ++i) {
    image.instances[i].visible_fraction = number_in(infos.at(i), "visib_fract");
  }
}

fs::path bop_picture_of_kind(const BopImage& image, std::string_view kind) {
  if (!image.key.empty()) return picture_named(image.folder, fmt::format("{}.{}", image.key, kind));
  return numbered_picture(folder_of_kind(image, kind), {image.im_id});
}

fs::path bop_picture(const BopImage& image) {
  // HOT3D names its sensors by what they see: its folder rgb/ is that of the sensor "rgb".
  if (!image.sensor.empty()) {
    const fs::path of_sensor = numbered_picture(image.folder / image.sensor, {image.im_id});
    if (!of_sensor.empty()) return of_sensor;
  }
  const fs::path colour = bop_picture_of_kind(image, bop::kColourFolder);
  return colour.empty() ? bop_picture_of_kind(image, bop::kGreyFolder) : colour;
}

fs::path missing_bop_picture(const BopImage& image) {
  if (!image.key.empty()) {
    return image.folder / fmt::format("{}.{}.png", image.key, bop::kColourFolder);
  }
  const fs::path colour = folder_of_kind(image, bop::kColourFolder);
  const fs::path grey = folder_of_kind(image, bop::kGreyFolder);
  const bool is_grey = !fs::is_directory(colour) && fs::is_directory(grey);
  return (is_grey ? grey : colour) / (bop::image_name(image.im_id) + ".png");
}

Camera bop_camera(const BopImage& image) {
  try {
    Camera camera = camera_from_matrix(image.k);
    camera.lens = image.lens;
    return camera;
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: image {}: cam_K {}", bop_camera_file(image).string(),
                                 image.im_id, error.what()));
  }
}

fs::path bop_camera_file(const BopImage& image) {
  if (image.key.empty()) {
    return plain_or_packed(image.folder / bop::of_sensor(bop::kSceneCameraFile, image.sensor));
  }
  // The first is what the toolkit writes.
  constexpr std::array<std::string_view, 2> kEndings = {".camera.json", ".cam.json"};
  for (const std::string_view ending : kEndings) {
    const fs::path file = plain_or_packed(image.folder / fmt::format("{}{}", image.key, ending));
    if (fs::exists(file)) return file;
  }
  return image.folder / fmt::format("{}{}", image.key, kEndings.front());
}

fs::path bop_truth_file(const BopImage& image) {
  return plain_or_packed(image.folder / (image.key.empty()
                                             ? bop::of_sensor(bop::kSceneTruthFile, image.sensor)
                                             : image.key + std::string(bop::kImageTruthFile)));
}

fs::path bop_visible_mask(const BopImage& image, int gt_id) {
  if (image.key.empty()) {
    return numbered_picture(folder_of_kind(image, bop::kVisibleMaskFolder), {image.im_id, gt_id});
  }
  const fs::path masks =
      plain_or_packed(image.folder / fmt::format("{}.{}.json", image.key, bop::kVisibleMaskFolder));
  return fs::exists(masks) ? masks : fs::path();
}

}  // namespace sightline
