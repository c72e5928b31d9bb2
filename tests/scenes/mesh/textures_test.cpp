// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/textures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "scenes/files/input_error.h"
#include "scenes/files/toml_table.h"
#include "scenes/picture/picture_file.h"
#include "scenes/scene/colouring.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

// Two texels, red and half green, as OpenCV has them: blue, green, red.
cv::Mat red_and_green() {
  cv::Mat picture(1, 2, CV_8UC3);
  picture.at<cv::Vec3b>(0, 0) = {0, 0, 255};
  picture.at<cv::Vec3b>(0, 1) = {0, 128, 0};
  return picture;
}

std::string decode_error(const std::string& bytes, int64_t pixels = kMaxTexturePixels) {
  return error_of([&] { decode_texture(bytes, pixels); });
}

// A header of a PNG that says its size, and nothing after it.
std::string png_header(uint32_t width, uint32_t height) {
  std::string bytes("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16);
  for (const uint32_t side : {width, height}) {
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(side >> shift);
  }
  return bytes + std::string("\x08\x02\0\0\0", 5);
}

TEST(Textures, EveryDepthAndChannelCountBecomesRgba) {
  EXPECT_THAT(decode_texture(png_bytes(red_and_green()), 2).rgba,
              ElementsAre(255, 0, 0, 255, 0, 128, 0, 255));
  const cv::Mat grey(1, 1, CV_8U, cv::Scalar(77));
  EXPECT_THAT(decode_texture(png_bytes(grey), 1).rgba, ElementsAre(77, 77, 77, 255));
  const cv::Mat deep(1, 1, CV_16UC3, cv::Scalar(257 * 3, 257 * 2, 257 * 1));
  EXPECT_THAT(decode_texture(png_bytes(deep), 1).rgba, ElementsAre(1, 2, 3, 255));
  const cv::Mat clear(1, 1, CV_8UC4, cv::Scalar(3, 2, 1, 9));
  EXPECT_THAT(decode_texture(png_bytes(clear), 1).rgba, ElementsAre(1, 2, 3, 9));
  const cv::Mat flat(8, 8, CV_8UC3, cv::Scalar(200, 200, 200));
  const Texture jpeg = decode_texture(jpeg_bytes(flat), 64);
  EXPECT_EQ(jpeg.width, 8);
  EXPECT_NEAR(jpeg.rgba[0], 200, 1);
}

TEST(Textures, ATornOneSaysSo) {
  cv::Mat noise(32, 32, CV_8UC3);
  cv::randu(noise, 0, 255);
  for (const std::string& whole : {png_bytes(noise), jpeg_bytes(noise)}) {
    for (const double share : {0.35, 0.7, 0.95}) {
      EXPECT_THAT(decode_error(whole.substr(0, static_cast<size_t>(share * whole.size()))),
                  HasSubstr("torn"))
          << share;
    }
    EXPECT_EQ(decode_error(whole), "");
  }
}

TEST(Textures, SizesAndFormatsAreKnownBeforeDecoding) {
  EXPECT_THAT(decode_error(png_header(100000, 1)),
              AllOf(HasSubstr("100000 x 1"), HasSubstr("16384")));
  EXPECT_THAT(decode_error(png_header(16384, 16384)), HasSubstr("in all"));
  EXPECT_THAT(decode_error(png_bytes(red_and_green()), 1), HasSubstr("in all"));
  EXPECT_THAT(decode_error(png_header(0, 7)), HasSubstr("torn"));
  EXPECT_THAT(decode_error("DDS |"), HasSubstr("format unknown"));
  EXPECT_THAT(decode_error(""), HasSubstr("format unknown"));
}

class TexturedMesh : public testing::Test {
 protected:
  // A square with its texture upright, and a material after its name.
  std::filesystem::path square(const std::string& mtl) {
    folder_.write("square.mtl", "newmtl painted\n" + mtl);
    return folder_.write("square.obj",
                         "mtllib square.mtl\nusemtl painted\n"
                         "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                         "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n");
  }

  void write_picture() { folder_.write("label.png", png_bytes(red_and_green())); }

  TemporaryFolder folder_;
};

TEST_F(TexturedMesh, ObjBringsItsPictureAndCoordinates) {
  write_picture();
  for (const char* kd : {"Kd 1 1 1\n", "Kd 0 0 0\n"}) {  // black beside a picture is none of it
    const Mesh mesh = read_mesh(square(std::string(kd) + "map_Kd label.png\n")).mesh;
    ASSERT_EQ(mesh.textures.size(), 1u);
    EXPECT_EQ(mesh.textures[0]->width, 2);
    EXPECT_THAT(mesh.lost_textures, ElementsAre());
    ASSERT_EQ(mesh.coats.size(), mesh.triangles.size());
    EXPECT_EQ(mesh.parts[0].albedo, 1) << kd;
    ASSERT_TRUE(mesh.parts[0].material);
    EXPECT_THAT(mesh.parts[0].material->base, ElementsAre(1, 1, 1, 1)) << kd;
    // The vertex at the lower left of the square is that of the picture: v points up in .obj.
    const auto& m = mesh.parts[0].material->base_texture.texture_from_uv;
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        const Eigen::Vector3d& x = mesh.vertices[mesh.triangles[i].vertex[c]];
        const Eigen::Vector2f& uv = mesh.coats[i].uv[c];
        EXPECT_NEAR(m[0] * uv.x() + m[1] * uv.y() + m[2], x.x(), 1e-6);
        EXPECT_NEAR(m[3] * uv.x() + m[4] * uv.y() + m[5], 1 - x.y(), 1e-6);
      }
    }
  }
}

TEST_F(TexturedMesh, OneThatIsLostIsNamed) {
  const Mesh missing = read_mesh(square("Kd 1 1 1\nmap_Kd gone.png\n")).mesh;
  EXPECT_THAT(missing.lost_textures, ElementsAre("texture gone.png is missing"));
  EXPECT_THAT(missing.textures, ElementsAre());
  EXPECT_EQ(missing.triangles.size(), 2u);
  folder_.write("wide.png", png_header(100000, 1));
  EXPECT_THAT(read_mesh(square("map_Kd wide.png\n")).mesh.lost_textures,
              ElementsAre(HasSubstr("texture wide.png has 100000 x 1 px")));
  // What lies outside the mesh's folder is not opened; a path from elsewhere is tried by its name.
  EXPECT_THAT(read_mesh(square("map_Kd ../../etc/hostname\n")).mesh.lost_textures,
              ElementsAre(HasSubstr("lies outside the mesh's folder")));
  write_picture();
  EXPECT_EQ(read_mesh(square("map_Kd C:\\work\\label.png\n")).mesh.textures.size(), 1u);
}

TEST_F(TexturedMesh, AScenesKeySaysWhetherALostOneMatters) {
  const Mesh mesh = read_mesh(square("map_Kd gone.png\n")).mesh;
  const auto error = [&](const std::string& text) {
    const TomlTable table = TomlTable::read_text(text, "scene.toml");
    return error_of([&] { require_textures(table, read_colouring(table), "square", mesh); });
  };
  EXPECT_THAT(error(""), AllOf(HasSubstr("scene.toml"), HasSubstr("gone.png is missing"),
                               HasSubstr("--missing-textures grey")));
  EXPECT_EQ(error("[image]\nmissing_textures = \"grey\"\n"), "");
  EXPECT_EQ(error("[image]\ntextures = false\n"), "");
  EXPECT_THAT(error("[image]\nmissing_textures = \"pink\"\n"), HasSubstr("missing_textures"));
}

TEST_F(TexturedMesh, PlyBringsThePictureAndTheColoursOfItsVertices) {
  write_picture();
  const auto textured =
      folder_.write("t.ply",
                    "ply\nformat ascii 1.0\ncomment TextureFile label.png\nelement vertex 3\n"
                    "property float x\nproperty float y\nproperty float z\n"
                    "property float texture_u\nproperty float texture_v\nelement face 1\n"
                    "property list uchar int vertex_indices\nend_header\n"
                    "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n");
  const Mesh mesh = read_mesh(textured).mesh;
  EXPECT_EQ(mesh.textures.size(), 1u);
  EXPECT_EQ(mesh.coats.size(), 1u);
  const auto coloured = folder_.write(
      "c.ply",
      "ply\nformat ascii 1.0\nelement vertex 3\n"
      "property float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n"
      "0 0 0 255 0 0\n1 0 0 255 128 0\n0 1 0 255 0 0\n3 0 1 2\n");
  const Mesh colours = read_mesh(coloured).mesh;
  ASSERT_EQ(colours.coats.size(), 1u);
  float greenest = 0;
  for (const Eigen::Vector4f& colour : colours.coats[0].colour) {
    EXPECT_EQ(colour[0], 1);
    greenest = std::max(greenest, colour[1]);
  }
  EXPECT_NEAR(greenest, linear_from_srgb(128 / 255.0), 1e-6);
}

// Two triangles and a quadrangle, each of its own colour, which its corners do not share.
TEST_F(TexturedMesh, PlyBringsTheColoursOfItsFaces) {
  const std::string head =
      "element vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 3\nproperty list uchar int vertex_indices\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  const std::vector<std::array<float, 3>> points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0},
                                                    {0, 1, 0}, {1, 1, 0}, {2, 1, 0}};
  const std::vector<std::vector<int>> faces = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5, 4}};
  const std::vector<std::array<uint8_t, 3>> colours = {{255, 0, 0}, {0, 128, 0}, {0, 0, 255}};
  std::string text = "ply\nformat ascii 1.0\n" + head;
  std::string binary = "ply\nformat binary_little_endian 1.0\n" + head;
  for (const auto& [x, y, z] : points) {
    text += fmt::format("{} {} {}\n", x, y, z);
    for (const float number : {x, y, z}) {
      binary.append(reinterpret_cast<const char*>(&number), sizeof number);
    }
  }
  for (size_t i = 0; i < faces.size(); ++i) {
    const auto& [r, g, b] = colours[i];
    text += fmt::format("{} {} {} {} {}\n", faces[i].size(), fmt::join(faces[i], " "), r, g, b);
    binary += static_cast<char>(faces[i].size());
    for (const int corner : faces[i]) {
      binary.append(reinterpret_cast<const char*>(&corner), sizeof corner);
    }
    for (const uint8_t channel : colours[i]) binary += static_cast<char>(channel);
  }
  for (const std::string& bytes : {text, binary}) {
    const Mesh mesh = read_mesh(folder_.write("faces.ply", bytes)).mesh;
    EXPECT_THAT(mesh.notes, testing::IsEmpty());
    ASSERT_EQ(mesh.coats.size(), 4u);
    for (size_t i = 0; i < 4; ++i) {
      for (const Eigen::Vector4f& colour : mesh.coats[i].colour) {
        const auto& expected = colours[std::min<size_t>(i, 2)];
        for (int channel = 0; channel < 3; ++channel) {
          EXPECT_NEAR(colour[channel], linear_from_srgb(expected[channel] / 255.0), 1e-6) << i;
        }
      }
    }
  }
  std::string torn = text;
  torn.replace(torn.find("element vertex 6\n"), 17,
               "element scan 1\nproperty list uchar int of\nelement vertex 6\n");
  torn.insert(torn.find("end_header\n") + 11, "1 7\n");
  EXPECT_THAT(read_mesh(folder_.write("lists.ply", torn)).mesh.notes,
              testing::Contains("not drawn: the colours of its faces"));
}

// A soup with everything that a surface may have.
MeshSoup painted_triangle() {
  MeshSoup soup;
  soup.points = {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0)};
  soup.triangles = {{.point = {0, 1, 2}}};
  soup.coats.resize(1);
  soup.coats[0].uv[1] = {0.25f, -3};
  soup.coats[0].colour[2] = {0.5f, 0.25f, 1, 0};
  Material material;
  material.base = {0.25, 0.5, 1, 0.75};
  material.has_gloss = true;
  material.metallic = 0.5;
  material.emissive = {3, 0, 0};
  material.alpha_mode = AlphaMode::kMask;
  material.base_texture.texture = 0;
  material.base_texture.wrap_v = Wrap::kMirror;
  material.base_texture.texture_from_uv[2] = 7;
  material.is_two_sided = false;
  material.occlusion_texture.texture = 0;
  material.occlusion_strength = 0.25;
  soup.parts = {{"label", 0.5, material}};
  soup.has_coats = true;
  soup.textures = {{"label.png", 2, 1, true, {1, 2, 3, 4, 5, 6, 7, 8}}};
  soup.lost_textures = {"texture gone.png is missing"};
  return soup;
}

TEST(MeshSurface, CrossesAsBytes) {
  const MeshSoup soup = painted_triangle();
  const MeshSoup back = decode(encode(soup), "mesh.glb");
  EXPECT_EQ(encode(back), encode(soup));
  ASSERT_TRUE(back.parts[0].material);
  EXPECT_EQ(back.parts[0].material->emissive[0], 3);
  EXPECT_EQ(back.parts[0].material->base_texture.wrap_v, Wrap::kMirror);
  EXPECT_FALSE(back.parts[0].material->is_two_sided);
  EXPECT_EQ(back.parts[0].material->occlusion_texture.texture, 0);
  EXPECT_EQ(back.parts[0].material->occlusion_strength, 0.25);
  EXPECT_EQ(back.coats[0].uv[1], soup.coats[0].uv[1]);
  EXPECT_EQ(back.textures[0].rgba, soup.textures[0].rgba);
  EXPECT_EQ(back.lost_textures, soup.lost_textures);
}

TEST(MeshSurface, TheDecoderTrustsNothing) {
  const std::string whole = encode(painted_triangle());
  MeshSoup plain = painted_triangle();
  plain = {.points = plain.points, .triangles = plain.triangles, .parts = {{"label", 0.5}}};
  const size_t shape_alone = encode(plain).size();
  for (size_t size = shape_alone + 1; size < whole.size(); ++size) {
    EXPECT_THAT(error_of([&] { decode(whole.substr(0, size), "mesh.glb"); }),
                HasSubstr("mesh.glb"));
  }
  const auto error = [](const auto& spoil) {
    MeshSoup soup = painted_triangle();
    spoil(soup);
    return error_of([&] { decode(encode(soup), "mesh.glb"); });
  };
  EXPECT_THAT(error([](MeshSoup& s) { s.parts[0].material->base[1] = 1.5; }),
              HasSubstr("material"));
  EXPECT_THAT(error([](MeshSoup& s) { s.parts[0].material->roughness = std::nan(""); }),
              HasSubstr("material"));
  EXPECT_THAT(error([](MeshSoup& s) { s.parts[0].material->base_texture.texture = 1; }),
              HasSubstr("no such texture"));
  EXPECT_THAT(error([](MeshSoup& s) { s.coats[0].uv[0].x() = std::nanf(""); }),
              HasSubstr("coordinate"));
  EXPECT_THAT(error([](MeshSoup& s) { s.coats[0].colour[0][0] = 2; }), HasSubstr("colour"));
  EXPECT_THAT(error([](MeshSoup& s) { s.textures[0].width = 1 << 30; }), HasSubstr("size"));
}

}  // namespace
}  // namespace sightline
