// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

// Compiled here without its image codecs, which nothing needs: Debian's compiled library disagrees
// with its own header about the class and finds no file callbacks.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <algorithm>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <span>

#include <Eigen/Geometry>
#include <tiny_gltf.h>

#include "scenes/files/input_error.h"
#include "scenes/mesh/gltf_material.h"
#include "scenes/mesh/mesh_soup.h"
#include "scenes/mesh/textures.h"

namespace sightline {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, std::string reason) {
  while (!reason.empty() && reason.back() == '\n') reason.pop_back();
  throw InputError(fmt::format("{}: cannot be read as glTF: {}", file.string(), reason));
}

// The bytes of element i of an accessor; checked against the buffer's end, since files lie.
class Accessor {
 public:
  Accessor(const tinygltf::Model& model, int index, const std::filesystem::path& file)
      : file_(file) {
    if (index < 0 || index >= static_cast<int>(model.accessors.size())) fail(file, "bad accessor");
    accessor_ = &model.accessors[index];
    if (accessor_->sparse.isSparse) fail(file, "sparse accessors are not supported");
    const int view_index = accessor_->bufferView;
    if (view_index < 0 || view_index >= static_cast<int>(model.bufferViews.size())) {
      fail(file, "an accessor without a buffer view (compressed meshes are not supported)");
    }
    const tinygltf::BufferView& view = model.bufferViews[view_index];
    if (view.buffer < 0 || view.buffer >= static_cast<int>(model.buffers.size())) {
      fail(file, "bad buffer index");
    }
    const auto& bytes = model.buffers[view.buffer].data;
    const int stride = accessor_->ByteStride(view);
    const int element = tinygltf::GetComponentSizeInBytes(accessor_->componentType) *
                        tinygltf::GetNumComponentsInType(accessor_->type);
    const size_t begin = view.byteOffset + accessor_->byteOffset;
    // By division: a lying count must not wrap.
    const bool fits = stride > 0 && element > 0 && begin <= bytes.size() &&
                      static_cast<size_t>(element) <= bytes.size() - begin &&
                      accessor_->count <= 1 + (bytes.size() - begin - element) / stride;
    if (!fits) fail(file, "an accessor reaches past its buffer");
    data_ = bytes.data() + begin;
    stride_ = stride;
  }

  size_t count() const { return accessor_->count; }

  Eigen::Vector3d vector3(size_t i) const {
    if (accessor_->componentType != TINYGLTF_COMPONENT_TYPE_FLOAT ||
        accessor_->type != TINYGLTF_TYPE_VEC3) {
      fail(file_, "positions and normals must be three floats");
    }
    float xyz[3];
    std::memcpy(xyz, data_ + stride_ * i, sizeof xyz);
    return {xyz[0], xyz[1], xyz[2]};
  }

  // As many numbers of element i as `out` has; what the accessor lacks stays. Whole numbers are
  // normalised, as glTF's coordinates and colours are.
  void read_numbers(size_t i, std::span<float> out) const {
    const int type = accessor_->componentType;
    const int size = tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(type));
    const int there = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor_->type));
    for (size_t k = 0; k < std::min(out.size(), static_cast<size_t>(there)); ++k) {
      const unsigned char* at = data_ + stride_ * i + k * size;
      if (type == TINYGLTF_COMPONENT_TYPE_FLOAT) std::memcpy(&out[k], at, sizeof out[k]);
      if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) out[k] = static_cast<float>(*at / 255.0);
      if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) {
        uint16_t value;
        std::memcpy(&value, at, sizeof value);
        out[k] = static_cast<float>(value / 65535.0);
      }
    }
  }

  size_t index(size_t i) const {
    const unsigned char* at = data_ + stride_ * i;
    switch (accessor_->componentType) {
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return *at;
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: {
        uint16_t value;
        std::memcpy(&value, at, sizeof value);
        return value;
      }
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: {
        uint32_t value;
        std::memcpy(&value, at, sizeof value);
        return value;
      }
      default:
        fail(file_, "indices must be unsigned integers");
    }
  }

 private:
  const std::filesystem::path& file_;
  const tinygltf::Accessor* accessor_ = nullptr;
  const unsigned char* data_ = nullptr;
  size_t stride_ = 0;
};

Eigen::Matrix4d local_transform(const tinygltf::Node& node) {
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  if (node.matrix.size() == 16) return Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
  if (node.translation.size() == 3) {
    transform.translate(Eigen::Vector3d(node.translation.data()));
  }
  if (node.rotation.size() == 4) {
    const auto& q = node.rotation;  // glTF stores x, y, z, w
    transform.rotate(Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized());
  }
  if (node.scale.size() == 3) transform.scale(Eigen::Vector3d(node.scale.data()));
  return transform.matrix();
}

// The three vertex indices of triangle i of a list, strip or fan.
std::array<size_t, 3> corners_of(int mode, size_t i) {
  if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
    return i % 2 == 0 ? std::array<size_t, 3>{i, i + 1, i + 2}
                      : std::array<size_t, 3>{i + 1, i, i + 2};
  }
  if (mode == TINYGLTF_MODE_TRIANGLE_FAN) return {0, i + 1, i + 2};
  return {3 * i, 3 * i + 1, 3 * i + 2};
}

constexpr int kMaxDepth = 256;

class Reader {
 public:
  Reader(const tinygltf::Model& model, const std::filesystem::path& file)
      : model_(model), file_(file), shelf_(soup_, file), materials_(model, shelf_) {}

  MeshSoup read() {
    for (const int node : root_nodes()) add_node(node, Eigen::Matrix4d::Identity(), 0);
    return std::move(soup_);
  }

 private:
  // Those of the default scene; in a file without scenes, the nodes that are nobody's child.
  std::vector<int> root_nodes() const {
    if (!model_.scenes.empty()) {
      const size_t scene = static_cast<size_t>(std::max(0, model_.defaultScene));
      if (scene >= model_.scenes.size()) fail(file_, "bad scene index");
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

  void add_node(int index, const Eigen::Matrix4d& file_from_parent, int depth) {
    if (index < 0 || index >= static_cast<int>(model_.nodes.size())) fail(file_, "bad node index");
    if (depth > kMaxDepth) fail(file_, fmt::format("nodes are nested deeper than {}", kMaxDepth));
    // Each has one parent, says glTF; else a few nodes could unfold into any number.
    if (!visited_.insert(index).second) fail(file_, fmt::format("node {} has two parents", index));
    const tinygltf::Node& node = model_.nodes[index];
    const Eigen::Matrix4d file_from_node = file_from_parent * local_transform(node);
    if (node.mesh >= 0 && node.mesh < static_cast<int>(model_.meshes.size())) {
      for (const tinygltf::Primitive& primitive : model_.meshes[node.mesh].primitives) {
        add_primitive(primitive, node, file_from_node);
      }
    }
    for (const int child : node.children) add_node(child, file_from_node, depth + 1);
  }

  void add_primitive(const tinygltf::Primitive& primitive, const tinygltf::Node& node,
                     const Eigen::Matrix4d& file_from_node) {
    const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP &&
        mode != TINYGLTF_MODE_TRIANGLE_FAN) {
      return;  // points and lines
    }
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) return;
    const Accessor positions(model_, position->second, file_);
    const auto normal = primitive.attributes.find("NORMAL");
    std::optional<Accessor> normals;
    if (normal != primitive.attributes.end()) normals.emplace(model_, normal->second, file_);
    std::optional<Accessor> indices;
    if (primitive.indices >= 0) indices.emplace(model_, primitive.indices, file_);

    const size_t corner_count = indices ? indices->count() : positions.count();
    const size_t triangle_count = mode == TINYGLTF_MODE_TRIANGLES ? corner_count / 3
                                  : corner_count < 3              ? 0
                                                                  : corner_count - 2;
    require_room(soup_, triangle_count, file_);
    const CoatAccessors coats = coats_of(primitive);
    soup_.parts.push_back(
        {part_name(primitive, node), albedo_of(primitive), material_of(primitive, coats)});
    for (size_t i = 0; i < triangle_count; ++i) {
      SoupTriangle triangle;
      triangle.part = static_cast<int>(soup_.parts.size()) - 1;
      const std::array<size_t, 3> corners = corners_of(mode, i);
      for (int c = 0; c < 3; ++c) {
        const size_t vertex = indices ? indices->index(corners[c]) : corners[c];
        if (vertex >= positions.count()) fail(file_, "an index is out of range");
        triangle.corner[c] = positions.vector3(vertex);
        const bool has_normal = normals && vertex < normals->count();
        triangle.normal[c] = has_normal ? normals->vector3(vertex) : Eigen::Vector3d::Zero();
        coats.read(vertex, c, triangle.coat);
      }
      add_transformed(soup_, triangle, file_from_node);
    }
  }

  // Where a primitive's corners have texture coordinates and colours.
  struct CoatAccessors {
    std::optional<Accessor> uv;
    std::optional<Accessor> colours;

    void read(size_t vertex, int corner, Coat& coat) const {
      if (uv && vertex < uv->count()) uv->read_numbers(vertex, {coat.uv[corner].data(), 2});
      if (!colours || vertex >= colours->count()) return;
      Eigen::Vector4f& colour = coat.colour[corner];
      colours->read_numbers(vertex, {colour.data(), 4});
      for (float& channel : colour) channel = channel > 0 ? std::min(channel, 1.0f) : 0.0f;
    }
  };

  bool has_material(const tinygltf::Primitive& primitive) const {
    return primitive.material >= 0 &&
           primitive.material < static_cast<int>(model_.materials.size());
  }

  CoatAccessors coats_of(const tinygltf::Primitive& primitive) {
    const int set = has_material(primitive) ? materials_.uv_set(primitive.material) : 0;
    CoatAccessors out;
    const auto& attributes = primitive.attributes;
    const auto uv = attributes.find(fmt::format("TEXCOORD_{}", set));
    const auto colours = attributes.find("COLOR_0");
    if (uv != attributes.end()) out.uv.emplace(model_, uv->second, file_);
    if (colours != attributes.end()) out.colours.emplace(model_, colours->second, file_);
    return out;
  }

  std::optional<Material> material_of(const tinygltf::Primitive& primitive,
                                      const CoatAccessors& coats) {
    std::optional<Material> material;
    if (has_material(primitive)) material = materials_.material(primitive.material);
    if (!material && coats.colours) material.emplace();  // white and dull
    if (!material) return material;
    if (!coats.uv) {
      for (TextureRef* ref : material->textures()) *ref = {};
    }
    const auto refs = material->textures();
    const bool has_texture =
        std::any_of(refs.begin(), refs.end(), [](const TextureRef* r) { return r->is_there(); });
    soup_.has_coats = soup_.has_coats || has_texture || coats.colours;
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
  std::set<int> visited_;
  MeshSoup soup_;
  TextureShelf shelf_;
  GltfMaterials materials_;
};

constexpr std::string_view kBinaryMagic = "glTF";

std::string read_whole(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(stream)), {});
  if (!stream) fail(file, "it cannot be opened");
  return bytes;
}

// Throws unless the chunks of a .glb lie within it: tinygltf believes their lengths.
void require_whole_glb(std::string_view bytes, const std::filesystem::path& file) {
  constexpr size_t kHeaderBytes = 12;  // magic, version, length
  constexpr size_t kChunkHeaderBytes = 8;
  if (bytes.size() < kHeaderBytes) fail(file, "it is torn within its header");
  uint32_t declared = 0;
  std::memcpy(&declared, bytes.data() + 8, sizeof declared);
  bytes = bytes.substr(0, declared);
  size_t at = kHeaderBytes;
  while (at < bytes.size()) {
    if (bytes.size() - at < kChunkHeaderBytes) fail(file, "it is torn within a chunk's header");
    uint32_t length = 0;
    std::memcpy(&length, bytes.data() + at, sizeof length);
    at += kChunkHeaderBytes;
    if (length > bytes.size() - at) fail(file, "it is torn: a chunk is longer than the file");
    at += length;
  }
}

// What tinygltf may open for a buffer's URI: regular files in the folder, or below it.
bool is_readable(const std::string& path, void* folder) {
  return is_inside(*static_cast<const std::filesystem::path*>(folder), path) &&
         std::filesystem::is_regular_file(path);
}

bool read_buffer(std::vector<unsigned char>* out, std::string* error, const std::string& path,
                 void* folder) {
  if (!is_readable(path, folder)) {
    *error = "lies outside the file's folder";
    return false;
  }
  std::ifstream stream(path, std::ios::binary);
  out->assign(std::istreambuf_iterator<char>(stream), {});
  return static_cast<bool>(stream);
}

}  // namespace

MeshSoup read_gltf_bytes(std::string_view bytes, const std::filesystem::path& file) {
  std::filesystem::path folder = std::filesystem::absolute(file).parent_path();
  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks({.FileExists = is_readable,
                         .ExpandFilePath = tinygltf::ExpandFilePath,
                         .ReadWholeFile = read_buffer,
                         .WriteWholeFile = tinygltf::WriteWholeFile,
                         .user_data = &folder});
  // Images stay as their files have them: which are needed, and how, the materials say.
  loader.SetImageLoader(
      [](tinygltf::Image* image, const int, std::string*, std::string*, int, int,
         const unsigned char* image_bytes, int count, void*) {
        image->image.assign(image_bytes, image_bytes + count);
        return true;
      },
      nullptr);
  if (bytes.size() > std::numeric_limits<unsigned>::max()) fail(file, "it is larger than 4 GiB");
  const auto size = static_cast<unsigned>(bytes.size());
  const bool is_binary = bytes.starts_with(kBinaryMagic);
  if (is_binary) require_whole_glb(bytes, file);
  tinygltf::Model model;
  std::string error, warning;
  const bool read =
      is_binary ? loader.LoadBinaryFromMemory(&model, &error, &warning,
                                              reinterpret_cast<const unsigned char*>(bytes.data()),
                                              size, folder.string())
                : loader.LoadASCIIFromString(&model, &error, &warning, bytes.data(), size,
                                             folder.string());
  if (!read) fail(file, error.empty() ? "not a glTF file" : error);
  return Reader(model, file).read();
}

MeshSoup read_gltf(const std::filesystem::path& file) {
  return read_gltf_bytes(read_whole(file), file);
}

}  // namespace sightline
