// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/score/targets_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <ostream>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/output/csv.h"
#include "eval/output/csv_reader.h"
#include "eval/score/target_numbers.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

constexpr std::array<std::string_view, 9> kOwnColumns = {"method",     "scene_id",   "im_id",
                                                         "obj_id",     "gt_id",      "true_tx_mm",
                                                         "true_ty_mm", "true_tz_mm", "estimated"};

bool is_error(const std::string& name) {
  for (const TargetNumber& number : target_numbers()) {
    if (number.name == name) return number.kind == TargetNumberKind::kError;
  }
  return false;
}

TargetRow row_of(const CsvReader& csv, const std::vector<std::string>& names) {
  TargetRow row;
  row.method = csv.text("method");
  row.id = {csv.whole("scene_id"), csv.wide_whole("im_id"), csv.whole("obj_id"),
            csv.whole("gt_id")};
  row.true_t_mm = {csv.number("true_tx_mm"), csv.number("true_ty_mm"), csv.number("true_tz_mm")};
  row.is_estimated = csv.whole("estimated") != 0;
  for (const std::string& name : names) {
    const bool is_missed = !row.is_estimated && is_error(name);
    const double if_empty = is_missed ? std::numeric_limits<double>::infinity() : kNoNumber;
    row.numbers.push_back(csv.number_or(name, if_empty));
  }
  return row;
}

std::string target_line(const MethodScores& method, const BopTarget& target) {
  const BopImage& image = method.scored.dataset.images[target.image];
  const Eigen::Vector3d& t = image.instances[target.instance].cam_from_model.translation;
  CsvLine line;
  line << method.name << image.scene_id << image.im_id << target.obj_id
       << static_cast<int64_t>(target.instance) << t.x() << t.y() << t.z()
       << int{target.chosen.has_value()};
  for (const TargetNumber& number : target_numbers()) {
    const double value = number.of(method.scored.scores, target);
    const bool is_told = std::isfinite(value) || (target.chosen && std::isinf(value));
    is_told ? line << value : line << "";
  }
  return std::move(line).end();
}

}  // namespace

void write_targets_csv(std::span<const MethodScores> methods, std::ostream& out) {
  out << fmt::to_string(fmt::join(kOwnColumns, ","));
  for (const TargetNumber& number : target_numbers()) out << "," << number.name;
  out << "\n";
  for (const MethodScores& method : methods) {
    for (const BopTarget& target : method.scored.scores.targets) out << target_line(method, target);
  }
}

TargetsTable read_targets_csv(const std::filesystem::path& file) {
  CsvReader csv(file);
  const std::vector<std::string>& columns = csv.columns();
  const bool is_ours = columns.size() > kOwnColumns.size() &&
                       std::equal(kOwnColumns.begin(), kOwnColumns.end(), columns.begin());
  if (!is_ours) {
    throw InputError(fmt::format("{}: is no targets.csv of `sightline score`: line 1 must begin {}",
                                 file.string(), fmt::join(kOwnColumns, ",")));
  }
  TargetsTable table;
  table.numbers.assign(columns.begin() + kOwnColumns.size(), columns.end());
  while (csv.next()) table.rows.push_back(row_of(csv, table.numbers));
  if (table.rows.empty()) throw InputError(fmt::format("{}: has no target", file.string()));
  return table;
}

}  // namespace sightline
