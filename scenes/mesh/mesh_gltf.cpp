// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

// Compiled here without its image codecs, which nothing needs: Debian's compiled library disagrees
// with its own header about the class and finds no file callbacks.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>
#include <tiny_gltf.h>

#include "scenes/files/input_error.h"
#include "scenes/mesh/gltf_accessor.h"
#include "scenes/mesh/gltf_material.h"
#include "scenes/mesh/gltf_shape.h"
#include "scenes/mesh/gltf_unpack.h"
#include "scenes/mesh/gltf_uri.h"
#include "scenes/mesh/mesh_folder.h"
#include "scenes/mesh/mesh_soup.h"
#include "scenes/mesh/mesh_text.h"
#include "scenes/mesh/textures.h"

namespace sightline {
namespace {

// The three vertex indices of triangle i of a list, strip or fan.
std::array<size_t, 3> corners_of(int mode, size_t i) {
  if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
    return i % 2 == 0 ? std::array<size_t, 3>{i, i + 1, i + 2}
                      : std::array<size_t, 3>{i + 1, i, i + 2};
  }
  if (mode == TINYGLTF_MODE_TRIANGLE_FAN) return {0, i + 1, i + 2};
  return {3 * i, 3 * i + 1, 3 * i + 2};
}

// Extensions that a file may require: those that are read, lights, which a scene has of its own,
// and textures that become lost ones.
constexpr std::array<std::string_view, 11> kKnownExtensions = {
    "KHR_mesh_quantization",
    "EXT_meshopt_compression",
    "KHR_draco_mesh_compression",
    "EXT_mesh_gpu_instancing",
    "KHR_texture_transform",
    "EXT_texture_webp",
    "KHR_materials_unlit",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_lights_punctual",
    "KHR_texture_basisu"};

bool is_known(const std::string& extension) {
  return std::find(kKnownExtensions.begin(), kKnownExtensions.end(), extension) !=
         kKnownExtensions.end();
}

void require_known_extensions(const tinygltf::Model& model, const std::filesystem::path& file) {
  for (const std::string& extension : model.extensionsRequired) {
    if (is_known(extension)) continue;
    fail_gltf(file, fmt::format("it requires the extension {}, which is not known here; export it "
                                "without (known: {})",
                                extension, fmt::join(kKnownExtensions, ", ")));
  }
}

class Reader {
 public:
  Reader(const tinygltf::Model& model, const std::filesystem::path& file)
      : model_(model),
        file_(file),
        file_from_nodes_(global_transforms(model, file)),
        shelf_(soup_, file),
        materials_(model, file, shelf_) {}

  MeshSoup read() {
    require_known_extensions(model_, file_);
    for (const int node : root_nodes()) add_node(node);
    add_notes();
    return std::move(soup_);
  }

 private:
  // Those of the default scene; in a file without scenes, the nodes that are nobody's child.
  std::vector<int> root_nodes() const {
    if (!model_.scenes.empty()) {
      const size_t scene = static_cast<size_t>(std::max(0, model_.defaultScene));
      if (scene >= model_.scenes.size()) fail_gltf(file_, "bad scene index");
      return model_.scenes[scene].nodes;
    }
    std::set<int> children;
    for (const tinygltf::Node& node : model_.nodes) {
      children.insert(node.children.begin(), node.children.end());
    }
    std::vector<int> roots;
    for (int i = 0; i < static_cast<int>(model_.nodes.size()); ++i) {
      if (!children.contains(i)) roots.push_back(i);
    }
    return roots;
  }

  // The nodes make a forest: see global_transforms.
  void add_node(int index) {
    if (index < 0 || index >= static_cast<int>(model_.nodes.size())) {
      fail_gltf(file_, "bad node index");
    }
    if (!visited_.insert(index).second) {
      fail_gltf(file_, fmt::format("node {} is in the scene twice", index));
    }
    const tinygltf::Node& node = model_.nodes[index];
    if (node.mesh >= 0 && node.mesh < static_cast<int>(model_.meshes.size())) {
      for (const tinygltf::Primitive& primitive : model_.meshes[node.mesh].primitives) {
        add_primitive(primitive, node, file_from_nodes_[index]);
      }
    }
    for (const int child : node.children) add_node(child);
  }

  void add_primitive(const tinygltf::Primitive& primitive, const tinygltf::Node& node,
                     const Eigen::Matrix4d& file_from_node) {
    const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP &&
        mode != TINYGLTF_MODE_TRIANGLE_FAN) {
      ++undrawn_primitives_;  // points and lines
      return;
    }
    if (!primitive.attributes.contains("POSITION")) return;
    const GltfShape shape(model_, primitive, node, file_from_nodes_, file_);
    std::optional<GltfAccessor> indices;
    if (primitive.indices >= 0) indices.emplace(model_, primitive.indices, file_);
    const size_t corner_count = indices ? indices->count() : shape.vertex_count();
    const size_t triangle_count = mode == TINYGLTF_MODE_TRIANGLES ? corner_count / 3
                                  : corner_count < 3              ? 0
                                                                  : corner_count - 2;
    std::vector<Eigen::Matrix4d> copies = instances_of(model_, node, file_);
    if (shape.is_skinned()) copies.assign(1, Eigen::Matrix4d::Identity());
    if (triangle_count > 0 && copies.size() > kMaxTriangles / triangle_count) {
      require_room(soup_, kMaxTriangles + 1, file_);
    }
    require_room(soup_, triangle_count * copies.size(), file_);
    const CoatAccessors coats = coats_of(primitive, shape.vertex_count());
    soup_.is_flat.resize(soup_.parts.size());
    soup_.is_flat.push_back(!shape.has_normals());
    std::string name = part_name(primitive, node);
    std::optional<Material> material = material_of(primitive, coats, name);
    soup_.parts.push_back({std::move(name), albedo_of(primitive), std::move(material)});
    std::vector<SoupTransform> transforms;
    for (const Eigen::Matrix4d& copy : copies) {
      transforms.emplace_back(shape.is_skinned() ? copy : Eigen::Matrix4d(file_from_node * copy),
                              triangle_count, shape.vertex_count());
    }
    for (size_t i = 0; i < triangle_count; ++i) {
      SoupTriangle triangle;
      triangle.part = static_cast<int>(soup_.parts.size()) - 1;
      const std::array<size_t, 3> corners = corners_of(mode, i);
      for (int c = 0; c < 3; ++c) {
        const size_t vertex = indices ? indices->index(corners[c]) : corners[c];
        if (vertex >= shape.vertex_count()) fail_gltf(file_, "an index is out of range");
        triangle.vertex[c] = static_cast<int>(vertex);
        triangle.corner[c] = shape.position(vertex);
        triangle.normal[c] = shape.normal(vertex);
        coats.read(vertex, c, triangle.coat);
      }
      for (SoupTransform& transform : transforms) transform.add(soup_, triangle);
    }
  }

  // What the file holds and a picture of it does not show.
  void add_notes() {
    std::vector<std::string> undrawn;
    if (undrawn_primitives_ > 0) {
      undrawn.push_back(fmt::format("{} primitive{} of points or lines", undrawn_primitives_,
                                    undrawn_primitives_ == 1 ? "" : "s"));
    }
    if (!model_.animations.empty()) {
      undrawn.push_back(fmt::format("{} animation{} (it stands as its nodes do)",
                                    model_.animations.size(),
                                    model_.animations.size() == 1 ? "" : "s"));
    }
    if (!model_.lights.empty()) {
      undrawn.push_back(fmt::format("{} light{} of its own", model_.lights.size(),
                                    model_.lights.size() == 1 ? "" : "s"));
    }
    if (model_.scenes.size() > 1) {
      undrawn.push_back(fmt::format("{} other scene{}", model_.scenes.size() - 1,
                                    model_.scenes.size() == 2 ? "" : "s"));
    }
    if (!undrawn.empty())
      soup_.notes.push_back(fmt::format("not drawn: {}", fmt::join(undrawn, ", ")));
    if (!without_uv_.empty()) {
      soup_.notes.push_back(fmt::format(
          "drawn without textures, whose coordinates are not there: {}", listed(without_uv_)));
    }
    if (!materials_.left_out().empty()) {
      soup_.notes.push_back(
          fmt::format("not drawn, since a material takes one set of texture coordinates: {}",
                      listed(materials_.left_out())));
    }
  }

  // Where a primitive's corners have texture coordinates and colours.
  struct CoatAccessors {
    std::optional<GltfAccessor> uv;
    std::optional<GltfAccessor> colours;
    bool is_uv_normalised = true;  // whole numbers always are, but for KHR_mesh_quantization

    void read(size_t vertex, int corner, Coat& coat) const {
      if (uv && vertex < uv->count()) {
        uv->read_numbers(vertex, {coat.uv[corner].data(), 2}, is_uv_normalised);
      }
      if (!colours || vertex >= colours->count()) return;
      Eigen::Vector4f& colour = coat.colour[corner];
      colours->read_numbers(vertex, {colour.data(), 4}, true);
      for (float& channel : colour) channel = channel > 0 ? std::min(channel, 1.0f) : 0.0f;
    }
  };

  bool has_material(const tinygltf::Primitive& primitive) const {
    return primitive.material >= 0 &&
           primitive.material < static_cast<int>(model_.materials.size());
  }

  // Those of an attribute; none where the primitive lacks it.
  std::optional<GltfAccessor> attribute(const tinygltf::Primitive& primitive,
                                        const std::string& name, size_t vertices) const {
    const auto found = primitive.attributes.find(name);
    if (found == primitive.attributes.end()) return std::nullopt;
    GltfAccessor accessor(model_, found->second, file_);
    require_one_each(accessor, name, vertices, file_);
    return accessor;
  }

  CoatAccessors coats_of(const tinygltf::Primitive& primitive, size_t vertices) const {
    const int set = has_material(primitive) ? materials_.uv_set(primitive.material) : 0;
    CoatAccessors out;
    const auto& used = model_.extensionsUsed;
    out.is_uv_normalised =
        std::find(used.begin(), used.end(), "KHR_mesh_quantization") == used.end();
    out.uv = attribute(primitive, fmt::format("TEXCOORD_{}", set), vertices);
    out.colours = attribute(primitive, "COLOR_0", vertices);
    return out;
  }

  std::optional<Material> material_of(const tinygltf::Primitive& primitive,
                                      const CoatAccessors& coats, const std::string& part) {
    std::optional<Material> material;
    if (has_material(primitive)) material = materials_.material(primitive.material);
    if (!material && coats.colours) material.emplace();  // white and dull
    if (!material) return material;
    const auto refs = material->textures();
    const bool has_texture =
        std::any_of(refs.begin(), refs.end(), [](const TextureRef* r) { return r->is_there(); });
    if (!coats.uv) {
      for (TextureRef* ref : refs) *ref = {};
      if (has_texture) {
        without_uv_.insert(
            fmt::format("{} (TEXCOORD_{})", part, materials_.uv_set(primitive.material)));
      }
    }
    soup_.has_coats = soup_.has_coats || (has_texture && coats.uv) || coats.colours;
    return material;
  }

  std::string part_name(const tinygltf::Primitive& primitive, const tinygltf::Node& node) const {
    if (!node.name.empty() && model_.meshes[node.mesh].primitives.size() == 1) return node.name;
    if (has_material(primitive) && !model_.materials[primitive.material].name.empty()) {
      return model_.materials[primitive.material].name;
    }
    return fmt::format("part_{}", soup_.parts.size());
  }

  double albedo_of(const tinygltf::Primitive& primitive) const {
    if (!has_material(primitive)) return Part{}.albedo;
    const auto& colour = model_.materials[primitive.material].pbrMetallicRoughness.baseColorFactor;
    return colour.size() < 3 ? Part{}.albedo : luminance(colour[0], colour[1], colour[2]);
  }

  const tinygltf::Model& model_;
  const std::filesystem::path& file_;
  std::vector<Eigen::Matrix4d> file_from_nodes_;
  std::set<int> visited_;
  int undrawn_primitives_ = 0;
  std::set<std::string> without_uv_;  // parts
  MeshSoup soup_;
  TextureShelf shelf_;
  GltfMaterials materials_;
};

constexpr std::string_view kBinaryMagic = "glTF";

// Throws unless the chunks of a .glb lie within it: tinygltf believes their lengths.
void require_whole_glb(std::string_view bytes, const std::filesystem::path& file) {
  constexpr size_t kHeaderBytes = 12;  // magic, version, length
  constexpr size_t kChunkHeaderBytes = 8;
  if (bytes.size() < kHeaderBytes) fail_gltf(file, "it is torn within its header");
  uint32_t declared = 0;
  std::memcpy(&declared, bytes.data() + 8, sizeof declared);
  bytes = bytes.substr(0, declared);
  size_t at = kHeaderBytes;
  while (at < bytes.size()) {
    if (bytes.size() - at < kChunkHeaderBytes)
      fail_gltf(file, "it is torn within a chunk's header");
    uint32_t length = 0;
    std::memcpy(&length, bytes.data() + at, sizeof length);
    at += kChunkHeaderBytes;
    if (length > bytes.size() - at) fail_gltf(file, "it is torn: a chunk is longer than the file");
    at += length;
  }
}

// What tinygltf may open: the files that the mesh may name, and what was unpacked.
struct Files {
  MeshFolder folder;
  std::map<std::string, GltfBytes> unpacked = {};

  const GltfBytes* find_unpacked(const std::string& path) const {
    const auto found = unpacked.find(std::filesystem::path(path).filename().string());
    return found == unpacked.end() ? nullptr : &found->second;
  }
};

bool is_readable(const std::string& path, void* files) {
  const auto& of = *static_cast<const Files*>(files);
  // One that lies outside too: `read_buffer` says so.
  return of.find_unpacked(path) != nullptr || of.folder.find(path) || of.folder.is_outside(path);
}

bool read_buffer(std::vector<unsigned char>* out, std::string* error, const std::string& path,
                 void* files) {
  const auto& of = *static_cast<const Files*>(files);
  if (const GltfBytes* unpacked = of.find_unpacked(path)) {
    *out = *unpacked;
    return true;
  }
  const auto found = of.folder.find(path);
  if (!found) {
    *error = "it lies outside the mesh's folder and is not read";
    return false;
  }
  const std::optional<std::string> bytes = whole_file(*found);
  if (!bytes) return false;
  out->assign(bytes->begin(), bytes->end());
  return true;
}

// The buffer of a URI: data that stand in it, or a file.
GltfBytes buffer_of(const std::string& uri, Files& files) {
  GltfBytes out;
  std::string unused;
  if (tinygltf::IsDataURI(uri)) {
    tinygltf::DecodeDataURI(&out, unused, uri, 0, false);
    return out;
  }
  if (!read_buffer(&out, &unused, path_of_uri(uri), &files)) {
    throw InputError(fmt::format("buffer {} cannot be read", uri));
  }
  return out;
}

}  // namespace

MeshSoup read_gltf_bytes(std::string_view bytes, const std::filesystem::path& file) {
  Files files{MeshFolder(file)};
  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks({.FileExists = is_readable,
                         .ExpandFilePath = tinygltf::ExpandFilePath,
                         .ReadWholeFile = read_buffer,
                         .WriteWholeFile = tinygltf::WriteWholeFile,
                         .user_data = &files});
  // Images stay as their files have them: which are needed, and how, the materials say.
  loader.SetImageLoader(
      [](tinygltf::Image* image, const int, std::string*, std::string*, int, int,
         const unsigned char* image_bytes, int count, void*) {
        image->image.assign(image_bytes, image_bytes + count);
        return true;
      },
      nullptr);
  if (bytes.size() > std::numeric_limits<unsigned>::max()) {
    fail_gltf(file, "it is larger than 4 GiB");
  }
  if (bytes.starts_with(kBinaryMagic)) require_whole_glb(bytes, file);
  std::string plain;
  if (auto escaped = with_escaped_pluses(bytes)) {
    plain = *std::move(escaped);
    bytes = plain;
  }
  try {
    if (auto unpacked =
            unpack_gltf(bytes, [&](const std::string& uri) { return buffer_of(uri, files); })) {
      plain = std::move(unpacked->json);
      files.unpacked = std::move(unpacked->buffers);
      bytes = plain;
    }
  } catch (const InputError& error) {
    fail_gltf(file, error.what());
  }
  const auto size = static_cast<unsigned>(bytes.size());
  tinygltf::Model model;
  std::string error, warning;
  const bool read =
      bytes.starts_with(kBinaryMagic)
          ? loader.LoadBinaryFromMemory(&model, &error, &warning,
                                        reinterpret_cast<const unsigned char*>(bytes.data()), size,
                                        files.folder.path().string())
          : loader.LoadASCIIFromString(&model, &error, &warning, bytes.data(), size,
                                       files.folder.path().string());
  if (!read) fail_gltf(file, error.empty() ? "not a glTF file" : error);
  return Reader(model, file).read();
}

MeshSoup read_gltf(const std::filesystem::path& file) {
  const auto bytes = whole_file(file);
  if (!bytes) fail_gltf(file, "it cannot be opened");
  return read_gltf_bytes(*bytes, file);
}

}  // namespace sightline
