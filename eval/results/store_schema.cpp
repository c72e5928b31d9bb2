// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/results/store_schema.h"

#include <array>
#include <set>
#include <type_traits>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/records/records.h"

namespace sightline {
namespace {

// Columns of doubles have no type on purpose: SQLite writes them as they are, while in a column of
// type REAL it turns -0 into 0.
template <typename Value>
constexpr std::string_view sql_type() {
  using std::is_same_v;
  if (is_same_v<Value, int> || is_same_v<Value, bool> || is_same_v<Value, std::optional<bool>>) {
    return "INTEGER";
  }
  if (is_same_v<Value, std::optional<Eigen::Matrix<double, 6, 6>>>) return "BLOB";
  if (is_same_v<Value, std::string> || is_same_v<Value, std::vector<std::string>>) return "TEXT";
  return Named<Value> ? "TEXT" : "";
}

template <typename Record, size_t kCount>
void add_columns(const std::array<Field<Record>, kCount>& fields, StoreTable& table) {
  for (const Field<Record>& field : fields) {
    StoreColumns& columns = table.columns.emplace_back();
    for (const std::string_view component : component_names(field, PoseAs::kMatrix)) {
      columns.names.push_back(fmt::format("{}{}", field.name, component));
    }
    columns.unit = field.unit;
    columns.meaning = field.meaning;
    const auto set_type = [&]<typename Value>(Value Record::*) {
      columns.type = sql_type<Value>();
      columns.is_required = std::is_same_v<Value, std::string> || Named<Value>;
    };
    std::visit(set_type, field.member);
  }
}

StoreTable table_of_trials() {
  StoreTable table{
      "trials", "trial", {{{"trial"}, "INTEGER", true, "", "its number, which draws it"}}};
  add_columns(kTrialFields, table);
  add_columns(kPoseTrialFields, table);
  return table;
}

// A table whose rows are those of a list of each trial.
template <typename Record, size_t kCount>
StoreTable table_of_list(const char* name, const std::array<Field<Record>, kCount>& fields) {
  StoreTable table{name,
                   "trial, position",
                   {{{"trial"}, "INTEGER", true, "", "the trial's number"},
                    {{"position"}, "INTEGER", true, "", "place in the trial's list, from 0"}}};
  add_columns(fields, table);
  return table;
}

std::string create_sql(const StoreTable& table) {
  const bool is_of_trials = &table == &trials_table();
  std::vector<std::string> columns;
  for (const StoreColumns& group : table.columns) {
    for (const std::string& name : group.names) {
      columns.push_back(
          fmt::format("{} {}{}", name, group.type, group.is_required ? " NOT NULL" : ""));
    }
  }
  if (!is_of_trials) columns.push_back("FOREIGN KEY (trial) REFERENCES trials (trial)");
  return fmt::format("CREATE TABLE {} ({}, PRIMARY KEY ({})){}", table.name,
                     fmt::join(columns, ", "), table.key, is_of_trials ? "" : " WITHOUT ROWID");
}

// What a view or a virtual table shows is computed when it is read, what a trigger does when
// something is written: by whoever made the file. Only tables and indices have pages of their own.
std::string why_not_plain(const SQLite::Database& database) {
  SQLite::Statement select(database,
                           "SELECT type, name FROM sqlite_master WHERE coalesce(rootpage, 0) = 0");
  if (!select.executeStep()) return "";
  const std::string type = select.getColumn(0).getString();
  const std::string name = select.getColumn(1).getString();
  if (type == "table") return fmt::format("{} is a virtual table; must have tables alone", name);
  return fmt::format("{} is a {}; must have tables alone", name, type);
}

}  // namespace

std::vector<std::string> StoreTable::column_names() const {
  std::vector<std::string> all;
  for (const StoreColumns& group : columns) {
    all.insert(all.end(), group.names.begin(), group.names.end());
  }
  return all;
}

const StoreTable& trials_table() {
  static const StoreTable table = table_of_trials();
  return table;
}

const StoreTable& observations_table() {
  static const StoreTable table = table_of_list("observations", kObservationFields);
  return table;
}

const StoreTable& lines_table() {
  static const StoreTable table = [] {
    StoreTable lines = table_of_list("lines", kLineFields);
    lines.is_required = false;
    return lines;
  }();
  return table;
}

const StoreTable& estimates_table() {
  static const StoreTable table = table_of_list("estimates", kEstimateFields);
  return table;
}

const StoreTable& orientations_table() {
  static const StoreTable table = table_of_list("orientations", kOrientationFields);
  return table;
}

std::vector<const StoreTable*> store_tables() {
  return {&trials_table(), &observations_table(), &lines_table(), &estimates_table(),
          &orientations_table()};
}

void create_tables(SQLite::Database& database) {
  for (const StoreTable* table : store_tables()) database.exec(create_sql(*table));
}

ColumnsThere columns_there(const SQLite::Database& database, const StoreTable& table,
                           const char* database_name) {
  SQLite::Statement select(database, "SELECT name FROM pragma_table_info(?, ?)");
  select.bind(1, table.name);
  select.bind(2, database_name);
  std::set<std::string> names;
  while (select.executeStep()) names.insert(select.getColumn(0).getString());
  ColumnsThere columns;
  for (const std::string& name : table.column_names()) {
    (names.contains(name) ? columns.there : columns.lacking).push_back(name);
  }
  return columns;
}

std::string why_not_readable(const SQLite::Database& database) {
  std::string not_plain = why_not_plain(database);
  if (!not_plain.empty()) return not_plain;
  for (const StoreTable* table : store_tables()) {
    const ColumnsThere columns = columns_there(database, *table);
    if (columns.there.empty() && !table->is_required) continue;
    if (columns.there.empty()) return fmt::format("no table {}", table->name);
    const std::set<std::string> lacking(columns.lacking.begin(), columns.lacking.end());
    for (const StoreColumns& group : table->columns) {
      for (const std::string& name : group.names) {
        if (!group.is_required || !lacking.contains(name)) continue;
        return fmt::format("table {} without {}", table->name, name);
      }
    }
  }
  return "";
}

void add_what_is_lacking(SQLite::Database& database) {
  for (const StoreTable* table : store_tables()) {
    const ColumnsThere columns = columns_there(database, *table);
    if (columns.there.empty()) {
      database.exec(create_sql(*table));
      continue;
    }
    const std::set<std::string> lacking(columns.lacking.begin(), columns.lacking.end());
    for (const StoreColumns& group : table->columns) {
      for (const std::string& name : group.names) {
        if (!lacking.contains(name)) continue;
        database.exec(
            fmt::format("ALTER TABLE {} ADD COLUMN {} {}", table->name, name, group.type));
      }
    }
  }
}

void copy_trials_of_other(SQLite::Database& database) {
  for (const StoreTable* table : store_tables()) {
    const std::vector<std::string> columns = columns_there(database, *table, "other").there;
    if (columns.empty()) continue;
    database.exec(fmt::format("INSERT INTO main.{0} ({1}) SELECT {1} FROM other.{0}", table->name,
                              fmt::join(columns, ",")));
  }
}

}  // namespace sightline
