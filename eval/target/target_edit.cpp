// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/target/target_edit.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/output/output_folder.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"
#include "scenes/files/toml_text.h"
#include "scenes/target/rounded_tips.h"
#include "scenes/target/target.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFeatureLine = "[[feature]]";
constexpr double kAddedClearance = 0.01;

// The file cut before every line that begins a feature: what stands before them, then one each.
// Tables that follow the features stand before them afterwards, so that none is lost with one.
std::vector<std::string> cut_at_features(const std::string& text) {
  std::vector<std::string> pieces(1);
  size_t begin = 0;
  bool is_in_feature = false;
  while (begin < text.size()) {
    const size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    const std::string line = text.substr(begin, end - begin);
    if (line.starts_with(kFeatureLine)) pieces.emplace_back();
    if (line.starts_with('[')) {
      is_in_feature = line.starts_with("[[feature") || line.starts_with("[feature.");
    }
    (is_in_feature ? pieces.back() : pieces.front()) += line;
    begin = end;
  }
  return pieces;
}

// The number of the first added_N that no feature is called.
size_t free_number(const std::vector<std::string>& names) {
  size_t number = names.size() + 1;
  while (std::ranges::find(names, fmt::format("added_{}", number)) != names.end()) ++number;
  return number;
}

struct AddedFeature {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  std::string name;
};

AddedFeature read_added(const std::string& text, size_t number) {
  AddedFeature added{.name = fmt::format("added_{}", number)};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (int axis = 0; axis < 3; ++axis) {
    const auto [next, error] = std::from_chars(at, end, added.position_m[axis]);
    const bool is_last = axis == 2 && next == end;
    if (error != std::errc() || (!is_last && (next == end || *next != ','))) {
      throw InputError(fmt::format(
          "--add {}: must be x,y,z or x,y,z,NAME (metres: x forward, y starboard, z down)", text));
    }
    at = is_last ? next : next + 1;
  }
  if (at != end) added.name = std::string(at, end);
  return added;
}

std::string feature_text(const Target& target, const AddedFeature& added) {
  const Bounds box = bounds(target.mesh);
  const double size_m = (box.max_m - box.min_m).norm();
  const double off_m = target.occluder.distance_m(added.position_m);
  if (off_m > kAddedClearance * size_m) {
    throw InputError(fmt::format(
        "--add {}: lies {:.3g} m off the mesh, may lie at most {:.3g} m off (1 % of its size)",
        added.name, off_m, kAddedClearance * size_m));
  }
  std::vector<std::string> parts;
  const double reach_m = std::max(kTipRadius * size_m, 2 * off_m);
  for (const std::string& part : parts_about(target.mesh, added.position_m, reach_m)) {
    parts.push_back(toml_text(part));
  }
  if (parts.empty()) {
    throw InputError(fmt::format("--add {}: no part of the mesh has a vertex within {:.3g} m",
                                 added.name, reach_m));
  }
  const Eigen::Vector3d& p = added.position_m;
  return fmt::format(
      "\n{}\nname = {}\nkind = \"contour\"\nposition_m = [{}, {}, {}]\nclearance_m = {:.6g}\n"
      "parts = [{}]\nreach_m = {:.6g}\n",
      kFeatureLine, toml_text(added.name), p.x(), p.y(), p.z(), off_m + kAddedClearance * size_m,
      fmt::join(parts, ", "), kTipReach * size_m);
}

// Writes the text and loads it as a target; takes it back where that fails.
void replace_text(const fs::path& file, const std::string& before, const std::string& after) {
  write_file(file, after);
  try {
    load_target(file.string());
  } catch (const InputError&) {
    write_file(file, before);
    throw;
  }
}

}  // namespace

std::string edit_target(const fs::path& file, const TargetEdits& edits) {
  if (file.extension() != ".toml") {
    throw InputError(
        fmt::format("{}: --drop and --add change a target.toml (see --propose)", file.string()));
  }
  const std::shared_ptr<const Target> target = load_target(file.string());
  if (!target->has_mesh()) {
    throw InputError(fmt::format("{}: has keypoints alone; change them by hand", file.string()));
  }
  const std::string before = read_input_file(file, kMostTextBytes);
  std::vector<std::string> pieces = cut_at_features(before);
  if (pieces.size() != target->features.size() + 1) {
    throw InputError(
        fmt::format("{}: does not begin each feature with a line {}; change it by hand",
                    file.string(), kFeatureLine));
  }
  std::vector<std::string> names;
  for (const TargetFeature& feature : target->features) names.push_back(feature.name);
  std::string told;
  for (const std::string& name : edits.dropped) {
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) {
      throw InputError(fmt::format("--drop {}: {} has no such feature{}", name, file.string(),
                                   suggestion(name, names)));
    }
    pieces.erase(pieces.begin() + 1 + (found - names.begin()));
    names.erase(found);
    told += fmt::format("dropped    {}\n", name);
  }
  for (size_t i = 0; i < edits.added.size(); ++i) {
    const AddedFeature added = read_added(edits.added[i], free_number(names));
    if (std::ranges::find(names, added.name) != names.end()) {
      throw InputError(fmt::format("--add {}: there is a feature of that name", added.name));
    }
    pieces.push_back(feature_text(*target, added));
    names.push_back(added.name);
    told += fmt::format("added      {}\n", added.name);
  }
  replace_text(file, before, fmt::format("{}", fmt::join(pieces, "")));
  return told;
}

}  // namespace sightline
