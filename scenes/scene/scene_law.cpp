// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/scene_law.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace sightline {
namespace {

// A given pose that cannot be imaged is the user's error, not a failed trial.
void require_imageable(const TomlTable& poses, const SceneLaw& law) {
  for (size_t i = 0; i < law.poses.t_m.size(); ++i) {
    Scene scene;
    scene.target = law.target;
    scene.camera = law.camera;
    scene.cam_from_target = pose_from(law.poses.theta_deg[i], law.poses.t_m[i]);
    const std::string reason = why_not_imageable(scene);
    if (!reason.empty()) poses.fail(fmt::format("fixed[{}]", i), "cannot be imaged: " + reason);
  }
}

// A panorama is all the light there is, but for what the file adds.
void leave_light_to_environment(const TomlTable& file, LightLaw& light) {
  const TomlTable table = file.table("light");
  if (!table.has("ambient")) light.ambient = 0;
  if (!table.has("directional")) light.directional = 0;
}

bool has_all_features_inside(const SceneLaw& law, const Pose& cam_from_target) {
  return std::all_of(law.features.begin(), law.features.end(), [&](int feature) {
    const Eigen::Vector3d& position = law.target->features[feature].position_m;
    const auto pixel = project(law.camera, cam_from_target * position);
    return pixel && is_inside(law.camera, *pixel);
  });
}

// Places the main target, and counts how often it was drawn anew.
void draw_pose(const SceneLaw& law, int given_pose, const Draws& draws, DrawnScene& drawn) {
  RandomStream stream = draws.stream("pose");
  Pose& pose = drawn.scene.cam_from_target;
  if (!law.poses.t_m.empty()) {
    pose = jittered_pose(law.poses, given_pose, stream);
    return;
  }
  pose = drawn_pose(law.poses, stream);
  while (drawn.redraws < law.poses.max_redraws && !has_all_features_inside(law, pose)) {
    pose = drawn_pose(law.poses, stream);
    ++drawn.redraws;
  }
}

}  // namespace

SceneLaw read_scene_law(const TomlTable& table, std::shared_ptr<const Target> target,
                        std::vector<int> features) {
  SceneLaw law;
  law.target = std::move(target);
  law.features = std::move(features);
  law.camera = read_camera(table.table("camera"));
  const TomlTable poses = table.table("poses");
  law.poses = read_poses(poses);
  law.samples_per_pixel = read_samples_per_pixel(table);
  law.sensor = read_sensor(table);
  law.colouring = read_colouring(table);
  if (law.colouring.mode == ColourMode::kGrey && table.table("image").has("response")) {
    table.table("image").fail("response", "needs image.colour = \"rgb\" or \"bayer\"");
  }
  require_textures(table, law.colouring, law.target->name, law.target->mesh);
  law.light = read_light(table);
  law.lamps = read_lamps(table);
  law.environment = read_environment(table);
  if (law.environment.is_there()) leave_light_to_environment(table, law.light);
  law.background = read_background(table);
  if (law.background.kind == BackgroundKind::kEnvironment && !law.environment.is_there()) {
    table.table("background").fail("kind", "is \"environment\", which needs environment.file");
  }
  Livery livery;
  read_keys(table, keys_of(law.livery, livery));
  Motion motion;
  read_keys(table, keys_of(law.motion, motion));
  Optics optics;
  read_keys(table, keys_of(law.optics, optics));
  if (law.optics.aperture_mm.max > 0 && !is_pinhole(law.camera.lens)) {
    table.table("optics").fail("aperture_mm", "needs a camera without lens distortion");
  }
  law.others = read_others(table);
  for (const OtherLaw& other : law.others) {
    require_textures(table, law.colouring, other.target->name, other.target->mesh);
  }
  law.materials = read_materials(table, law.colouring, law.target, law.others);
  require_imageable(poses, law);
  return law;
}

std::vector<KeyText> scene_keys() {
  CameraLaw camera;
  FixedPose fixed;
  OtherLaw other;
  SceneLaw law;
  Scene scene;
  std::vector<KeyText> all;
  const auto add = [&all](const std::vector<Key>& keys, std::string_view object) {
    for (KeyText& text : texts_of(keys, object)) all.push_back(std::move(text));
  };
  add(keys_of(camera), "camera");
  add(keys_of(law.poses), "bodies");
  add(keys_of(fixed), "bodies");
  add(keys_of_sampling(law.samples_per_pixel, scene.samples_per_pixel), "scene");
  add(keys_of(law.sensor, scene.sensor), "scene.sensor");
  add(keys_of(law.colouring, scene.colouring), "scene.colouring");
  add(keys_of(law.background, scene.background), "scene.background");
  add(keys_of(law.light, scene.light), "scene.light");
  LampLaw lamp;
  add(keys_of(lamp), "scene.lamps");
  add(keys_of(law.environment, scene.environment), "scene.environment");
  add(keys_of(law.livery, scene.livery), "scene.livery");
  add(keys_of(law.materials), "scene.materials");
  add(keys_of(law.motion, scene.motion), "scene.motion");
  add(keys_of(law.optics, scene.optics), "scene.optics");
  add(keys_of(other), "bodies");
  return all;
}

DrawnScene draw_scene(const SceneLaw& law, int given_pose, uint64_t seed, int64_t index) {
  const Draws draws{seed, index};
  DrawnScene drawn;
  Scene& scene = drawn.scene;
  scene.target = law.target;
  scene.camera = law.camera;
  scene.samples_per_pixel = law.samples_per_pixel;
  draw_pose(law, given_pose, draws, drawn);
  scene.light = draw_light(law.light, scene.cam_from_target, draws);
  scene.lamps = draw_lamps(law.lamps, scene.cam_from_target, draws);
  scene.environment = draw_environment(law.environment, draws);
  scene.background = draw_background(law.background, draws);
  scene.livery = draw_livery(law.livery, draws);
  scene.motion = draw_motion(law.motion, law.camera, scene.cam_from_target, draws);
  scene.optics = draw_optics(law.optics, scene.cam_from_target, draws);
  scene.sensor = draw_sensor(law.sensor, seed, draws);
  scene.colouring = draw_colouring(law.colouring, draws);
  DrawnOthers others =
      draw_others(law.others, law.camera, law.target->mesh, scene.cam_from_target, draws);
  scene.others = std::move(others.bodies);
  scene.misplaced = std::move(others.problem);
  scene.materials = dress(law.materials, draws, scene.target, scene.others);
  drawn.is_imageable = why_not_imageable(scene).empty();
  return drawn;
}

void check_drawn_files(const SceneLaw& law, uint64_t seed, int64_t index, CheckedFiles& checked) {
  const Draws draws{seed, index};
  check_drawn_file(law.environment, draws, checked);
  check_drawn_file(law.background, draws, checked);
  check_drawn_files(law.materials, draws, checked);
}

}  // namespace sightline
