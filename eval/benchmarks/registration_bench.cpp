// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// registration/<target>: a mesh laid on frames of 512 x 512 from the prior, from blurred to sharp;
// registration/<target>/near: from a pose 0.3 px off, as features give, on the sharp image alone.
#include <optional>
#include <string>

#include <benchmark/benchmark.h>

#include "eval/benchmarks/benches.h"
#include "eval/benchmarks/registration_frames.h"
#include "registration/registration.h"

namespace sightline {
namespace {

constexpr int kFrames = 16;

void run_registration(benchmark::State& state, const std::string& target, bool is_near) {
  const FramedTarget shown = rendered_frames(target, kFrames);
  RegistrationOptions options;
  options.noise_sd_grey = 3;
  size_t next = 0;
  double drawings = 0;
  for (auto _ : state) {
    const ShownFrame& frame = shown.frames[next];
    RegistrationTask task{shown.mesh,  frame.camera, frame.image, 255, drawn_prior(shown, next, 1),
                          std::nullopt};
    if (is_near) {
      task.start = frame.cam_from_target;
      task.start->translation.x() += 0.3 * task.start->translation.z() / frame.camera.fx_px;
    }
    next = (next + 1) % shown.frames.size();
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
