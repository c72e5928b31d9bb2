// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "eval/doors/trial_name.h"
#include "eval/records/names.h"
#include "features/observation.h"
#include "features/prediction.h"

namespace sightline {

class ExternalProcess;

/// What a guest is asked to find in one image.
struct ExtractorQuestion {
  const cv::Mat& image;       ///< CV_8U or CV_16U
  double white;               ///< the image's greatest possible value
  const PredictedView& view;  ///< camera, and where the prior expects each feature
  TrialName trial;
  std::filesystem::path picture = {};  ///< the image's file in a data set; empty: it is rendered
};

/// What it found: an observation a feature of the view, in their order; or why the trial failed.
struct ExtractorAnswer {
  std::vector<Observation> observations;
  std::optional<EstimateOutcome> problem;
};

/// Who finds features in the images of a study in place of the program's own extractors: a file of
/// observations, a process, a function of whoever embeds the program. It is asked once an image;
/// passes of extraction and the removal of bias are for the program's own.
struct TrialExtractor {
  std::string name;
  std::string summary;  ///< for the report: where its observations come from, how sure they are
  std::function<ExtractorAnswer(const ExtractorQuestion&)> extract;
  /// That answers; null: none does. Only a run may ask it (eval/doors/external_process.h).
  std::shared_ptr<ExternalProcess> process = nullptr;
};

/// Observations of the view's features that have found nothing yet (status kMissing), with what
/// reports show of the prediction.
std::vector<Observation> missing_observations(const PredictedView& view);

}  // namespace sightline
