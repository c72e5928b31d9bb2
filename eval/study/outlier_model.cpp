// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/study/outlier_model.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "eval/output/json.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

std::vector<OutlierModel::Failure> failures_of(const TrialRecord& trial) {
  std::vector<OutlierModel::Failure> failures;
  for (const ObservationRecord& o : trial.observations()) {
    if (o.is_outlier) failures.push_back({o.feature, false, o.pixel - o.true_pixel});
    if (!o.is_found() && o.is_visible) failures.push_back({o.feature, true, {0, 0}});
  }
  return failures;
}

OutlierModel::Failure failure_from(const Json& json, const std::vector<std::string>& features) {
  const bool has_index = json.is_array() && (json.size() == 1 || json.size() == 3) &&
                         json[0].is_number_unsigned() && json[0].get<size_t>() < features.size();
  if (!has_index) {
    throw InputError(fmt::format("a failure is {}, must be [feature] or [feature, du, dv]",
                                 json.dump().substr(0, 40)));
  }
  OutlierModel::Failure failure;
  failure.feature = features[json[0].get<size_t>()];
  failure.is_missing = json.size() == 1;
  if (failure.is_missing) return failure;
  const std::vector<double> numbers = finite_numbers(json, "a failure", 3);
  failure.displacement_px = {numbers[1], numbers[2]};
  return failure;
}

}  // namespace

OutlierModel outlier_model_of(std::span<const TrialRecord> trials) {
  OutlierModel model;
  for (const TrialRecord& trial : trials) {
    if (trial.observations().empty()) continue;
    if (model.trials.size() == kMostModelTrials) break;
    model.trials.push_back(failures_of(trial));
  }
  return model;
}

std::string to_json(const OutlierModel& model, const std::string& study) {
  std::vector<std::string> features;
  const auto index_of = [&features](const std::string& name) {
    const auto found = std::find(features.begin(), features.end(), name);
    if (found != features.end()) return found - features.begin();
    features.push_back(name);
    return std::ssize(features) - 1;
  };
  Json trials = Json::array();
  for (const auto& failures : model.trials) {
    Json row = Json::array();
    for (const OutlierModel::Failure& failure : failures) {
      Json entry = {index_of(failure.feature)};
      if (!failure.is_missing) {
        entry.push_back(failure.displacement_px.x());
        entry.push_back(failure.displacement_px.y());
      }
      row.push_back(entry);
    }
    trials.push_back(row);
  }
  return Json{{"study", study}, {"features", features}, {"trials", trials}}.dump() + "\n";
}

OutlierModel read_outlier_model(const std::filesystem::path& file) {
  OutlierModel model;
  try {
    with_json(file, [&model](const Json& json) {
      const auto features = value_in(json, "features").get<std::vector<std::string>>();
      for (const Json& row : value_in(json, "trials")) {
        auto& failures = model.trials.emplace_back();
        for (const Json& entry : row) failures.push_back(failure_from(entry, features));
      }
    });
  } catch (const InputError& error) {
    throw InputError(fmt::format("{} (it is not an outliers.json)", error.what()));
  }
  if (model.trials.empty()) {
    throw InputError(fmt::format("{}: holds no trials", file.string()));
  }
  return model;
}

}  // namespace sightline
