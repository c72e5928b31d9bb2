// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// extract/<extractor>: all features of a 707 that the extractor can look for, in one frame;
// extract/<extractor>/cube: the cube's vertices; the counter us_per_window is per feature looked
// for. pipeline/<target>: whole trials, from drawn
// scene to errors: render 512 x 512 at 16 samples a pixel, extract in two passes, solve.
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>

#include "eval/benchmarks/benches.h"
#include "eval/study/study_file.h"
#include "eval/trial/image_trial.h"
#include "features/extractor.h"
#include "features/prediction.h"
#include "renderer/renderer.h"
#include "scenes/scene/scene_law.h"

namespace sightline {
namespace {

constexpr int kFrames = 32;

Study study_of(const std::string& target) {
  if (target == "cube") {
    return read_study("feature-localisation", {.trials = 100, .seed = 1, .set = {"sweep={}"}});
  }
  return read_study("outlier-impact",
                    {.trials = 100,
                     .seed = 1,
                     .set = {"sweep={}", "solver.inputs=[]", "solvers=['orpe_weighed']"}});
}

// A frame and what a prior pose expects in it.
struct ExtractionCase {
  cv::Mat image;
  PredictedView view;
};

std::vector<ExtractionCase> cases_for(const Study& of_seed, const FeatureExtractor& extractor) {
  const ImageStudy& study = *of_seed.images();
  const uint64_t seed = of_seed.seed;
  const ImageSetup& setup = study.setups.front();
  std::vector<int> features;
  for (const int feature : study.features) {
    if (extractor.finds(study.target->features[static_cast<size_t>(feature)].kind)) {
      features.push_back(feature);
    }
  }
  Renderer renderer;
  std::vector<ExtractionCase> cases;
  for (int i = 0; i < kFrames; ++i) {
    const Scene scene = draw_scene(setup.scene, 0, seed, i).scene;
    RandomStream prior_stream(seed, "prior", static_cast<uint64_t>(i));
    const Pose prior = draw_prior(scene.cam_from_target, scene.camera, setup.prior, prior_stream);
    cases.push_back(
        {renderer.render(scene, RandomStream(seed, "sensor", static_cast<uint64_t>(i))).image,
         predict_features(*study.target, features, scene.camera,
                          prior_of(prior, scene.camera, setup.prior))});
  }
  return cases;
}

void run_extractor(benchmark::State& state, const FeatureExtractor& extractor,
                   const std::string& target) {
  const Study study = study_of(target);
  const std::vector<ExtractionCase> cases = cases_for(study, extractor);
  const ExtractorChoice choice{&extractor, &extractor, &extractor};
  int64_t windows = 0;
  size_t next = 0;
  const int64_t begin = cv::getTickCount();
  for (auto _ : state) {
    const ExtractionCase& frame = cases[next];
    next = (next + 1) % cases.size();
    const std::vector<Observation> observations = extract_features(
        frame.image, 255, frame.view, choice, study.images()->setups.front().extractor_options);
    for (const Observation& observation : observations) {
      windows += observation.status != ObservationStatus::kHidden &&
                 observation.status != ObservationStatus::kOutsideImage;
    }
  }
  const double seconds = static_cast<double>(cv::getTickCount() - begin) / cv::getTickFrequency();
  state.counters["us_per_window"] = 1e6 * seconds / static_cast<double>(windows);
}

void run_pipeline(benchmark::State& state, const std::string& target) {
  const Study study = study_of(target);
  Renderer renderer;
  int64_t trial = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(run_image_trial(*study.images(), study.seed, trial, renderer));
    trial = (trial + 1) % study.trial_count();
  }
  state.counters["frames_per_s"] =
      benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

}  // namespace

void register_pipeline() {
  for (const FeatureExtractor& extractor : feature_extractors()) {
    for (const std::string target : {"boeing707", "cube"}) {
      const std::string name =
          "extract/" + std::string(extractor.name) + (target == "cube" ? "/cube" : "");
      benchmark::RegisterBenchmark(name.c_str(), [&extractor, target](benchmark::State& state) {
        run_extractor(state, extractor, target);
      })->Unit(benchmark::kMicrosecond);
    }
  }
  for (const std::string target : {"cube", "boeing707"}) {
    const std::string name = "pipeline/" + target;
    benchmark::RegisterBenchmark(name.c_str(), [target](benchmark::State& state) {
      run_pipeline(state, target);
    })->Unit(benchmark::kMillisecond);
  }
}

}  // namespace sightline
