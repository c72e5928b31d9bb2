// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output/json.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include <fmt/format.h>

#include "scenes/files/input_error.h"

namespace sightline {

void with_json(const std::filesystem::path& file, const std::function<void(const Json&)>& use) {
  std::ifstream stream(file);
  if (!stream) throw InputError(fmt::format("{}: is missing or cannot be read", file.string()));
  try {
    use(Json::parse(stream));
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
