// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/program/key_lists.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "eval/output/json.h"
#include "eval/study/key_tables.h"
#include "scenes/files/input_error.h"
#include "scenes/scene/scene_law.h"

namespace sightline {
namespace {

// A table of a file and its keys.
struct KeyTable {
  std::string name;
  std::vector<KeyText> keys;

  /// As a file writes it: "[image]", "[[other]]"; the keys above all tables have none.
  std::string heading() const {
    if (name.empty()) return "Above all tables";
    constexpr std::array<std::string_view, 7> kArrays = {"other",
                                                         "lamp",
                                                         "poses.fixed",
                                                         "observations",
                                                         "estimates",
                                                         "external.solver",
                                                         "external.extractor"};
    const bool is_array = std::find(kArrays.begin(), kArrays.end(), name) != kArrays.end();
    return is_array ? fmt::format("[[{}]]", name) : fmt::format("[{}]", name);
  }
};

// Several parts have keys in one table: they are listed together, where the first of them stands.
std::vector<KeyTable> all_tables() {
  std::vector<KeyText> keys = study_keys();
  for (KeyText& key : scene_keys()) keys.push_back(std::move(key));
  std::vector<KeyTable> tables;
  for (KeyText& key : keys) {
    auto found = std::find_if(tables.begin(), tables.end(),
                              [&](const KeyTable& table) { return table.name == key.table; });
    if (found == tables.end()) found = tables.insert(tables.end(), {key.table, {}});
    found->keys.push_back(std::move(key));
  }
  return tables;
}

// The table of that name, all where it is empty.
std::vector<KeyTable> tables_of_name(const std::string& name) {
  std::vector<KeyTable> found;
  std::vector<std::string> known;
  for (const KeyTable& table : all_tables()) {
    known.push_back(table.name);
    if (name.empty() || name == table.name) found.push_back(table);
  }
  if (!found.empty()) return found;
  std::erase(known, "");
  throw InputError(
      fmt::format("list keys: '{}' is not a table of a file{}", name, suggestion(name, known)));
}

using Row = std::array<std::string, 5>;

// The rows in columns; what is longer than most moves those after it in its own row alone.
std::string aligned(const std::vector<Row>& rows) {
  constexpr size_t kWidest = 32;
  std::array<size_t, 4> widths{};
  for (const Row& row : rows) {
    for (size_t i = 0; i < widths.size(); ++i) {
      if (row[i].size() <= kWidest) widths[i] = std::max(widths[i], row[i].size());
    }
  }
  std::string out;
  for (const Row& row : rows) {
    for (size_t i = 0; i < widths.size(); ++i) out += fmt::format("  {:<{}}", row[i], widths[i]);
    out += "  " + row.back() + "\n";
  }
  return out;
}

std::string text_of(const KeyTable& table) {
  std::vector<Row> rows = {{"key", "unit", "range", "default", "meaning"}};
  for (const KeyText& key : table.keys) {
    rows.push_back(
        {key.name, key.unit.empty() ? "-" : key.unit, key.range, key.fallback, key.meaning});
  }
  return table.heading() + "\n" + aligned(rows);
}

std::string markdown_of(const KeyTable& table) {
  std::string out = fmt::format("\n## {}\n", table.heading());
  out += "| key | unit | range | default | meaning |\n|---|---|---|---|---|\n";
  for (const KeyText& key : table.keys) {
    out += fmt::format("| `{}` | {} | {} | {} | {} |\n", key.name, key.unit, key.range,
                       key.fallback, key.meaning);
  }
  return out;
}

}  // namespace

std::string key_list(const std::string& table) {
  std::string out;
  for (const KeyTable& listed : tables_of_name(table)) {
    out += (out.empty() ? "" : "\n") + text_of(listed);
  }
  return out;
}

std::string key_json(const std::string& table) {
  Json json = {{"tables", Json::array()}};
  for (const KeyTable& listed : tables_of_name(table)) {
    Json keys = Json::array();
    for (const KeyText& key : listed.keys) {
      keys.push_back({{"key", key.name},
                      {"unit", key.unit},
                      {"range", key.range},
                      {"default", key.fallback},
                      {"meaning", key.meaning}});
    }
    json["tables"].push_back({{"table", listed.name}, {"keys", std::move(keys)}});
  }
  return json_text(json);
}

std::string page_licence() {
  // In two pieces, for the licence of a page is not that of this file's lines.
  return "<!-- SPDX-"
         "FileCopyrightText: 2026 The Sightline authors -->\n"
         "<!-- SPDX-"
         "License-Identifier: GPL-3.0-or-later -->\n\n";
}

std::string key_page() {
  std::string out =
      page_licence() +
      "# The keys of scene and study files\n\n"
      "Printed by `sightline list keys --markdown`, from the tables that read the files: do not\n"
      "edit. A key with a range \"or [low, high]\" is drawn anew for every image, uniformly.\n";
  for (const KeyTable& table : all_tables()) out += markdown_of(table);
  return out;
}

}  // namespace sightline
