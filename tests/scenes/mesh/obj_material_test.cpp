// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What .mtl files say of surfaces beside the colour, and what of it other formats say.
#include <assimp/Exporter.hpp>
#include <assimp/Importer.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "scenes/mesh/assimp_material.h"
#include "scenes/picture/picture_file.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class ObjMaterial : public testing::Test {
 protected:
  ObjMaterial() {
    folder_.write("red.png", png_bytes(cv::Mat(2, 2, CV_8UC3, cv::Scalar(0, 0, 255))));
  }

  // A square with that material.
  std::filesystem::path square(const std::string& mtl) const {
    folder_.write("square.mtl", "newmtl painted\n" + mtl);
    return folder_.write("square.obj",
                         "mtllib square.mtl\nusemtl painted\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                         "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n");
  }
  Mesh mesh(const std::string& mtl) const { return read_mesh(square(mtl)).mesh; }
  Material material(const std::string& mtl) const {
    const Mesh painted = mesh(mtl);
    EXPECT_THAT(painted.notes, IsEmpty());
    EXPECT_THAT(painted.lost_textures, IsEmpty());
    return painted.parts.at(0).material.value_or(Material{});
  }
  // The same after a way through another format.
  Mesh exported(const std::string& mtl, const char* format, const char* name) const {
    Assimp::Importer importer;
    const aiScene* scene = importer.ReadFile(square(mtl).string(), 0);
    const auto file = folder_.path() / name;
    Assimp::Exporter exporter;
    EXPECT_EQ(exporter.Export(scene, format, file.string()), aiReturn_SUCCESS);
    return read_mesh(file).mesh;
  }
  TemporaryFolder folder_;
};

TEST_F(ObjMaterial, OpacityAndEmissionCome) {
  for (const char* clear : {"Kd 1 0 0\nd 0.3\n", "Kd 1 0 0\nTr 0.7\n"}) {
    const Material glass = material(clear);
    EXPECT_EQ(glass.alpha_mode, AlphaMode::kBlend) << clear;
    EXPECT_NEAR(glass.base[3], 0.3, 1e-6) << clear;
  }
  EXPECT_EQ(material("Kd 1 0 0\nd 1\n").alpha_mode, AlphaMode::kOpaque);
  EXPECT_THAT(material("Kd 0 0 0\nKe 1 0.5 2\n").emissive, ElementsAre(1, 0.5, 2));
  EXPECT_FALSE(mesh("Kd 0.5 0.5 0.5\n").parts[0].material);
  const Material lit = material("Kd 0 0 0\nmap_Ke red.png\n");
  EXPECT_TRUE(lit.emissive_texture.is_there());
  EXPECT_THAT(lit.emissive, ElementsAre(1, 1, 1));
  EXPECT_TRUE(material("Kd 0 0 0\n").is_two_sided);
}

TEST_F(ObjMaterial, OtherFormatsSayThemToo) {
  for (const auto& [format, name] : {std::pair{"collada", "glass.dae"}, {"3ds", "glass.3ds"}}) {
    const Mesh glass = exported("Kd 1 0 0\nKe 0 0 0.5\nd 0.25\n", format, name);
    ASSERT_TRUE(glass.parts[0].material) << format;
    EXPECT_NEAR(glass.parts[0].material->base[3], 0.25, 1e-4) << format;
    EXPECT_EQ(glass.parts[0].material->alpha_mode, AlphaMode::kBlend) << format;
    EXPECT_NEAR(glass.parts[0].material->emissive[2], 0.5, 1e-4) << format;
  }
}

TEST_F(ObjMaterial, WhatIsWhollyClearIsTakenForOpaqueAndSaid) {
  const Mesh clear = mesh("Kd 1 0 0\nd 0\n");
  EXPECT_EQ(clear.parts[0].material->alpha_mode, AlphaMode::kOpaque);
  EXPECT_EQ(clear.parts[0].material->base[3], 1);
  EXPECT_THAT(clear.notes, ElementsAre(HasSubstr("opacity of 0")));
}

TEST_F(ObjMaterial, AnOpacityPictureGoesIntoTheColoursAlpha) {
  cv::Mat hole(1, 2, CV_8U, cv::Scalar(255));
  hole.at<uint8_t>(0, 1) = 0;
  folder_.write("hole.png", png_bytes(hole));
  const Mesh holed = mesh("Kd 1 1 1\nmap_Kd red.png\nmap_d hole.png\n");
  const Material& of_hole = *holed.parts[0].material;
  EXPECT_EQ(of_hole.alpha_mode, AlphaMode::kMask);
  EXPECT_THAT(holed.textures.at(of_hole.base_texture.texture)->rgba,
              ElementsAre(255, 0, 0, 255, 255, 0, 0, 0, 255, 0, 0, 255, 255, 0, 0, 0));
  hole.at<uint8_t>(0, 1) = 100;
  folder_.write("hole.png", png_bytes(hole));
  const Mesh veiled = mesh("Kd 0 1 0\nmap_d hole.png\n");  // without colours of a picture
  const Material& veil = *veiled.parts[0].material;
  EXPECT_EQ(veil.alpha_mode, AlphaMode::kBlend);
  EXPECT_THAT(veil.base, ElementsAre(0, 1, 0, 1));
  EXPECT_THAT(veiled.textures.at(veil.base_texture.texture)->rgba,
              ElementsAre(255, 255, 255, 255, 255, 255, 255, 100));
  EXPECT_THAT(mesh("map_Kd red.png\nmap_d -s 2 2 hole.png\n").notes,
              ElementsAre("opacity that lies as the colour under it does: hole.png"));
  // A picture that is both is opaque where it has no alpha, however dark.
  EXPECT_EQ(material("map_Kd red.png\nmap_d red.png\n").alpha_mode, AlphaMode::kOpaque);
}

TEST_F(ObjMaterial, AnOpacityPictureTakesNoRoomOfItsOwn) {
  cv::Mat cut(2, 2, CV_8UC4, cv::Scalar(0, 0, 255, 255));
  cut.at<cv::Vec4b>(0, 0)[3] = 0;
  folder_.write("cut.png", png_bytes(cut));
  folder_.write("grey.png", png_bytes(cv::Mat(2, 2, CV_8U, cv::Scalar(100))));
  const Mesh same = mesh("map_Kd cut.png\nmap_d cut.png\n");
  EXPECT_EQ(same.parts[0].material->alpha_mode, AlphaMode::kMask);
  EXPECT_EQ(same.textures.size(), 1u);
  EXPECT_EQ(mesh("map_Kd red.png\nmap_d grey.png\n").textures.size(), 2u);
  EXPECT_EQ(mesh("map_d grey.png\n").textures.size(), 1u);
}

TEST_F(ObjMaterial, AColourStaysWhereItsOpacityFindsNoRoom) {
  const cv::Mat large(4096, 8192 + 1, CV_8UC4, cv::Scalar(0, 0, 255, 100));  // over half the room
  folder_.write("large.png", png_bytes(large));
  folder_.write("grey.png", png_bytes(cv::Mat(1, 1, CV_8U, cv::Scalar(100))));
  const Mesh same = mesh("map_Kd large.png\nmap_d large.png\n");
  EXPECT_THAT(same.lost_textures, IsEmpty());
  EXPECT_EQ(same.parts[0].material->alpha_mode, AlphaMode::kBlend);
  const Mesh other = mesh("map_Kd large.png\nmap_d grey.png\n");
  EXPECT_THAT(other.lost_textures, ElementsAre(HasSubstr("is one too many")));
  EXPECT_TRUE(other.parts[0].material->base_texture.is_there());
  EXPECT_EQ(other.parts[0].material->alpha_mode, AlphaMode::kOpaque);
}

TEST_F(ObjMaterial, APicturesOptionsSayWhereItLies) {
  const auto transform = [&](const std::string& options) {
    return material("Kd 1 1 1\nmap_Kd " + options + " red.png\n").base_texture.texture_from_uv;
  };
  EXPECT_THAT(transform(""), ElementsAre(1, 0, 0, 0, -1, 1));
  EXPECT_THAT(transform("-s 2 3 1"), ElementsAre(2, 0, 0, 0, -3, 1));
  EXPECT_THAT(transform("-s 2 3"), ElementsAre(2, 0, 0, 0, -3, 1));
  EXPECT_THAT(transform("-bm 0.5 -o 0.25 0.125 0 -clamp on"),
              ElementsAre(1, 0, 0.25, 0, -1, 0.875));
  EXPECT_EQ(material("map_Kd -clamp on red.png\n").base_texture.wrap_u, Wrap::kClamp);
  EXPECT_EQ(material("map_Kd -s 2 2 red.png\n").base_texture.wrap_u, Wrap::kRepeat);
}

TEST_F(ObjMaterial, NamesMayHaveSpacesAndNumbers) {
  const auto maps = mtl_materials("newmtl  a b \r\nmap_Kd -s 2 2 2 3 4.png\r\nnewmtl c\nmap_d 7\n");
  EXPECT_EQ(maps.at("a b").colour->file, "3 4.png");
  EXPECT_EQ(maps.at("c").alpha->file, "7");
  EXPECT_THAT(mtl_files("# mtllib no\nmtllib a b.mtl\r\n  mtllib c.mtl\nmtllibx d\n"),
              ElementsAre("a b.mtl", "c.mtl"));
}

TEST_F(ObjMaterial, WhatIsMissingIsSaid) {
  square("Kd 1 0 0\n");
  const auto lost = folder_.write("lost.obj",
                                  "mtllib gone.mtl\nusemtl painted\nv 0 0 0\nv 1 0 0\nv 1 1 0\n"
                                  "f 1 2 3\n");
  EXPECT_THAT(read_mesh(lost).mesh.notes,
              ElementsAre("drawn without its materials, whose file is missing: gone.mtl"));
  folder_.write("square.mtl", "newmtl painted\nmap_Kd red.png\n");
  const auto bare = folder_.write("bare.obj",
                                  "mtllib square.mtl\no plate\nusemtl painted\nv 0 0 0\nv 1 0 0\n"
                                  "v 1 1 0\nf 1 2 3\n");
  EXPECT_THAT(read_mesh(bare).mesh.notes,
              ElementsAre("drawn without textures, whose coordinates are not there: plate"));
}

}  // namespace
}  // namespace sightline
