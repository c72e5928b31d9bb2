// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/solve/answers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/output/json.h"
#include "pose/angles.h"
#include "pose/lines/joint.h"

namespace sightline {
namespace {

constexpr double kHalfWidth95 = 1.959963984540054;  // of a Gaussian's 95 % interval, in sigmas

// The covariance of (w, dt), radians and metres, as far as the estimate and the noise tell.
std::optional<Matrix6d> covariance_of(const PoseProblem& problem, const PoseEstimate& estimate) {
  if (estimate.covariance) return estimate.covariance;
  const bool is_in_sigmas = !problem.covariances_px2.empty();
  if (!is_in_sigmas && problem.sigma_px <= 0) return std::nullopt;
  const double variance = is_in_sigmas ? 1 : problem.sigma_px * problem.sigma_px;
  const Matrix6d covariance = variance * estimate.unit_covariance;
  if (covariance.isZero(0) || !covariance.allFinite()) return std::nullopt;
  return covariance;
}

// "x  1.234 +- 0.056 m" in columns.
std::string row(const char* name, double value, const std::optional<Matrix6d>& covariance,
                int index, double unit, const char* unit_name) {
  std::string text = fmt::format("  {:<22}{:>14.6f}", name, value);
  if (covariance) {
    text +=
        fmt::format("  +- {:.2g}", kHalfWidth95 * std::sqrt((*covariance)(index, index)) / unit);
  }
  return text + fmt::format(" {}\n", unit_name);
}

std::string pose_rows(const char* title, const Pose& pose,
                      const std::optional<Matrix6d>& covariance) {
  const Eigen::Vector4d q = quaternion_wxyz(pose.rotation);
  const Eigen::Vector3d w = vector_from_rotation(pose.rotation) / kDegree;
  const Eigen::Vector3d& t = pose.translation;
  std::string text = fmt::format("{}{}\n", title, covariance ? ", with 95 % intervals" : "");
  text += fmt::format("  {:<22}[{:.9f}, {:.9f}, {:.9f}, {:.9f}]\n", "quaternion w x y z", q[0],
                      q[1], q[2], q[3]);
  constexpr std::array kTurns = {"rotation vector x", "rotation vector y", "rotation vector z"};
  constexpr std::array kMoves = {"translation x", "translation y", "translation z"};
  for (int i = 0; i < 3; ++i) text += row(kTurns[i], w[i], covariance, i, kDegree, "deg");
  for (int i = 0; i < 3; ++i) text += row(kMoves[i], t[i], covariance, 3 + i, 1, "m");
  return text;
}

std::string list_row(const char* name, const std::vector<int>& points) {
  if (points.empty()) return "";
  constexpr size_t kMost = 20;
  const auto end = points.begin() + static_cast<std::ptrdiff_t>(std::min(points.size(), kMost));
  return fmt::format("  {:<22}{} ({}{})\n", name, points.size(),
                     fmt::join(points.begin(), end, ", "), points.size() > kMost ? ", ..." : "");
}

Json matrix_json(const Matrix6d& matrix) {
  Json rows = Json::array();
  for (int i = 0; i < 6; ++i) {
    rows.push_back(std::vector<double>(matrix.row(i).begin(), matrix.row(i).end()));
  }
  return rows;
}

Json pose_json(const Pose& pose) {
  const Eigen::Vector4d q = quaternion_wxyz(pose.rotation);
  return {{"quaternion_wxyz", std::vector<double>(q.begin(), q.end())},
          {"translation_m", std::vector<double>(pose.translation.begin(), pose.translation.end())}};
}

template <typename Value>
void put(Json& json, const char* key, const std::optional<Value>& value) {
  if (value) json[key] = *value;
}

// What should keep a reader from trusting the pose; a line each.
std::string warnings(const PoseEstimate& estimate) {
  const Diagnosis diagnosis = estimate.diagnosis.value_or(Diagnosis{});
  std::string text;
  if (diagnosis.is_ambiguous.value_or(false)) {
    text += "warning: another pose explains the points nearly as well\n";
    if (estimate.second_cam_from_target) {
      text += pose_rows("the other pose", *estimate.second_cam_from_target, std::nullopt);
    }
  }
  if (!diagnosis.is_significant.value_or(true)) {
    text += "warning: so few points agree on this pose that chance may have made it\n";
  }
  if (diagnosis.is_test_failed.value_or(false)) {
    text += "warning: the residuals do not look like noise\n";
  }
  return text;
}

// The root mean square of a minimum's residuals, in each coordinate.
double residual_rms(const PoseProblem& problem, const PoseMinima& minima,
                    const std::vector<int>& left_out, const PoseMinimum& minimum) {
  const size_t kept = problem.pixels.size() - minima.ignored.size() - left_out.size();
  return std::sqrt(minimum.cost / (2 * static_cast<double>(kept)));
}

}  // namespace

std::string text_of(const PoseProblem& problem, const PoseEstimate& estimate) {
  const std::string ignored = list_row("points unusable", estimate.ignored) +
                              list_row("lines unusable", estimate.ignored_lines);
  if (estimate.status != PoseStatus::kOk) {
    const bool is_too_many = estimate.status == PoseStatus::kTooManyPoints;
    return fmt::format(
        "no pose: {}\n{}{}", to_string(estimate.status), ignored,
        is_too_many ? "consensus and orpe_consensus take any number of points\n" : "");
  }
  std::string text = pose_rows("cam_from_target (camera x right, y down, z forward)",
                               estimate.cam_from_target, covariance_of(problem, estimate));
  const size_t all = problem.points_in_target.size();
  text += fmt::format("  {:<22}{} of {}\n", "points kept",
                      all - estimate.removed.size() - estimate.ignored.size(), all);
  text += list_row("points removed", estimate.removed);
  if (!problem.lines.empty()) {
    const size_t lines = problem.lines.size();
    text +=
        fmt::format("  {:<22}{} of {}\n", "lines kept",
                    lines - estimate.removed_lines.size() - estimate.ignored_lines.size(), lines);
  }
  text += list_row("lines removed", estimate.removed_lines) + ignored;
  const bool is_in_sigmas = !problem.lines.empty() && lines::is_noise_known(problem);
  const char* const unit = is_in_sigmas ? "sigma" : "px";
  if (estimate.noise_px) {
    text += fmt::format("  {:<22}{:.4g} {}\n", "noise", *estimate.noise_px, unit);
  }
  if (estimate.residual_rms_px) {
    text += fmt::format("  {:<22}{:.4g} {}\n", "residuals, rms", *estimate.residual_rms_px, unit);
  }
  return text + warnings(estimate);
}

std::string json_of(const PoseProblem& problem, const PoseEstimate& estimate) {
  Json json = {{"status", to_string(estimate.status)}, {"ignored", estimate.ignored}};
  if (!problem.lines.empty()) json["ignored_lines"] = estimate.ignored_lines;
  if (estimate.status == PoseStatus::kOk) {
    const Diagnosis diagnosis = estimate.diagnosis.value_or(Diagnosis{});
    json["cam_from_target"] = pose_json(estimate.cam_from_target);
    json["removed"] = estimate.removed;
    if (const auto covariance = covariance_of(problem, estimate)) {
      json["covariance_rad_m"] = matrix_json(*covariance);
    }
    if (!problem.lines.empty()) json["removed_lines"] = estimate.removed_lines;
    put(json, "inlier_probabilities", estimate.inlier_probabilities);
    put(json, "noise_px", estimate.noise_px);
    put(json, "residual_rms_px", estimate.residual_rms_px);
    put(json, "is_ambiguous", diagnosis.is_ambiguous);
    put(json, "is_significant", diagnosis.is_significant);
    put(json, "is_test_failed", diagnosis.is_test_failed);
    if (estimate.second_cam_from_target) {
      json["second_cam_from_target"] = pose_json(*estimate.second_cam_from_target);
    }
  }
  return json_text(json);
}

std::string text_of(const PoseProblem& problem, const PoseMinima& minima,
                    const std::vector<int>& left_out) {
  const std::string lists =
      list_row("points removed", left_out) + list_row("points unusable", minima.ignored);
  if (minima.status != PoseStatus::kOk) {
    return fmt::format("no pose: {}\n{}", to_string(minima.status), lists);
  }
  std::string text;
  for (size_t i = 0; i < minima.minima.size(); ++i) {
    const PoseMinimum& minimum = minima.minima[i];
    const std::string title = fmt::format("cam_from_target, {} of {}", i + 1, minima.minima.size());
    text += pose_rows(title.c_str(), minimum.cam_from_target, std::nullopt);
    text += fmt::format("  {:<22}{:.4g} {}\n", "residuals, rms",
                        residual_rms(problem, minima, left_out, minimum),
                        problem.covariances_px2.empty() ? "px" : "sigma");
  }
  return text + lists;
}

std::string json_of(const PoseProblem& problem, const PoseMinima& minima,
                    const std::vector<int>& left_out) {
  Json json = {{"status", to_string(minima.status)},
               {"ignored", minima.ignored},
               {"removed", left_out},
               {"poses", Json::array()}};
  for (const PoseMinimum& minimum : minima.minima) {
    json["poses"].push_back(
        {{"cam_from_target", pose_json(minimum.cam_from_target)},
         {"cost", minimum.cost},
         {"residual_rms_px", residual_rms(problem, minima, left_out, minimum)}});
  }
  return json_text(json);
}

std::string text_of(const RobustAlignment& alignment) {
  const std::string ignored = list_row("pairs unusable", alignment.ignored);
  if (alignment.status != OrientationStatus::kOk) {
    return fmt::format("no alignment: {}\n{}", to_string(alignment.status), ignored);
  }
  std::string text = pose_rows("b_from_a", alignment.b_from_a, alignment.covariance);
  if (alignment.scale_sd > 0) {
    text += fmt::format("  {:<22}{:>14.6f}  +- {:.2g}\n", "scale", alignment.scale,
                        kHalfWidth95 * alignment.scale_sd);
  }
  const size_t all = alignment.residuals_m.size();
  text += fmt::format("  {:<22}{} of {}\n", "pairs kept",
                      all - alignment.removed.size() - alignment.ignored.size(), all);
  text += list_row("pairs removed", alignment.removed) + ignored;
  text += fmt::format("  {:<22}{:.4g} m\n", "noise", alignment.sigma_m);
  text += fmt::format("  {:<22}{:.4g} m\n", "residuals, rms", alignment.residual_rms_m);
  if (!alignment.is_significant) {
    text += "warning: so few pairs agree that chance may have made it\n";
  }
  return text;
}

std::string json_of(const RobustAlignment& alignment) {
  Json json = {{"status", to_string(alignment.status)}, {"ignored", alignment.ignored}};
  if (alignment.status == OrientationStatus::kOk) {
    json["b_from_a"] = pose_json(alignment.b_from_a);
    json["scale"] = alignment.scale;
    json["scale_sd"] = alignment.scale_sd;
    json["removed"] = alignment.removed;
    json["covariance_rad_m"] = matrix_json(alignment.covariance);
    json["inlier_probabilities"] = alignment.inlier_probabilities;
    json["residuals_m"] = alignment.residuals_m;
    json["residual_rms_m"] = alignment.residual_rms_m;
    json["noise_m"] = alignment.sigma_m;
    json["is_significant"] = alignment.is_significant;
  }
  return json_text(json);
}

}  // namespace sightline
