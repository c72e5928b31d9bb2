// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstring>
#include <fstream>
#include <limits>
#include <map>

#include <fmt/format.h>

// As mesh_gltf.cpp has it, which holds the library's code.
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include "scenes/files/input_error.h"
#include "scenes/mesh/mesh_io.h"

namespace sightline {
namespace {

// Accumulates the one binary buffer of the file that is written.
class BufferWriter {
 public:
  explicit BufferWriter(tinygltf::Model& model) : model_(model) { model_.buffers.resize(1); }

  template <typename T>
  int add(const std::vector<T>& values, int type, int component_type, int target,
          size_t values_per_element) {
    std::vector<unsigned char>& bytes = model_.buffers[0].data;
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = bytes.size();
    view.byteLength = values.size() * sizeof(T);
    view.target = target;
    bytes.resize(bytes.size() + view.byteLength);
    std::memcpy(bytes.data() + view.byteOffset, values.data(), view.byteLength);
    model_.bufferViews.push_back(view);
    tinygltf::Accessor accessor;
    accessor.bufferView = static_cast<int>(model_.bufferViews.size()) - 1;
    accessor.type = type;
    accessor.componentType = component_type;
    accessor.count = values.size() / values_per_element;
    model_.accessors.push_back(accessor);
    return static_cast<int>(model_.accessors.size()) - 1;
  }

 private:
  tinygltf::Model& model_;
};

struct PartVertices {
  std::vector<float> positions;
  std::vector<float> normals;
  std::vector<uint32_t> indices;
};

// Target frame (x forward, y starboard, z down) to glTF's (z forward, y up, x port).
std::array<float, 3> to_gltf(const Eigen::Vector3d& v) {
  return {static_cast<float>(-v.y()), static_cast<float>(-v.z()), static_cast<float>(v.x())};
}

PartVertices vertices_of(const Mesh& mesh, int part) {
  PartVertices out;
  std::map<std::array<float, 6>, uint32_t> index_of;
  for (const Triangle& triangle : mesh.triangles) {
    if (triangle.part != part) continue;
    for (int c = 0; c < 3; ++c) {
      const auto position = to_gltf(mesh.vertices[triangle.vertex[c]]);
      const auto normal = to_gltf(triangle.normal[c]);
      const std::array<float, 6> key{position[0], position[1], position[2],
                                     normal[0],   normal[1],   normal[2]};
      const auto [at, is_new] = index_of.emplace(key, static_cast<uint32_t>(index_of.size()));
      if (is_new) {
        out.positions.insert(out.positions.end(), position.begin(), position.end());
        out.normals.insert(out.normals.end(), normal.begin(), normal.end());
      }
      out.indices.push_back(at->second);
    }
  }
  return out;
}

// glTF demands the bounds of every position accessor.
void set_bounds(tinygltf::Accessor& accessor, const std::vector<float>& positions) {
  accessor.minValues.assign(3, std::numeric_limits<double>::infinity());
  accessor.maxValues.assign(3, -std::numeric_limits<double>::infinity());
  for (size_t i = 0; i < positions.size(); ++i) {
    accessor.minValues[i % 3] = std::min<double>(accessor.minValues[i % 3], positions[i]);
    accessor.maxValues[i % 3] = std::max<double>(accessor.maxValues[i % 3], positions[i]);
  }
}

// The factors of a part's material, without textures; grey and dull where it has none.
tinygltf::Material gltf_material(const Part& part) {
  tinygltf::Material out;
  out.name = part.name;
  out.pbrMetallicRoughness.baseColorFactor = {part.albedo, part.albedo, part.albedo, 1};
  out.pbrMetallicRoughness.metallicFactor = 0;
  out.pbrMetallicRoughness.roughnessFactor = 1;
  if (!part.material || !part.material->has_gloss) return out;
  const Material& material = *part.material;
  out.pbrMetallicRoughness.baseColorFactor.assign(material.base.begin(), material.base.end());
  out.pbrMetallicRoughness.metallicFactor = material.metallic;
  out.pbrMetallicRoughness.roughnessFactor = material.roughness;
  return out;
}

void add_part(tinygltf::Model& model, BufferWriter& writer, const Mesh& mesh, int part) {
  const PartVertices vertices = vertices_of(mesh, part);
  if (vertices.indices.empty()) return;  // glTF has no primitives without vertices
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.material = static_cast<int>(model.materials.size());
  primitive.attributes["POSITION"] =
      writer.add(vertices.positions, TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT,
                 TINYGLTF_TARGET_ARRAY_BUFFER, 3);
  set_bounds(model.accessors.back(), vertices.positions);
  primitive.attributes["NORMAL"] =
      writer.add(vertices.normals, TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT,
                 TINYGLTF_TARGET_ARRAY_BUFFER, 3);
  primitive.indices =
      writer.add(vertices.indices, TINYGLTF_TYPE_SCALAR, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                 TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, 1);

  model.materials.push_back(gltf_material(mesh.parts[part]));

  tinygltf::Mesh gltf_mesh;
  gltf_mesh.name = mesh.parts[part].name;
  gltf_mesh.primitives.push_back(primitive);
  model.meshes.push_back(gltf_mesh);

  tinygltf::Node node;
  node.name = mesh.parts[part].name;
  node.mesh = static_cast<int>(model.meshes.size()) - 1;
  model.nodes.push_back(node);
  model.scenes[0].nodes.push_back(static_cast<int>(model.nodes.size()) - 1);
}

}  // namespace

void write_glb(const Mesh& mesh, const std::filesystem::path& file) {
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "sightline";
  model.scenes.resize(1);
  model.defaultScene = 0;
  BufferWriter writer(model);
  for (size_t part = 0; part < mesh.parts.size(); ++part) {
    add_part(model, writer, mesh, static_cast<int>(part));
  }
  // To a stream of our own: tinygltf's writer to a file does not notice when it cannot be opened.
  std::ofstream stream(file, std::ios::binary);
  tinygltf::TinyGLTF gltf;
  const bool is_written = gltf.WriteGltfSceneToStream(&model, stream, false, true);
  stream.close();
  if (!is_written || !stream) throw InputError(fmt::format("{}: cannot be written", file.string()));
}

}  // namespace sightline
