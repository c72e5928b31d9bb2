// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Mesh files of other formats: what they say of units and axes, what is untidy about them, where
// their pieces lie.
#include <algorithm>
#include <cctype>
#include <cstdint>

#include <assimp/Exporter.hpp>
#include <assimp/Importer.hpp>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/mesh/mesh_folder.h"
#include "scenes/mesh/mesh_inspection.h"
#include "scenes/mesh/mesh_io.h"
#include "scenes/mesh/mesh_text.h"
#include "scenes/mesh/ply_text.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A corner of a box, 4 by 3 by 1 of its units.
constexpr const char* kCorner =
    "o corner\nv 0 0 0\nv 4 0 0\nv 0 3 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

Eigen::Vector3d size_of(const fs::path& file, const MeshFrame& frame = {}) {
  const Bounds box = bounds(read_mesh(file, frame).mesh);
  return box.max_m - box.min_m;
}

void expect_size(const fs::path& file, const MeshFrame& frame, double unit_m) {
  EXPECT_NEAR((size_of(file, frame) - unit_m * Eigen::Vector3d(4, 3, 1)).norm(), 0, 1e-6 * unit_m)
      << file;
}

class MeshFiles : public testing::Test {
 protected:
  // The corner in a format of Assimp's.
  fs::path exported(const char* format, const char* name) const {
    const fs::path file = folder_.path() / name;
    Assimp::Importer importer;
    const aiScene* scene = importer.ReadFile(folder_.write("corner.obj", kCorner).string(), 0);
    Assimp::Exporter exporter;
    EXPECT_EQ(exporter.Export(scene, format, file.string()), aiReturn_SUCCESS);
    return file;
  }
  fs::path edited(const fs::path& file, const std::string& from, const std::string& to) const {
    std::string text = read_whole(file);
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    return folder_.write("edited" + file.extension().string(), text);
  }
  TemporaryFolder folder_;
};

TEST_F(MeshFiles, AUnitThatAFileStatesIsAppliedOnce) {
  // FBX states centimetres, here of 2.54; another unit stands in the place of that.
  const fs::path fbx = exported("fbxa", "corner.fbx");
  expect_size(fbx, {}, 0.01);
  expect_size(fbx, {"+x", "-z", 0.001}, 0.001);
  const fs::path inches = edited(fbx, R"("UnitScaleFactor", "double", "Number", "", 1)",
                                 R"("UnitScaleFactor", "double", "Number", "", 2.54)");
  expect_size(inches, {}, 0.0254);
  EXPECT_THAT(read_mesh(inches).mesh.notes, ElementsAre(HasSubstr("its unit is 0.0254 m")));
  expect_size(exported("3mf", "corner.3mf"), {}, 0.001);
  const fs::path dae = exported("collada", "corner.dae");
  expect_size(dae, {}, 1);
  EXPECT_THAT(read_mesh(dae).mesh.notes, IsEmpty());
}

TEST_F(MeshFiles, AColladaFileHasItsOwnAxesAndUnit) {
  fs::path dae = exported("collada", "corner.dae");
  dae = edited(dae, "Y_UP", "Z_UP");
  expect_size(dae, {}, 1);
  const size_t at = read_whole(dae).find("meter=\"");
  ASSERT_NE(at, std::string::npos);
  const std::string stated = read_whole(dae).substr(at, read_whole(dae).find('"', at + 7) - at + 1);
  dae = edited(dae, stated, "meter=\"0.0254\"");
  expect_size(dae, {}, 0.0254);
  expect_size(dae, {"+x", "+z", 0.001}, 0.001);
}

TEST_F(MeshFiles, UnitsAreFoundInTheirTexts) {
  EXPECT_EQ(collada_unit_m("<asset><unit name='inch' meter='0.0254'/></asset>"), 0.0254);
  EXPECT_EQ(collada_unit_m("<asset><unit name=\"x\"/></asset>"), 1);
  EXPECT_EQ(collada_unit_m("<unit name=\"meter\" meter=\"0.01\"/>"), 0.01);
  EXPECT_EQ(collada_unit_m("<unit meter=\"-3\"/>"), 1);
  EXPECT_EQ(collada_unit_m("<unit meter=\"0.5"), 1);
  EXPECT_EQ(threemf_unit_m("<model unit=\"inch\" xml:lang=\"en\">"), 0.0254);
  EXPECT_EQ(threemf_unit_m("<model xml:lang=\"en\"><x unit=\"meter\"/>"), 0.001);
}

TEST_F(MeshFiles, UntidyStlIsRead) {
  const fs::path text = exported("stl", "corner.stl");
  const fs::path binary = exported("stlb", "binary.stl");
  for (const fs::path& file : {text, binary}) expect_size(file, {}, 1);
  std::string upper = read_whole(text);
  std::transform(upper.begin(), upper.end(), upper.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  expect_size(folder_.write("upper.stl", upper), {}, 1);
  expect_size(folder_.write("blank.stl", "\n\n " + upper), {}, 1);
  expect_size(folder_.write("trailing.stl", read_whole(binary) + "\0\0more"), {}, 1);
  EXPECT_EQ(tidy_stl(read_whole(text)), "");
  EXPECT_EQ(tidy_stl(read_whole(binary)), "");
  // What is missing is not made up.
  const std::string torn = read_whole(binary).substr(0, 84 + 50 * 3 + 20);
  EXPECT_NE(error_of([&] { read_mesh(folder_.write("torn.stl", torn)); }), "");
}

TEST_F(MeshFiles, WhatIsNoMeshIsNamedForWhatItIs) {
  const auto error = [&](const char* name, const std::string& text) {
    const fs::path file = folder_.write(name, text);
    return error_of([&] { read_mesh(file); });
  };
  EXPECT_THAT(error("part.step", "ISO-10303-21;\n"), AllOf(HasSubstr("CAD"), HasSubstr("FreeCAD")));
  EXPECT_THAT(error("part.txt", "ISO-10303-21;\nHEADER;FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));"),
              HasSubstr("CAD"));
  EXPECT_THAT(error("part.USDA", "#usda 1.0\n"), HasSubstr("USD scene"));
  EXPECT_THAT(error("robot.urdf", "<robot name='r'/>"), HasSubstr("robot's description"));
  EXPECT_THAT(error("corner.mtl", "newmtl x\n"), HasSubstr("materials of an .obj"));
  EXPECT_EQ(error("corner.obj", kCorner), "");
}

TEST_F(MeshFiles, LinksOfCachesAreFollowed) {
  // A mesh and its material as DVC and git-annex lay them: links into a store of hashes.
  fs::create_directories(folder_.path() / "store/ab");
  fs::create_directories(folder_.path() / "store/cd");
  fs::create_directories(folder_.path() / "work/inner");
  folder_.write("store/ab/1.obj", "mtllib corner.mtl\nusemtl paint\n" + std::string(kCorner));
  folder_.write("store/cd/2", "newmtl paint\nKd 0.25 0.25 0.25\n");
  const fs::path mesh = folder_.path() / "work/corner.obj";
  fs::create_symlink("../store/ab/1.obj", mesh);
  EXPECT_NE(read_mesh(mesh).mesh.parts[0].albedo, 0.25);  // nobody has the material yet
  fs::create_symlink("../store/cd/2", folder_.path() / "work/corner.mtl");
  EXPECT_NEAR(read_mesh(mesh).mesh.parts[0].albedo, 0.25, 1e-6);
  // As a model's cache lays them: all beside the link's target.
  fs::remove(folder_.path() / "work/corner.mtl");
  fs::copy_file(folder_.path() / "store/cd/2", folder_.path() / "store/ab/corner.mtl");
  EXPECT_NEAR(read_mesh(mesh).mesh.parts[0].albedo, 0.25, 1e-6);
}

TEST_F(MeshFiles, LinksLeadNowhereElse) {
  fs::create_directories(folder_.path() / "store");
  fs::create_directories(folder_.path() / "work");
  folder_.write("store/a.bin", "bytes");
  folder_.write("store/c.bin", "bytes");
  folder_.write("work/corner.obj", kCorner);
  fs::create_directory_symlink("../store", folder_.path() / "work/linked");
  fs::create_symlink("../store/a.bin", folder_.path() / "work/b.bin");
  fs::create_symlink("../store/absent", folder_.path() / "work/broken.bin");
  const MeshFolder folder(folder_.path() / "work/corner.obj");
  EXPECT_TRUE(folder.find("corner.obj").has_value());
  EXPECT_TRUE(folder.find("b.bin").has_value());
  EXPECT_TRUE(folder.find(folder_.path() / "work/b.bin").has_value());
  for (const char* name : {"linked/c.bin", "../store/c.bin", "broken.bin", "linked", "absent"}) {
    EXPECT_FALSE(folder.find(name).has_value()) << name;
  }
  EXPECT_FALSE(folder.find(folder_.path() / "store/c.bin").has_value());
}

TEST_F(MeshFiles, WhatIsIgnoredOrNotDrawnIsSaid) {
  fs::create_directories(folder_.path() / "inner");
  folder_.write("paint.mtl", "newmtl paint\nKd 0.25 0.25 0.25\n");
  const fs::path file = folder_.write(
      "inner/corner.obj", "mtllib ../paint.mtl\nusemtl paint\n" + std::string(kCorner) + "l 1 2\n");
  EXPECT_THAT(read_mesh(file).mesh.notes,
              ElementsAre(HasSubstr("not drawn: 1 point"), HasSubstr("../paint.mtl")));
  EXPECT_THAT(read_mesh(folder_.write("inner/plain.obj", kCorner)).mesh.notes, IsEmpty());
}

const Eigen::Vector3d kUtm(446789.256, 5411236.511, 312.123);

// The corner as a .ply in UTM coordinates, with a property more between those of its vertices.
std::string utm_ply(const std::string& format, const std::string& type) {
  std::string ply = fmt::format(
      "ply\nformat {} 1.0\ncomment scanned\nelement vertex 4\nproperty {} x\nproperty uchar q\n"
      "property {} y\nproperty {} z\nelement face 4\nproperty list uchar int vertex_indices\n"
      "end_header\n",
      format, type, type, type);
  const bool is_big = format == "binary_big_endian";
  const auto put = [&](const auto& value) {
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
    ply += is_big ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
  };
  const std::vector<std::array<double, 3>> corners = {{0, 0, 0}, {4, 0, 0}, {0, 3, 0}, {0, 0, 1}};
  const std::vector<std::array<int32_t, 3>> faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  for (const auto& c : corners) {
    const double x = kUtm.x() + c[0], y = kUtm.y() + c[1], z = kUtm.z() + c[2];
    if (format == "ascii") {
      ply += fmt::format("{} 7 {} {}\n", x, y, z);
    } else if (type == "double") {
      put(x), put(uint8_t{7}), put(y), put(z);
    } else {
      put(static_cast<float>(x)), put(uint8_t{7});
      put(static_cast<float>(y)), put(static_cast<float>(z));
    }
  }
  for (const auto& f : faces) {
    if (format == "ascii") {
      ply += fmt::format("3 {} {} {}\n", f[0], f[1], f[2]);
    } else {
      put(uint8_t{3}), put(f[0]), put(f[1]), put(f[2]);
    }
  }
  return ply;
}

TEST_F(MeshFiles, AGeoreferencedPlyOfDoublesIsExact) {
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    const auto file = folder_.write("utm.ply", utm_ply(format, "double"));
    expect_size(file, {}, 1);
    const Bounds box = bounds(read_mesh(file).mesh);
    EXPECT_NEAR((box.min_m - kUtm).norm(), 0, 1e-6) << format;
    // One that is torn within its vertices is refused as ever, in one line.
    const std::string text = utm_ply(format, "double");
    const size_t within = text.find("end_header") + 40;
    EXPECT_THAT(error_of([&] { read_mesh(folder_.write("torn.ply", text.substr(0, within))); }),
                AllOf(HasSubstr("torn.ply"), testing::Not(HasSubstr("\n"))));
  }
  // Single precision has half a metre there: nothing can bring it back.
  const auto coarse = folder_.write("utm.ply", utm_ply("binary_little_endian", "float"));
  EXPECT_GT((bounds(read_mesh(coarse).mesh).min_m - kUtm).norm(), 1e-3);
}

TEST(PlyText, OfMoreVerticesThanCanBeCountedIsNone) {
  const auto ply = [](const std::string& count) {
    return "ply\nformat ascii 1.0\nelement vertex " + count +
           "\nproperty double x\nproperty double y\nproperty double z\nend_header\n1e9 2 1e400\n";
  };
  ASSERT_TRUE(double_points(ply("1")));
  EXPECT_FALSE(double_points(ply("99999999999999999999")));
  EXPECT_FALSE(far_middle(*double_points(ply("1")), ply("1")));
}

}  // namespace
}  // namespace sightline
