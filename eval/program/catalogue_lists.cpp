// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/program/catalogue_lists.h"

#include <algorithm>
#include <filesystem>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/compare/measures.h"
#include "eval/output/json.h"
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

std::vector<Line> targets() {
  std::vector<Line> lines;
  for (const std::string& name : target_names()) {
    const TomlTable table = TomlTable::read_file(find_target_file(name));
    lines.push_back({name, table.text("description", "")});
  }
  return lines;
}

std::vector<Line> extractors() {
  std::vector<Line> lines;
  for (const FeatureExtractor& extractor : feature_extractors()) {
    lines.push_back({std::string(extractor.name),
                     fmt::format("[{}] {}", extractor.needs_edges ? "line_intersection" : "any",
                                 extractor.summary)});
  }
  return lines;
}

std::vector<Line> solvers() {
  std::vector<Line> lines;
  for (const PoseSolver& solver : pose_solvers()) {
    const char* note = solver.evaluation_only ? " (evaluation only: needs the truth)" : "";
    lines.push_back({std::string(solver.name), fmt::format("{}{}", solver.summary, note)});
  }
  return lines;
}

std::vector<Line> methods() {
  std::vector<Line> lines;
  for (const OrientationMethod& method : orientation_methods()) {
    lines.push_back({std::string(method.name), std::string(method.summary)});
  }
  for (const RobustAlignmentMethod& method : robust_alignment_methods()) {
    lines.push_back(
        {std::string(method.name), fmt::format("{} (for pairs with outliers)", method.summary)});
  }
  return lines;
}

std::vector<Line> studies() {
  std::vector<Line> lines;
  for (const std::string& name : study_names()) {
    const TomlTable table = TomlTable::read_file(find_study_file(name));
    const std::string reference = table.text("reference", "");
    lines.push_back({name, table.text("question", "") +
                               (reference.empty() ? "" : fmt::format(" [{}]", reference))});
  }
  return lines;
}

std::string fields(const std::vector<Line>& lines) {
  size_t width = 0;
  for (const Line& line : lines) width = std::max(width, line.name.size());
  std::string out;
  for (const Line& line : lines) {
    if (!line.text.empty()) out += fmt::format("{:<{}}  {}\n", line.name, width, line.text);
  }
  return out;
}

std::string study_entry(const std::string& name) {
  const std::filesystem::path file = find_study_file(name);
  const TomlTable table = TomlTable::read_file(file);
  return fields({{"study", name},
                 {"title", table.text("title", "")},
                 {"question", table.text("question", "")},
                 {"reference", table.text("reference", "")},
                 {"claim", table.text("claim", "")},
                 {"file", file.string()},
                 {"run it", "sightline study " + name}});
}

std::string target_entry(const std::string& name) {
  const std::filesystem::path file = find_target_file(name);
  const TomlTable table = TomlTable::read_file(file);
  std::vector<std::string> features;
  for (const TomlTable& feature : table.tables("feature")) {
    features.push_back(fmt::format("{} ({})", feature.text("name"), feature.text("kind", "")));
  }
  return fields({{"target", name},
                 {"description", table.text("description", "")},
                 {"features", fmt::to_string(fmt::join(features, ", "))},
                 {"file", file.string()},
                 {"all of it", "sightline target " + name},
                 {"a picture", fmt::format("sightline target {0} --picture {0}.png", name)}});
}

// What the catalogues of the code say of one of their names; empty where none has it.
std::string code_entry(const std::string& name) {
  if (const FeatureExtractor* extractor = find_feature_extractor(name)) {
    return fields(
        {{"extractor", name},
         {"summary", std::string(extractor->summary)},
         {"finds", extractor->needs_edges ? "line intersections" : "features of any kind"},
         {"needs", extractor->needs_mesh ? "a mesh" : ""},
         {"use it", fmt::format("--extractor {}", name)},
         {"more", "docs/features.md"}});
  }
  if (const PoseSolver* solver = find_pose_solver(name)) {
    return fields(
        {{"solver", name},
         {"summary", std::string(solver->summary)},
         {"needs", solver->evaluation_only ? "the truth: it is of evaluations alone" : ""},
         {"use it", fmt::format("--set 'solvers=[\"{}\"]'", name)},
         {"more", "docs/solvers.md"}});
  }
  for (const OrientationMethod& method : orientation_methods()) {
    if (method.name != name) continue;
    return fields({{"method", name}, {"summary", std::string(method.summary)}});
  }
  for (const RobustAlignmentMethod& method : robust_alignment_methods()) {
    if (method.name != name) continue;
    return fields({{"method", name},
                   {"summary", std::string(method.summary)},
                   {"use it", fmt::format("sightline align PAIRS --method {}", name)}});
  }
  return {};
}

// All that has that name: an estimator may be a solver and a method.
std::string entry(const std::string& name, std::vector<std::string>& names) {
  std::string out = code_entry(name);
  for (const std::string& study : study_names()) {
    names.push_back(study);
    if (study == name) out += study_entry(name);
  }
  for (const std::string& target : target_names()) {
    names.push_back(target);
    if (target == name) out += target_entry(name);
  }
  for (const PoseSolver& solver : pose_solvers()) names.emplace_back(solver.name);
  for (const FeatureExtractor& extractor : feature_extractors()) names.emplace_back(extractor.name);
  for (const OrientationMethod& method : orientation_methods()) names.emplace_back(method.name);
  return out;
}

using List = std::pair<std::string, std::vector<Line> (*)()>;

std::vector<List> all_lists() {
  return {{"targets", targets},
          {"extractors", extractors},
          {"solvers", solvers},
          {"methods", methods},
          {"studies", studies}};
}

}  // namespace

std::string catalogue_lists(const std::string& what) {
  // Too long to stand among the others:
  if (what == "columns") return columns_page();
  if (what == "measures") return measures_list();
  std::vector<std::string> known = {"columns", "measures"}, all;
  for (const auto& [name, list] : all_lists()) {
    if (what == name) return section(name, list());
    known.push_back(name);
    if (what.empty()) all.push_back(section(name, list()));
  }
  known.emplace_back("keys");
  if (what.empty()) return fmt::to_string(fmt::join(all, "\n"));
  if (const std::string found = entry(what, known); !found.empty()) return found;
  throw InputError(
      fmt::format("list: '{}' is no list and nothing in one{}", what, suggestion(what, known)));
}

std::string catalogue_json(const std::string& what) {
  Json json;
  std::vector<std::string> known;
  for (const auto& [name, list] : all_lists()) {
    known.push_back(name);
    if (!what.empty() && what != name) continue;
    json[name] = Json::array();
    for (const Line& line : list()) {
      json[name].push_back({{"name", line.name}, {"text", line.text}});
    }
  }
  if (json.is_null()) {
    throw InputError(fmt::format("list: '{}' has no JSON, must be one of {} or keys", what,
                                 fmt::join(known, ", ")));
  }
  return json_text(json);
}

}  // namespace sightline
