// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/study/sweep_keys.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sightline {
namespace {

// A key that is swept, and the values it takes, as TOML writes them.
struct SweptKey {
  std::string key;
  std::vector<std::string> values;
};

std::vector<SweptKey> read_sweep(const TomlTable& sweep, const std::vector<std::string>& tables) {
  constexpr size_t kMostCells = 10'000;
  std::vector<SweptKey> swept;
  size_t cells = 1;
  for (const std::string& key : sweep.keys()) {
    const std::string table = key.substr(0, key.find('.'));
    const bool is_known =
        table != key && std::find(tables.begin(), tables.end(), table) != tables.end();
    if (!is_known || key == "poses.fixed") {
      sweep.fail(key, fmt::format("cannot be swept, must be a quoted key of [{}], such as "
                                  "\"prior.attitude_deg\"",
                                  fmt::join(tables, "], [")));
    }
    swept.push_back({key, sweep.literals(key)});
    cells *= swept.back().values.size();
    if (cells > kMostCells) sweep.fail(key, fmt::format("makes over {} cells", kMostCells));
  }
  return swept;
}

// All combinations; the last key's values run fastest.
std::vector<SweptCell> combinations(const std::vector<SweptKey>& swept) {
  std::vector<SweptCell> all = {{}};
  for (const SweptKey& key : swept) {
    std::vector<SweptCell> longer;
    for (const SweptCell& begun : all) {
      for (const std::string& value : key.values) {
        longer.push_back(begun);
        longer.back().push_back({key.key, value});
      }
    }
    all = std::move(longer);
  }
  return all;
}

bool is_text(const std::string& literal) {
  return literal.front() == '\'' || literal.front() == '"';
}

// The keys that a study sweeps.
struct SweptKeys {
  std::set<std::string> all;
  std::set<std::string> of_words;
};

// What stands for a swept value in a condition's label: its key and the value, or a word alone
// where words are of one key. Where several are swept at once the key lacks its table, unless
// another ends alike.
std::string label_of(const SweptValue& swept, const std::string& shown, bool is_alone,
                     const SweptKeys& keys) {
  if (is_text(swept.literal) && keys.of_words.size() == 1) return shown;
  const auto last_part = [](const std::string& key) { return key.substr(key.rfind('.') + 1); };
  const std::string last = last_part(swept.key);
  const bool is_unique = std::none_of(keys.all.begin(), keys.all.end(), [&](const auto& key) {
    return key != swept.key && last_part(key) == last;
  });
  return fmt::format("{} {}", !is_alone && is_unique ? last : swept.key, shown);
}

// Notes a swept value in a cell's condition.
void add_value(Condition& condition, const SweptValue& swept, bool is_alone,
               const SweptKeys& keys) {
  const TomlTable value = TomlTable::read_text("value = " + swept.literal, swept.key);
  const bool is_number = swept.literal.find_first_not_of("+-.0123456789e_") == std::string::npos;
  std::string shown = swept.literal;
  std::erase(shown, ' ');  // of a list
  if (is_number) {
    condition.values[swept.key] = value.number("value");
  } else {
    if (is_text(swept.literal)) shown = value.text("value");
    condition.words[swept.key] = shown;
  }
  const std::string label = label_of(swept, shown, is_alone, keys);
  if (condition.label.empty()) {
    condition.label = label;
  } else if (is_text(swept.literal)) {  // words lead
    condition.label = fmt::format("{}, {}", label, condition.label);
  } else {
    condition.label += ", " + label;
  }
}

}  // namespace

std::vector<SweptCell> read_sweeps(const TomlTable& table, const std::vector<std::string>& tables) {
  if (!table.is_array("sweep")) return combinations(read_sweep(table.table("sweep"), tables));
  std::vector<SweptCell> cells;
  for (const TomlTable& sweep : table.tables("sweep")) {
    for (auto& cell : combinations(read_sweep(sweep, tables))) cells.push_back(std::move(cell));
  }
  return cells;
}

std::vector<Condition> conditions_of(const std::vector<SweptCell>& cells) {
  SweptKeys keys;
  for (const SweptCell& cell : cells) {
    for (const SweptValue& swept : cell) {
      keys.all.insert(swept.key);
      if (is_text(swept.literal)) keys.of_words.insert(swept.key);
    }
  }
  std::vector<Condition> conditions;
  for (const SweptCell& cell : cells) {
    Condition& condition = conditions.emplace_back();
    for (const SweptValue& swept : cell) add_value(condition, swept, cell.size() == 1, keys);
  }
  return conditions;
}

Axis read_axis(const TomlTable& sweep, const char* key, const Place& fixed, Interval allowed,
               std::optional<double> if_absent) {
  if (!sweep.has(key)) {
    const bool is_absent = if_absent && !fixed.table.has(fixed.key);
    return {{is_absent ? *if_absent : fixed.table.number(fixed.key, allowed)}, false};
  }
  if (fixed.table.has(fixed.key)) {
    sweep.fail(key, fmt::format("cannot stand beside {}.{}: give one or the other", fixed.name,
                                fixed.key));
  }
  return {sweep.number_list(key, allowed), true};
}

Axis read_count_axis(const TomlTable& sweep, const char* key, const Place& fixed,
                     Interval allowed) {
  const Axis axis = read_axis(sweep, key, fixed, allowed);
  for (const double value : axis.values) {
    if (value == std::floor(value)) continue;
    const std::string message = fmt::format("holds {}, must hold whole numbers", value);
    if (axis.is_swept) sweep.fail(key, message);
    fixed.table.fail(fixed.key, message);
  }
  return axis;
}

Condition condition_at(std::span<const Coordinate> coordinates) {
  Condition condition;
  for (const Coordinate& c : coordinates) {
    if (!c.axis.is_swept) continue;
    condition.values[c.key] = c.value;
    condition.label += (condition.label.empty() ? "" : ", ") + c.label;
  }
  if (condition.label.empty()) condition.label = "all";
  return condition;
}

}  // namespace sightline
