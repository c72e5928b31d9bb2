// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/doors/trial_extractor.h"

namespace sightline {

std::vector<Observation> missing_observations(const PredictedView& view) {
  std::vector<Observation> observations;
  for (const FeaturePrediction& prediction : view.features) {
    Observation& observation = observations.emplace_back();
    observation.feature = prediction.feature;
    observation.status = ObservationStatus::kMissing;
    observation.predicted_px = prediction.pixel;
  }
  return observations;
}

}  // namespace sightline
