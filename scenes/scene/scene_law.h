// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "scenes/files/toml_table.h"
#include "scenes/scene/poses.h"
#include "scenes/scene/scene.h"
#include "scenes/target/target.h"

namespace sightline {

/// What the frames of a study's cell or of an image set have in common, and what is drawn for each:
/// the tables [camera], [poses], [image], [background], [noise], [light], [environment], [livery],
/// [material], [motion], [optics], [[lamp]] and [[other]] of a scene file. Each part is read and
/// drawn in a file of its own.
struct SceneLaw {
  std::shared_ptr<const Target> target;
  std::vector<int> features;  ///< indices into the target's; drawn poses keep them in the image
  Camera camera;
  PoseLaw poses;
  std::vector<OtherLaw> others;
  LightLaw light;
  std::vector<LampLaw> lamps;
  EnvironmentLaw environment;
  BackgroundLaw background;
  LiveryLaw livery;
  MaterialLaw materials;
  MotionLaw motion;
  OpticsLaw optics;
  SensorLaw sensor;
  ColouringLaw colouring;
  int samples_per_pixel = kSamplesPerPixel;
};

/// Reads and checks the law from a file's tables. `target` and `features` are not keys of its own
/// tables: the caller has read them. Throws InputError.
SceneLaw read_scene_law(const TomlTable& table, std::shared_ptr<const Target> target,
                        std::vector<int> features);

/// All keys of a scene's tables in words, table by table.
std::vector<KeyText> scene_keys();

/// A scene as drawn. The last draw stands when none has all features inside.
struct DrawnScene {
  Scene scene;
  int redraws = 0;
  bool is_imageable = true;  ///< false: why_not_imageable says why
};

/// The scene number `index` of a law. `given_pose` says which of the given poses; it means nothing
/// where poses are drawn. Every quantity has a random stream of its own: see Draws.
DrawnScene draw_scene(const SceneLaw& law, int given_pose, uint64_t seed, int64_t index);

/// Reads what a scene draws of the folders that its keys name, unless `checked` has it already: a
/// file that is torn is found before any frame is made. Throws InputError, naming the key.
void check_drawn_files(const SceneLaw& law, uint64_t seed, int64_t index, CheckedFiles& checked);

}  // namespace sightline
