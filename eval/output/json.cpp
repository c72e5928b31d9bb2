// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output/json.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <system_error>

#include <fmt/format.h>

#include "scenes/files/input_error.h"

namespace sightline {

Json read_json(const std::filesystem::path& file) {
  constexpr uintmax_t kMostBytes = uintmax_t{1} << 30;
  constexpr int kDeepest = 100;
  std::error_code error;
  const bool is_file = std::filesystem::is_regular_file(file, error);
  std::ifstream stream;
  if (is_file) stream.open(file, std::ios::binary);
  if (!is_file || !stream) {
    throw InputError(fmt::format("{}: is missing or cannot be read", file.string()));
  }
  if (std::filesystem::file_size(file, error) > kMostBytes) {
    throw InputError(fmt::format("{}: is larger than 1 GiB", file.string()));
  }
  const auto check_depth = [&](int depth, Json::parse_event_t, const Json&) {
    if (depth <= kDeepest) return true;
    throw InputError(fmt::format("{}: is nested deeper than {}", file.string(), kDeepest));
  };
  try {
    return Json::parse(stream, check_depth);
  } catch (const Json::exception& problem) {
    throw InputError(
        fmt::format("{}: is not as its format has it: {}", file.string(), problem.what()));
  }
}

void with_json(const std::filesystem::path& file, const std::function<void(const Json&)>& use) {
  const Json json = read_json(file);
  try {
    use(json);
  } catch (const Json::exception& error) {
    throw InputError(
        fmt::format("{}: is not as its format has it: {}", file.string(), error.what()));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file.string(), error.what()));
  }
}

std::vector<double> numbers_in(const Json& json, const std::string& key, size_t count) {
  const auto values = json.at(key).get<std::vector<double>>();
  const bool is_finite =
      std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  if (values.size() == count && is_finite) return values;
  throw InputError(fmt::format("{} has {} numbers, must have {}", key, values.size(), count));
}

}  // namespace sightline
