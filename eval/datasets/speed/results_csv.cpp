// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/speed/results_csv.h"

#include <set>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "eval/datasets/conventions.h"
#include "eval/output/csv_reader.h"
#include "scenes/files/input_error.h"

namespace sightline {

std::vector<SpeedEstimate> read_speed_results(const std::filesystem::path& file) {
  CsvReader csv(file, {"filename", "q0", "q1", "q2", "q3", "x", "y", "z"});
  std::vector<SpeedEstimate> estimates;
  std::set<std::string> seen;
  while (csv.next()) {
    if (estimates.empty() && csv.text("filename") == "filename") continue;
    SpeedEstimate estimate;
    estimate.picture = std::filesystem::path(csv.text("filename")).filename().string();
    estimate.line = csv.line();
    const Eigen::Quaterniond q(csv.number("q0"), csv.number("q1"), csv.number("q2"),
                               csv.number("q3"));
    try {
      estimate.cam_from_model.rotation = rotation_of_printed(q, "the quaternion");
    } catch (const InputError& error) {
      csv.fail(fmt::format("is wrong: {}", error.what()));
    }
    estimate.cam_from_model.translation = {csv.number("x"), csv.number("y"), csv.number("z")};
    if (!seen.insert(estimate.picture).second) {
      csv.fail(fmt::format("names a picture that was named before: {}", estimate.picture));
    }
    estimates.push_back(std::move(estimate));
  }
  return estimates;
}

}  // namespace sightline
