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
#include "scenes/mesh/textures.h"

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

// What the files that are read share: where the textures go, and what is read.
struct Reading {
  const aiScene& scene;
  const std::filesystem::path& file;
  MeshSoup& soup;
  TextureShelf& shelf;
};

Wrap wrap_of(const aiMaterial& material, const char* key, unsigned type, unsigned index) {
  int mode = aiTextureMapMode_Wrap;
  material.Get(key, type, index, mode);
  if (mode == aiTextureMapMode_Mirror) return Wrap::kMirror;
  return mode == aiTextureMapMode_Clamp ? Wrap::kClamp : Wrap::kRepeat;
}

// The index of a texture that a material names: a file, or one within the mesh's file.
int texture_index(const Reading& reading, const aiString& path) {
  const aiTexture* inside = reading.scene.GetEmbeddedTexture(path.C_Str());
  if (inside == nullptr) return reading.shelf.from_file(path.C_Str(), true);
  const bool is_encoded = inside->mHeight == 0;  // then the width is its bytes
  const auto* bytes = reinterpret_cast<const char*>(inside->pcData);
  const std::string name = fmt::format("{} within the file", path.C_Str());
  return reading.shelf.from_bytes({bytes, is_encoded ? inside->mWidth : 0}, name, true);
}

// The texture of a material's colour; `is_named` also where it is lost.
TextureRef base_texture_of(const Reading& reading, const aiMaterial& material, bool& is_named) {
  for (const aiTextureType type : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}) {
    aiString path;
    if (material.GetTexture(type, 0, &path) != aiReturn_SUCCESS || path.length == 0) continue;
    is_named = true;
    // Assimp's coordinates begin at the lower left corner.
    return {.texture = texture_index(reading, path),
            .wrap_u = wrap_of(material, AI_MATKEY_MAPPINGMODE_U(type, 0)),
            .wrap_v = wrap_of(material, AI_MATKEY_MAPPINGMODE_V(type, 0)),
            .texture_from_uv = {1, 0, 0, 0, -1, 1}};
  }
  return {};
}

// A colour of nothing beside a texture means that the texture is the colour.
aiColor3D diffuse_of(const aiMaterial* material, bool has_texture) {
  aiColor3D diffuse(0.8f, 0.8f, 0.8f);
  if (material != nullptr) material->Get(AI_MATKEY_COLOR_DIFFUSE, diffuse);
  if (has_texture && diffuse.IsBlack()) diffuse = aiColor3D(1, 1, 1);
  return diffuse;
}

double within_unit(double value) {
  return value > 0 ? std::min(value, 1.0) : 0.0;
}

Part part_of(const Reading& reading, const aiMesh& mesh, std::string name) {
  const aiScene& scene = reading.scene;
  const aiMaterial* from =
      mesh.mMaterialIndex < scene.mNumMaterials ? scene.mMaterials[mesh.mMaterialIndex] : nullptr;
  bool has_texture = false;
  Material material;
  if (from != nullptr && mesh.HasTextureCoords(0)) {
    material.base_texture = base_texture_of(reading, *from, has_texture);
  }
  const aiColor3D diffuse = diffuse_of(from, has_texture);
  const double albedo = luminance(diffuse.r, diffuse.g, diffuse.b);
  const bool is_grey = diffuse.r == diffuse.g && diffuse.g == diffuse.b;
  if (is_grey && !has_texture && !mesh.HasVertexColors(0)) return {std::move(name), albedo};
  material.base = {within_unit(diffuse.r), within_unit(diffuse.g), within_unit(diffuse.b), 1};
  if (mesh.HasVertexColors(0) && !has_texture) material.base = {1, 1, 1, 1};
  reading.soup.has_coats |= material.base_texture.is_there() || mesh.HasVertexColors(0);
  return {std::move(name), albedo, material};
}

// Formats of that kind have the colours of their vertices as pictures have them, encoded.
float linear_colour(float encoded) {
  return static_cast<float>(linear_from_srgb(within_unit(encoded)));
}

void set_coat(const aiMesh& mesh, unsigned vertex, int corner, Coat& coat) {
  if (mesh.HasTextureCoords(0)) {
    const aiVector3D& uv = mesh.mTextureCoords[0][vertex];
    coat.uv[corner] = {uv.x, uv.y};
  }
  if (!mesh.HasVertexColors(0)) return;
  const aiColor4D& c = mesh.mColors[0][vertex];
  coat.colour[corner] = {linear_colour(c.r), linear_colour(c.g), linear_colour(c.b),
                         static_cast<float>(within_unit(c.a))};
}

void add_mesh(const Reading& reading, const aiMesh& mesh, const aiNode& node,
              const Eigen::Matrix4d& file_from_node) {
  MeshSoup& soup = reading.soup;
  require_room(soup, mesh.mNumFaces, reading.file);
  // Formats differ in where they name a piece: .ac on the node, .obj and .3ds on the mesh.
  const std::string node_name = node.mName.C_Str();
  const std::string mesh_name = mesh.mName.C_Str();
  const bool use_node = !node_name.empty() && &node != reading.scene.mRootNode;
  std::string name = use_node ? node_name : mesh_name;
  if (name.empty()) name = fmt::format("part_{}", soup.parts.size());
  soup.parts.push_back(part_of(reading, mesh, std::move(name)));
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
      set_coat(mesh, index, corner, triangle.coat);
    }
    add_transformed(soup, triangle, file_from_node);
  }
}

void add_node(const Reading& reading, const aiNode& node, const Eigen::Matrix4d& file_from_parent) {
  const Eigen::Matrix4d file_from_node = file_from_parent * to_eigen(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    add_mesh(reading, *reading.scene.mMeshes[node.mMeshes[i]], node, file_from_node);
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) {
    add_node(reading, *node.mChildren[i], file_from_node);
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
  TextureShelf shelf(soup, file);
  add_node({*scene, file, soup, shelf}, *scene->mRootNode, Eigen::Matrix4d::Identity());
  return soup;
}

}  // namespace sightline
