// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/gltf_material.h"

#include <cstring>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "scenes/mesh/gltf_uri.h"
#include "scenes/picture/picture_file.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class GltfMaterial : public testing::Test {
 protected:
  GltfMaterial() {
    // Three positions, three texture coordinates as normalised bytes, three colours as floats.
    std::string bytes;
    const auto add = [&bytes](const auto& value) {
      bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) add(x);
    for (const int code : {0, 0, 0, 0, 255, 0, 0, 0, 0, 51, 0, 0}) add(static_cast<uint8_t>(code));
    for (const float c : {1.f, 0.f, 0.f, 0.25f, 0.5f, 2.f, 0.f, 0.f, 0.f}) add(c);
    folder_.write("mesh.bin", bytes);
    folder_.write("picture.png", png_bytes(cv::Mat(2, 2, CV_8UC3, cv::Scalar(1, 2, 3))));
  }

  // The mesh of a triangle with a material; `rest` are further members of the file.
  Mesh mesh(const std::string& material, const std::string& rest = "",
            const std::string& image = "picture.png", const std::string& generator = "test") {
    return read_mesh(folder_.write("mesh.gltf", text(material, rest, image, generator))).mesh;
  }

  std::string text(const std::string& material, const std::string& rest, const std::string& image,
                   const std::string& generator) {
    return fmt::format(
        R"({{"asset": {{"version": "2.0", "generator": "{}"}},
"buffers": [{{"uri": "mesh.bin", "byteLength": 84}}],
"bufferViews": [{{"buffer": 0, "byteLength": 36}},
  {{"buffer": 0, "byteOffset": 36, "byteLength": 12, "byteStride": 4}},
  {{"buffer": 0, "byteOffset": 48, "byteLength": 36}}],
"accessors": [{{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3,
    "min": [0, 0, 0], "max": [1, 1, 0]}},
  {{"bufferView": 1, "componentType": 5121, "normalized": true, "type": "VEC2", "count": 3}},
  {{"bufferView": 2, "componentType": 5126, "type": "VEC3", "count": 3}}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "TEXCOORD_0": 1, "COLOR_0": 2}}{}}}]}}],
"nodes": [{{"mesh": 0}}], "scenes": [{{"nodes": [0]}}], "scene": 0,
"images": [{{"uri": "{}"}}], "textures": [{{"source": 0, "sampler": 0}}]{}{}}})",
        generator, material.empty() ? "" : ", \"material\": 0", image,
        material.empty() ? "" : fmt::format(", \"materials\": [{}]", material),
        rest.empty() ? ", \"samplers\": [{}]" : ", " + rest);
  }

  TemporaryFolder folder_;
};

constexpr const char* kPainted = R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0},
  "baseColorFactor": [0.2, 1, 0.7, 1], "metallicFactor": 0.25, "roughnessFactor": 0.5},
  "emissiveFactor": [1, 0.5, 0], "alphaMode": "MASK", "alphaCutoff": 0.25,
  "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4}}})";

TEST_F(GltfMaterial, FactorsTexturesAndCoordinatesCome) {
  const Mesh painted = mesh(kPainted);
  ASSERT_TRUE(painted.parts[0].material);
  const Material& material = *painted.parts[0].material;
  EXPECT_THAT(material.base, ElementsAre(0.2, 1, 0.7, 1));
  EXPECT_TRUE(material.has_gloss);
  EXPECT_EQ(material.metallic, 0.25);
  EXPECT_EQ(material.roughness, 0.5);
  EXPECT_THAT(material.emissive, ElementsAre(4, 2, 0));
  EXPECT_EQ(material.alpha_mode, AlphaMode::kMask);
  EXPECT_EQ(material.alpha_cutoff, 0.25);
  ASSERT_EQ(painted.textures.size(), 1u);
  EXPECT_THAT(painted.textures[0]->rgba, testing::SizeIs(16));
  EXPECT_EQ(material.base_texture.wrap_u, Wrap::kRepeat);
  ASSERT_EQ(painted.coats.size(), 1u);
  for (int c = 0; c < 3; ++c) {
    const Eigen::Vector3d& x = painted.vertices[painted.triangles[0].vertex[c]];
    EXPECT_NEAR(painted.coats[0].uv[c].x(), x.x(), 1e-6);
    EXPECT_NEAR(painted.coats[0].uv[c].y(), 0.2 * x.y(), 1e-6);
    const Eigen::Vector4f expected = x.x() == 1   ? Eigen::Vector4f(0.25f, 0.5f, 1, 1)
                                     : x.y() == 1 ? Eigen::Vector4f(0, 0, 0, 1)
                                                  : Eigen::Vector4f(1, 0, 0, 1);
    EXPECT_EQ(painted.coats[0].colour[c], expected);
  }
}

TEST_F(GltfMaterial, SamplersSayWhatLiesBeyondTheBorders) {
  const Mesh painted =
      mesh(kPainted, R"("samplers": [{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}])");
  const TextureRef& ref = painted.parts[0].material->base_texture;
  EXPECT_EQ(ref.wrap_u, Wrap::kClamp);
  EXPECT_EQ(ref.wrap_v, Wrap::kMirror);
  EXPECT_TRUE(ref.is_nearest);
}

// The example of KHR_texture_transform: these show the lower left quadrant of the texture.
TEST_F(GltfMaterial, TransformsAreThoseOfTheExtensionsExample) {
  const Mesh painted = mesh(R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0,
    "extensions": {"KHR_texture_transform": {"offset": [0, 1], "rotation": 1.57079632679,
    "scale": [0.5, 0.5]}}}}})");
  const auto& m = painted.parts[0].material->base_texture.texture_from_uv;
  for (const auto& [u, v] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}}) {
    const double across = m[0] * u + m[1] * v + m[2];
    const double down = m[3] * u + m[4] * v + m[5];
    EXPECT_NEAR(across, 0.5 * v, 1e-9);
    EXPECT_NEAR(down, 1 - 0.5 * u, 1e-9);
  }
}

TEST_F(GltfMaterial, AnImageThatIsLostIsNamedAndTheRestIsThere) {
  const Mesh lost = mesh(kPainted, "", "gone.png");
  EXPECT_THAT(lost.lost_textures, ElementsAre("texture gone.png is missing"));
  EXPECT_FALSE(lost.parts[0].material->base_texture.is_there());
  EXPECT_THAT(lost.parts[0].material->base, ElementsAre(0.2, 1, 0.7, 1));
  folder_.write("torn.png", std::string("\x89PNG\r\n\x1a\nxyz"));
  EXPECT_THAT(mesh(kPainted, "", "torn.png").lost_textures, ElementsAre(HasSubstr("torn")));
  EXPECT_THAT(mesh(kPainted, "", "../picture.png").lost_textures,
              ElementsAre(HasSubstr("missing")));
}

TEST_F(GltfMaterial, AnImageOutsideTheFolderIsSaidToLieThere) {
  std::filesystem::create_directory(folder_.path() / "inside");
  for (const char* name : {"mesh.bin", "picture.png"}) {
    std::filesystem::copy(folder_.path() / name, folder_.path() / "inside" / name);
  }
  const auto file = folder_.write("inside/mesh.gltf", text(kPainted, "", "../picture.png", "test"));
  EXPECT_THAT(read_mesh(file).mesh.lost_textures,
              ElementsAre("texture ../picture.png lies outside the mesh's folder and is not read"));
}

// RFC 3986: "%20" is a space, "+" is not.
TEST_F(GltfMaterial, APlusInAnUriIsAPlus) {
  folder_.write("a+b c.png", png_bytes(cv::Mat(3, 5, CV_8UC3, cv::Scalar(1, 2, 3))));
  folder_.write("a b c.png", png_bytes(cv::Mat(1, 1, CV_8UC3, cv::Scalar(1, 2, 3))));
  for (const char* uri : {"a+b%20c.png", "a%2Bb c.png"}) {
    const Mesh painted = mesh(kPainted, "", uri);
    ASSERT_EQ(painted.textures.size(), 1u) << uri;
    EXPECT_EQ(painted.textures[0]->width, 5) << uri;
    EXPECT_EQ(painted.textures[0]->name, "a+b c.png") << uri;
  }
  std::string of_plus = text(kPainted, "", "picture.png", "test");
  of_plus.replace(of_plus.find("mesh.bin"), 8, "m+s.bin");
  folder_.write("m+s.bin", read_whole(folder_.path() / "mesh.bin"));
  EXPECT_EQ(read_mesh(folder_.write("plus.gltf", of_plus)).mesh.triangles.size(), 1u);
}

TEST(GltfUri, OfABinaryFileTheChunksStayWhole) {
  const auto chunk = [](const char* kind, const std::string& content) {
    const auto length = static_cast<uint32_t>(content.size());
    return std::string(reinterpret_cast<const char*>(&length), 4) + std::string(kind, 4) + content;
  };
  const auto file = [&](const std::string& content) {
    const std::string chunks = chunk("JSON", content) + chunk("BIN\0", "1+2=");
    const auto length = static_cast<uint32_t>(12 + chunks.size());
    return std::string("glTF\2\0\0\0", 8) + std::string(reinterpret_cast<const char*>(&length), 4) +
           chunks;
  };
  EXPECT_EQ(with_escaped_pluses(file(R"({"uri": "a+b", "name": "c+"})")),
            file(R"({"uri": "a%2Bb", "name": "c+"}  )"));
  EXPECT_EQ(with_escaped_pluses(file(R"({"uri": "data:,a+b" })")), std::nullopt);
  EXPECT_EQ(with_escaped_pluses(file(R"({"uri": "a%20b" })")), std::nullopt);
}

TEST_F(GltfMaterial, ATextureThatTheFileDoesNotHaveIsRefused) {
  constexpr const char* kSeventh =
      R"({"name": "paint", "pbrMetallicRoughness": {"baseColorTexture": {"index": 7}}})";
  EXPECT_THAT(error_of([&] { mesh(kSeventh); }),
              HasSubstr("the base texture of paint is number 7, but it has 1"));
}

TEST_F(GltfMaterial, CoordinatesThatAreNotThereAreSaid) {
  constexpr const char* kSecondSet =
      R"({"name": "paint", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 1}}})";
  const Mesh bare = mesh(kSecondSet);
  EXPECT_THAT(bare.notes, ElementsAre("drawn without textures, whose coordinates are not there: "
                                      "paint (TEXCOORD_1)"));
  EXPECT_FALSE(bare.parts[0].material->base_texture.is_there());
  const Mesh two_sets = mesh(R"({"name": "paint", "pbrMetallicRoughness":
    {"baseColorTexture": {"index": 0}}, "normalTexture": {"index": 0, "texCoord": 1}})");
  EXPECT_THAT(two_sets.notes, ElementsAre(HasSubstr("the normal texture of paint")));
  EXPECT_THAT(mesh(kPainted).notes, ElementsAre());
}

TEST_F(GltfMaterial, FewerCoordinatesThanVerticesAreRefused) {
  std::string three_of_four = text(kPainted, "", "picture.png", "test");
  const std::string whole = R"("VEC2", "count": 3)";
  three_of_four.replace(three_of_four.find(whole), whole.size(), R"("VEC2", "count": 2)");
  EXPECT_THAT(error_of([&] { read_mesh(folder_.write("few.gltf", three_of_four)); }),
              HasSubstr("2 elements of TEXCOORD_0 for 3 vertices"));
}

TEST_F(GltfMaterial, AFormatThatIsNotReadIsNamed) {
  std::string packed = text(kPainted, "", "picture.png", "test");
  const std::string source = R"("source": 0,)";
  packed.replace(packed.find(source), source.size(),
                 R"("extensions": {"KHR_texture_basisu": {"source": 0}},)");
  EXPECT_THAT(read_mesh(folder_.write("packed.gltf", packed)).mesh.lost_textures,
              ElementsAre("texture number 0 is in a format that is not read (KTX 2, "
                          "KHR_texture_basisu)"));
}

TEST_F(GltfMaterial, BothSidesAreThereWhereTheFileSaysSo) {
  EXPECT_FALSE(mesh(kPainted).parts[0].material->is_two_sided);
  EXPECT_TRUE(mesh(R"({"doubleSided": true})").parts[0].material->is_two_sided);
}

TEST_F(GltfMaterial, AnOcclusionTextureIsLinearAndCheckedAsTheOthers) {
  constexpr const char* kShaded = R"({"occlusionTexture": {"index": 0, "strength": 0.25}})";
  const Mesh shaded = mesh(kShaded);
  const Material& material = *shaded.parts[0].material;
  ASSERT_TRUE(material.occlusion_texture.is_there());
  EXPECT_EQ(material.occlusion_strength, 0.25);
  EXPECT_FALSE(shaded.textures[material.occlusion_texture.texture]->is_srgb);
  folder_.write("garbage.png", "no picture at all");
  EXPECT_THAT(mesh(kShaded, "", "garbage.png").lost_textures, ElementsAre(HasSubstr("garbage")));
}

TEST_F(GltfMaterial, WhatIsWrittenHasItsSidesAndItsOcclusionAgain) {
  Mesh shaded = mesh(R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
    "occlusionTexture": {"index": 0, "strength": 0.5}, "doubleSided": true})");
  const auto file = folder_.path() / "written.glb";
  write_glb(shaded, file);
  const Material both = *read_mesh(file).mesh.parts[0].material;
  EXPECT_TRUE(both.is_two_sided);
  EXPECT_TRUE(both.occlusion_texture.is_there());
  EXPECT_EQ(both.occlusion_strength, 0.5);
  shaded.parts[0].material->is_two_sided = false;
  write_glb(shaded, file);
  EXPECT_FALSE(read_mesh(file).mesh.parts[0].material->is_two_sided);
}

TEST_F(GltfMaterial, OursAreDullWhereTheySaySoAndWhatHasNoMaterialIsWhite) {
  constexpr const char* kDull =
      R"({"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 1}})";
  EXPECT_FALSE(mesh(kDull, "", "picture.png", "sightline").parts[0].material->has_gloss);
  EXPECT_TRUE(mesh(kDull).parts[0].material->has_gloss);
  EXPECT_TRUE(mesh(kPainted, "", "picture.png", "sightline").parts[0].material->has_gloss);
  const Mesh bare = mesh("");
  EXPECT_FALSE(bare.parts[0].material->has_gloss);
  EXPECT_THAT(bare.parts[0].material->base, ElementsAre(1, 1, 1, 1));
  EXPECT_EQ(bare.coats.size(), 1u);
}

}  // namespace
}  // namespace sightline
