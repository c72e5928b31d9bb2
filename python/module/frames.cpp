// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Targets, and frames with all that is true of them.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "eval/image_sets/set_plan.h"
#include "eval/trial/image_trial.h"
#include "python/module/arrays.h"
#include "python/module/bindings.h"
#include "python/module/long_call.h"
#include "python/module/study_handle.h"
#include "scenes/files/input_error.h"
#include "scenes/mesh/diameter.h"
#include "scenes/target/target.h"

namespace sightline {
namespace {

namespace py = pybind11;

py::dict load(const std::string& name) {
  std::shared_ptr<const Target> target;
  double diameter_m = 0;
  {
    const LongCall call;
    target = load_target(name);
    diameter_m = diameter(target->mesh.vertices);
  }
  std::vector<std::string> names, kinds, parts;
  std::vector<Eigen::Vector3d> positions;
  for (const TargetFeature& feature : target->features) {
    names.push_back(feature.name);
    kinds.emplace_back(to_string(feature.kind));
    positions.push_back(feature.position_m);
  }
  for (const Part& part : target->mesh.parts) parts.push_back(part.name);
  const auto triangles = static_cast<py::ssize_t>(target->mesh.triangles.size());
  py::array_t<int> corners({triangles, py::ssize_t{3}});
  for (py::ssize_t i = 0; i < triangles; ++i) {
    for (int k = 0; k < 3; ++k) corners.mutable_at(i, k) = target->mesh.triangles[i].vertex[k];
  }
  py::dict out;
  out["name"] = target->name;
  out["description"] = target->description;
  out["features"] = names;
  out["kinds"] = kinds;
  out["points"] = rows_of(positions);
  out["vertices"] = rows_of(target->mesh.vertices);
  out["triangles"] = corners;
  out["parts"] = parts;
  out["diameter_m"] = diameter_m;
  return out;
}

std::shared_ptr<StudyHandle> read_scene_of(const std::string& source,
                                           const std::vector<std::string>& settings,
                                           std::optional<int64_t> seed) {
  StudyOverrides overrides;
  overrides.set = settings;
  overrides.seed = seed;
  const LongCall call;
  return std::make_shared<StudyHandle>(read_set_study(source, overrides));
}

py::dict dict_of(const BodyTruth& body, const Target& target) {
  std::vector<std::string> names;
  std::vector<Eigen::Vector2d> pixels;
  std::vector<bool> is_visible;
  for (size_t i = 0; i < body.features.size(); ++i) {
    names.push_back(target.features[i].name);
    pixels.push_back(body.features[i].pixel);
    is_visible.push_back(body.features[i].is_visible);
  }
  const cv::Rect& box = body.visible_box;
  py::dict out;
  out["target"] = target.name;
  out["cam_from_target"] = matrix_of(body.cam_from_target);
  out["is_occluder"] = body.is_occluder;
  out["features"] = names;
  out["pixels"] = rows_of(pixels);
  out["is_visible"] = is_visible;
  out["box"] = py::make_tuple(box.x, box.y, box.width, box.height);
  out["visible_fraction"] = body.visible_fraction();
  return out;
}

// Of a scene that could not be imaged there is no image and no truth but the pose.
py::dict dict_of(const Scene& scene, const Frame& frame) {
  py::dict out;
  out["camera"] = numbers_of(scene.camera);
  out["bits"] = scene.sensor.bits;
  out["cam_from_target"] = matrix_of(scene.cam_from_target);
  if (frame.image.empty()) return out;
  out["image"] = view_of(frame.image);
  if (!frame.colour.empty()) out["colour"] = colours_of(frame.colour);
  // A data set may lack them.
  if (!frame.depth_m.empty()) out["depth_m"] = view_of(frame.depth_m);
  if (!frame.part_ids.empty()) out["part_ids"] = view_of(frame.part_ids);
  if (!frame.body_ids.empty()) out["body_ids"] = view_of(frame.body_ids);
  py::list bodies;
  const size_t told = std::min(frame.truth.bodies.size(), scene.others.size() + 1);
  for (size_t i = 0; i < told; ++i) {
    const Target& target = i == 0 ? *scene.target : *scene.others[i - 1].target;
    bodies.append(dict_of(frame.truth.bodies[i], target));
  }
  out["bodies"] = bodies;
  return out;
}

void require_image(int64_t index) {
  if (index < 0) throw InputError(fmt::format("render: index is {}, must be 0 or more", index));
}

// Image `index` of the set that `sightline render` would write, or the same scene at another pose.
py::dict render_frame_of(StudyHandle& handle, int64_t index,
                         const std::optional<Doubles>& cam_from_target) {
  require_image(index);
  std::optional<Pose> pose;
  if (cam_from_target) pose = pose_from(*cam_from_target);
  if (pose && !is_valid(*pose)) {
    throw InputError("render: cam_from_target is no rigid transform of finite numbers");
  }
  Scene scene;
  Frame frame;
  {
    const LongCall call;
    const ImageStudy& images = *handle.study.images();
    const ImageCell& cell = images.cells[handle.study.condition_of(index)];
    const int64_t draw = images.draw_of(index);
    scene = draw_scene(images.setups[cell.setup].scene, cell.pose, handle.study.seed, draw).scene;
    if (pose) scene.cam_from_target = *pose;
    frame = handle.with_renderer([&](Renderer& renderer) {
      return renderer.render(scene, RandomStream(handle.study.seed, "sensor", draw));
    });
  }
  return dict_of(scene, frame);
}

py::dict observations_of(const ImageStudy& study, const Trial& trial) {
  std::vector<std::string> names, statuses;
  std::vector<Eigen::Vector2d> pixels;
  std::vector<Eigen::Matrix2d> covariances;
  for (const Observation& observation : trial.observations) {
    names.push_back(study.target->features[observation.feature].name);
    statuses.emplace_back(to_string(observation.status));
    pixels.push_back(observation.pixel);
    covariances.push_back(observation.covariance_px2);
  }
  py::dict out;
  out["features"] = names;
  out["status"] = statuses;
  out["pixels"] = rows_of(pixels);
  out["covariances"] = array_of(covariances);
  return out;
}

// The frame of a study's trial, and what its extractors find there.
py::dict trial_frame(StudyHandle& handle, int64_t index) {
  const ImageStudy* const images = handle.study.images();
  if (images == nullptr) {
    throw InputError(fmt::format("frames: the study {} has no images", handle.study.name));
  }
  Trial trial;
  {
    const LongCall call;
    trial = handle.with_renderer([&](Renderer& renderer) {
      return run_image_trial(*images, handle.study.seed, index, renderer);
    });
  }
  py::dict out = dict_of(trial.scene, trial.frame);
  out["trial"] = index;
  out["condition"] = handle.study.conditions[trial.record.condition].label;
  out["prior_cam_from_target"] = matrix_of(trial.record.pose_trial().prior_cam_from_target);
  out["observations"] = observations_of(*images, trial);
  return out;
}

}  // namespace

void bind_frames(py::module_& module) {
  module.def("target", &load);
  module.def("read_scene", &read_scene_of);
  module.def("render", &render_frame_of);
  module.def("trial_frame", &trial_frame);
}

}  // namespace sightline
