// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/bop/results_csv.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "eval/datasets/conventions.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

constexpr std::string_view kHeader = "scene_id,im_id,obj_id,score,R,t,time";
constexpr size_t kFields = 7;

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const size_t begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

// Pieces between separators; empty ones count, unless the separator is a space.
std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> pieces;
  while (true) {
    const size_t end = text.find(separator);
    const std::string_view piece = trimmed(text.substr(0, end));
    if (separator != ' ' || !piece.empty()) pieces.push_back(piece);
    if (end == std::string_view::npos) return pieces;
    text.remove_prefix(end + 1);
  }
}

// One line of the file, to be read field by field.
class ResultLine {
 public:
  ResultLine(const std::filesystem::path& file, int number, std::string_view text)
      : file_(file), number_(number), fields_(split(text, ',')) {
    if (fields_.size() == kFields) return;
    fail(fmt::format("has {} fields, must have {}: {}", fields_.size(), kFields, kHeader));
  }

  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(fmt::format("{}: line {} {}", file_.string(), number_, reason));
  }

  int number_in_file() const { return number_; }

  int id(size_t field, std::string_view name) const {
    const std::string_view text = fields_[field];
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || value < 0) {
      fail(fmt::format("has {} '{}', must be a whole number from 0", name, text));
    }
    return value;
  }

  double number(size_t field, std::string_view name) const { return value(fields_[field], name); }

  std::vector<double> numbers(size_t field, std::string_view name, size_t count) const {
    const std::vector<std::string_view> pieces = split(fields_[field], ' ');
    if (pieces.size() != count) {
      fail(fmt::format("has {} numbers for {}, must have {} with spaces between them",
                       pieces.size(), name, count));
    }
    std::vector<double> values;
    for (const std::string_view piece : pieces) values.push_back(value(piece, name));
    return values;
  }

 private:
  double value(std::string_view text, std::string_view name) const {
    double value = 0;
    if (text.starts_with('+')) text.remove_prefix(1);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
      fail(fmt::format("has '{}' for {}, must be a finite number", text, name));
    }
    return value;
  }

  const std::filesystem::path& file_;
  int number_;
  std::vector<std::string_view> fields_;
};

BopEstimate estimate_of(const ResultLine& line) {
  BopEstimate estimate{.scene_id = line.id(0, "scene_id"),
                       .im_id = line.id(1, "im_id"),
                       .obj_id = line.id(2, "obj_id"),
                       .score = line.number(3, "score"),
                       .cam_from_model = {},
                       .time_s = line.number(6, "time"),
                       .line = line.number_in_file()};
  const std::vector<double> rotation = line.numbers(4, "R", 9);
  const std::vector<double> translation = line.numbers(5, "t", 3);
  estimate.cam_from_model.rotation = matrix_from_rows(rotation);
  estimate.cam_from_model.translation = Eigen::Map<const Eigen::Vector3d>(translation.data());
  if (!is_near_rotation(estimate.cam_from_model.rotation)) {
    line.fail("has an R that is no rotation");
  }
  return estimate;
}

}  // namespace

std::vector<BopEstimate> read_bop_results(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream || std::filesystem::is_directory(file)) {
    throw InputError(fmt::format("{}: cannot be read", file.string()));
  }
  std::string text;
  std::getline(stream, text);
  if (trimmed(text) != kHeader) {
    throw InputError(fmt::format("{}: line 1 is '{}', must be {}", file.string(),
                                 trimmed(text).substr(0, 80), kHeader));
  }
  std::vector<BopEstimate> estimates;
  for (int number = 2; std::getline(stream, text); ++number) {
    if (!trimmed(text).empty()) estimates.push_back(estimate_of(ResultLine(file, number, text)));
  }
  return estimates;
}

}  // namespace sightline
