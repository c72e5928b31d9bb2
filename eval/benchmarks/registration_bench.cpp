// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// registration/<target>: a mesh laid on frames of 512 x 512 from the prior, from blurred to sharp;
// registration/<target>/near: from a pose 0.3 px off, as features give, on the sharp image alone.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "eval/benchmarks/benches.h"
#include "eval/study/study_file.h"
#include "registration/registration.h"
#include "renderer/renderer.h"

namespace sightline {
namespace {

constexpr int kFrames = 16;

struct ShownFrame {
  Camera camera;
  cv::Mat image;
  PosePrior prior;
  Pose near_truth;
};

Study study_of(const std::string& target) {
  const char* const name = target == "cube" ? "feature-localisation" : "boeing-random";
  return read_study(name, {.trials = kFrames, .seed = 1, .set = {"sweep={}"}});
}

std::vector<ShownFrame> frames_of(const Study& study) {
  const ImageSetup& setup = study.images()->setups.front();
  Renderer renderer;
  std::vector<ShownFrame> frames;
  for (uint64_t i = 0; i < kFrames; ++i) {
    const Scene scene = draw_scene(setup.scene, 0, study.seed, static_cast<int64_t>(i)).scene;
    RandomStream stream(study.seed, "prior", i);
    const Pose prior = draw_prior(scene.cam_from_target, scene.camera, setup.prior, stream);
    Pose near_truth = scene.cam_from_target;
    near_truth.translation.x() += 0.3 * near_truth.translation.z() / scene.camera.fx_px;
    frames.push_back({scene.camera,
                      renderer.render(scene, RandomStream(study.seed, "sensor", i)).image,
                      prior_of(prior, scene.camera, setup.prior), near_truth});
  }
  return frames;
}

void run_registration(benchmark::State& state, const std::string& target, bool is_near) {
  const Study study = study_of(target);
  const std::vector<ShownFrame> frames = frames_of(study);
  const Mesh& mesh = study.images()->target->mesh;
  RegistrationOptions options;
  options.noise_sd_grey = 3;
  size_t next = 0;
  double drawings = 0;
  for (auto _ : state) {
    const ShownFrame& frame = frames[next];
    next = (next + 1) % frames.size();
    RegistrationTask task{mesh, frame.camera, frame.image, 255, frame.prior, std::nullopt};
    if (is_near) task.start = frame.near_truth;
    drawings += register_mesh(task, options).drawings;
  }
  state.counters["drawings"] = drawings / static_cast<double>(state.iterations());
}

}  // namespace

void register_registration() {
  for (const std::string target : {"boeing707", "cube"}) {
    for (const bool is_near : {false, true}) {
      const std::string name = "registration/" + target + (is_near ? "/near" : "");
      benchmark::RegisterBenchmark(name.c_str(), [target, is_near](benchmark::State& state) {
        run_registration(state, target, is_near);
      })->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace sightline
