// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// [sweep]: keys that take several values, each combination of which is a condition of the study.
#pragma once

#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "eval/study/study.h"
#include "scenes/files/toml_table.h"

namespace sightline {

/// One value of a key that is swept by its name, as TOML writes it.
struct SweptValue {
  std::string key;
  std::string literal;
};

/// One value of every swept key: what sets a cell apart.
using SweptCell = std::vector<SweptValue>;

/// The cells of [sweep] or of several [[sweep]], which follow each other; the last key's values run
/// fastest. One cell without values where nothing is swept. Keys are of these tables alone, but for
/// `axes`, whose reader is read_axis.
std::vector<SweptCell> read_sweeps(const TomlTable& study, const std::vector<std::string>& tables,
                                   const std::vector<std::string>& axes = {});

/// More conditions than anybody reads. Throws InputError of the file's sweep beyond that.
void require_few_cells(const TomlTable& study, size_t cells);

/// Calls `use` with the study's file in which the swept keys have a cell's values; with the file
/// itself for a cell without any. What is wrong with a swept value is said of the sweep: nobody has
/// typed the --set that stands for it.
void with_swept_values(const TomlTable& study, const SweptCell& cell,
                       const std::function<void(const TomlTable&)>& use);

/// The condition of each cell: the values, and a label in which words lead, without a list that is
/// the only one of its key; empty where nothing is swept.
std::vector<Condition> conditions_of(const std::vector<SweptCell>& cells);

/// A quantity of a numeric or orientation study that is swept, or has one value.
struct Axis {
  std::vector<double> values;
  bool is_swept = false;
};

/// Where the value of a quantity stands that is not swept.
struct Place {
  const TomlTable& table;
  const char* name;  ///< of the table
  const char* key;
};

/// `if_absent`: the value where the file has neither; without it the file must have one.
Axis read_axis(const TomlTable& sweep, const char* key, const Place& fixed, Interval allowed,
               std::optional<double> if_absent = std::nullopt);

/// An axis of whole numbers.
Axis read_count_axis(const TomlTable& sweep, const char* key, const Place& fixed, Interval allowed,
                     std::optional<double> if_absent = std::nullopt);

/// One value of an axis: where it is swept it is part of its cell's condition.
struct Coordinate {
  const Axis& axis;
  std::string key;    ///< in summary.json
  std::string label;  ///< for readers
  double value = 0;
};

Condition condition_at(std::span<const Coordinate> coordinates);

/// The condition of both: of keys that are swept by their names, and of axes.
Condition joined(const Condition& swept, const Condition& axes);

}  // namespace sightline
