// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/benchmarks/registration_frames.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "eval/datasets/pictures.h"
#include "eval/datasets/sightings.h"
#include "eval/study/study_file.h"
#include "renderer/renderer.h"
#include "scenes/files/input_error.h"
#include "scenes/target/target.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

FramedTarget photographs_of(const fs::path& set) {
  const auto target = load_target((set / "models" / "obj_000001.ply").string(),
                                  {.forward = "+x", .up = "-z", .unit = "mm"});
  SightingSource source;
  source.folder = set;
  FramedTarget shown = {set.filename().string(), target->mesh, PriorError{}, true};
  for (const Sighting& sighting : read_sightings(source, target).sightings) {
    shown.frames.push_back(
        {sighting.camera, read_grey_picture(sighting.picture), sighting.cam_from_target});
  }
  return shown;
}

}  // namespace

FramedTarget rendered_frames(const std::string& target, int count) {
  const char* const name = target == "cube" ? "feature-localisation" : "boeing-random";
  const Study study = read_study(name, {.trials = count, .seed = 1, .set = {"sweep={}"}});
  const ImageSetup& setup = study.images()->setups.front();
  FramedTarget shown = {target, study.images()->target->mesh, setup.prior, false};
  Renderer renderer;
  for (int i = 0; i < count; ++i) {
    const Scene scene = draw_scene(setup.scene, 0, study.seed, i).scene;
    const RandomStream sensor(study.seed, "sensor", static_cast<uint64_t>(i));
    shown.frames.push_back(
        {scene.camera, renderer.render(scene, sensor).image, scene.cam_from_target});
  }
  return shown;
}

std::vector<FramedTarget> photographs() {
  const char* const folder = std::getenv("SIGHTLINE_TEST_REAL");
  if (folder == nullptr) return {};
  if (!fs::is_directory(folder)) {
    throw InputError(fmt::format("SIGHTLINE_TEST_REAL: {} is no folder", folder));
  }
  std::vector<fs::path> sets;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (fs::exists(entry.path() / "models")) sets.push_back(entry.path());
  }
  std::sort(sets.begin(), sets.end());
  std::vector<FramedTarget> shown;
  for (const fs::path& set : sets) shown.push_back(photographs_of(set));
  return shown;
}

PosePrior drawn_prior(const FramedTarget& target, size_t frame, uint64_t seed) {
  const ShownFrame& shown = target.frames[frame];
  RandomStream stream(seed, "prior", frame);
  return prior_of(draw_prior(shown.cam_from_target, shown.camera, target.prior, stream),
                  shown.camera, target.prior);
}

}  // namespace sightline
