// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <iterator>
#include <new>
#include <optional>
#include <set>
#include <string_view>

#include <assimp/DefaultIOSystem.h>
#include <assimp/Importer.hpp>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenes/files/input_error.h"
#include "scenes/mesh/mesh_folder.h"
#include "scenes/mesh/mesh_soup.h"
#include "scenes/mesh/mesh_text.h"
#include "scenes/mesh/obj_text.h"
#include "scenes/mesh/ply_text.h"
#include "scenes/mesh/textures.h"

namespace sightline {
namespace {

// Materials and scenes name other files: only those that the mesh may name are opened.
class FolderOnly : public Assimp::DefaultIOSystem {
 public:
  explicit FolderOnly(const std::filesystem::path& mesh) : folder_(mesh) {}

  bool Exists(const char* file) const override { return find(file).has_value(); }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    const auto found = find(file);
    if (!found) return nullptr;
    if (!text_.empty() && *found == text_of_) {
      return new Assimp::MemoryIOStream(reinterpret_cast<const uint8_t*>(text_.data()),
                                        text_.size());
    }
    return DefaultIOSystem::Open(found->c_str(), mode);
  }

  // Files that are there, but were not read, as the mesh names them.
  const std::set<std::string>& ignored() const { return ignored_; }

  // What is read for that file, instead of what is in it.
  void give(std::filesystem::path file, std::string text) {
    text_of_ = std::move(file);
    text_ = std::move(text);
  }

 private:
  std::optional<std::filesystem::path> find(const char* file) const {
    const auto found = folder_.find(file);
    std::error_code error;
    if (!found && std::filesystem::is_regular_file(file, error)) {
      ignored_.insert(std::filesystem::path(file).lexically_proximate(folder_.path()).string());
    }
    return found;
  }

  MeshFolder folder_;
  mutable std::set<std::string> ignored_;
  std::filesystem::path text_of_;
  std::string text_;
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
  SoupTransform transform(file_from_node, mesh.mNumFaces, mesh.mNumVertices);
  for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
    const aiFace& face = mesh.mFaces[i];
    if (face.mNumIndices != 3) continue;  // points and lines
    SoupTriangle triangle;
    triangle.part = static_cast<int>(soup.parts.size()) - 1;
    for (int corner = 0; corner < 3; ++corner) {
      const unsigned index = face.mIndices[corner];
      triangle.vertex[corner] = static_cast<int>(index);
      triangle.corner[corner] = to_eigen(mesh.mVertices[index]);
      triangle.normal[corner] =
          mesh.HasNormals() ? to_eigen(mesh.mNormals[index]) : Eigen::Vector3d::Zero();
      set_coat(mesh, index, corner, triangle.coat);
    }
    transform.add(soup, triangle);
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

// The file's text moved near its origin, where it lies far off.
struct MovedText {
  std::string text;
  Eigen::Vector3d by = Eigen::Vector3d::Zero();
};

std::optional<MovedText> moved_near(const std::string& extension, const std::string& text) {
  if (extension == ".obj") {
    if (const auto middle = far_middle(text)) return MovedText{moved_obj(text, *middle), *middle};
  } else if (extension == ".ply") {
    const auto points = double_points(text);
    if (!points) return std::nullopt;
    const auto middle = far_middle(*points, text);
    if (middle) return MovedText{moved_ply(text, *points, *middle), *middle};
  }
  return std::nullopt;
}

// Gives Assimp what it can read of a file that it cannot read as it is: a georeferenced .obj or
// .ply moved near its origin, a tidy .stl. Returns how what is read goes back.
Eigen::Matrix4d prepare(const std::filesystem::path& file, FolderOnly& files) {
  Eigen::Matrix4d file_from_read = Eigen::Matrix4d::Identity();
  const std::string extension = lower_extension(file);
  if (extension == ".stl") {
    std::string tidy = tidy_stl(whole_file(file).value_or(""));
    if (!tidy.empty()) files.give(file, std::move(tidy));
  }
  if (extension != ".obj" && extension != ".ply") return file_from_read;
  if (auto moved = moved_near(extension, whole_file(file).value_or(""))) {
    files.give(file, std::move(moved->text));
    file_from_read.topRightCorner<3, 1>() = moved->by;
  }
  return file_from_read;
}

// Metres in a unit of the file, as far as its format says.
double stated_unit_m(const aiScene& scene, const std::filesystem::path& file) {
  const std::string extension = lower_extension(file);
  if (extension == ".dae") return collada_unit_m(whole_file(file).value_or(""));
  if (extension == ".fbx") {  // in centimetres; a number of either kind, by the file's version
    double centimetres = 1;
    float single = 1;
    if (scene.mMetaData == nullptr) return 0.01;
    if (scene.mMetaData->Get("UnitScaleFactor", centimetres)) return 0.01 * centimetres;
    if (!scene.mMetaData->Get("UnitScaleFactor", single)) return 0.01;
    return 0.01 * std::stod(fmt::format("{}", single));  // 2.54, not what a float makes of it
  }
  return extension == ".3mf"
             ? threemf_unit_m(beginning_in_zip(whole_file(file).value_or(""), ".model"))
             : 1;
}

size_t undrawn_faces(const aiScene& scene) {
  size_t count = 0;
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
    const aiMesh& mesh = *scene.mMeshes[i];
    count += std::count_if(mesh.mFaces, mesh.mFaces + mesh.mNumFaces,
                           [](const aiFace& face) { return face.mNumIndices != 3; });
  }
  return count;
}

std::string counted(size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

// What the file holds and a picture of it does not show.
void add_notes(const aiScene& scene, const FolderOnly& files, MeshSoup& soup) {
  std::vector<std::string> undrawn;
  const size_t faces = undrawn_faces(scene);
  if (faces > 0) undrawn.push_back(counted(faces, "point") + " and lines");
  if (scene.mNumAnimations > 0) {
    undrawn.push_back(counted(scene.mNumAnimations, "animation") + " (it stands as its nodes do)");
  }
  if (scene.mNumLights > 0) undrawn.push_back(counted(scene.mNumLights, "light") + " of its own");
  if (!undrawn.empty()) {
    soup.notes.push_back(fmt::format("not drawn: {}", fmt::join(undrawn, ", ")));
  }
  if (!files.ignored().empty()) {
    soup.notes.push_back(fmt::format("ignored, for they lie outside its folder: {}",
                                     fmt::join(files.ignored(), ", ")));
  }
}

}  // namespace

MeshSoup read_with_assimp(const std::filesystem::path& file) {
  const std::filesystem::path whole_path = std::filesystem::absolute(file).lexically_normal();
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, true);  // not their ids
  // Axes are the file's own, as of every format; the caller says which point where.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  auto* files = new FolderOnly(whole_path);  // the importer deletes it
  importer.SetIOHandler(files);
  Eigen::Matrix4d file_from_read = prepare(whole_path, *files);
  const aiScene* scene = importer.ReadFile(whole_path.string(),
                                           aiProcess_Triangulate | aiProcess_ValidateDataStructure);
  const bool is_whole = scene != nullptr && scene->mRootNode != nullptr &&
                        (scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE) == 0;
  if (!is_whole) {
    const std::string_view why = importer.GetErrorString();
    if (why.find("bad_alloc") != why.npos) throw std::bad_alloc();  // a library's word for memory
    throw InputError(
        fmt::format("{}: cannot be read as a mesh: {}", file.string(), importer.GetErrorString()));
  }
  MeshSoup soup;
  soup.unit_m = stated_unit_m(*scene, whole_path);
  if (soup.unit_m != 1) {
    soup.notes.push_back(fmt::format("its unit is {:.6g} m by its own word", soup.unit_m));
  }
  // Assimp has applied a .dae's unit: what the caller may replace is taken back.
  if (lower_extension(file) == ".dae") file_from_read.topRows<3>() /= soup.unit_m;
  TextureShelf shelf(soup, file);
  add_node({*scene, file, soup, shelf}, *scene->mRootNode, file_from_read);
  add_notes(*scene, *files, soup);
  return soup;
}

}  // namespace sightline
