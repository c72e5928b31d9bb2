// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/settings.h"

#include <optional>
#include <set>
#include <string_view>

#include <fmt/format.h>

#include "eval/output/numbers.h"
#include "eval/output/text_table.h"
#include "scenes/files/toml_table.h"

namespace sightline {
namespace {

constexpr const char* kNotStated = "not stated";

bool is_same_value(const std::string& a, const std::string& b) {
  if (a == b) return true;
  const auto number_a = parsed_number(a);
  const auto number_b = parsed_number(b);
  return number_a && number_b && *number_a == *number_b;
}

std::string value_in(const Settings& settings, const std::string& name) {
  constexpr size_t kLongest = 60;
  const auto found = settings.find(name);
  return found == settings.end() ? kNotStated : shortened(found->second, kLongest);
}

Settings settings_of(const ComparedRun& run) {
  Settings settings = TomlTable::read_text(*run.toml, run.path / "study.toml").values();
  for (const char* explanation : {"title", "question", "reference", "claim"}) {
    settings.erase(explanation);
  }
  return settings;
}

}  // namespace

std::string settings_text(const Settings& base, const Settings& now) {
  std::set<std::string> names;
  for (const Settings* settings : {&base, &now}) {
    for (const auto& [name, value] : *settings) names.insert(name);
  }
  std::string text;
  for (const std::string& name : names) {
    const auto before = base.find(name);
    const auto after = now.find(name);
    const bool are_stated = before != base.end() && after != now.end();
    if (are_stated && is_same_value(before->second, after->second)) continue;
    text += fmt::format("{}{} {} to {}", text.empty() ? "settings differ: " : "; ", name,
                        value_in(base, name), value_in(now, name));
  }
  return text.empty() ? "settings: the same in both" : text;
}

std::string settings_text(const ComparedRun& base, const ComparedRun& now) {
  for (const ComparedRun* run : {&base, &now}) {
    if (run->toml) continue;
    return fmt::format("settings: not known, as {} has no study.toml", run->path.string());
  }
  return settings_text(settings_of(base), settings_of(now));
}

}  // namespace sightline
