// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/gltf_unpack.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <utility>

#include <draco/compression/decode.h>
#include <draco/core/decoder_buffer.h>
#include <fmt/format.h>
#include <meshoptimizer.h>
#include <nlohmann/json.hpp>

#include "scenes/files/input_error.h"

namespace sightline {
namespace {

using nlohmann::json;

constexpr const char* kMeshopt = "EXT_meshopt_compression";
constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr size_t kMaxUnpackedBytes = size_t{1} << 31;

// glTF's names of types of numbers.
enum ComponentType { kInt8 = 5120, kUint8, kInt16, kUint16, kUint32 = 5125, kFloat };

// The text of a .gltf, or the two chunks of a .glb.
struct Chunks {
  std::string_view text;
  std::string_view binary;
};

Chunks chunks_of(std::string_view bytes) {
  if (!bytes.starts_with("glTF")) return {bytes, {}};
  constexpr size_t kHeaderBytes = 12;
  constexpr size_t kChunkHeaderBytes = 8;
  Chunks chunks;
  size_t at = kHeaderBytes;
  while (at + kChunkHeaderBytes <= bytes.size()) {
    uint32_t length = 0;
    std::memcpy(&length, bytes.data() + at, sizeof length);
    const std::string_view kind = bytes.substr(at + 4, 4);
    at += kChunkHeaderBytes;
    const std::string_view chunk = bytes.substr(at, length);
    if (kind == "JSON" && chunks.text.empty()) chunks.text = chunk;
    if (kind.starts_with("BIN") && chunks.binary.empty()) chunks.binary = chunk;
    at += length;
  }
  return chunks;
}

size_t number_of(const json& object, const char* key, size_t fallback) {
  return object.contains(key) ? object.at(key).get<size_t>() : fallback;
}

int components_of(const std::string& type) {
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  return type == "VEC3" ? 3 : 4;
}

class Unpacker {
 public:
  Unpacker(json& gltf, std::string_view binary,
           const std::function<GltfBytes(const std::string&)>& read)
      : gltf_(gltf), binary_(binary), read_(read) {}

  std::map<std::string, GltfBytes> unpack() {
    name_own_buffers();
    for (json& view : gltf_["bufferViews"]) unpack_view(view);
    if (gltf_.contains("meshes")) {
      for (json& mesh : gltf_["meshes"]) {
        for (json& primitive : mesh.at("primitives")) unpack_primitive(primitive);
      }
    }
    return std::move(buffers_);
  }

 private:
  // A .glb's own buffer, and those that are there for readers that cannot decompress, get names.
  void name_own_buffers() {
    json& buffers = gltf_["buffers"];
    for (size_t i = 0; i < buffers.size(); ++i) {
      if (buffers[i].contains("uri")) continue;
      const size_t length = std::min(number_of(buffers[i], "byteLength", 0), binary_.size());
      GltfBytes bytes(i == 0 && length > 0 ? length : 1);  // of a fallback nothing is needed
      if (i == 0 && length > 0) std::memcpy(bytes.data(), binary_.data(), length);
      set_buffer(buffers[i], std::move(bytes));
    }
  }

  void set_buffer(json& buffer, GltfBytes bytes) {
    const std::string uri = fmt::format("sightline-unpacked-{}", buffers_.size());
    buffer = {{"uri", uri}, {"byteLength", bytes.size()}};
    buffers_[uri] = std::move(bytes);
  }

  // A buffer view of its own for these bytes.
  size_t add_view(GltfBytes bytes) {
    gltf_["buffers"].push_back(json::object());
    const size_t length = bytes.size();
    set_buffer(gltf_["buffers"].back(), std::move(bytes));
    gltf_["bufferViews"].push_back(
        {{"buffer", gltf_["buffers"].size() - 1}, {"byteOffset", 0}, {"byteLength", length}});
    return gltf_["bufferViews"].size() - 1;
  }

  const GltfBytes& buffer(size_t index) {
    const std::string uri = gltf_["buffers"].at(index).at("uri").get<std::string>();
    const auto known = buffers_.find(uri);
    if (known != buffers_.end()) return known->second;
    const auto [loaded, is_new] = loaded_.try_emplace(uri);
    if (is_new) loaded->second = read_(uri);
    return loaded->second;
  }

  std::string_view part_of(size_t index, size_t offset, size_t length) {
    const GltfBytes& bytes = buffer(index);
    if (offset > bytes.size() || length > bytes.size() - offset) {
      throw InputError("compressed data reach past their buffer");
    }
    return {reinterpret_cast<const char*>(bytes.data()) + offset, length};
  }

  void unpack_view(json& view) {
    if (!view.contains("extensions") || !view["extensions"].contains(kMeshopt)) return;
    const json packed = view["extensions"][kMeshopt];
    const std::string_view source =
        part_of(packed.at("buffer").get<size_t>(), number_of(packed, "byteOffset", 0),
                packed.at("byteLength").get<size_t>());
    GltfBytes plain = decoded(packed, source);
    view["extensions"].erase(kMeshopt);
    view["byteLength"] = plain.size();
    view["byteOffset"] = 0;
    view["buffer"] = gltf_["buffers"].size();
    gltf_["buffers"].push_back(json::object());
    set_buffer(gltf_["buffers"].back(), std::move(plain));
  }

  static GltfBytes decoded(const json& packed, std::string_view source) {
    const auto count = packed.at("count").get<size_t>();
    const auto stride = packed.at("byteStride").get<size_t>();
    const auto mode = packed.at("mode").get<std::string>();
    const bool has_vertices = mode == "ATTRIBUTES";
    const bool fits = has_vertices
                          ? stride > 0 && stride <= 256 && stride % 4 == 0
                          : (stride == 2 || stride == 4) && (mode != "TRIANGLES" || count % 3 == 0);
    if (!fits || count > kMaxUnpackedBytes / stride) {
      throw InputError(
          fmt::format("{} says {} times {} bytes, which cannot be", kMeshopt, count, stride));
    }
    GltfBytes plain(count * stride);
    const auto* bytes = reinterpret_cast<const unsigned char*>(source.data());
    const int error =
        has_vertices ? meshopt_decodeVertexBuffer(plain.data(), count, stride, bytes, source.size())
        : mode == "TRIANGLES"
            ? meshopt_decodeIndexBuffer(plain.data(), count, stride, bytes, source.size())
            : meshopt_decodeIndexSequence(plain.data(), count, stride, bytes, source.size());
    if (error != 0) throw InputError(fmt::format("data of {} cannot be decoded", kMeshopt));
    filter(packed.value("filter", "NONE"), count, stride, plain);
    return plain;
  }

  static void filter(const std::string& name, size_t count, size_t stride, GltfBytes& plain) {
    if (name == "OCTAHEDRAL" && (stride == 4 || stride == 8)) {
      meshopt_decodeFilterOct(plain.data(), count, stride);
    } else if (name == "QUATERNION" && stride == 8) {
      meshopt_decodeFilterQuat(plain.data(), count, stride);
    } else if (name == "EXPONENTIAL" && stride % 4 == 0) {
      meshopt_decodeFilterExp(plain.data(), count, stride);
    } else if (name != "NONE") {
      throw InputError(
          fmt::format("{} has the filter {} on {} bytes, which cannot be", kMeshopt, name, stride));
    }
  }

  void unpack_primitive(json& primitive) {
    if (!primitive.contains("extensions") || !primitive["extensions"].contains(kDraco)) return;
    const json packed = primitive["extensions"][kDraco];
    const json view = gltf_["bufferViews"].at(packed.at("bufferView").get<size_t>());
    const std::string_view source =
        part_of(view.at("buffer").get<size_t>(), number_of(view, "byteOffset", 0),
                view.at("byteLength").get<size_t>());
    draco::DecoderBuffer input;
    input.Init(source.data(), source.size());
    draco::Decoder decoder;
    const auto result = decoder.DecodeMeshFromBuffer(&input);
    if (!result.ok()) {
      throw InputError(
          fmt::format("data of {} cannot be decoded: {}", kDraco, result.status().error_msg()));
    }
    const draco::Mesh& mesh = *result.value();
    primitive["indices"] = add_indices(mesh);
    primitive["mode"] = 4;  // Draco has triangles alone
    for (const auto& [name, id] : packed.at("attributes").items()) {
      const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(id.get<uint32_t>());
      if (attribute == nullptr || !primitive.at("attributes").contains(name)) continue;
      const auto accessor = primitive["attributes"][name].get<size_t>();
      primitive["attributes"][name] =
          add_attribute(gltf_["accessors"].at(accessor), mesh, *attribute);
    }
    primitive["extensions"].erase(kDraco);
  }

  size_t add_indices(const draco::Mesh& mesh) {
    std::vector<uint32_t> indices;
    indices.reserve(size_t{3} * mesh.num_faces());
    for (draco::FaceIndex i(0); i < mesh.num_faces(); ++i) {
      const draco::Mesh::Face& face = mesh.face(i);
      for (size_t c = 0; c < face.size(); ++c) indices.push_back(face[c].value());
    }
    const auto* bytes = reinterpret_cast<const unsigned char*>(indices.data());
    const size_t view = add_view({bytes, bytes + indices.size() * sizeof(uint32_t)});
    gltf_["accessors"].push_back({{"bufferView", view},
                                  {"componentType", kUint32},
                                  {"type", "SCALAR"},
                                  {"count", indices.size()}});
    return gltf_["accessors"].size() - 1;
  }

  size_t add_attribute(json accessor, const draco::Mesh& mesh,
                       const draco::PointAttribute& attribute) {
    const int components = components_of(accessor.at("type").get<std::string>());
    accessor["bufferView"] =
        add_view(values_of(accessor.at("componentType").get<int>(), components, mesh, attribute));
    accessor["byteOffset"] = 0;
    accessor["count"] = mesh.num_points();
    accessor.erase("sparse");
    gltf_["accessors"].push_back(std::move(accessor));
    return gltf_["accessors"].size() - 1;
  }

  static GltfBytes values_of(int component_type, int components, const draco::Mesh& mesh,
                             const draco::PointAttribute& attribute) {
    switch (component_type) {
      case kInt8:
        return values_as<int8_t>(components, mesh, attribute);
      case kUint8:
        return values_as<uint8_t>(components, mesh, attribute);
      case kInt16:
        return values_as<int16_t>(components, mesh, attribute);
      case kUint16:
        return values_as<uint16_t>(components, mesh, attribute);
      case kUint32:
        return values_as<uint32_t>(components, mesh, attribute);
      case kFloat:
        return values_as<float>(components, mesh, attribute);
      default:
        throw InputError(fmt::format("an accessor has the component type {}", component_type));
    }
  }

  template <typename Number>
  static GltfBytes values_as(int components, const draco::Mesh& mesh,
                             const draco::PointAttribute& attribute) {
    const size_t element = static_cast<size_t>(components) * sizeof(Number);
    GltfBytes bytes(element * mesh.num_points());
    std::array<Number, 4> values{};
    for (draco::PointIndex i(0); i < mesh.num_points(); ++i) {
      if (!attribute.ConvertValue<Number>(attribute.mapped_index(i),
                                          static_cast<int8_t>(components), values.data())) {
        throw InputError(fmt::format("an attribute of {} has other components", kDraco));
      }
      std::memcpy(bytes.data() + element * i.value(), values.data(), element);
    }
    return bytes;
  }

  json& gltf_;
  std::string_view binary_;
  const std::function<GltfBytes(const std::string&)>& read_;
  std::map<std::string, GltfBytes> buffers_;  // of the file that is made
  std::map<std::string, GltfBytes> loaded_;   // of the file that is read
};

}  // namespace

std::optional<UnpackedGltf> unpack_gltf(std::string_view bytes,
                                        const std::function<GltfBytes(const std::string&)>& read) {
  const Chunks chunks = chunks_of(bytes);
  const bool is_packed = chunks.text.find(kMeshopt) != std::string_view::npos ||
                         chunks.text.find(kDraco) != std::string_view::npos;
  if (!is_packed) return std::nullopt;
  try {
    json gltf = json::parse(chunks.text);
    UnpackedGltf unpacked;
    unpacked.buffers = Unpacker(gltf, chunks.binary, read).unpack();
    unpacked.json = gltf.dump();
    return unpacked;
  } catch (const json::exception& error) {
    throw InputError(fmt::format("its JSON is not what glTF says: {}", error.what()));
  }
}

}  // namespace sightline
