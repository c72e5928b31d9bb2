// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/bop/results_csv.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/datasets/conventions.h"
#include "eval/output/csv_reader.h"
#include "eval/output/numbers.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

const std::vector<std::string> kColumns = {"scene_id", "im_id", "obj_id", "score",
                                           "R",        "t",     "time"};
constexpr const char* kCovariance = "covariance";
constexpr const char* kRemoved = "removed";
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

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

// The file at its first row; one whose first line is an estimate already has no header.
CsvReader opened(const std::filesystem::path& file) {
  CsvReader csv(file);
  const std::string& first = csv.columns().front();
  const bool is_row = csv.columns().size() == kColumns.size() && parsed_number(first);
  if (is_row) return {file, kColumns};
  require_header(file, csv);
  return csv;
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

// Why the numbers of a row are no estimate; empty where they are one.
std::string problem_of(const BopEstimate& estimate) {
  if (!estimate.cam_from_model.rotation.allFinite()) return "R is not finite";
  if (!estimate.cam_from_model.translation.allFinite()) return "t is not finite";
  if (!std::isfinite(estimate.score)) return "score is not finite";
  if (!std::isfinite(estimate.time_s)) return "time is not finite";
  if (estimate.covariance_rad_m && !estimate.covariance_rad_m->allFinite()) {
    return "covariance is not finite";
  }
  return is_near_rotation(estimate.cam_from_model.rotation) ? "" : "R is no rotation";
}

BopEstimate estimate_of(const CsvReader& csv) {
  BopEstimate estimate;
  estimate.scene_id = csv.integer("scene_id");
  estimate.im_id = csv.wide_integer("im_id");
  estimate.obj_id = csv.integer("obj_id");
  estimate.score = csv.number_or("score", kNaN);
  estimate.time_s = csv.number_or("time", kNaN);
  estimate.line = csv.line();
  const std::vector<double> rotation = csv.any_numbers("R", 9);
  const std::vector<double> translation = csv.any_numbers("t", 3);
  estimate.cam_from_model.rotation = matrix_from_rows(rotation);
  estimate.cam_from_model.translation = Eigen::Map<const Eigen::Vector3d>(translation.data());
  if (csv.has_column(kCovariance) && !csv.is_empty(kCovariance)) {
    estimate.covariance_rad_m = symmetric_of(csv.any_numbers(kCovariance, 21));
  }
  estimate.problem = problem_of(estimate);
  if (!std::isfinite(estimate.score)) estimate.score = -std::numeric_limits<double>::infinity();
  if (estimate.problem.empty()) {
    estimate.cam_from_model.rotation = *usable_rotation(estimate.cam_from_model.rotation);
  }
  if (csv.has_column(kRemoved)) estimate.removed = csv.names(kRemoved);
  return estimate;
}

}  // namespace

std::vector<BopEstimate> read_bop_results(const std::filesystem::path& file) {
  CsvReader csv = opened(file);
  std::vector<BopEstimate> estimates;
  while (csv.next()) estimates.push_back(estimate_of(csv));
  return estimates;
}

std::string failed_rows(std::span<const BopEstimate> estimates) {
  const auto is_failed = [](const BopEstimate& e) { return !e.problem.empty(); };
  const auto first = std::find_if(estimates.begin(), estimates.end(), is_failed);
  if (first == estimates.end()) return "";
  const auto count = std::count_if(first, estimates.end(), is_failed);
  return fmt::format("{} {} no estimate and {} as failed, the first in line {}: {}", count,
                     count == 1 ? "row is" : "rows are", count == 1 ? "counts" : "count",
                     first->line, first->problem);
}

}  // namespace sightline
