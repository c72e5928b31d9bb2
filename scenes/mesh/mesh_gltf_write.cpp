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
#include "scenes/picture/picture_file.h"

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

  // A file within the file; numbers must not be written after one, for it may end at any byte.
  int add(const std::string& file) {
    std::vector<unsigned char>& bytes = model_.buffers[0].data;
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = bytes.size();
    view.byteLength = file.size();
    bytes.insert(bytes.end(), file.begin(), file.end());
    model_.bufferViews.push_back(view);
    return static_cast<int>(model_.bufferViews.size()) - 1;
  }

 private:
  tinygltf::Model& model_;
};

struct PartVertices {
  std::vector<float> positions;
  std::vector<float> normals;
  std::vector<float> uv;  // of a part with a texture
  std::vector<uint32_t> indices;
};

// The texture by which a part's corners have their coordinates; none where there is none to write.
const TextureRef* texture_on(const Mesh& mesh, int part) {
  const std::optional<Material>& material = mesh.parts[part].material;
  if (!material || mesh.coats.empty()) return nullptr;
  if (material->base_texture.is_there()) return &material->base_texture;
  return material->occlusion_texture.is_there() ? &material->occlusion_texture : nullptr;
}

// Where a corner lies in a texture.
std::array<float, 2> uv_of(const Coat& coat, int corner, const TextureRef& ref) {
  const Eigen::Vector2d uv = coat.uv[corner].cast<double>();
  const auto& m = ref.texture_from_uv;
  return {static_cast<float>(m[0] * uv.x() + m[1] * uv.y() + m[2]),
          static_cast<float>(m[3] * uv.x() + m[4] * uv.y() + m[5])};
}

// Target frame (x forward, y starboard, z down) to glTF's (z forward, y up, x port).
std::array<float, 3> to_gltf(const Eigen::Vector3d& v) {
  return {static_cast<float>(-v.y()), static_cast<float>(-v.z()), static_cast<float>(v.x())};
}

PartVertices vertices_of(const Mesh& mesh, int part) {
  PartVertices out;
  const TextureRef* ref = texture_on(mesh, part);
  std::map<std::array<float, 8>, uint32_t> index_of;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& triangle = mesh.triangles[t];
    if (triangle.part != part) continue;
    for (int c = 0; c < 3; ++c) {
      const auto position = to_gltf(mesh.vertices[triangle.vertex[c]]);
      const auto normal = to_gltf(triangle.normal[c]);
      const auto uv = ref == nullptr ? std::array<float, 2>{} : uv_of(mesh.coats[t], c, *ref);
      const auto [at, is_new] =
          index_of.emplace(std::array{position[0], position[1], position[2], normal[0], normal[1],
                                      normal[2], uv[0], uv[1]},
                           static_cast<uint32_t>(index_of.size()));
      if (is_new) {
        out.positions.insert(out.positions.end(), position.begin(), position.end());
        out.normals.insert(out.normals.end(), normal.begin(), normal.end());
        if (ref != nullptr) out.uv.insert(out.uv.end(), uv.begin(), uv.end());
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

int gltf_wrap(Wrap wrap) {
  if (wrap == Wrap::kClamp) return TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
  return wrap == Wrap::kMirror ? TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT
                               : TINYGLTF_TEXTURE_WRAP_REPEAT;
}

// The number of the texture that is looked up so; made where no part before had it.
int gltf_texture(tinygltf::Model& model, const TextureRef& ref) {
  tinygltf::Sampler sampler;
  sampler.wrapS = gltf_wrap(ref.wrap_u);
  sampler.wrapT = gltf_wrap(ref.wrap_v);
  sampler.magFilter =
      ref.is_nearest ? TINYGLTF_TEXTURE_FILTER_NEAREST : TINYGLTF_TEXTURE_FILTER_LINEAR;
  for (size_t i = 0; i < model.textures.size(); ++i) {
    if (model.textures[i].source == ref.texture && model.samplers[i] == sampler) {
      return static_cast<int>(i);
    }
  }
  tinygltf::Texture texture;
  texture.source = ref.texture;
  texture.sampler = static_cast<int>(model.samplers.size());
  model.samplers.push_back(sampler);
  model.textures.push_back(texture);
  return texture.sampler;
}

// The factors of a part's material; grey and dull where it has none.
tinygltf::Material gltf_material(const Part& part) {
  tinygltf::Material out;
  out.name = part.name;
  out.pbrMetallicRoughness.baseColorFactor = {part.albedo, part.albedo, part.albedo, 1};
  out.pbrMetallicRoughness.metallicFactor = 0;
  out.pbrMetallicRoughness.roughnessFactor = 1;
  out.doubleSided = !part.material || part.material->is_two_sided;
  if (!part.material || !part.material->has_gloss) return out;
  const Material& material = *part.material;
  out.pbrMetallicRoughness.baseColorFactor.assign(material.base.begin(), material.base.end());
  out.pbrMetallicRoughness.metallicFactor = material.metallic;
  out.pbrMetallicRoughness.roughnessFactor = material.roughness;
  return out;
}

// Puts a material's textures on the last one of the file, as far as they lie where `ref` lies.
void add_textures(tinygltf::Model& model, const Material& material, const TextureRef& ref) {
  tinygltf::Material& out = model.materials.back();
  out.pbrMetallicRoughness.baseColorFactor.assign(material.base.begin(), material.base.end());
  if (material.base_texture.is_there()) {
    out.pbrMetallicRoughness.baseColorTexture.index = gltf_texture(model, material.base_texture);
  }
  const TextureRef& occlusion = material.occlusion_texture;
  if (!occlusion.is_there() || occlusion.texture_from_uv != ref.texture_from_uv) return;
  out.occlusionTexture.index = gltf_texture(model, occlusion);
  out.occlusionTexture.strength = material.occlusion_strength;
}

void add_image(tinygltf::Model& model, BufferWriter& writer, const Texture& texture) {
  cv::Mat picture(texture.height, texture.width, CV_8UC3);
  for (size_t i = 0; i < picture.total(); ++i) {
    const uint8_t* texel = texture.rgba.data() + 4 * i;
    picture.at<cv::Vec3b>(static_cast<int>(i)) = {texel[2], texel[1], texel[0]};
  }
  tinygltf::Image image;
  image.name = texture.name;
  image.mimeType = "image/png";
  image.bufferView = writer.add(png_bytes(picture, PngEffort::kSmall));
  model.images.push_back(image);
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
  if (!vertices.uv.empty()) {
    primitive.attributes["TEXCOORD_0"] =
        writer.add(vertices.uv, TINYGLTF_TYPE_VEC2, TINYGLTF_COMPONENT_TYPE_FLOAT,
                   TINYGLTF_TARGET_ARRAY_BUFFER, 2);
  }
  primitive.indices =
      writer.add(vertices.indices, TINYGLTF_TYPE_SCALAR, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                 TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, 1);

  model.materials.push_back(gltf_material(mesh.parts[part]));
  if (const TextureRef* ref = texture_on(mesh, part)) {
    add_textures(model, *mesh.parts[part].material, *ref);
  }

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
  if (!model.textures.empty()) {
    for (const auto& texture : mesh.textures) add_image(model, writer, *texture);
  }
  // To a stream of our own: tinygltf's writer to a file does not notice when it cannot be opened.
  std::ofstream stream(file, std::ios::binary);
  tinygltf::TinyGLTF gltf;
  const bool is_written = gltf.WriteGltfSceneToStream(&model, stream, false, true);
  stream.close();
  if (!is_written || !stream) throw InputError(fmt::format("{}: cannot be written", file.string()));
}

}  // namespace sightline
