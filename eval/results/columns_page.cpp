// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/results/columns_page.h"

#include <set>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/records/names.h"
#include "eval/results/results_csv.h"
#include "eval/results/store_schema.h"

namespace sightline {
namespace {

// Stands for the keys that a study's conditions sweep, each of which has a column.
const std::set<std::string> kAnyKey = {"KEY"};

// "- `pixel_u` `pixel_v` (px): where it was found"
std::string line_of(const std::vector<std::string>& names, std::string_view unit,
                    std::string_view meaning) {
  return fmt::format("- `{}`{}: {}\n", fmt::join(names, "` `"),
                     unit.empty() ? "" : fmt::format(" ({})", unit), meaning);
}

std::string csv_section(std::string_view title, const std::vector<CsvColumns>& columns) {
  std::string out = fmt::format("\n## {}\n\n", title);
  for (const CsvColumns& column : columns) {
    out += line_of(column.names, column.unit, column.meaning);
  }
  return out;
}

std::string store_section(const StoreTable& table) {
  std::string out = fmt::format("\n## results.sqlite: {}\n\n", table.name);
  for (const StoreColumns& columns : table.columns) {
    out += line_of(columns.names, columns.unit, columns.meaning);
  }
  return out;
}

template <Named Enum>
std::string names_section(std::string_view title) {
  return fmt::format("\n## {}\n\n{}\n", title, fmt::join(names_of(Enum{}), ", "));
}

}  // namespace

std::string columns_page() {
  std::string out =
      "# The columns of results\n\n"
      "`sightline list columns` prints this page. Poses are `cam_from_target`: camera x right, y\n"
      "down, z forward; in metres; CSV files have them as quaternions, scalar first, the store as\n"
      "matrices. KEY stands for each key that a study's conditions sweep.\n";
  out += csv_section("results.csv", estimate_columns(kAnyKey, /*has_sightings=*/true));
  out += "\n`image` to `gt_id` are those of a data set's image, and stand in its results alone.\n";
  out += csv_section("results.csv of an orientation study", orientation_columns(kAnyKey));
  out += csv_section("timings.csv", timing_columns(kAnyKey));
  for (const StoreTable* table : store_tables()) out += store_section(*table);
  out += names_section<EstimateOutcome>("Statuses of estimates and orientations");
  out += names_section<ObservationOutcome>("Statuses of observations");
  out += names_section<ObservationLabel>("Labels of observations");
  out += names_section<LineLabel>("Labels of lines");
  return out;
}

}  // namespace sightline
