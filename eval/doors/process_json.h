// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What questions to processes and their answers have in common: docs/external.md.
#pragma once

#include <span>
#include <string>

#include <Eigen/Core>

#include "eval/doors/trial_name.h"
#include "eval/output/json.h"
#include "pose/camera.h"
#include "pose/pose.h"

namespace sightline {

/// A question's kind, and the trial and picture that it is about.
Json question_about(const char* type, const TrialName& trial);

Json json_of(const Camera& camera);
Json json_of(const Pose& pose);
/// Row by row.
Json json_of(const Eigen::Ref<const Eigen::MatrixXd>& matrix);
/// Its coordinates.
Json json_of_point(const Eigen::Ref<const Eigen::VectorXd>& point);

/// A number. These throw BadAnswer where what is asked for is missing or not so.
double number_at(const Json& json, const char* key);
Eigen::VectorXd vector_at(const Json& json, const char* key, int size);
Eigen::MatrixXd square_matrix_at(const Json& json, const char* key, int size);
/// A symmetric, positive definite matrix.
Eigen::MatrixXd covariance_at(const Json& json, const char* key, int size);
/// The place of a name in a list of them.
size_t place_of(const std::string& name, std::span<const std::string> names);

}  // namespace sightline
