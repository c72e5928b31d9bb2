// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/speed/results_csv.h"

#include <limits>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "eval/datasets/conventions.h"
#include "eval/output/csv_reader.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

}  // namespace

void set_pose(const Eigen::Quaterniond& attitude, const Eigen::Vector3d& translation_m,
              SpeedEstimate& estimate) {
  const auto rotation = usable_rotation(attitude);
  if (!attitude.coeffs().allFinite()) {
    estimate.problem = "the quaternion is not finite";
  } else if (!rotation) {
    estimate.problem =
        fmt::format("the quaternion has the length {:.4g}, must have length 1", attitude.norm());
  } else if (!translation_m.allFinite()) {
    estimate.problem = "the translation is not finite";
  } else {
    estimate.cam_from_model = {*rotation, translation_m};
  }
}

std::vector<SpeedEstimate> read_speed_results(const std::filesystem::path& file) {
  CsvReader csv(file, {"filename", "q0", "q1", "q2", "q3", "x", "y", "z"});
  std::vector<SpeedEstimate> estimates;
  std::set<std::string> seen;
  while (csv.next()) {
    if (estimates.empty() && csv.text("filename") == "filename") continue;
    SpeedEstimate estimate;
    estimate.picture = csv.text("filename");
    estimate.line = csv.line();
    const auto number = [&csv](const char* column) { return csv.number_or(column, kNoValue); };
    set_pose({number("q0"), number("q1"), number("q2"), number("q3")},
             {number("x"), number("y"), number("z")}, estimate);
    if (!seen.insert(estimate.picture).second) {
      csv.fail(fmt::format("names a picture that was named before: {}", estimate.picture));
    }
    estimates.push_back(std::move(estimate));
  }
  if (estimates.empty()) throw InputError(fmt::format("{}: has no estimates", file.string()));
  return estimates;
}

std::vector<std::optional<int>> pictures_of(std::span<const SpeedEstimate> estimates,
                                            const PictureNames& names,
                                            const std::filesystem::path& file) {
  std::vector<std::optional<int>> pictures;
  std::map<int, std::string> named;
  for (const SpeedEstimate& estimate : estimates) {
    const auto& id = pictures.emplace_back(names.find(estimate.picture, file.string()));
    if (!id || named.emplace(*id, estimate.picture).second) continue;
    throw InputError(fmt::format("{}: has two estimates of one picture, as {} and as {}",
                                 file.string(), named.at(*id), estimate.picture));
  }
  return pictures;
}

}  // namespace sightline
