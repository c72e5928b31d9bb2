// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "scenes/mesh/gltf_accessor.h"

namespace tinygltf {
class Model;
class Node;
struct Primitive;
}  // namespace tinygltf

namespace sightline {

/// The transform of a node beside its parent's.
Eigen::Matrix4d local_transform(const tinygltf::Node& node);

/// Of every node of the model its transform to the file's axes. Throws InputError for a node with
/// two parents, or nested too deeply.
std::vector<Eigen::Matrix4d> global_transforms(const tinygltf::Model& model,
                                               const std::filesystem::path& file);

/// Where the copies of a node's mesh stand beside the node (EXT_mesh_gpu_instancing); of a node
/// without copies, where it stands itself.
std::vector<Eigen::Matrix4d> instances_of(const tinygltf::Model& model, const tinygltf::Node& node,
                                          const std::filesystem::path& file);

/// The vertices of a primitive as they stand in the file: morphed by the weights that the node or
/// the mesh states, and carried by the skin's joints as the nodes stand, which is the rest pose.
class GltfShape {
 public:
  GltfShape(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
            const tinygltf::Node& node, const std::vector<Eigen::Matrix4d>& file_from_nodes,
            const std::filesystem::path& file);

  size_t vertex_count() const { return positions_.count(); }
  bool has_normals() const { return normals_.has_value(); }
  /// In the mesh's axes; of a skinned mesh, which its node does not move, in the file's.
  bool is_skinned() const { return !joint_matrices_.empty(); }

  Eigen::Vector3d position(size_t vertex) const;
  /// Zero where there is none.
  Eigen::Vector3d normal(size_t vertex) const;

 private:
  struct Target {
    double weight = 0;
    std::optional<GltfAccessor> positions;
    std::optional<GltfAccessor> normals;
  };
  struct Joints {
    GltfAccessor joints;
    GltfAccessor weights;
  };

  void add_targets(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                   const tinygltf::Node& node);
  void add_skin(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                const tinygltf::Node& node, const std::vector<Eigen::Matrix4d>& file_from_nodes);
  Eigen::Matrix4d skin_matrix(size_t vertex) const;

  std::filesystem::path file_;
  GltfAccessor positions_;
  std::optional<GltfAccessor> normals_;
  std::vector<Target> targets_;
  std::vector<Eigen::Matrix4d> joint_matrices_;
  std::vector<Joints> joints_;
};

}  // namespace sightline
