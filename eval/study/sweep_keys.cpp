// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/study/sweep_keys.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenes/files/input_error.h"

namespace sightline {
namespace {

// A key that is swept, and the values it takes, as TOML writes them.
struct SweptKey {
  std::string key;
  std::vector<std::string> values;
};

constexpr size_t kMostCells = 10'000;

// Of [[lamp]] and [[other]] a key says which: "lamp.0.strength" is of the first.
void require_numbered(const TomlTable& study, const TomlTable& sweep, const std::string& key,
                      const std::string& table) {
  const bool has_number = std::isdigit(static_cast<unsigned char>(key[table.size() + 1])) != 0;
  if (has_number || !study.is_array(table)) return;
  sweep.fail(key, fmt::format("must say which [[{0}]] it is of, such as \"{0}.0{1}\" of the first",
                              table, key.substr(table.size())));
}

std::vector<SweptKey> read_sweep(const TomlTable& study, const TomlTable& sweep,
                                 const std::vector<std::string>& tables,
                                 const std::vector<std::string>& axes) {
  std::vector<SweptKey> swept;
  size_t cells = 1;
  for (const std::string& key : sweep.keys()) {
    if (std::find(axes.begin(), axes.end(), key) != axes.end()) continue;
    const std::string table = key.substr(0, key.find('.'));
    const bool is_known =
        table != key && std::find(tables.begin(), tables.end(), table) != tables.end();
    if (!is_known || key == "poses.fixed") {
      const std::string or_axes =
          axes.empty() ? "" : fmt::format(", or one of {}", fmt::join(axes, ", "));
      sweep.fail(key, fmt::format("cannot be swept, must be a quoted key of [{}], such as "
                                  "\"prior.attitude_deg\"{}",
                                  fmt::join(tables, "], ["), or_axes));
    }
    require_numbered(study, sweep, key, table);
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
  std::map<std::string, std::set<std::string>> lists;  // the values that are lists of numbers

  // A list that is the key's only one says too little for its length.
  bool is_named(const SweptValue& swept) const {
    const auto found = lists.find(swept.key);
    return found == lists.end() || found->second.size() > 1;
  }
};

// Whether the words of a key say whose they are ("rgb", "contrast").
bool has_plain_words(const std::string& key) {
  return key == "image.colour" || key == "extraction.channel";
}

// What stands for a swept value in a condition's label: its key and the value, or a word alone
// where it is plain or all others are of one key. Where several are swept at once the key lacks its
// table, unless another ends alike.
std::string label_of(const SweptValue& swept, const std::string& shown, bool is_alone,
                     const SweptKeys& keys) {
  const bool is_plain = has_plain_words(swept.key) || keys.of_words.size() == 1;
  if (is_text(swept.literal) && is_plain) return shown;
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
  if (!keys.is_named(swept)) return;
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

std::vector<SweptCell> read_sweeps(const TomlTable& table, const std::vector<std::string>& tables,
                                   const std::vector<std::string>& axes) {
  if (!table.is_array("sweep"))
    return combinations(read_sweep(table, table.table("sweep"), tables, axes));
  if (!axes.empty()) table.fail("sweep", "must be one table of a study without images");
  std::vector<SweptCell> cells;
  for (const TomlTable& sweep : table.tables("sweep")) {
    for (auto& cell : combinations(read_sweep(table, sweep, tables, axes))) {
      cells.push_back(std::move(cell));
    }
    require_few_cells(table, cells.size());
  }
  return cells;
}

void require_few_cells(const TomlTable& study, size_t cells) {
  if (cells > kMostCells) study.fail("sweep", fmt::format("makes over {} cells", kMostCells));
}

void with_swept_values(const TomlTable& study, const SweptCell& cell,
                       const std::function<void(const TomlTable&)>& use) {
  if (cell.empty()) return use(study);
  std::vector<std::string> settings;
  for (const SweptValue& value : cell) {
    settings.push_back(fmt::format("{}={}", value.key, value.literal));
  }
  try {
    use(TomlTable::read_text(study.to_toml(), study.file(), settings));
  } catch (const InputError& error) {
    const std::string text = error.what();
    for (const std::string& setting : settings) {
      const std::string typed = fmt::format("--set {}: ", setting);
      if (!text.starts_with(typed)) continue;
      throw InputError(fmt::format("{}: sweep: {}: {}", study.file().string(), setting,
                                   text.substr(typed.size())));
    }
    throw;
  }
}

std::vector<Condition> conditions_of(const std::vector<SweptCell>& cells) {
  SweptKeys keys;
  for (const SweptCell& cell : cells) {
    for (const SweptValue& swept : cell) {
      keys.all.insert(swept.key);
      const bool is_word = is_text(swept.literal) && !has_plain_words(swept.key);
      if (is_word) keys.of_words.insert(swept.key);
      if (swept.literal.front() == '[') keys.lists[swept.key].insert(swept.literal);
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

Axis read_count_axis(const TomlTable& sweep, const char* key, const Place& fixed, Interval allowed,
                     std::optional<double> if_absent) {
  const Axis axis = read_axis(sweep, key, fixed, allowed, if_absent);
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

Condition joined(const Condition& swept, const Condition& axes) {
  if (swept.label.empty()) return axes;
  Condition both = swept;
  both.values.insert(axes.values.begin(), axes.values.end());
  if (!axes.values.empty()) both.label += ", " + axes.label;
  return both;
}

}  // namespace sightline
