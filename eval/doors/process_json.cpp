// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/doors/process_json.h"

#include <algorithm>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "eval/doors/external_process.h"
#include "pose/lenses/catalogue.h"

namespace sightline {

Json question_about(const char* type, const TrialName& trial) {
  return {{"type", type},         {"id", 0},
          {"trial", trial.trial}, {"scene_id", trial.scene_id},
          {"im_id", trial.im_id}, {"gt_id", trial.gt_id}};
}

Json json_of(const Camera& camera) {
  const LensModel& model = model_of(camera.lens);
  const std::vector<double> coefficients = coefficients_of(camera.lens);
  Json json = {{"width_px", camera.width_px}, {"height_px", camera.height_px},
               {"fx_px", camera.fx_px},       {"fy_px", camera.fy_px},
               {"cx_px", camera.cx_px},       {"cy_px", camera.cy_px}};
  // Whoever knows no other lens is told of the one that most cameras have as ever.
  if (camera.skew_px != 0) json["skew_px"] = camera.skew_px;
  if (!std::holds_alternative<BrownConrady>(camera.lens)) json["lens"] = model.name;
  for (size_t i = 0; i < coefficients.size(); ++i) json[model.coefficients[i]] = coefficients[i];
  return json;
}

Json json_of(const Pose& pose) {
  return {{"rotation", json_of(pose.rotation)}, {"translation_m", json_of_point(pose.translation)}};
}

Json json_of(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    rows.push_back(json_of_point(matrix.row(i).transpose()));
  }
  return rows;
}

Json json_of_point(const Eigen::Ref<const Eigen::VectorXd>& point) {
  Json numbers = Json::array();
  for (const double number : point) numbers.push_back(number);
  return numbers;
}

double number_at(const Json& json, const char* key) {
  if (json.contains(key) && json[key].is_number()) return json[key].get<double>();
  throw BadAnswer(fmt::format("has no number {}", key));
}

Eigen::VectorXd vector_at(const Json& json, const char* key, int size) {
  if (!json.contains(key) || !json[key].is_array() ||
      json[key].size() != static_cast<size_t>(size)) {
    throw BadAnswer(fmt::format("has no {} of {} numbers", key, size));
  }
  Eigen::VectorXd vector(size);
  for (int i = 0; i < size; ++i) vector[i] = json[key][static_cast<size_t>(i)].get<double>();
  return vector;
}

Eigen::MatrixXd square_matrix_at(const Json& json, const char* key, int size) {
  const auto is_row = [size](const Json& row) {
    return row.is_array() && row.size() == static_cast<size_t>(size);
  };
  if (!json.contains(key) || !is_row(json[key]) ||
      !std::all_of(json[key].begin(), json[key].end(), is_row)) {
    throw BadAnswer(fmt::format("has no {} of {} rows of {} numbers", key, size, size));
  }
  Eigen::MatrixXd matrix(size, size);
  for (int i = 0; i < size; ++i) {
    const Json& row = json[key][static_cast<size_t>(i)];
    for (int j = 0; j < size; ++j) matrix(i, j) = row[static_cast<size_t>(j)].get<double>();
  }
  return matrix;
}

Eigen::MatrixXd covariance_at(const Json& json, const char* key, int size) {
  constexpr double kTolerance = 1e-6;  // of what few printed digits leave of symmetry
  const Eigen::MatrixXd given = square_matrix_at(json, key, size);
  if (!(given.diagonal().minCoeff() > 0)) {
    throw BadAnswer(fmt::format("has a {} with a variance that is not positive", key));
  }
  // In comparable units, for the sake of rounding: radians stand beside metres.
  const Eigen::VectorXd scale = given.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd correlation = scale.asDiagonal() * given * scale.asDiagonal();
  const Eigen::MatrixXd mirrored = correlation.transpose();
  if (!((correlation - mirrored).cwiseAbs().maxCoeff() <= kTolerance)) {
    throw BadAnswer(fmt::format("has a {} that is not symmetric", key));
  }
  if (Eigen::LLT<Eigen::MatrixXd>(correlation).info() != Eigen::Success) {
    throw BadAnswer(fmt::format("has a {} that is not positive definite", key));
  }
  return (given + given.transpose()) / 2;
}

size_t place_of(const std::string& name, std::span<const std::string> names) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<size_t>(found - names.begin());
  throw BadAnswer(fmt::format("names the feature '{}', which the question does not have", name));
}

}  // namespace sightline
