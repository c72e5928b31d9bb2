// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/bop/results_csv.h"

#include <algorithm>
#include <span>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/datasets/conventions.h"
#include "eval/output/csv_reader.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

const std::vector<std::string> kColumns = {"scene_id", "im_id", "obj_id", "score",
                                           "R",        "t",     "time"};
constexpr const char* kCovariance = "covariance";
constexpr const char* kRemoved = "removed";

// The columns that BOP knows stand first, in its order; ours may follow.
void require_header(const std::filesystem::path& file, const CsvReader& csv) {
  const auto& columns = csv.columns();
  const bool begins_so = columns.size() >= kColumns.size() &&
                         std::equal(kColumns.begin(), kColumns.end(), columns.begin());
  if (!begins_so) {
    throw InputError(fmt::format("{}: line 1 is '{}', must be {}", file.string(),
                                 fmt::to_string(fmt::join(columns, ",")).substr(0, 80),
                                 fmt::join(kColumns, ",")));
  }
  std::vector<std::string> known = kColumns;
  known.insert(known.end(), {kCovariance, kRemoved});
  csv.require_columns(kColumns, known);
}

Matrix6d symmetric_of(std::span<const double> upper_triangle) {
  Matrix6d matrix;
  size_t next = 0;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      matrix(row, column) = matrix(column, row) = upper_triangle[next++];
    }
  }
  return matrix;
}

BopEstimate estimate_of(const CsvReader& csv) {
  BopEstimate estimate;
  estimate.scene_id = csv.whole("scene_id");
  estimate.im_id = csv.whole("im_id");
  estimate.obj_id = csv.whole("obj_id");
  estimate.score = csv.number("score");
  estimate.time_s = csv.number("time");
  estimate.line = csv.line();
  const std::vector<double> rotation = csv.numbers("R", 9);
  const std::vector<double> translation = csv.numbers("t", 3);
  estimate.cam_from_model.rotation = matrix_from_rows(rotation);
  estimate.cam_from_model.translation = Eigen::Map<const Eigen::Vector3d>(translation.data());
  if (!is_near_rotation(estimate.cam_from_model.rotation)) csv.fail("has an R that is no rotation");
  if (csv.has_column(kCovariance) && !csv.is_empty(kCovariance)) {
    estimate.covariance_rad_m = symmetric_of(csv.numbers(kCovariance, 21));
  }
  if (csv.has_column(kRemoved)) estimate.removed = csv.names(kRemoved);
  return estimate;
}

}  // namespace

std::vector<BopEstimate> read_bop_results(const std::filesystem::path& file) {
  CsvReader csv(file);
  require_header(file, csv);
  std::vector<BopEstimate> estimates;
  while (csv.next()) estimates.push_back(estimate_of(csv));
  return estimates;
}

}  // namespace sightline
