// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <iterator>
#include <map>
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
#include "scenes/mesh/assimp_material.h"
#include "scenes/mesh/mesh_folder.h"
#include "scenes/mesh/mesh_soup.h"
#include "scenes/mesh/mesh_text.h"
#include "scenes/mesh/mtl_text.h"
#include "scenes/mesh/obj_text.h"
#include "scenes/mesh/ply_faces.h"
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

// What a file's own text says and Assimp does not.
struct OwnText {
  std::map<std::string, MtlMaterial> materials;  // of an .obj
  std::set<std::string> missing;                 // of an .obj, files of materials
  PlyFaceColours faces;                          // of a .ply
};

// What the files that are read share: where the materials come from, and what is read.
struct Reading {
  const aiScene& scene;
  const std::filesystem::path& file;
  MeshSoup& soup;
  AssimpMaterials& materials;
  const PlyFaceColours& faces;
};

// Whether the colours of the file's faces are those of the mesh's triangles.
bool has_face_colours(const aiScene& scene, const PlyFaceColours& faces) {
  return scene.mNumMeshes == 1 && !scene.mMeshes[0]->HasVertexColors(0) &&
         !faces.of_triangles.empty() && faces.of_triangles.size() == scene.mMeshes[0]->mNumFaces;
}

// Formats of that kind have the colours of their vertices as pictures have them, encoded.
Eigen::Vector4f linear_colour(const Eigen::Vector4f& encoded) {
  Eigen::Vector4f linear;
  for (int i = 0; i < 3; ++i) {
    linear[i] = static_cast<float>(linear_from_srgb(within_unit(encoded[i])));
  }
  linear[3] = static_cast<float>(within_unit(encoded[3]));
  return linear;
}

void set_coat(const aiMesh& mesh, unsigned vertex, int corner, Coat& coat) {
  if (mesh.HasTextureCoords(0)) {
    const aiVector3D& uv = mesh.mTextureCoords[0][vertex];
    coat.uv[corner] = {uv.x, uv.y};
  }
  if (!mesh.HasVertexColors(0)) return;
  const aiColor4D& c = mesh.mColors[0][vertex];
  coat.colour[corner] = linear_colour({c.r, c.g, c.b, c.a});
}

// Says whether the last part makes coats necessary; colours of faces lie on white.
void mark_coats(MeshSoup& soup, bool has_vertex_colours, bool has_face_colours) {
  std::optional<Material>& material = soup.parts.back().material;
  if (!material && has_face_colours) material.emplace();
  if (!material) return;
  if (has_face_colours && !material->base_texture.is_there()) {
    material->base = {1, 1, 1, material->base[3]};
  }
  const auto refs = material->textures();
  soup.has_coats |= has_vertex_colours || has_face_colours ||
                    std::any_of(refs.begin(), refs.end(), [](auto* r) { return r->is_there(); });
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
  soup.parts.push_back(reading.materials.part(mesh, std::move(name)));
  const bool has_faces = has_face_colours(reading.scene, reading.faces);
  mark_coats(soup, mesh.HasVertexColors(0), has_faces);
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
      if (has_faces) {
        triangle.coat.colour[corner] = linear_colour(reading.faces.of_triangles[i]);
      }
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

void read_materials(const std::filesystem::path& obj, std::string_view text, OwnText& own) {
  const MeshFolder folder(obj);
  for (const std::string& name : mtl_files(text)) {
    auto found = folder.find(name);
    // Assimp takes the one that is called as the .obj in the place of one that is not there.
    if (!found) found = folder.find(std::filesystem::path(obj).replace_extension(".mtl"));
    if (found) own.materials.merge(mtl_materials(whole_file(*found).value_or("")));
    if (!found && !folder.is_outside(name)) own.missing.insert(name);
  }
}

// Gives Assimp what it can read of a file that it cannot read as it is: a georeferenced .obj or
// .ply moved near its origin, a tidy .stl. Returns how what is read goes back.
Eigen::Matrix4d prepare(const std::filesystem::path& file, FolderOnly& files, OwnText& own) {
  Eigen::Matrix4d file_from_read = Eigen::Matrix4d::Identity();
  const std::string extension = lower_extension(file);
  if (extension == ".stl") {
    std::string tidy = tidy_stl(whole_file(file).value_or(""));
    if (!tidy.empty()) files.give(file, std::move(tidy));
  }
  if (extension != ".obj" && extension != ".ply") return file_from_read;
  const std::string text = whole_file(file).value_or("");
  if (extension == ".obj") read_materials(file, text, own);
  if (extension == ".ply") own.faces = ply_face_colours(text);
  if (auto moved = moved_near(extension, text)) {
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
  OwnText own;
  Eigen::Matrix4d file_from_read = prepare(whole_path, *files, own);
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
  AssimpMaterials materials(*scene, std::move(own.materials), shelf);
  add_node({*scene, file, soup, materials, own.faces}, *scene->mRootNode, file_from_read);
  add_notes(*scene, *files, soup);
  if (!own.missing.empty()) {
    soup.notes.push_back(
        fmt::format("drawn without its materials, whose file is missing: {}", listed(own.missing)));
  }
  for (std::string& note : materials.notes()) soup.notes.push_back(std::move(note));
  if (own.faces.are_there && !has_face_colours(*scene, own.faces)) {
    soup.notes.emplace_back("not drawn: the colours of its faces");
  }
  return soup;
}

}  // namespace sightline
