// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/keys.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sightline {
namespace {

// The table of a path such as "extraction.lines"; the file itself of an empty one.
TomlTable table_at(const TomlTable& file, const std::string& path) {
  if (path.empty()) return file;
  const size_t dot = path.find('.');
  const TomlTable table = file.table(path.substr(0, dot));
  return dot == std::string::npos ? table : table_at(table, path.substr(dot + 1));
}

// Reads what the file has under a key; it is there, or required.
struct Reader {
  const TomlTable& table;
  const Key& key;

  void operator()(double* value) const { *value = table.number(key.name, key.allowed); }
  void operator()(int* value) const {
    *value = static_cast<int>(table.integer(key.name, key.allowed));
  }
  void operator()(bool* value) const { *value = table.flag(key.name); }
  void operator()(std::string* value) const { *value = table.text(key.name); }
  void operator()(std::filesystem::path* value) const { *value = table.text(key.name); }
  void operator()(const Choice& value) const {
    const std::string word = table.choice(key.name, value.words);
    const auto found = std::find(value.words.begin(), value.words.end(), word);
    value.choose(static_cast<size_t>(found - value.words.begin()));
  }
  void operator()(Range* value) const {
    const Interval ends = table.number_or_range(key.name, key.allowed, 0);
    *value = {ends.min, ends.max};
  }
  void operator()(LowHigh value) const { *value.range = read_range(table, key.name, key.allowed); }
  void operator()(Percent value) const {
    *value.fraction = table.number(key.name, key.allowed) / 100;
  }
  void operator()(std::optional<double>* value) const { (*this)(&value->emplace()); }
  void operator()(std::optional<int>* value) const { (*this)(&value->emplace()); }
  void operator()(std::optional<Range>* value) const { (*this)(&value->emplace()); }
  void operator()(OptionalLowHigh value) const { (*this)(LowHigh{&value.range->emplace()}); }
  void operator()(Eigen::Vector3d* value) const { *value = table.vector3(key.name); }
  void operator()(std::vector<double>* value) const {
    *value = table.numbers(key.name, value->size());
  }
  void operator()(const Described&) const {}
};

// Gives the frame the value of the law. The two must be alike, which a mistake in a table is not.
struct Drawer {
  const Key& key;
  const Draws& draws;

  void operator()(std::monostate) const {}
  void operator()(double* to) const { *to = draws(*std::get<Range*>(key.value), key.path()); }
  void operator()(int* to) const { *to = *std::get<int*>(key.value); }
  void operator()(bool* to) const { *to = *std::get<bool*>(key.value); }
  void operator()(const Choice& to) const { to.choose(std::get<Choice>(key.value).chosen()); }
};

struct FactMaker {
  FactValue operator()(std::monostate) const { throw std::logic_error("no key of a frame"); }
  FactValue operator()(double* value) const { return *value; }
  FactValue operator()(int* value) const { return int64_t{*value}; }
  FactValue operator()(bool* value) const { return *value; }
  FactValue operator()(const Choice& value) const { return value.fact(); }
};

bool is_of_frame(const Key& key) {
  return !std::holds_alternative<std::monostate>(key.frame);
}

std::string truth_name(const Key& key) {
  return key.truth.empty() && is_of_frame(key) ? key.name : key.truth;
}

// "0 to 50", "at least 1"; empty where every number is allowed.
std::string text_of(Interval allowed) {
  if (std::isfinite(allowed.min) && std::isfinite(allowed.max)) {
    return fmt::format("{} to {}", allowed.min, allowed.max);
  }
  if (std::isfinite(allowed.min)) return fmt::format("at least {}", allowed.min);
  return std::isfinite(allowed.max) ? fmt::format("at most {}", allowed.max) : "any number";
}

// What a file may say under a key.
struct RangeText {
  const Key& key;

  std::string numbers() const { return text_of(key.allowed); }
  std::string operator()(double*) const { return numbers(); }
  std::string operator()(int*) const { return "whole, " + numbers(); }
  std::string operator()(bool*) const { return "true or false"; }
  std::string operator()(std::string*) const { return "a text"; }
  std::string operator()(std::filesystem::path*) const { return "a text"; }
  std::string operator()(const Choice& value) const {
    return fmt::format("\"{}\"", fmt::join(value.words, "\", \""));
  }
  std::string operator()(Range*) const { return numbers() + ", or [low, high]"; }
  std::string operator()(LowHigh) const { return "[low, high], " + numbers(); }
  std::string operator()(Percent) const { return numbers(); }
  std::string operator()(std::optional<double>*) const { return numbers(); }
  std::string operator()(std::optional<int>*) const { return "whole, " + numbers(); }
  std::string operator()(std::optional<Range>*) const { return numbers() + ", or [low, high]"; }
  std::string operator()(OptionalLowHigh) const { return "[low, high], " + numbers(); }
  std::string operator()(Eigen::Vector3d*) const { return "3 numbers"; }
  std::string operator()(std::vector<double>* value) const {
    return fmt::format("{} numbers", value->size());
  }
  std::string operator()(const Described& value) const {
    return value.range.empty() ? numbers() : value.range;
  }
};

// What stands in the law while no file was read.
struct DefaultText {
  std::string operator()(double* value) const { return fmt::to_string(*value); }
  std::string operator()(int* value) const { return fmt::to_string(*value); }
  std::string operator()(bool* value) const { return fmt::to_string(*value); }
  std::string operator()(std::string* value) const { return fmt::format("\"{}\"", *value); }
  std::string operator()(std::filesystem::path* value) const {
    return fmt::format("\"{}\"", value->string());
  }
  std::string operator()(const Choice& value) const {
    return fmt::format("\"{}\"", value.words[value.chosen()]);
  }
  std::string operator()(Range* value) const {
    if (value->min == value->max) return fmt::to_string(value->min);
    return fmt::format("[{}, {}]", value->min, value->max);
  }
  std::string operator()(LowHigh value) const {
    return fmt::format("[{}, {}]", value.range->min, value.range->max);
  }
  std::string operator()(Percent value) const { return fmt::to_string(100 * *value.fraction); }
  std::string operator()(std::optional<double>*) const { return "none"; }
  std::string operator()(std::optional<int>*) const { return "none"; }
  std::string operator()(std::optional<Range>*) const { return "none"; }
  std::string operator()(OptionalLowHigh) const { return "none"; }
  std::string operator()(Eigen::Vector3d* value) const {
    return fmt::format("[{}, {}, {}]", value->x(), value->y(), value->z());
  }
  std::string operator()(std::vector<double>* value) const {
    return fmt::format("[{}]", fmt::join(*value, ", "));
  }
  std::string operator()(const Described& value) const { return value.fallback; }
};

std::string default_text(const Key& key) {
  if (key.is_required) return "required";
  return key.if_absent.empty() ? std::visit(DefaultText{}, key.value) : key.if_absent;
}

}  // namespace

void read_key(const TomlTable& table, const Key& key) {
  if (table.has(key.name) || key.is_required) std::visit(Reader{table, key}, key.value);
}

void read_keys(const TomlTable& file, std::span<const Key> keys) {
  for (const Key& key : keys) read_key(table_at(file, key.table), key);
}

const Key& find_key(std::span<const Key> keys, std::string_view name) {
  const auto found = std::find_if(keys.begin(), keys.end(), [&](const Key& key) {
    return key.name == name || key.path() == name;
  });
  if (found == keys.end()) throw std::logic_error(fmt::format("no key '{}' in the table", name));
  return *found;
}

Range read_range(const TomlTable& table, std::string_view key, Interval allowed) {
  const std::vector<double> ends = table.numbers(key, 2);
  if (!(ends[0] <= ends[1]) || ends[0] < allowed.min || ends[1] > allowed.max) {
    table.fail(key, fmt::format("is [{}, {}], must be [low, high] between {} and {}", ends[0],
                                ends[1], allowed.min, allowed.max));
  }
  return {ends[0], ends[1]};
}

void require_within(const TomlTable& table, std::string_view key, std::span<const double> numbers,
                    Interval allowed) {
  const bool is_within = std::ranges::all_of(
      numbers, [allowed](double x) { return x >= allowed.min && x <= allowed.max; });
  if (is_within) return;
  table.fail(key, fmt::format("is [{}], must be {} numbers from {}", fmt::join(numbers, ", "),
                              numbers.size() == 3 ? "three" : fmt::to_string(numbers.size()),
                              text_of(allowed)));
}

void require_within(const TomlTable& table, std::string_view key, const Eigen::Vector3d& numbers,
                    Interval allowed) {
  require_within(table, key, std::span(numbers.data(), 3), allowed);
}

RandomStream Draws::stream(std::string_view name) const {
  return {seed, name, static_cast<uint64_t>(index)};
}

double Draws::operator()(const Range& range, std::string_view name) const {
  if (range.min == range.max) return range.min;
  RandomStream own = stream(name);
  return range.draw(own);
}

void draw_keys(std::span<const Key> keys, const Draws& draws) {
  for (const Key& key : keys) std::visit(Drawer{key, draws}, key.frame);
}

std::vector<Fact> facts_of(std::span<const Key> keys) {
  std::vector<Fact> facts;
  for (const Key& key : keys) {
    if (is_of_frame(key)) facts.push_back({truth_name(key), std::visit(FactMaker{}, key.frame)});
  }
  return facts;
}

std::vector<KeyText> texts_of(std::span<const Key> keys, std::string_view object) {
  std::vector<KeyText> texts;
  for (const Key& key : keys) {
    const std::string truth = truth_name(key);
    texts.push_back({.table = key.table,
                     .name = key.name,
                     .unit = key.unit,
                     .range = std::visit(RangeText{key}, key.value),
                     .fallback = default_text(key),
                     .meaning = key.meaning,
                     .truth = truth.empty() ? "" : fmt::format("{}.{}", object, truth)});
  }
  return texts;
}

}  // namespace sightline
