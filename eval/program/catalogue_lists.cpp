// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/program/catalogue_lists.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/compare/measures.h"
#include "eval/results/columns_page.h"
#include "features/extractor.h"
#include "pose/absolute_orientation.h"
#include "pose/robust_alignment.h"
#include "pose/solver.h"
#include "scenes/files/assets.h"
#include "scenes/files/input_error.h"
#include "scenes/files/toml_table.h"

namespace sightline {
namespace {

struct Line {
  std::string name;
  std::string text;
};

std::string section(const std::string& title, const std::vector<Line>& lines) {
  size_t width = 0;
  for (const Line& line : lines) width = std::max(width, line.name.size());
  std::string out = title + "\n";
  for (const Line& line : lines) out += fmt::format("  {:<{}}  {}\n", line.name, width, line.text);
  return out;
}

std::string targets() {
  std::vector<Line> lines;
  for (const std::string& name : target_names()) {
    const TomlTable table = TomlTable::read_file(find_target_file(name));
    lines.push_back({name, table.text("description", "")});
  }
  return section("targets", lines);
}

std::string extractors() {
  std::vector<Line> lines;
  for (const FeatureExtractor& extractor : feature_extractors()) {
    lines.push_back({std::string(extractor.name),
                     fmt::format("[{}] {}", extractor.needs_edges ? "line_intersection" : "any",
                                 extractor.summary)});
  }
  return section("extractors", lines);
}

std::string solvers() {
  std::vector<Line> lines;
  for (const PoseSolver& solver : pose_solvers()) {
    const char* note = solver.evaluation_only ? " (evaluation only: needs the truth)" : "";
    lines.push_back({std::string(solver.name), fmt::format("{}{}", solver.summary, note)});
  }
  return section("solvers", lines);
}

std::string methods() {
  std::vector<Line> lines;
  for (const OrientationMethod& method : orientation_methods()) {
    lines.push_back({std::string(method.name), std::string(method.summary)});
  }
  for (const RobustAlignmentMethod& method : robust_alignment_methods()) {
    lines.push_back(
        {std::string(method.name), fmt::format("{} (for pairs with outliers)", method.summary)});
  }
  return section("methods", lines);
}

std::string studies() {
  std::vector<Line> lines;
  for (const std::string& name : study_names()) {
    const TomlTable table = TomlTable::read_file(find_study_file(name));
    const std::string reference = table.text("reference", "");
    lines.push_back({name, table.text("question", "") +
                               (reference.empty() ? "" : fmt::format(" [{}]", reference))});
  }
  return section("studies", lines);
}

}  // namespace

std::string catalogue_lists(const std::string& what) {
  using List = std::pair<std::string, std::string (*)()>;
  const std::vector<List> lists = {{"targets", targets},
                                   {"extractors", extractors},
                                   {"solvers", solvers},
                                   {"methods", methods},
                                   {"studies", studies}};
  // Too long to stand among the others:
  if (what == "columns") return columns_page();
  if (what == "measures") return measures_list();
  std::vector<std::string> known = {"columns", "measures"}, all;
  for (const auto& [name, list] : lists) {
    if (what == name) return list();
    known.push_back(name);
    if (what.empty()) all.push_back(list());
  }
  known.emplace_back("keys");
  if (what.empty()) return fmt::to_string(fmt::join(all, "\n"));
  throw InputError(fmt::format("list: '{}' is not a list{}", what, suggestion(what, known)));
}

}  // namespace sightline
