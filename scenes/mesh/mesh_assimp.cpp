// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <assimp/DefaultIOSystem.h>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include "scenes/files/input_error.h"
#include "scenes/mesh/mesh_soup.h"

namespace sightline {
namespace {

// Materials and scenes name other files: only those of the mesh's own folder are opened.
class FolderOnly : public Assimp::DefaultIOSystem {
 public:
  explicit FolderOnly(std::filesystem::path folder) : folder_(std::move(folder)) {}

  bool Exists(const char* file) const override {
    return is_inside(folder_, file) && std::filesystem::is_regular_file(file);
  }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    return Exists(file) ? DefaultIOSystem::Open(file, mode) : nullptr;
  }

 private:
  std::filesystem::path folder_;
};

Eigen::Matrix4d to_eigen(const aiMatrix4x4& m) {
  Eigen::Matrix4d out;
  for (int row = 0; row < 4; ++row) {
    for (int col = 0; col < 4; ++col) out(row, col) = m[row][col];
  }
  return out;
}

Eigen::Vector3d to_eigen(const aiVector3D& v) {
  return {v.x, v.y, v.z};
}

double albedo_of(const aiScene& scene, const aiMesh& mesh) {
  aiColor3D diffuse(0.8f, 0.8f, 0.8f);
  if (mesh.mMaterialIndex < scene.mNumMaterials) {
    scene.mMaterials[mesh.mMaterialIndex]->Get(AI_MATKEY_COLOR_DIFFUSE, diffuse);
  }
  return luminance(diffuse.r, diffuse.g, diffuse.b);
}

void add_mesh(const aiScene& scene, const aiMesh& mesh, const aiNode& node,
              const Eigen::Matrix4d& file_from_node, const std::filesystem::path& file,
              MeshSoup& soup) {
  require_room(soup, mesh.mNumFaces, file);
  // Formats differ in where they name a piece: .ac on the node, .obj and .3ds on the mesh.
  const std::string node_name = node.mName.C_Str();
  const std::string mesh_name = mesh.mName.C_Str();
  const bool use_node = !node_name.empty() && &node != scene.mRootNode;
  std::string name = use_node ? node_name : mesh_name;
  if (name.empty()) name = fmt::format("part_{}", soup.parts.size());
  soup.parts.push_back({name, albedo_of(scene, mesh)});
  for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
    const aiFace& face = mesh.mFaces[i];
    if (face.mNumIndices != 3) continue;  // points and lines
    SoupTriangle triangle;
    triangle.part = static_cast<int>(soup.parts.size()) - 1;
    for (int corner = 0; corner < 3; ++corner) {
      const unsigned index = face.mIndices[corner];
      triangle.corner[corner] = to_eigen(mesh.mVertices[index]);
      triangle.normal[corner] =
          mesh.HasNormals() ? to_eigen(mesh.mNormals[index]) : Eigen::Vector3d::Zero();
    }
    add_transformed(soup, triangle, file_from_node);
  }
}

void add_node(const aiScene& scene, const aiNode& node, const Eigen::Matrix4d& file_from_parent,
              const std::filesystem::path& file, MeshSoup& soup) {
  const Eigen::Matrix4d file_from_node = file_from_parent * to_eigen(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    add_mesh(scene, *scene.mMeshes[node.mMeshes[i]], node, file_from_node, file, soup);
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) {
    add_node(scene, *node.mChildren[i], file_from_node, file, soup);
  }
}

}  // namespace

MeshSoup read_with_assimp(const std::filesystem::path& file) {
  const std::filesystem::path whole_path = std::filesystem::absolute(file);
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, true);  // not their ids
  importer.SetIOHandler(new FolderOnly(whole_path.parent_path()));  // the importer deletes it
  const aiScene* scene = importer.ReadFile(whole_path.string(),
                                           aiProcess_Triangulate | aiProcess_ValidateDataStructure);
  const bool is_whole = scene != nullptr && scene->mRootNode != nullptr &&
                        (scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE) == 0;
  if (!is_whole) {
    throw InputError(
        fmt::format("{}: cannot be read as a mesh: {}", file.string(), importer.GetErrorString()));
  }
  MeshSoup soup;
  add_node(*scene, *scene->mRootNode, Eigen::Matrix4d::Identity(), file, soup);
  return soup;
}

}  // namespace sightline
