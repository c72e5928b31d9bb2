// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/bop/models.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "eval/datasets/bop/layout.h"
#include "eval/datasets/bop/numbered.h"
#include "eval/datasets/conventions.h"
#include "eval/datasets/ply_reader.h"
#include "eval/output/json.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"
#include "scenes/mesh/diameter.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr double kSymmetryStep = 0.01;       // of the diameter
constexpr size_t kMostSymmetries = 100'000;  // every vertex is held against each

using RowWise4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

std::vector<Pose> discrete_symmetries(const Json& info) {
  std::vector<Pose> poses{Pose{}};
  if (!info.contains("symmetries_discrete")) return poses;
  for (const Json& symmetry : info["symmetries_discrete"]) {
    const auto values = finite_numbers(symmetry, "symmetries_discrete", 16);
    const RowWise4 matrix = Eigen::Map<const RowWise4>(values.data());
    const auto rotation = usable_rotation(Eigen::Matrix3d(matrix.topLeftCorner<3, 3>()));
    if (!rotation) {
      throw InputError(
          fmt::format("symmetries_discrete has no rotation at place {}", poses.size() - 1));
    }
    poses.push_back({*rotation, matrix.topRightCorner<3, 1>()});
  }
  return poses;
}

std::vector<SymmetryAxis> axes_of(const Json& info) {
  std::vector<SymmetryAxis> axes;
  if (!info.contains("symmetries_continuous")) return axes;
  for (const Json& symmetry : info["symmetries_continuous"]) {
    const Eigen::Vector3d axis(numbers_in(symmetry, "axis", 3).data());
    const Eigen::Vector3d offset(numbers_in(symmetry, "offset", 3).data());
    if (axis.isZero()) throw InputError("symmetries_continuous has an axis of no length");
    axes.push_back({axis.normalized(), offset});
  }
  return axes;
}

std::vector<Pose> turns_about(const std::vector<SymmetryAxis>& axes, int steps) {
  std::vector<Pose> poses;
  for (const SymmetryAxis& axis : axes) {
    for (int i = 0; i < steps; ++i) {
      const double angle_rad = 2 * std::numbers::pi * i / steps;
      const Eigen::Matrix3d rotation = rotation_from_vector(angle_rad * axis.direction);
      poses.push_back({rotation, axis.point - rotation * axis.point});
    }
  }
  return poses;
}

std::vector<Pose> symmetries_of(const Json& info) {
  const std::vector<Pose> discrete = discrete_symmetries(info);
  const std::vector<SymmetryAxis> axes = axes_of(info);
  const int steps = static_cast<int>(std::ceil(std::numbers::pi / kSymmetryStep));
  const size_t count = discrete.size() * std::max<size_t>(1, axes.size() * steps);
  if (count > kMostSymmetries) {
    throw InputError(fmt::format("its symmetries make {} poses of one, must make {} at most", count,
                                 kMostSymmetries));
  }
  if (axes.empty()) return discrete;
  const std::vector<Pose> turns = turns_about(axes, steps);
  std::vector<Pose> poses;
  for (const Pose& jump : discrete) {
    for (const Pose& turn : turns) poses.push_back(turn * jump);
  }
  return poses;
}

// Where a set has its models. Some have them several times, as drawn (models_cad) and as scanned
// (models_reconst), and some of those alone.
fs::path models_folder(const fs::path& set) {
  for (const std::string_view name : {bop::kEvaluatedModelsFolder, bop::kModelsFolder}) {
    if (fs::is_directory(set / name)) return set / name;
  }
  std::set<fs::path> others;
  for (const auto& entry : fs::directory_iterator(set)) {
    const bool is_one = entry.path().filename().string().starts_with(bop::kModelsFolder);
    if (is_one && entry.is_directory()) others.insert(entry.path());
  }
  return others.empty() ? set / bop::kModelsFolder : *others.begin();
}

BopModel read_model(const fs::path& file) {
  BopModel model;
  model.mesh_mm = read_ply_as_it_is(file);
  model.points_mm.resize(3, static_cast<Eigen::Index>(model.mesh_mm.vertices.size()));
  for (size_t i = 0; i < model.mesh_mm.vertices.size(); ++i) {
    model.points_mm.col(static_cast<Eigen::Index>(i)) = model.mesh_mm.vertices[i];
  }
  model.symmetries = {Pose{}};
  return model;
}

std::optional<Eigen::AlignedBox3d> stated_box(const Json& info) {
  if (!info.contains("min_x")) return std::nullopt;
  const auto vector = [&info](const std::string& name) {
    return Eigen::Vector3d(number_in(info, name + "_x"), number_in(info, name + "_y"),
                           number_in(info, name + "_z"));
  };
  const Eigen::Vector3d min = vector("min");
  return Eigen::AlignedBox3d(min, min + vector("size"));
}

std::vector<Pose> symmetries_of_object(const Json& info, int obj_id) {
  try {
    return symmetries_of(info);
  } catch (const InputError& error) {
    throw InputError(fmt::format("object {}: {}", obj_id, error.what()));
  }
}

}  // namespace

std::vector<Pose> bop_symmetries(const std::string& info) {
  return symmetries_of(Json::parse(info));
}

fs::path bop_models_info(const fs::path& set) {
  for (const fs::path& folder : {models_folder(set), set / bop::kModelsFolder}) {
    fs::path file = plain_or_packed(folder / bop::kModelsInfoFile);
    if (fs::exists(file)) return file;
  }
  return {};
}

std::map<int, BopModel> read_bop_models(const fs::path& set, const std::set<int>& obj_ids) {
  const fs::path folder = models_folder(set);
  std::map<int, BopModel> models;
  for (const int id : obj_ids) models[id] = read_model(numbered_model(folder, id));
  const fs::path infos_file = bop_models_info(set);
  if (infos_file.empty()) {
    for (auto& [id, model] : models) model.diameter_mm = diameter(model.mesh_mm.vertices);
    return models;
  }
  with_json(infos_file, [&models](const Json& infos) {
    const NumberedEntries by_object(infos);
    for (auto& [id, model] : models) {
      const Json* const info = by_object.find(id);
      if (info == nullptr) throw InputError(fmt::format("has no object {}, which a target is", id));
      model.diameter_mm = info->contains("diameter") ? number_in(*info, "diameter")
                                                     : diameter(model.mesh_mm.vertices);
      if (!(model.diameter_mm > 0)) throw InputError(fmt::format("{}: diameter must be > 0", id));
      model.symmetries = symmetries_of_object(*info, id);
    }
  });
  return models;
}

BopModelFacts bop_model_facts(const fs::path& set, int obj_id) {
  const fs::path folder = models_folder(set);
  BopModelFacts facts{.box_mm = {}, .file = bop_models_info(set), .symmetries = {}};
  if (!facts.file.empty()) {
    with_json(facts.file, [&](const Json& infos) {
      const Json* const info = NumberedEntries(infos).find(obj_id);
      if (info == nullptr) return;
      facts.symmetries = {symmetries_of_object(*info, obj_id), axes_of(*info)};
      facts.box_mm = stated_box(*info);
    });
  }
  const fs::path model_file = numbered_model(folder, obj_id);
  if (facts.box_mm || !fs::exists(model_file)) return facts;
  facts.file = model_file;
  facts.box_mm.emplace();
  for (const Eigen::Vector3d& vertex : read_ply_as_it_is(model_file).vertices) {
    facts.box_mm->extend(vertex);
  }
  return facts;
}

}  // namespace sightline
