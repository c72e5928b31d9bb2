// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/gltf_shape.h"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>

// As mesh_gltf.cpp has it, which holds the library's code.
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

namespace sightline {
namespace {

constexpr int kMaxDepth = 256;
constexpr size_t kMaxInstances = 1'000'000;
constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";

Eigen::Matrix4d matrix_of(const Eigen::Vector3d& translation, const Eigen::Quaterniond& rotation,
                          const Eigen::Vector3d& scale) {
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  transform.translate(translation);
  transform.rotate(rotation.normalized());
  transform.scale(scale);
  return transform.matrix();
}

// The parent of every node, or -1. Each has one, says glTF; else a few could unfold into any
// number.
std::vector<int> parents_of(const tinygltf::Model& model, const std::filesystem::path& file) {
  std::vector<int> parents(model.nodes.size(), -1);
  for (size_t i = 0; i < model.nodes.size(); ++i) {
    for (const int child : model.nodes[i].children) {
      if (child < 0 || child >= static_cast<int>(model.nodes.size())) {
        fail_gltf(file, "bad node index");
      }
      if (parents[child] >= 0) fail_gltf(file, fmt::format("node {} has two parents", child));
      parents[child] = static_cast<int>(i);
    }
  }
  return parents;
}

std::optional<GltfAccessor> accessor_of(const tinygltf::Model& model,
                                        const std::map<std::string, int>& attributes,
                                        const std::string& name,
                                        const std::filesystem::path& file) {
  const auto found = attributes.find(name);
  if (found == attributes.end()) return std::nullopt;
  return GltfAccessor(model, found->second, file);
}

// The accessor that an extension's attributes name.
std::optional<GltfAccessor> accessor_of(const tinygltf::Model& model,
                                        const tinygltf::Value& attributes, const char* name,
                                        const std::filesystem::path& file) {
  if (!attributes.Has(name)) return std::nullopt;
  return GltfAccessor(model, attributes.Get(name).GetNumberAsInt(), file);
}

double weight_of(const tinygltf::Model& model, const tinygltf::Node& node, size_t target) {
  const std::vector<double>& weights =
      node.weights.empty() ? model.meshes[node.mesh].weights : node.weights;
  return target < weights.size() ? weights[target] : 0;
}

// Normals go by the cofactors, which are also right for singular and mirroring transforms.
Eigen::Vector3d turned_normal(const Eigen::Matrix3d& m, const Eigen::Vector3d& normal) {
  Eigen::Matrix3d cofactors;
  cofactors.col(0) = m.col(1).cross(m.col(2));
  cofactors.col(1) = m.col(2).cross(m.col(0));
  cofactors.col(2) = m.col(0).cross(m.col(1));
  const Eigen::Vector3d turned = (cofactors * normal).stableNormalized();
  return turned.allFinite() ? turned : Eigen::Vector3d(Eigen::Vector3d::Zero());
}

}  // namespace

Eigen::Matrix4d local_transform(const tinygltf::Node& node) {
  if (node.matrix.size() == 16) return Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
  const auto& q = node.rotation;  // glTF stores x, y, z, w
  return matrix_of(
      node.translation.size() == 3 ? Eigen::Vector3d(node.translation.data())
                                   : Eigen::Vector3d(Eigen::Vector3d::Zero()),
      q.size() == 4 ? Eigen::Quaterniond(q[3], q[0], q[1], q[2]) : Eigen::Quaterniond::Identity(),
      node.scale.size() == 3 ? Eigen::Vector3d(node.scale.data())
                             : Eigen::Vector3d(Eigen::Vector3d::Ones()));
}

std::vector<Eigen::Matrix4d> global_transforms(const tinygltf::Model& model,
                                               const std::filesystem::path& file) {
  const std::vector<int> parents = parents_of(model, file);
  std::vector<Eigen::Matrix4d> global;
  for (size_t i = 0; i < model.nodes.size(); ++i) {
    Eigen::Matrix4d transform = local_transform(model.nodes[i]);
    int depth = 0;
    for (int at = parents[i]; at >= 0; at = parents[at]) {
      if (++depth > kMaxDepth) {
        fail_gltf(file, fmt::format("nodes are nested deeper than {}", kMaxDepth));
      }
      transform = local_transform(model.nodes[at]) * transform;
    }
    global.push_back(transform);
  }
  return global;
}

std::vector<Eigen::Matrix4d> instances_of(const tinygltf::Model& model, const tinygltf::Node& node,
                                          const std::filesystem::path& file) {
  const auto found = node.extensions.find(kInstancing);
  if (found == node.extensions.end() || !found->second.Has("attributes")) {
    return {Eigen::Matrix4d::Identity()};
  }
  const tinygltf::Value& attributes = found->second.Get("attributes");
  const auto translations = accessor_of(model, attributes, "TRANSLATION", file);
  const auto rotations = accessor_of(model, attributes, "ROTATION", file);
  const auto scales = accessor_of(model, attributes, "SCALE", file);
  size_t count = 0;
  for (const auto* accessor : {&translations, &rotations, &scales}) {
    if (*accessor) count = std::max(count, (*accessor)->count());
  }
  if (count > kMaxInstances) {
    fail_gltf(file, fmt::format("a node has {} copies, may have {}", count, kMaxInstances));
  }
  std::vector<Eigen::Matrix4d> instances;
  for (size_t i = 0; i < count; ++i) {
    std::array<float, 4> q{0, 0, 0, 1};
    if (rotations && i < rotations->count()) rotations->read_numbers(i, q);
    const Eigen::Vector3d none = Eigen::Vector3d::Zero();
    const Eigen::Vector3d one = Eigen::Vector3d::Ones();
    instances.push_back(
        matrix_of(translations && i < translations->count() ? translations->vector3(i) : none,
                  Eigen::Quaterniond(q[3], q[0], q[1], q[2]),
                  scales && i < scales->count() ? scales->vector3(i) : one));
  }
  return instances;
}

GltfShape::GltfShape(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                     const tinygltf::Node& node,
                     const std::vector<Eigen::Matrix4d>& file_from_nodes,
                     const std::filesystem::path& file)
    : file_(file),
      positions_(model, primitive.attributes.at("POSITION"), file),
      normals_(accessor_of(model, primitive.attributes, "NORMAL", file)) {
  if (normals_) require_one_each(*normals_, "NORMAL", vertex_count(), file);
  add_targets(model, primitive, node);
  add_skin(model, primitive, node, file_from_nodes);
}

void GltfShape::add_targets(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                            const tinygltf::Node& node) {
  for (size_t i = 0; i < primitive.targets.size(); ++i) {
    const double weight = weight_of(model, node, i);
    if (weight == 0) continue;
    targets_.push_back({weight, accessor_of(model, primitive.targets[i], "POSITION", file_),
                        accessor_of(model, primitive.targets[i], "NORMAL", file_)});
  }
}

void GltfShape::add_skin(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                         const tinygltf::Node& node,
                         const std::vector<Eigen::Matrix4d>& file_from_nodes) {
  if (node.skin < 0) return;
  if (node.skin >= static_cast<int>(model.skins.size())) fail_gltf(file_, "bad skin index");
  for (int set = 0;; ++set) {
    auto joints = accessor_of(model, primitive.attributes, fmt::format("JOINTS_{}", set), file_);
    auto weights = accessor_of(model, primitive.attributes, fmt::format("WEIGHTS_{}", set), file_);
    if (!joints || !weights) break;
    joints_.push_back({std::move(*joints), std::move(*weights)});
  }
  if (joints_.empty()) return;
  const tinygltf::Skin& skin = model.skins[node.skin];
  std::optional<GltfAccessor> inverses;
  if (skin.inverseBindMatrices >= 0) inverses.emplace(model, skin.inverseBindMatrices, file_);
  for (size_t i = 0; i < skin.joints.size(); ++i) {
    const int joint = skin.joints[i];
    if (joint < 0 || joint >= static_cast<int>(file_from_nodes.size())) {
      fail_gltf(file_, "bad joint index");
    }
    Eigen::Matrix4d matrix = file_from_nodes[joint];
    if (inverses && i < inverses->count()) matrix = matrix * inverses->matrix4(i);
    joint_matrices_.push_back(matrix);
  }
}

Eigen::Matrix4d GltfShape::skin_matrix(size_t vertex) const {
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  double total = 0;
  for (const Joints& set : joints_) {
    if (vertex >= set.joints.count() || vertex >= set.weights.count()) continue;
    std::array<float, 4> weights{};
    set.weights.read_numbers(vertex, weights, true);
    for (size_t k = 0; k < weights.size(); ++k) {
      if (weights[k] == 0) continue;
      const size_t joint = set.joints.index(vertex, k);
      if (joint >= joint_matrices_.size()) fail_gltf(file_, "a joint is out of range");
      sum += weights[k] * joint_matrices_[joint];
      total += weights[k];
    }
  }
  return total > 0 ? Eigen::Matrix4d(sum / total) : Eigen::Matrix4d(Eigen::Matrix4d::Identity());
}

Eigen::Vector3d GltfShape::position(size_t vertex) const {
  Eigen::Vector3d position = positions_.vector3(vertex);
  for (const Target& target : targets_) {
    if (!target.positions || vertex >= target.positions->count()) continue;
    position += target.weight * target.positions->vector3(vertex);
  }
  if (!is_skinned()) return position;
  return (skin_matrix(vertex) * position.homogeneous()).head<3>();
}

Eigen::Vector3d GltfShape::normal(size_t vertex) const {
  if (!normals_ || vertex >= normals_->count()) return Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = normals_->vector3(vertex);
  for (const Target& target : targets_) {
    if (!target.normals || vertex >= target.normals->count()) continue;
    normal += target.weight * target.normals->vector3(vertex);
  }
  if (!is_skinned()) return normal;
  return turned_normal(skin_matrix(vertex).topLeftCorner<3, 3>(), normal);
}

}  // namespace sightline
