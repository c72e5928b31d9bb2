// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/scene_law.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <opencv2/imgcodecs.hpp>

#include "pose/attitude.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Range drawn(const TomlTable& table, const char* key, Interval allowed, double fallback) {
  const auto [min, max] = table.number_or_range(key, allowed, fallback);
  return {min, max};
}

void read_fixed_poses(const std::vector<TomlTable>& fixed, PoseLaw& law) {
  for (const TomlTable& pose : fixed) {
    law.theta_deg.push_back(pose.vector3("theta_deg"));
    law.t_m.push_back(pose.vector3("t_m"));
    pose.table("paper");  // a study's: what the paper found there
  }
}

PoseLaw read_poses(const TomlTable& table) {
  const auto fixed = table.tables("fixed");
  PoseLaw law;
  law.lateral_jitter_m = table.number("lateral_jitter_m", {0, 1e6}, 0.0);
  law.max_redraws = static_cast<int>(table.integer("max_redraws", {0, 100000}, law.max_redraws));
  if (!fixed.empty()) {
    for (const char* key :
         {"angle_deg", "attitude", "tilt_deg", "lateral_m", "range_m", "max_redraws"}) {
      if (table.has(key))
        table.fail(key, "cannot stand beside [[poses.fixed]]: give one or the other");
    }
    read_fixed_poses(fixed, law);
    return law;
  }
  if (!table.has("range_m")) {
    table.fail("fixed",
               "is missing: give [[poses.fixed]], or the ranges angle_deg, lateral_m and "
               "range_m to draw from");
  }
  if (table.has("lateral_jitter_m")) table.fail("lateral_jitter_m", "belongs to [[poses.fixed]]");
  const std::vector<std::string> attitudes = {"angles", "uniform"};
  law.is_attitude_uniform = table.choice("attitude", attitudes, attitudes[0]) == attitudes[1];
  if (!law.is_attitude_uniform) {
    law.drawn_angle_deg = read_range(table, "angle_deg", {-180, 180});
  } else if (table.has("angle_deg")) {
    table.fail("angle_deg", "cannot stand beside attitude = \"uniform\"");
  }
  if (table.has("tilt_deg")) {
    if (!law.is_attitude_uniform) {
      table.fail("tilt_deg", "needs attitude = \"uniform\" beside it");
    }
    law.tilt_deg = drawn(table, "tilt_deg", {0, 180}, 0);
  }
  read_position_ranges(table, law);
  return law;
}

void read_image(const TomlTable& image, SceneLaw& law) {
  law.samples_per_pixel = static_cast<int>(image.integer("samples_per_pixel", {1, 256}, 16));
  const auto end = kSampleCounts.end();
  if (std::find(kSampleCounts.begin(), end, law.samples_per_pixel) == end) {
    image.fail("samples_per_pixel", fmt::format("is {}, must be one of {}", law.samples_per_pixel,
                                                fmt::join(kSampleCounts, ", ")));
  }
  law.psf_sigma_px = drawn(image, "psf_sigma_px", {0, 50}, 0.7);
  law.gain = drawn(image, "gain", {0.001, 1000}, 1);
  law.bits = static_cast<int>(image.integer("bits", {1, 16}, 8));
  const std::vector<std::string> encodings = {"linear", "srgb"};
  law.is_srgb = image.choice("encoding", encodings, encodings[0]) == encodings[1];
}

void read_noise(const TomlTable& noise, SceneLaw& law) {
  law.noise_scale = noise.number("scale", {0, 1000}, 1.0);
  law.read_noise_grey = drawn(noise, "read_noise_grey", {0, 255}, 3);
  law.full_well_electrons = drawn(noise, "full_well_electrons", {0, 1e9}, 0);
  law.dead_fraction = drawn(noise, "dead_fraction", {0, 0.5}, 0);
  law.hot_fraction = drawn(noise, "hot_fraction", {0, 0.5}, 0);
}

void read_light(const TomlTable& light, SceneLaw& law) {
  law.ambient = drawn(light, "ambient", {0, 1}, 0.30);
  law.directional = drawn(light, "directional", {0, 1}, 0.75);
  law.specular = drawn(light, "specular", {0, 1}, 0);
  law.shininess = drawn(light, "shininess", {1, 1000}, 20);
  law.casts_shadow = light.flag("casts_shadow", false);
  if (light.has("phase_deg")) {
    if (light.has("cone_deg")) {
      light.fail("cone_deg", "cannot stand beside phase_deg: give one or the other");
    }
    law.light_phase_deg = drawn(light, "phase_deg", {0, 180}, 0);
    law.light_azimuth_deg = {0, 360};
    if (light.has("azimuth_deg")) {
      law.light_azimuth_deg = drawn(light, "azimuth_deg", {-360, 360}, 0);
    }
  } else if (light.has("azimuth_deg")) {
    light.fail("azimuth_deg", "needs phase_deg beside it");
  }
  law.light_cone_deg = light.number("cone_deg", {0, 180}, 45.0);
}

// As grey on a linear scale: files are taken for sRGB.
void read_picture(const TomlTable& table, SceneLaw& law) {
  const std::filesystem::path given = table.text("file");
  const std::filesystem::path beside = table.file().parent_path() / given;
  const std::filesystem::path file = std::filesystem::exists(beside) ? beside : given;
  cv::Mat grey;
  try {
    grey = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
  } catch (const cv::Exception&) {
  }
  if (grey.empty()) {
    table.fail("file",
               fmt::format("is \"{}\", which is no picture that can be read", given.string()));
  }
  auto pixels = std::make_shared<std::vector<float>>();
  pixels->reserve(grey.total());
  for (int v = 0; v < grey.rows; ++v) {
    for (int u = 0; u < grey.cols; ++u) {
      const double encoded = grey.at<uint8_t>(v, u) / 255.0;
      pixels->push_back(static_cast<float>(
          encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4)));
    }
  }
  law.picture = std::move(pixels);
  law.picture_width = grey.cols;
}

void read_background(const TomlTable& table, SceneLaw& law) {
  std::vector<std::string> kinds;
  for (int kind = 0; kind <= static_cast<int>(BackgroundKind::kImage); ++kind) {
    kinds.emplace_back(to_string(static_cast<BackgroundKind>(kind)));
  }
  const std::string kind = table.choice("kind", kinds, kinds[0]);
  law.background_kind =
      static_cast<BackgroundKind>(std::find(kinds.begin(), kinds.end(), kind) - kinds.begin());
  law.background_level = drawn(table, "level", {0, 1}, 0.15);
  law.background_contrast = drawn(table, "contrast", {0, 2}, 0.2);
  law.background_angle_deg = drawn(table, "angle_deg", {-360, 360}, 90);
  law.cloud_px = drawn(table, "cloud_px", {2, 100000}, 120);
  law.stars_per_megapixel = drawn(table, "stars_per_megapixel", {0, 1e5}, 200);
  if (law.background_kind == BackgroundKind::kImage) {
    read_picture(table, law);
  } else if (table.has("file")) {
    table.fail("file", "belongs to kind = \"image\"");
  }
}

void read_motion(const TomlTable& motion, SceneLaw& law) {
  law.motion_rotation_deg = drawn(motion, "rotation_deg", {0, 90}, 0);
  law.motion_shift_px = drawn(motion, "shift_px", {0, 1000}, 0);
  law.motion_samples = static_cast<int>(motion.integer("samples", {2, 256}, 9));
}

std::shared_ptr<const Target> load_other(const TomlTable& table) {
  const std::string name = table.text("target");
  const double scale = table.number("scale", {1e-9, 1e9}, 1.0);
  try {
    return scaled(load_target(name), scale);
  } catch (const InputError& error) {
    table.fail("target", fmt::format("cannot be used: {}", error.what()));
  }
}

std::vector<OtherLaw> read_others(const TomlTable& table) {
  constexpr int kMostBodies = 254;  // body ids have 8 bits
  std::vector<OtherLaw> others;
  int bodies = 0;
  for (const TomlTable& other : table.tables("other")) {
    OtherLaw law;
    law.target = load_other(other);
    const std::vector<std::string> roles = {"occluder", "target"};
    law.is_occluder = other.choice("role", roles, roles[0]) == roles[0];
    law.count = static_cast<int>(other.integer("count", {0, kMostBodies}, 1));
    if (other.has("offset_px")) law.offset_px = read_range(other, "offset_px", {-1e6, 1e6});
    if (other.has("range_fraction")) {
      law.range_fraction = read_range(other, "range_fraction", {1e-3, 1e3});
    }
    if (other.has("angle_deg")) law.angle_deg = read_range(other, "angle_deg", {-180, 180});
    bodies += law.count;
    if (bodies > kMostBodies) {
      other.fail("count", fmt::format("makes {} bodies, at most {} can stand beside the target",
                                      bodies, kMostBodies));
    }
    others.push_back(std::move(law));
  }
  return others;
}

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

// ---- draws

// Draws of one scene: a stream for every quantity.
struct Draws {
  uint64_t seed;
  int64_t index;

  RandomStream stream(std::string_view name) const {
    return {seed, name, static_cast<uint64_t>(index)};
  }
  double operator()(const Range& range, std::string_view name) const {
    if (range.min == range.max) return range.min;
    RandomStream own = stream(name);
    return range.draw(own);
  }
};

Pose jittered_pose(const PoseLaw& law, int pose, RandomStream& stream) {
  const double dx = law.lateral_jitter_m * stream.uniform(-1, 1);
  const double dy = law.lateral_jitter_m * stream.uniform(-1, 1);
  return pose_from(law.theta_deg[pose], law.t_m[pose] + Eigen::Vector3d(dx, dy, 0));
}

// Uniform about both z axes, which make an angle of the range.
Eigen::Matrix3d tilted_attitude(const Range& tilt_deg, RandomStream& stream) {
  const auto turn = [](double angle, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  };
  const double before = stream.uniform(0, 2 * std::numbers::pi);
  const double tilt = tilt_deg.draw(stream) * kDegree;
  const double after = stream.uniform(0, 2 * std::numbers::pi);
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  return turn(after, z) * turn(tilt, Eigen::Vector3d::UnitY()) * turn(before, z);
}

bool has_all_features_inside(const SceneLaw& law, const Pose& cam_from_target) {
  return std::all_of(law.features.begin(), law.features.end(), [&](int feature) {
    const Eigen::Vector3d& position = law.target->features[feature].position_m;
    const auto pixel = project(law.camera, cam_from_target * position);
    return pixel && is_inside(law.camera, *pixel);
  });
}

Light draw_light(const SceneLaw& law, const Pose& cam_from_target, const Draws& draws) {
  Light light;
  light.ambient = draws(law.ambient, "light.ambient");
  light.directional = draws(law.directional, "light.directional");
  light.specular = draws(law.specular, "light.specular");
  light.shininess = draws(law.shininess, "light.shininess");
  light.casts_shadow = law.casts_shadow;
  const Eigen::Vector3d to_camera = -cam_from_target.translation.normalized();
  if (!law.light_phase_deg) {
    RandomStream stream = draws.stream("light");
    light.to_light_in_cam = stream.direction_near(to_camera, law.light_cone_deg * kDegree);
    return light;
  }
  const double phase = draws(*law.light_phase_deg, "light.phase_deg") * kDegree;
  const double azimuth = draws(law.light_azimuth_deg, "light.azimuth_deg") * kDegree;
  const Eigen::Vector3d right = Eigen::Vector3d::UnitY().cross(-to_camera).normalized();
  const Eigen::Vector3d down = (-to_camera).cross(right);
  light.to_light_in_cam = std::cos(phase) * to_camera +
                          std::sin(phase) * (std::cos(azimuth) * right + std::sin(azimuth) * down);
  return light;
}

Background draw_background(const SceneLaw& law, const Draws& draws) {
  Background background;
  background.kind = law.background_kind;
  background.level = draws(law.background_level, "background.level");
  background.contrast = draws(law.background_contrast, "background.contrast");
  background.angle_deg = draws(law.background_angle_deg, "background.angle_deg");
  background.cloud_px = draws(law.cloud_px, "background.cloud_px");
  background.stars_per_megapixel = draws(law.stars_per_megapixel, "background.stars_per_megapixel");
  background.picture = law.picture;
  background.picture_width = law.picture_width;
  background.seed = draws.stream("background").bits();
  return background;
}

Motion draw_motion(const SceneLaw& law, const Pose& cam_from_target, const Draws& draws) {
  Motion motion;
  motion.samples = law.motion_samples;
  RandomStream stream = draws.stream("motion");
  const double angle = draws(law.motion_rotation_deg, "motion.rotation_deg") * kDegree;
  motion.rotation_rad = angle * stream.direction_near(Eigen::Vector3d::UnitZ(), std::numbers::pi);
  const double shift_m = draws(law.motion_shift_px, "motion.shift_px") / law.camera.fx_px *
                         cam_from_target.translation.z();
  const double side = stream.uniform(0, 2 * std::numbers::pi);
  motion.translation_m = shift_m * Eigen::Vector3d(std::cos(side), std::sin(side), 0);
  return motion;
}

Sensor draw_sensor(const SceneLaw& law, uint64_t seed, const Draws& draws) {
  Sensor sensor;
  const double scale = law.noise_scale;
  sensor.psf_sigma_px = draws(law.psf_sigma_px, "image.psf_sigma_px");
  sensor.gain = draws(law.gain, "image.gain");
  sensor.bits = law.bits;
  sensor.is_srgb = law.is_srgb;
  sensor.read_noise_grey = scale * draws(law.read_noise_grey, "noise.read_noise_grey");
  const double electrons = draws(law.full_well_electrons, "noise.full_well_electrons");
  sensor.full_well_electrons = scale > 0 ? electrons / (scale * scale) : 0;
  sensor.dead_fraction = draws(law.dead_fraction, "noise.dead_fraction");
  sensor.hot_fraction = draws(law.hot_fraction, "noise.hot_fraction");
  sensor.defect_seed = seed;
  return sensor;
}

std::vector<OtherBody> draw_others(const SceneLaw& law, const Scene& scene, const Draws& draws) {
  std::vector<OtherBody> others;
  RandomStream stream = draws.stream("other");
  const Eigen::Vector3d& origin = scene.cam_from_target.translation;
  for (const OtherLaw& other : law.others) {
    for (int i = 0; i < other.count; ++i) {
      const double du_px = other.offset_px.draw(stream);
      const double dv_px = other.offset_px.draw(stream);
      const double fraction = other.range_fraction.draw(stream);
      Eigen::Vector3d theta_deg;
      for (double& angle : theta_deg) angle = other.angle_deg ? other.angle_deg->draw(stream) : 0;
      OtherBody body{other.target, pose_from(theta_deg, origin), other.is_occluder};
      if (!other.angle_deg) body.cam_from_target.rotation = stream.rotation();
      body.cam_from_target.translation +=
          origin.z() * Eigen::Vector3d(du_px / law.camera.fx_px, dv_px / law.camera.fy_px, 0);
      body.cam_from_target.translation *= fraction;
      others.push_back(std::move(body));
    }
  }
  return others;
}

}  // namespace

Camera read_camera(const TomlTable& table) {
  const int width = static_cast<int>(table.integer("width_px", {16, 16384}, 512));
  const int height = static_cast<int>(table.integer("height_px", {16, 16384}, 512));
  Camera camera = centred_camera(width, height, table.number("f_px", {1, 1e7}));
  const std::vector<double> centre =
      table.numbers("principal_point_px", 2, std::vector{camera.cx_px, camera.cy_px});
  camera.cx_px = centre[0];
  camera.cy_px = centre[1];
  const std::vector<double> k = table.numbers("distortion", 5, std::vector<double>(5, 0.0));
  camera.distortion = {.k1 = k[0], .k2 = k[1], .p1 = k[2], .p2 = k[3], .k3 = k[4]};
  // A lens that folds the image over would image points twice.
  for (const double u : {-0.5, camera.cx_px, width - 0.5}) {
    for (const double v : {-0.5, camera.cy_px, height - 0.5}) {
      if (normalised_from_pixel(camera, {u, v})) continue;
      table.fail(k == std::vector<double>(5, 0.0) ? "principal_point_px" : "distortion",
                 fmt::format("cannot be undone at pixel ({}, {})", u, v));
    }
  }
  return camera;
}

Range read_range(const TomlTable& table, std::string_view key, Interval allowed) {
  const std::vector<double> ends = table.numbers(key, 2);
  if (!(ends[0] <= ends[1]) || ends[0] < allowed.min || ends[1] > allowed.max) {
    table.fail(key, fmt::format("is [{}, {}], must be [low, high] between {} and {}", ends[0],
                                ends[1], allowed.min, allowed.max));
  }
  return {ends[0], ends[1]};
}

void read_position_ranges(const TomlTable& poses, PoseLaw& law) {
  law.drawn_lateral_m = read_range(poses, "lateral_m", {-1e6, 1e6});
  law.drawn_range_m = read_range(poses, "range_m", {1e-3, 1e9});
}

SceneLaw read_scene_law(const TomlTable& table, std::shared_ptr<const Target> target,
                        std::vector<int> features) {
  SceneLaw law;
  law.target = std::move(target);
  law.features = std::move(features);
  law.camera = read_camera(table.table("camera"));
  const TomlTable poses = table.table("poses");
  law.poses = read_poses(poses);
  read_image(table.table("image"), law);
  read_noise(table.table("noise"), law);
  read_light(table.table("light"), law);
  read_background(table.table("background"), law);
  const TomlTable livery = table.table("livery");
  law.stripe_contrast = drawn(livery, "contrast", {0, 1}, 0);
  law.stripe_m = drawn(livery, "stripe_m", {1e-6, 1e6}, 2);
  read_motion(table.table("motion"), law);
  law.others = read_others(table);
  require_imageable(poses, law);
  return law;
}

Pose pose_from(const Eigen::Vector3d& theta_deg, const Eigen::Vector3d& t_m) {
  const Eigen::Vector3d theta = theta_deg * kDegree;
  return {rotation_from_attitude({theta.x(), theta.y(), theta.z()}), t_m};
}

Pose drawn_pose(const PoseLaw& law, RandomStream& stream) {
  Pose pose;
  if (law.tilt_deg) {
    pose.rotation = tilted_attitude(*law.tilt_deg, stream);
  } else if (law.is_attitude_uniform) {
    pose.rotation = stream.rotation();
  } else {
    Eigen::Vector3d theta_deg;
    for (double& angle : theta_deg) angle = law.drawn_angle_deg.draw(stream);
    pose = pose_from(theta_deg, Eigen::Vector3d::Zero());
  }
  pose.translation.x() = law.drawn_lateral_m.draw(stream);
  pose.translation.y() = law.drawn_lateral_m.draw(stream);
  pose.translation.z() = law.drawn_range_m.draw(stream);
  return pose;
}

DrawnScene draw_scene(const SceneLaw& law, int given_pose, uint64_t seed, int64_t index) {
  const Draws draws{seed, index};
  DrawnScene drawn;
  Scene& scene = drawn.scene;
  scene.target = law.target;
  scene.camera = law.camera;
  scene.samples_per_pixel = law.samples_per_pixel;
  RandomStream pose_stream = draws.stream("pose");
  if (!law.poses.t_m.empty()) {
    scene.cam_from_target = jittered_pose(law.poses, given_pose, pose_stream);
  } else {
    scene.cam_from_target = drawn_pose(law.poses, pose_stream);
    while (drawn.redraws < law.poses.max_redraws &&
           !has_all_features_inside(law, scene.cam_from_target)) {
      scene.cam_from_target = drawn_pose(law.poses, pose_stream);
      ++drawn.redraws;
    }
  }
  scene.light = draw_light(law, scene.cam_from_target, draws);
  scene.background = draw_background(law, draws);
  scene.livery = {draws(law.stripe_contrast, "livery.contrast"),
                  draws(law.stripe_m, "livery.stripe_m")};
  scene.motion = draw_motion(law, scene.cam_from_target, draws);
  scene.sensor = draw_sensor(law, seed, draws);
  scene.others = draw_others(law, scene, draws);
  drawn.is_imageable = why_not_imageable(scene).empty();
  return drawn;
}

}  // namespace sightline
