// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/target/image_bound_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "eval/output/json.h"
#include "eval/output/text_table.h"
#include "pose/angles.h"
#include "pose/bounds.h"
#include "registration/image_bound.h"

namespace sightline {
namespace {

constexpr size_t kKinds = std::size(kImageBoundKinds);

// Sums of squares over the scenes of a condition.
struct BoundSums {
  std::array<double, kKinds> theta{}, t{};
  std::array<int, kKinds> count{};

  void add(size_t kind, const std::optional<Matrix6d>& covariance, const Pose& pose) {
    if (!covariance) return;
    const PoseBound bound = pose_bound(*covariance, pose);
    if (!std::isfinite(bound.attitude_rms_rad)) return;
    theta[kind] += std::pow(bound.attitude_rms_rad / kDegree, 2);
    t[kind] += std::pow(100 * bound.translation_rms, 2);
    ++count[kind];
  }
};

ImageBoundRow row_of(const Study& study, int condition, int scenes, Renderer& renderer) {
  const ImageStudy& images = *study.images();
  BoundSums sums;
  ImageBoundRow row;
  row.label = study.conditions[static_cast<size_t>(condition)].label;
  for (int i = 0; i < scenes; ++i) {
    const int64_t draw =
        images.draw_of(i * static_cast<int64_t>(study.conditions.size()) + condition);
    const DrawnScene drawn =
        draw_scene(images.setup_of(condition).scene,
                   images.cells[static_cast<size_t>(condition)].pose, study.seed, draw);
    if (!drawn.is_imageable) continue;
    ++row.scenes;
    const ImageBounds bounds = image_bounds(drawn.scene, renderer);
    sums.add(0, bounds.known_light, drawn.scene.cam_from_target);
    sums.add(1, bounds.unknown_light, drawn.scene.cam_from_target);
    sums.add(2, bounds.outline, drawn.scene.cam_from_target);
  }
  row.determined = sums.count[1];
  for (size_t kind = 0; kind < kKinds; ++kind) {
    const bool is_known = sums.count[kind] > 0;
    const double none = std::numeric_limits<double>::quiet_NaN();
    row.theta_deg.push_back(is_known ? std::sqrt(sums.theta[kind] / sums.count[kind]) : none);
    row.t_percent.push_back(is_known ? std::sqrt(sums.t[kind] / sums.count[kind]) : none);
  }
  return row;
}

// A bar whose length is the logarithm of the value over the least of all.
std::string bar_of(double value, double least, double greatest) {
  constexpr int kLongest = 24;
  if (!std::isfinite(value)) return "";
  const double share = greatest > least ? std::log(value / least) / std::log(greatest / least) : 0;
  return std::string(1 + static_cast<size_t>(std::lround(share * (kLongest - 1))), '#');
}

}  // namespace

std::vector<ImageBoundRow> image_bound_rows(const Study& study, int scenes) {
  Renderer renderer;
  std::vector<ImageBoundRow> rows;
  for (size_t condition = 0; condition < study.conditions.size(); ++condition) {
    rows.push_back(row_of(study, static_cast<int>(condition), scenes, renderer));
  }
  return rows;
}

std::string image_bound_table(const std::string& title, const std::vector<ImageBoundRow>& rows) {
  double least = std::numeric_limits<double>::infinity(), greatest = 0;
  for (const ImageBoundRow& row : rows) {
    if (!std::isfinite(row.theta_deg[1])) continue;
    least = std::min(least, row.theta_deg[1]);
    greatest = std::max(greatest, row.theta_deg[1]);
  }
  std::vector<std::string> labels;
  TextColumn scenes{"scenes", {}}, unknown_light{"theta / °", {}}, bars{"", {}};
  for (const ImageBoundRow& row : rows) {
    labels.push_back(row.label);
    scenes.cells.push_back(fmt::to_string(row.scenes));
    unknown_light.cells.push_back(fmt::format("{:.5f}", row.theta_deg[1]));
    bars.cells.push_back(fmt::format("{:<24}", bar_of(row.theta_deg[1], least, greatest)));
  }
  std::vector<TextGroup> groups = {{"", {scenes}}};
  for (size_t kind = 0; kind < kKinds; ++kind) {
    TextColumn theta{"theta / °", {}}, t{"T / %", {}};
    for (const ImageBoundRow& row : rows) {
      theta.cells.push_back(fmt::format("{:.5f}", row.theta_deg[kind]));
      t.cells.push_back(fmt::format("{:.5f}", row.t_percent[kind]));
    }
    groups.push_back({kImageBoundKinds[kind], {theta, t}});
  }
  std::string text =
      title + "\n" +
      text_block("Cramér-Rao bounds of theta_error and T_error, root mean squares over the scenes",
                 labels, groups);
  if (rows.size() < 2) return text;
  return text + text_block("theta_error, light unknown, on a logarithmic scale", labels,
                           {{"", {unknown_light, bars}}});
}

std::string image_bound_csv(const std::vector<ImageBoundRow>& rows) {
  std::string text =
      "condition,scenes,determined,known_light_theta_deg,known_light_t_percent,"
      "unknown_light_theta_deg,unknown_light_t_percent,outline_theta_deg,outline_t_percent\n";
  for (const ImageBoundRow& row : rows) {
    std::string label = row.label;
    std::replace(label.begin(), label.end(), '"', '\'');
    text += fmt::format("\"{}\",{},{}", label, row.scenes, row.determined);
    for (size_t kind = 0; kind < kKinds; ++kind) {
      text += fmt::format(",{},{}", row.theta_deg[kind], row.t_percent[kind]);
    }
    text += "\n";
  }
  return text;
}

std::string image_bound_json(const std::string& title, const std::vector<ImageBoundRow>& rows) {
  constexpr std::array<const char*, kKinds> kKeys = {"known_light", "unknown_light", "outline"};
  Json json = {{"title", title}, {"conditions", Json::array()}};
  for (const ImageBoundRow& row : rows) {
    Json condition = {
        {"condition", row.label}, {"scenes", row.scenes}, {"determined", row.determined}};
    for (size_t kind = 0; kind < kKinds; ++kind) {
      condition[kKeys[kind]] = {{"theta_error_deg", row.theta_deg[kind]},
                                {"t_error_percent", row.t_percent[kind]}};
    }
    json["conditions"].push_back(std::move(condition));
  }
  return json_text(json);
}

}  // namespace sightline
