// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/score/targets_file.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <ostream>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/output/csv.h"
#include "eval/score/target_numbers.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

constexpr std::array<std::string_view, 9> kOwnColumns = {"method",     "scene_id",   "im_id",
                                                         "obj_id",     "gt_id",      "true_tx_mm",
                                                         "true_ty_mm", "true_tz_mm", "estimated"};

// The fields of a line; a quoted one may hold commas and doubled quotes, but no line ends.
std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  bool is_quoted = false;
  for (size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    const bool is_doubled = is_quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"';
    if (is_doubled) {
      fields.back() += c;
      ++i;
    } else if (c == '"') {
      is_quoted = !is_quoted;
    } else if (c == ',' && !is_quoted) {
      fields.emplace_back();
    } else if (c != '\r') {
      fields.back() += c;
    }
  }
  return fields;
}

// A line of the file, to be read from its left.
class TargetLine {
 public:
  TargetLine(const std::filesystem::path& file, int number, std::vector<std::string> fields)
      : file_(file), number_(number), fields_(std::move(fields)) {}

  [[noreturn]] void fail(const std::string& problem) const {
    throw InputError(fmt::format("{}: line {} {}", file_.string(), number_, problem));
  }

  const std::string& text() { return fields_[next_++]; }
  bool is_empty() const { return fields_[next_].empty(); }

  template <typename Number>
  Number number() {
    const std::string& field = fields_[next_++];
    Number value{};
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error == std::errc() && end == field.data() + field.size()) return value;
    fail(fmt::format("has '{}' for a number", field));
  }

 private:
  const std::filesystem::path& file_;
  int number_;
  std::vector<std::string> fields_;
  size_t next_ = 0;
};

bool is_error(const std::string& name) {
  for (const TargetNumber& number : target_numbers()) {
    if (number.name == name) return number.kind == TargetNumberKind::kError;
  }
  return false;
}

TargetRow row_of(TargetLine& line, const std::vector<std::string>& names) {
  TargetRow row;
  row.method = line.text();
  for (int& id : row.id) id = line.number<int>();
  for (double& coordinate : row.true_t_mm) coordinate = line.number<double>();
  row.is_estimated = line.number<int>() != 0;
  for (const std::string& name : names) {
    if (!line.is_empty()) {
      row.numbers.push_back(line.number<double>());
      continue;
    }
    line.text();
    const bool is_missed = !row.is_estimated && is_error(name);
    row.numbers.push_back(is_missed ? std::numeric_limits<double>::infinity() : kNoNumber);
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
  std::ifstream stream(file);
  std::string text;
  if (!std::getline(stream, text)) {
    throw InputError(fmt::format("{}: cannot be read, or is empty", file.string()));
  }
  const std::vector<std::string> columns = fields_of(text);
  const bool is_ours = columns.size() > kOwnColumns.size() &&
                       std::equal(kOwnColumns.begin(), kOwnColumns.end(), columns.begin());
  if (!is_ours) {
    throw InputError(fmt::format("{}: is no targets.csv of `sightline score`: line 1 must begin {}",
                                 file.string(), fmt::join(kOwnColumns, ",")));
  }
  TargetsTable table;
  table.numbers.assign(columns.begin() + kOwnColumns.size(), columns.end());
  for (int number = 2; std::getline(stream, text); ++number) {
    TargetLine line(file, number, fields_of(text));
    const size_t count = fields_of(text).size();
    if (count != columns.size()) {
      line.fail(fmt::format("has {} fields, must have {}", count, columns.size()));
    }
    table.rows.push_back(row_of(line, table.numbers));
  }
  if (table.rows.empty()) throw InputError(fmt::format("{}: has no target", file.string()));
  return table;
}

}  // namespace sightline
