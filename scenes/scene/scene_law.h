// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenes/files/toml_table.h"
#include "scenes/scene/scene.h"
#include "scenes/target/target.h"

namespace sightline {

/// The range a quantity is drawn from, uniformly; a single value where its ends are equal.
struct Range {
  double min = 0;
  double max = 0;

  double draw(RandomStream& stream) const { return stream.uniform(min, max); }
};

/// A pose that is given, or the ranges that poses are drawn from (uniform, in the file's units).
struct PoseLaw {
  /// One pose each; empty where poses are drawn. Pitch, yaw, roll in degrees; metres.
  std::vector<Eigen::Vector3d> theta_deg;
  std::vector<Eigen::Vector3d> t_m;
  /// Added to both lateral coordinates of a given pose, uniform in +-.
  double lateral_jitter_m = 0;
  bool is_attitude_uniform = false;  ///< uniform on SO(3), and drawn_angle_deg means nothing
  /// Of a uniform attitude: the angle between the target's z axis and the camera's, where given.
  std::optional<Range> tilt_deg;
  Range drawn_angle_deg;  ///< each of the three angles
  Range drawn_lateral_m;  ///< x and y of the target's origin
  Range drawn_range_m;    ///< z of the target's origin
  int max_redraws = 100;  ///< of a drawn pose with a feature outside the image
};

/// How bodies beside the main target are placed: `count` times, each by draws of its own.
struct OtherLaw {
  std::shared_ptr<const Target> target;
  bool is_occluder = true;
  int count = 1;
  Range offset_px{-100, 100};       ///< of its origin from the main target's, in u and in v
  Range range_fraction{0.8, 0.95};  ///< of its z to the main target's
  std::optional<Range> angle_deg;   ///< each of its three angles; none: uniform on SO(3)
};

/// What the frames of a study's cell or of an image set have in common, and what is drawn for each:
/// the tables [camera], [poses], [image], [background], [noise], [light], [livery], [motion] and
/// [[other]] of a scene file. A quantity that is a Range may be a number or [low, high] there.
struct SceneLaw {
  std::shared_ptr<const Target> target;
  std::vector<int> features;  ///< indices into the target's; drawn poses keep them in the image
  Camera camera;
  PoseLaw poses;
  std::vector<OtherLaw> others;

  Range ambient, directional, specular, shininess;
  double light_cone_deg = 45;  ///< the light's direction is uniform about that to the camera ...
  std::optional<Range> light_phase_deg;  ///< ... or at this angle from it,
  Range light_azimuth_deg;               ///< towards this side; 0 is image right, 90 down
  bool casts_shadow = false;

  BackgroundKind background_kind = BackgroundKind::kUniform;
  Range background_level, background_contrast, background_angle_deg, cloud_px, stars_per_megapixel;
  std::shared_ptr<const std::vector<float>> picture;
  int picture_width = 0;

  Range stripe_contrast, stripe_m;
  Range motion_rotation_deg;  ///< turned during the exposure, about a uniform axis
  Range motion_shift_px;      ///< of the target's origin, to a uniform side
  int motion_samples = 9;

  Range psf_sigma_px, gain, read_noise_grey, full_well_electrons, dead_fraction, hot_fraction;
  double noise_scale = 1;  ///< multiplies the applied noise
  int bits = 8;
  bool is_srgb = false;
  int samples_per_pixel = 16;
};

/// Reads and checks the law from a file's tables. `target` and `features` are not keys of its own
/// tables: the caller has read them. Throws InputError.
SceneLaw read_scene_law(const TomlTable& table, std::shared_ptr<const Target> target,
                        std::vector<int> features);

/// The camera of [camera]: `width_px`, `height_px`, `f_px`, and optionally `principal_point_px` and
/// `distortion` = [k1, k2, p1, p2, k3].
Camera read_camera(const TomlTable& table);

/// [low, high] within the allowed interval.
Range read_range(const TomlTable& table, std::string_view key, Interval allowed);

/// The ranges of [poses] but for the angles.
void read_position_ranges(const TomlTable& poses, PoseLaw& law);

/// cam_from_target of an attitude in degrees (pitch, yaw, roll) and a translation.
Pose pose_from(const Eigen::Vector3d& theta_deg, const Eigen::Vector3d& t_m);

/// A pose of the law's ranges.
Pose drawn_pose(const PoseLaw& law, RandomStream& stream);

/// A scene as drawn. The last draw stands when none has all features inside.
struct DrawnScene {
  Scene scene;
  int redraws = 0;
  bool is_imageable = true;  ///< false: why_not_imageable says why
};

/// The scene number `index` of a law. `given_pose` says which of the given poses; it means nothing
/// where poses are drawn. Every quantity has a random stream of its own, keyed by (seed, its name,
/// index), so that widening one range leaves all other draws as they were.
DrawnScene draw_scene(const SceneLaw& law, int given_pose, uint64_t seed, int64_t index);

}  // namespace sightline
