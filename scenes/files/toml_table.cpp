// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/files/toml_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#define TOML_EXCEPTIONS 1
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>

#include <toml++/toml.h>

#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"
#include "scenes/files/toml_text.h"

namespace sightline {

struct TomlTable::Document {
  std::filesystem::path file;
  toml::table root;
  std::map<std::string, std::string> overrides;  // the setting as typed, by its key's path
};

struct TomlTable::Node {
  std::shared_ptr<const Document> document;
  std::string prefix;  // "pose." for the keys of [pose]
  const toml::table* table = nullptr;
  mutable std::set<std::string, std::less<>> known;  // keys a getter has named
  mutable std::map<std::string, std::vector<std::shared_ptr<const Node>>, std::less<>> children;
};

namespace {

const toml::table kEmptyTable;

std::string to_text(const toml::node& node) {
  std::ostringstream out;
  node.visit([&out](const auto& value) { out << toml::toml_formatter{value}; });
  return out.str();
}

std::string describe(Interval allowed) {
  const bool has_min = std::isfinite(allowed.min);
  const bool has_max = std::isfinite(allowed.max);
  if (has_min && has_max) return fmt::format("from {} to {}", allowed.min, allowed.max);
  if (has_min) return fmt::format("at least {}", allowed.min);
  if (has_max) return fmt::format("at most {}", allowed.max);
  return "a finite number";
}

std::optional<double> finite_number(const toml::node* node) {
  if (node == nullptr || !node->is_number()) return std::nullopt;
  const double value = *node->value<double>();
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::optional<Eigen::Vector3d> point_of(const toml::node* node) {
  const toml::array* array = node == nullptr ? nullptr : node->as_array();
  if (array == nullptr || array->size() != 3) return std::nullopt;
  Eigen::Vector3d point;
  for (int i = 0; i < 3; ++i) {
    const std::optional<double> value = finite_number(array->get(i));
    if (!value) return std::nullopt;
    point[i] = *value;
  }
  return point;
}

// The parts of a path between its dots. A part in quotes may hold dots, as a key of TOML may:
// sweep."poses.range_m". Quotes that are not closed are letters.
std::vector<std::string> split_path(std::string_view path) {
  std::vector<std::string> parts;
  while (!path.empty()) {
    const bool is_quoted = path.front() == '"' || path.front() == '\'';
    const size_t quote = is_quoted ? path.find(path.front(), 1) : std::string_view::npos;
    if (quote != std::string_view::npos && (quote + 1 == path.size() || path[quote + 1] == '.')) {
      parts.emplace_back(path.substr(1, quote - 1));
      path.remove_prefix(std::min(quote + 2, path.size()));
      continue;
    }
    const size_t dot = std::min(path.find('.'), path.size());
    parts.emplace_back(path.substr(0, dot));
    path.remove_prefix(std::min(dot + 1, path.size()));
  }
  return parts;
}

// What is wrong with TOML. Of a number that no double holds the library says that it "could not be
// interpreted".
std::string words_of(const toml::parse_error& error) {
  const std::string text(error.description());
  const size_t begin = text.find('\'');
  const size_t end = text.rfind('\'');
  if (!text.starts_with("Error while parsing floating-point: '") || begin == end) return text;
  return fmt::format("{} is beyond numbers of 64 bits, which reach to 1.8e308",
                     text.substr(begin, end - begin + 1));
}

// The value of an override: TOML if it parses as such, else the words themselves, unless they stand
// in brackets as a list or a table does.
toml::table parse_override_value(const std::string& setting) {
  const std::string value = setting.substr(setting.find('=') + 1);
  try {
    return toml::parse("value = " + typed_value(value).value_or(value));
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("--set {}: {}", setting, words_of(error)));
  }
}

// The element of an array that a part of a path names; null when it names none.
toml::node* element_of(toml::array& array, const std::string& index) {
  const bool is_number =
      index.size() < 6 && index.find_first_not_of("0123456789") == std::string::npos;
  return is_number ? array.get(std::stoul(index)) : nullptr;
}

// Sets the key and returns its path.
std::string apply_override(toml::table& root, const std::string& setting) {
  const size_t equals = setting.find('=');
  const std::string key = setting.substr(0, equals);
  const auto path = split_path(key);
  const bool is_key = key.find_first_of(" \t\n") == std::string::npos && !key.ends_with('.') &&
                      !path.empty() && std::count(path.begin(), path.end(), "") == 0;
  if (equals == std::string::npos || !is_key) {
    throw InputError(
        fmt::format("--set {}: must read key=value, for example noise.scale=2", setting));
  }
  toml::table* table = &root;
  for (size_t i = 0; i + 1 < path.size(); ++i) {
    if (!table->contains(path[i])) table->insert(path[i], toml::table{});
    toml::node* node = table->get(path[i]);
    if (const toml::array* array = node->as_array(); array != nullptr && i + 2 < path.size()) {
      node = element_of(*node->as_array(), path[++i]);
    }
    table = node == nullptr ? nullptr : node->as_table();
    if (table == nullptr) {
      throw InputError(fmt::format("--set {}: '{}' is not a table", setting, path[i]));
    }
  }
  const toml::table parsed = parse_override_value(setting);
  parsed.get("value")->visit(
      [&](const auto& value) { table->insert_or_assign(path.back(), value); });
  return fmt::to_string(fmt::join(path, "."));
}

void add_values(const std::string& path, const toml::node& node,
                std::map<std::string, std::string>& values) {
  const std::string prefix = path.empty() ? "" : path + ".";
  const toml::array* const array = node.as_array();
  if (const toml::table* table = node.as_table()) {
    for (const auto& [key, child] : *table) {
      add_values(prefix + std::string(key.str()), child, values);
    }
  } else if (array != nullptr && array->is_array_of_tables()) {
    for (size_t i = 0; i < array->size(); ++i) {
      add_values(prefix + std::to_string(i), *array->get(i), values);
    }
  } else {
    values[path] = with_shortest_numbers(to_text(node));
  }
}

}  // namespace

TomlTable TomlTable::read_file(const std::filesystem::path& file,
                               std::span<const std::string> overrides) {
  return read_text(read_input_file(file, kMostTextBytes), file, overrides);
}

TomlTable TomlTable::read_text(const std::string& text, const std::filesystem::path& name,
                               std::span<const std::string> overrides) {
  auto document = std::make_shared<Document>();
  document->file = name;
  require_shallow_keys(text, name);
  try {
    document->root = toml::parse(text, name.string());
  } catch (const toml::parse_error& error) {
    throw InputError(
        fmt::format("{}:{}: {}", name.string(), error.source().begin.line, words_of(error)));
  }
  for (const std::string& setting : overrides) {
    document->overrides[apply_override(document->root, setting)] = setting;
  }
  auto node = std::make_shared<Node>();
  node->table = &document->root;
  node->document = std::move(document);
  return TomlTable(node);
}

bool TomlTable::has(std::string_view key) const {
  node_->known.emplace(key);
  return node_->table->contains(key);
}

bool TomlTable::is_array(std::string_view key) const {
  return has(key) && node_->table->get(key)->is_array();
}

bool TomlTable::is_text(std::string_view key) const {
  return has(key) && node_->table->get(key)->is_string();
}

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> keys;
  for (const auto& [key, value] : *node_->table) keys.emplace_back(key.str());
  node_->known.insert(keys.begin(), keys.end());
  return keys;
}

double TomlTable::number(std::string_view key, Interval allowed,
                         std::optional<double> fallback) const {
  if (!has(key)) {
    if (fallback) return *fallback;
    fail(key, fmt::format("is missing (a number, {})", describe(allowed)));
  }
  const toml::node& node = *node_->table->get(key);
  const std::optional<double> value = finite_number(&node);
  if (!value || *value < allowed.min || *value > allowed.max) {
    fail(key, fmt::format("is {}, must be a number, {}", to_text(node), describe(allowed)));
  }
  return *value;
}

Interval TomlTable::number_or_range(std::string_view key, Interval allowed, double fallback) const {
  if (!has(key)) return {fallback, fallback};
  const toml::node& node = *node_->table->get(key);
  const toml::array* array = node.as_array();
  const auto low = finite_number(array == nullptr ? &node : array->get(0));
  const auto high = finite_number(array == nullptr ? &node : array->get(1));
  const bool is_good = (array == nullptr || array->size() == 2) && low && high && *low <= *high &&
                       *low >= allowed.min && *high <= allowed.max;
  if (!is_good) {
    fail(key, fmt::format("is {}, must be a number or [low, high], {}", to_text(node),
                          describe(allowed)));
  }
  return {*low, *high};
}

int64_t TomlTable::integer(std::string_view key, Interval allowed,
                           std::optional<int64_t> fallback) const {
  if (!has(key)) {
    if (fallback) return *fallback;
    fail(key, fmt::format("is missing (a whole number, {})", describe(allowed)));
  }
  const toml::node& node = *node_->table->get(key);
  const std::optional<int64_t> value = node.value_exact<int64_t>();
  const bool is_good = value && static_cast<double>(*value) >= allowed.min &&
                       static_cast<double>(*value) <= allowed.max;
  if (!is_good) {
    fail(key, fmt::format("is {}, must be a whole number, {}", to_text(node), describe(allowed)));
  }
  return *value;
}

bool TomlTable::flag(std::string_view key, std::optional<bool> fallback) const {
  if (!has(key)) {
    if (fallback) return *fallback;
    fail(key, "is missing (true or false)");
  }
  const toml::node& node = *node_->table->get(key);
  const std::optional<bool> value = node.value_exact<bool>();
  if (!value) fail(key, fmt::format("is {}, must be true or false", to_text(node)));
  return *value;
}

std::string TomlTable::text(std::string_view key, std::optional<std::string> fallback) const {
  if (!has(key)) {
    if (fallback) return *fallback;
    fail(key, "is missing (a text)");
  }
  const toml::node& node = *node_->table->get(key);
  const std::optional<std::string> value = node.value_exact<std::string>();
  if (!value) fail(key, fmt::format("is {}, must be a text in quotes", to_text(node)));
  return *value;
}

std::string TomlTable::choice(std::string_view key, std::span<const std::string> allowed,
                              std::optional<std::string> fallback) const {
  const std::string value = text(key, std::move(fallback));
  for (const std::string& name : allowed) {
    if (name == value) return value;
  }
  fail(key, fmt::format("is \"{}\"{}", value, suggestion(value, allowed)));
}

std::vector<std::string> TomlTable::texts(std::string_view key,
                                          std::optional<std::vector<std::string>> fallback) const {
  if (!has(key)) {
    if (fallback) return *fallback;
    fail(key, "is missing (an array of texts)");
  }
  const toml::node& node = *node_->table->get(key);
  std::vector<std::string> values;
  const toml::array* array = node.as_array();
  if (array == nullptr) fail(key, fmt::format("is {}, must be an array of texts", to_text(node)));
  for (const toml::node& element : *array) {
    const std::optional<std::string> value = element.value_exact<std::string>();
    if (!value) fail(key, fmt::format("holds {}, must hold texts only", to_text(element)));
    values.push_back(*value);
  }
  return values;
}

std::vector<double> TomlTable::numbers(std::string_view key, size_t count,
                                       std::optional<std::vector<double>> fallback) const {
  if (!has(key)) {
    if (fallback) return *fallback;
    fail(key, fmt::format("is missing (an array of {} numbers)", count));
  }
  const toml::node& node = *node_->table->get(key);
  const toml::array* array = node.as_array();
  std::vector<double> values;
  for (size_t i = 0; array != nullptr && i < array->size(); ++i) {
    const std::optional<double> value = finite_number(array->get(i));
    if (value) values.push_back(*value);
  }
  if (values.size() != count || array->size() != count) {
    fail(key, fmt::format("is {}, must be an array of {} finite numbers", to_text(node), count));
  }
  return values;
}

std::vector<double> TomlTable::numbers(std::string_view key, std::span<const size_t> counts) const {
  const toml::node* const node = node_->table->get(key);
  const toml::array* const array = node != nullptr ? node->as_array() : nullptr;
  const size_t size = array != nullptr ? array->size() : 0;
  if (std::find(counts.begin(), counts.end(), size) != counts.end()) return numbers(key, size);
  fail(key, fmt::format("is {}, must be an array of {} finite numbers",
                        node != nullptr ? to_text(*node) : "missing", fmt::join(counts, " or ")));
}

std::vector<double> TomlTable::number_list(std::string_view key, Interval allowed) const {
  if (!has(key)) {
    fail(key, fmt::format("is missing (an array of numbers, each {})", describe(allowed)));
  }
  const toml::node& node = *node_->table->get(key);
  const toml::array* array = node.as_array();
  std::vector<double> values;
  for (size_t i = 0; array != nullptr && i < array->size(); ++i) {
    const std::optional<double> value = finite_number(array->get(i));
    if (!value || *value < allowed.min || *value > allowed.max) {
      fail(key, fmt::format("holds {}, must hold numbers only, each {}", to_text(*array->get(i)),
                            describe(allowed)));
    }
    if (std::find(values.begin(), values.end(), *value) != values.end()) {
      fail(key, fmt::format("holds {} twice", *value));
    }
    values.push_back(*value);
  }
  if (values.empty()) {
    fail(key, fmt::format("is {}, must be an array of one or more numbers", to_text(node)));
  }
  return values;
}

std::vector<std::string> TomlTable::literals(std::string_view key) const {
  const std::string rule = "an array of one or more numbers, texts, flags or arrays of numbers";
  if (!has(key)) fail(key, fmt::format("is missing ({})", rule));
  const toml::node& node = *node_->table->get(key);
  const toml::array* array = node.as_array();
  std::vector<std::string> literals;
  for (size_t i = 0; array != nullptr && i < array->size(); ++i) {
    const toml::node& value = *array->get(i);
    const toml::array* inner = value.as_array();
    // Whether a number fits says the key that takes it.
    const bool is_good = value.is_number() || value.is_string() || value.is_boolean() ||
                         (inner != nullptr &&
                          std::all_of(inner->begin(), inner->end(), [](const toml::node& number) {
                            return finite_number(&number).has_value();
                          }));
    if (!is_good) fail(key, fmt::format("holds {}, must be {}", to_text(value), rule));
    literals.push_back(with_shortest_numbers(to_text(value)));
    if (std::count(literals.begin(), literals.end(), literals.back()) > 1) {
      fail(key, fmt::format("holds {} twice", literals.back()));
    }
  }
  if (literals.empty()) fail(key, fmt::format("is {}, must be {}", to_text(node), rule));
  return literals;
}

Eigen::Vector3d TomlTable::vector3(std::string_view key,
                                   std::optional<Eigen::Vector3d> fallback) const {
  if (!has(key) && fallback) return *fallback;
  const std::vector<double> values = numbers(key, 3);
  return {values[0], values[1], values[2]};
}

std::vector<std::vector<Eigen::Vector3d>> TomlTable::point_lists(std::string_view key,
                                                                 size_t least_outer,
                                                                 size_t inner) const {
  const std::string rule = fmt::format(
      "{} or more lists of {} points, each an array of 3 finite numbers", least_outer, inner);
  if (!has(key)) fail(key, fmt::format("is missing ({})", rule));
  const toml::array* lists = node_->table->get(key)->as_array();
  std::vector<std::vector<Eigen::Vector3d>> out;
  for (size_t i = 0; lists != nullptr && i < lists->size(); ++i) {
    const toml::array* list = lists->get(i)->as_array();
    std::vector<Eigen::Vector3d> points;
    for (size_t j = 0; list != nullptr && j < list->size(); ++j) {
      const std::optional<Eigen::Vector3d> point = point_of(list->get(j));
      if (!point) fail(key, fmt::format("must be {}", rule));
      points.push_back(*point);
    }
    if (points.size() != inner) fail(key, fmt::format("must be {}", rule));
    out.push_back(std::move(points));
  }
  if (out.size() < least_outer) fail(key, fmt::format("must be {}", rule));
  return out;
}

TomlTable TomlTable::table(std::string_view key) const {
  const bool is_given = has(key);
  const auto found = node_->children.find(key);
  if (found != node_->children.end()) return TomlTable(found->second.front());
  auto child = std::make_shared<Node>();
  child->document = node_->document;
  child->prefix = fmt::format("{}{}.", node_->prefix, key);
  child->table = is_given ? node_->table->get(key)->as_table() : &kEmptyTable;
  if (child->table == nullptr)
    fail(key, fmt::format("must be a table, [{}{}]", node_->prefix, key));
  node_->children[std::string(key)] = {child};
  return TomlTable(child);
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) const {
  std::vector<TomlTable> out;
  if (!has(key)) return out;
  const toml::array* array = node_->table->get(key)->as_array();
  const std::string rule = fmt::format("must be an array of tables, [[{}{}]]", node_->prefix, key);
  if (array == nullptr) fail(key, rule);
  std::vector<std::shared_ptr<const Node>>& children = node_->children[std::string(key)];
  for (const auto& child : children) out.push_back(TomlTable(child));
  for (size_t i = children.size(); i < array->size(); ++i) {
    auto child = std::make_shared<Node>();
    child->document = node_->document;
    child->prefix = fmt::format("{}{}[{}].", node_->prefix, key, i);
    child->table = array->get(i)->as_table();
    if (child->table == nullptr) fail(key, rule);
    children.push_back(child);
    out.push_back(TomlTable(child));
  }
  return out;
}

void TomlTable::reject_unknown_keys() const {
  for (const auto& [key, value] : *node_->table) {
    if (node_->known.contains(key.str())) continue;
    const std::vector<std::string> known(node_->known.begin(), node_->known.end());
    fail(key.str(), "is not a known key" + suggestion(key.str(), known));
  }
  for (const auto& [key, children] : node_->children) {
    for (const auto& child : children) TomlTable(child).reject_unknown_keys();
  }
}

void TomlTable::fail(std::string_view key, const std::string& message) const {
  const std::string path = fmt::format("{}{}", node_->prefix, key);
  const auto setting = node_->document->overrides.find(path);
  const std::string source = setting == node_->document->overrides.end()
                                 ? node_->document->file.string()
                                 : "--set " + setting->second;
  throw InputError(fmt::format("{}: {} {}", source, path, message));
}

const std::filesystem::path& TomlTable::file() const {
  return node_->document->file;
}

std::string TomlTable::to_toml() const {
  std::ostringstream out;
  out << node_->document->root << "\n";
  return with_shortest_numbers(out.str());
}

std::map<std::string, std::string> TomlTable::values() const {
  std::map<std::string, std::string> values;
  add_values("", *node_->table, values);
  return values;
}

}  // namespace sightline
