// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// glTF as exporters and packers write it: sparse, quantised and compressed accessors, skins, morph
// targets, copies, and what is not known. Every file holds the same box, 2 x 1.5 x 0.5.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>
#include <nlohmann/json.hpp>

#include "scenes/mesh/mesh_inspection.h"
#include "scenes/mesh/mesh_io.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const Eigen::Vector3d kSize(2, 1.5, 0.5);

std::vector<float> box_corners() {
  std::vector<float> xyz;
  for (int i = 0; i < 8; ++i) {
    xyz.push_back(static_cast<float>(i % 2 * kSize.x()));
    xyz.push_back(static_cast<float>(i / 2 % 2 * kSize.y()));
    xyz.push_back(static_cast<float>(i / 4 * kSize.z()));
  }
  return xyz;
}

const std::vector<uint16_t> kBoxIndices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                           2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

// A .gltf with its buffer beside it.
class Builder {
 public:
  Builder() {
    gltf["asset"] = {{"version", "2.0"}};
    gltf["nodes"] = json::array({{{"mesh", 0}}});
    gltf["scenes"] = json::array({{{"nodes", {0}}}});
    gltf["meshes"] = json::array({{{"primitives", json::array({json::object()})}}});
    primitive() = {{"attributes", {{"POSITION", 0}}}, {"indices", 1}};
  }

  json& primitive() { return gltf["meshes"][0]["primitives"][0]; }

  template <typename Number>
  int add_view(const std::vector<Number>& numbers) {
    while (bytes.size() % 8 != 0) bytes += '\0';
    const size_t length = numbers.size() * sizeof(Number);
    gltf["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", length}});
    bytes.append(reinterpret_cast<const char*>(numbers.data()), length);
    return static_cast<int>(gltf["bufferViews"].size()) - 1;
  }

  template <typename Number>
  int add(const std::vector<Number>& numbers, int type, const char* shape, size_t components) {
    const int view = add_view(numbers);
    gltf["accessors"].push_back({{"bufferView", view},
                                 {"componentType", type},
                                 {"type", shape},
                                 {"count", numbers.size() / components}});
    return static_cast<int>(gltf["accessors"].size()) - 1;
  }

  void add_box() {
    add(box_corners(), 5126, "VEC3", 3);
    add(kBoxIndices, 5123, "SCALAR", 1);
  }

  std::filesystem::path write(const TemporaryFolder& folder) {
    folder.write("box.bin", bytes);
    gltf["buffers"][0] = {{"uri", "box.bin"}, {"byteLength", bytes.size()}};
    return folder.write("box.gltf", gltf.dump());
  }

  json gltf;
  std::string bytes;
};

class GltfExtensions : public testing::Test {
 protected:
  Mesh read(Builder& builder) const { return read_mesh(builder.write(folder_)).mesh; }
  std::string error(Builder& builder) const {
    return error_of([&] { read_mesh(builder.write(folder_)); });
  }
  // Expects the box, moved and scaled.
  static void expect_box(const Mesh& mesh, const Eigen::Vector3d& low = Eigen::Vector3d::Zero(),
                         double scale = 1, double tolerance = 1e-6) {
    const Bounds box = bounds(mesh);
    EXPECT_NEAR((box.min_m - low).norm(), 0, tolerance);
    EXPECT_NEAR((box.max_m - box.min_m - scale * kSize).norm(), 0, tolerance);
    EXPECT_EQ(inspect(mesh).open_edges, 0);
    EXPECT_GT(inspect(mesh).volume_m3, 0);
  }
  TemporaryFolder folder_;
};

TEST_F(GltfExtensions, SparseAccessorsReplaceWhatTheyName) {
  Builder builder;
  builder.add_box();
  expect_box(read(builder));
  // The four corners of one end go to x = 4.
  const auto corners = box_corners();
  std::vector<float> moved;
  for (const size_t i : {1, 3, 5, 7}) {
    moved.insert(moved.end(), {4, corners[3 * i + 1], corners[3 * i + 2]});
  }
  const int indices = builder.add_view(std::vector<uint16_t>{1, 3, 5, 7});
  const int values = builder.add_view(moved);
  json& accessor = builder.gltf["accessors"][0];
  accessor["sparse"] = {{"count", 4},
                        {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                        {"values", {{"bufferView", values}}}};
  EXPECT_NEAR(bounds(read(builder)).max_m.x(), 4, 1e-6);
  accessor["sparse"]["count"] = 400;
  EXPECT_THAT(error(builder), HasSubstr("reaches past its buffer"));
  accessor["sparse"]["count"] = 4;
  accessor["count"] = 6;
  EXPECT_THAT(error(builder), HasSubstr("replaces what it does not have"));
}

// Whole numbers of 0 to 4000, which the node carries to the box.
std::vector<uint16_t> quantised_corners(size_t components) {
  std::vector<uint16_t> out;
  const auto corners = box_corners();
  for (size_t i = 0; i < 8; ++i) {
    for (size_t k = 0; k < components; ++k) {
      out.push_back(k < 3 ? static_cast<uint16_t>(2000 * corners[3 * i + k]) : 0);
    }
  }
  return out;
}

TEST_F(GltfExtensions, QuantisedPositionsAreRead) {
  Builder builder;
  builder.add(quantised_corners(3), 5123, "VEC3", 3);
  builder.add(kBoxIndices, 5123, "SCALAR", 1);
  builder.gltf["extensionsRequired"] = {"KHR_mesh_quantization"};
  builder.gltf["nodes"][0]["scale"] = {0.0005, 0.0005, 0.0005};
  expect_box(read(builder));
  // The same as fractions of 65535.
  builder.gltf["accessors"][0]["normalized"] = true;
  expect_box(read(builder), {0, 0, 0}, 1 / 65535.0, 1e-9);
}

TEST_F(GltfExtensions, MeshoptIsUnpacked) {
  const auto corners = quantised_corners(4);
  std::vector<unsigned char> vertices(meshopt_encodeVertexBufferBound(8, 8));
  vertices.resize(
      meshopt_encodeVertexBuffer(vertices.data(), vertices.size(), corners.data(), 8, 8));
  const std::vector<unsigned int> wide(kBoxIndices.begin(), kBoxIndices.end());
  std::vector<unsigned char> indices(meshopt_encodeIndexBufferBound(36, 8));
  indices.resize(meshopt_encodeIndexBuffer(indices.data(), indices.size(), wide.data(), 36));

  Builder builder;
  builder.gltf["nodes"][0]["scale"] = {0.0005, 0.0005, 0.0005};
  builder.gltf["extensionsRequired"] = {"KHR_mesh_quantization", "EXT_meshopt_compression"};
  const int packed_vertices = builder.add_view(vertices);
  const int packed_indices = builder.add_view(indices);
  const auto pack = [&](int from, size_t count, size_t stride, const char* mode) {
    json view = builder.gltf["bufferViews"][from];
    view["byteStride"] = stride;
    view["count"] = count;
    view["mode"] = mode;
    builder.gltf["bufferViews"].push_back({{"buffer", 1},
                                           {"byteOffset", 0},
                                           {"byteLength", count * stride},
                                           {"extensions", {{"EXT_meshopt_compression", view}}}});
    return builder.gltf["bufferViews"].size() - 1;
  };
  const size_t vertex_view = pack(packed_vertices, 8, 8, "ATTRIBUTES");
  builder.gltf["bufferViews"][vertex_view]["byteStride"] = 8;
  const size_t index_view = pack(packed_indices, 36, 2, "TRIANGLES");
  builder.gltf["accessors"] = json::array(
      {{{"bufferView", vertex_view}, {"componentType", 5123}, {"type", "VEC3"}, {"count", 8}},
       {{"bufferView", index_view}, {"componentType", 5123}, {"type", "SCALAR"}, {"count", 36}}});
  builder.gltf["buffers"] = json::array(
      {json::object(),
       {{"byteLength", 136}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}});
  expect_box(read(builder));

  json& packed = builder.gltf["bufferViews"][vertex_view]["extensions"]["EXT_meshopt_compression"];
  packed["byteLength"] = vertices.size() - 5;
  EXPECT_THAT(error(builder), HasSubstr("EXT_meshopt_compression cannot be decoded"));
  packed["byteLength"] = 100000;
  EXPECT_THAT(error(builder), HasSubstr("reach past their buffer"));
  packed["byteStride"] = 7;
  packed["byteLength"] = vertices.size();
  EXPECT_THAT(error(builder), HasSubstr("8 times 7 bytes"));
}

std::vector<unsigned char> draco_box() {
  const auto corners = box_corners();
  draco::TriangleSoupMeshBuilder soup;
  soup.Start(12);
  const int position = soup.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  for (int i = 0; i < 12; ++i) {
    std::array<const float*, 3> at{};
    for (int c = 0; c < 3; ++c) at[c] = &corners[3 * kBoxIndices[3 * i + c]];
    soup.SetAttributeValuesForFace(position, draco::FaceIndex(i), at[0], at[1], at[2]);
  }
  const auto mesh = soup.Finalize();
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  return {buffer.data(), buffer.data() + buffer.size()};
}

TEST_F(GltfExtensions, DracoIsUnpacked) {
  Builder builder;
  const int view = builder.add_view(draco_box());
  builder.gltf["accessors"] =
      json::array({{{"componentType", 5126}, {"type", "VEC3"}, {"count", 8}},
                   {{"componentType", 5123}, {"type", "SCALAR"}, {"count", 36}}});
  builder.gltf["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  builder.primitive()["extensions"] = {
      {"KHR_draco_mesh_compression", {{"bufferView", view}, {"attributes", {{"POSITION", 0}}}}}};
  expect_box(read(builder), {0, 0, 0}, 1, 2e-4);  // 14 bits of 2 m
  builder.gltf["bufferViews"][0]["byteLength"] = 30;
  EXPECT_THAT(error(builder), HasSubstr("KHR_draco_mesh_compression cannot be decoded"));
}

TEST_F(GltfExtensions, ASkinnedMeshStandsAsItsJointsDo) {
  Builder builder;
  builder.add_box();
  builder.add(std::vector<uint8_t>(32, 0), 5121, "VEC4", 4);
  std::vector<float> weights;
  for (int i = 0; i < 8; ++i) weights.insert(weights.end(), {1, 0, 0, 0});
  builder.add(weights, 5126, "VEC4", 4);
  builder.primitive()["attributes"]["JOINTS_0"] = 2;
  builder.primitive()["attributes"]["WEIGHTS_0"] = 3;
  // The node's own place means nothing to a skinned mesh, its joint's all.
  builder.gltf["nodes"] = json::array({{{"mesh", 0}, {"translation", {500, 0, 0}}},
                                       {{"children", {2}}, {"scale", {0.01, 0.01, 0.01}}},
                                       {{"translation", {100, 0, 0}}}});
  builder.gltf["scenes"][0]["nodes"] = {0, 1};
  builder.gltf["skins"] = json::array({{{"joints", {2}}}});
  expect_box(read(builder), {500, 0, 0});  // not skinned yet
  builder.gltf["nodes"][0]["skin"] = 0;
  expect_box(read(builder), {1, 0, 0}, 0.01);
  builder.gltf["skins"][0]["joints"] = {7};
  EXPECT_THAT(error(builder), HasSubstr("bad joint index"));
}

TEST_F(GltfExtensions, MorphTargetsStandAtTheirStatedWeights) {
  Builder builder;
  builder.add_box();
  std::vector<float> ten_up;
  for (int i = 0; i < 8; ++i) ten_up.insert(ten_up.end(), {0, 0, 10});
  builder.add(ten_up, 5126, "VEC3", 3);
  builder.primitive()["targets"] = json::array({{{"POSITION", 2}}});
  expect_box(read(builder));
  builder.gltf["meshes"][0]["weights"] = {1.0};
  expect_box(read(builder), {0, 0, 10});
  builder.gltf["nodes"][0]["weights"] = {0.5};  // the node's go before the mesh's
  expect_box(read(builder), {0, 0, 5});
}

TEST_F(GltfExtensions, CopiesAreDrawnEach) {
  Builder builder;
  builder.add_box();
  builder.add(std::vector<float>{0, 0, 0, 5, 0, 0, 0, 5, 0}, 5126, "VEC3", 3);
  builder.gltf["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  builder.gltf["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
      2;
  const Mesh mesh = read(builder);
  EXPECT_EQ(inspect(mesh).components, 3);
  EXPECT_EQ(mesh.parts.size(), 1u);
  EXPECT_NEAR((bounds(mesh).max_m - Eigen::Vector3d(7, 6.5, 0.5)).norm(), 0, 1e-6);
}

TEST_F(GltfExtensions, WhatIsRequiredAndNotKnownIsRefusedByName) {
  Builder builder;
  builder.add_box();
  builder.gltf["extensionsUsed"] = {"XYZ_curved_space"};
  expect_box(read(builder));
  builder.gltf["extensionsRequired"] = {"KHR_materials_unlit"};
  expect_box(read(builder));
  for (const char* unknown : {"XYZ_curved_space", "KHR_materials_transmission"}) {
    builder.gltf["extensionsRequired"] = {unknown};
    EXPECT_THAT(error(builder), HasSubstr(std::string("requires the extension ") + unknown));
    EXPECT_THAT(error(builder), HasSubstr("known: KHR_mesh_quantization"));
  }
}

TEST_F(GltfExtensions, FewerNormalsThanVerticesAreRefused) {
  Builder builder;
  builder.add_box();
  builder.primitive()["attributes"]["NORMAL"] =
      builder.add(std::vector<float>{0, 0, 1}, 5126, "VEC3", 3);
  EXPECT_THAT(error(builder), HasSubstr("1 elements of NORMAL for 8 vertices"));
}

// glTF 2.0, 3.7.2.1: without normals they are flat, also where the faces turn by little.
TEST_F(GltfExtensions, WithoutNormalsTheFacesAreFlat) {
  Builder roof;
  roof.add(std::vector<float>{0, 0, 0, 1, 0, 0.2f, 2, 0, 0, 0, 1, 0, 1, 1, 0.2f, 2, 1, 0}, 5126,
           "VEC3", 3);
  roof.add(std::vector<uint16_t>{0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4}, 5123, "SCALAR", 1);
  const Mesh mesh = read(roof);
  ASSERT_EQ(mesh.triangles.size(), 4u);
  for (const Triangle& triangle : mesh.triangles) {
    for (const Eigen::Vector3d& normal : triangle.normal) {
      EXPECT_NEAR((normal - face_normal(mesh, triangle)).norm(), 0, 1e-6);
    }
  }
  const Mesh smooth = read_mesh(folder_.write("roof.obj",
                                              "v 0 0 0\nv 1 0 0.2\nv 2 0 0\nv 0 1 0\nv 1 1 0.2\n"
                                              "v 2 1 0\nf 1 2 5 4\nf 2 3 6 5\n"))
                          .mesh;
  const Triangle& first = smooth.triangles.front();
  EXPECT_GT((first.normal[1] - face_normal(smooth, first)).norm(), 0.1);
}

TEST_F(GltfExtensions, WhatIsNotDrawnIsSaid) {
  Builder builder;
  builder.add_box();
  EXPECT_THAT(read(builder).notes, IsEmpty());
  json lines = builder.primitive();
  lines["mode"] = 1;
  builder.gltf["meshes"][0]["primitives"].push_back(lines);
  EXPECT_THAT(read(builder).notes, ElementsAre("not drawn: 1 primitive of points or lines"));
}

TEST_F(GltfExtensions, AnEmptyPrimitiveIsAPartWithoutTriangles) {
  Builder builder;
  builder.add_box();
  json empty = builder.gltf["accessors"][0];
  empty["count"] = 0;
  builder.gltf["accessors"].push_back(empty);
  builder.gltf["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 2}}}});
  const Mesh mesh = read(builder);
  EXPECT_EQ(mesh.parts.size(), 2u);
  expect_box(mesh);
}

}  // namespace
}  // namespace sightline
