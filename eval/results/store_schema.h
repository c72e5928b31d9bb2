// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace SQLite {
class Database;
}

namespace sightline {

// The tables of a store that hold trials, made from eval/records/records.h. What SQLite refuses
// throws SQLite::Exception.

/// Neighbouring columns of a table that mean one thing: one column, or the numbers of a pose.
struct StoreColumns {
  std::vector<std::string> names;
  std::string_view type;  ///< of SQLite
  bool is_required;       ///< without them nobody knows what a row is
  std::string_view unit;  ///< empty of what has none
  std::string_view meaning;
};

/// A table as new stores have it.
struct StoreTable {
  const char* name;
  const char* key;  ///< of a row: its columns, separated by commas
  std::vector<StoreColumns> columns;
  bool is_required = true;  ///< stores of before it came are read without it

  std::vector<std::string> column_names() const;
};

const StoreTable& trials_table();
const StoreTable& observations_table();
const StoreTable& lines_table();
const StoreTable& estimates_table();
const StoreTable& orientations_table();

/// In the order in which they are filled: no row of a later table without its trial.
std::vector<const StoreTable*> store_tables();

void create_tables(SQLite::Database& database);

/// Which columns of a table a file has, and which it lacks.
struct ColumnsThere {
  std::vector<std::string> there;
  std::vector<std::string> lacking;
};

/// In the order of the table. `database_name` is "main", or that of an attached file.
ColumnsThere columns_there(const SQLite::Database& database, const StoreTable& table,
                           const char* database_name = "main");

/// What makes the tables unreadable, in words: one is missing, or lacks a column that is required.
/// Empty where nothing does.
std::string why_not_readable(const SQLite::Database& database);

/// Gives a store of an older schema the tables that it lacks, empty, and its tables the columns
/// that they lack, all NULL.
void add_what_is_lacking(SQLite::Database& database);

/// Adds all trials of the file that is attached as `other`, which may be of an older schema.
void copy_trials_of_other(SQLite::Database& database);

}  // namespace sightline
