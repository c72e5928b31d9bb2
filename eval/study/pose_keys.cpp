// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The keys that studies of images and numeric studies share: target and features, prior, solvers.
#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/study/key_tables.h"
#include "eval/study/study_keys.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

constexpr const char* kAllFeatures = "all";

std::vector<PoseInput> read_inputs(const TomlTable& table) {
  std::vector<std::string> known;
  for (const PoseInput input : {PoseInput::kExact, PoseInput::kNoise, PoseInput::kInliers}) {
    known.emplace_back(to_string(input));
  }
  std::set<size_t> chosen;  // in the order of their steps
  for (const std::string& name : table.texts("inputs", std::vector<std::string>{})) {
    if (!chosen.insert(index_of(name, known, table, "inputs")).second) {
      table.fail("inputs", fmt::format("holds \"{}\" twice", name));
    }
  }
  std::vector<PoseInput> inputs;
  for (const size_t i : chosen) inputs.push_back(static_cast<PoseInput>(i));
  return inputs;
}

// An array of names, or the word for all, which is meant without the key too.
std::vector<std::string> read_feature_names(const TomlTable& table,
                                            const std::vector<std::string>& known) {
  if (!table.is_text("features")) return table.texts("features", known);
  const std::string word = table.text("features");
  if (word == kAllFeatures) return known;
  table.fail("features", fmt::format("is \"{}\", must be \"{}\" or an array of names (known: {})",
                                     word, kAllFeatures, fmt::join(known, ", ")));
}

}  // namespace

void require_plain_name(const TomlTable& table, const std::string& name) {
  const std::string allowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_.";
  if (name.empty() || name[0] == '.' || name.find_first_not_of(allowed) != std::string::npos) {
    table.fail("name", fmt::format("is \"{}\", must be letters, digits, '-', '_' and '.'", name));
  }
}

size_t index_of(const std::string& name, const std::vector<std::string>& names,
                const TomlTable& table, const char* key) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    table.fail(key, fmt::format("holds \"{}\"{}", name, suggestion(name, names)));
  }
  return static_cast<size_t>(found - names.begin());
}

Solving read_solving(const TomlTable& table, const std::string& default_start,
                     std::vector<TrialSolver> guests) {
  Solving solving;
  std::vector<TrialSolver> all;
  for (const PoseSolver& solver : pose_solvers()) all.push_back(built_in(solver));
  std::vector<std::string> fallback;
  for (TrialSolver& guest : guests) {
    fallback.push_back(guest.name);
    all.push_back(std::move(guest));
  }
  const std::vector<std::string> known = names_of(all);
  std::vector<std::string> names =
      guests.empty() ? table.texts("solvers") : table.texts("solvers", fallback);
  for (const std::string& guest : fallback) {
    if (std::find(names.begin(), names.end(), guest) == names.end()) names.push_back(guest);
  }
  std::set<std::string> seen;
  for (const std::string& name : names) {
    solving.solvers.push_back(all[index_of(name, known, table, "solvers")]);
    if (!seen.insert(name).second) {
      table.fail("solvers", fmt::format("holds \"{}\" twice", name));
    }
  }
  if (solving.solvers.empty()) table.fail("solvers", "is empty, must name at least one solver");

  solving.start = default_start == "prior" ? Start::kPrior : Start::kFree;
  read_keys(table, solver_keys(solving.start, solving.options));
  solving.inputs = read_inputs(table.table("solver"));
  return solving;
}

std::shared_ptr<const Target> read_target(const TomlTable& table) {
  const std::string name = table.text("target");
  const TomlTable mesh = table.table("mesh");
  const std::vector<std::string> none, backfaces = {"material", "seen"};
  const MeshUse use{.forward = mesh.text("forward", ""),
                    .up = mesh.text("up", ""),
                    .unit = mesh.text("unit", ""),
                    .hidden = mesh.texts("hide", none),
                    .backfaces = mesh.has("backfaces") ? mesh.choice("backfaces", backfaces) : ""};
  try {
    return load_target(name, use);
  } catch (const InputError& error) {
    table.fail("target", fmt::format("cannot be used: {}", error.what()));
  }
}

std::vector<int> read_features(const TomlTable& table, Use use, const Target& target) {
  std::vector<int> features;
  const std::vector<std::string> known = names_of(target.features);
  if (known.empty() && use == Use::kRendering && !table.has("features")) return {};
  if (known.empty()) {
    table.fail("target", fmt::format("'{}' has no features; a target.toml beside its mesh gives "
                                     "it some",
                                     target.name));
  }
  std::set<size_t> seen;
  for (const std::string& name : read_feature_names(table, known)) {
    const size_t index = index_of(name, known, table, "features");
    if (!seen.insert(index).second) {
      table.fail("features", fmt::format("holds \"{}\" twice", name));
    }
    features.push_back(static_cast<int>(index));
  }
  if (features.empty()) table.fail("features", "is empty, must name at least one");
  return features;
}

}  // namespace sightline
