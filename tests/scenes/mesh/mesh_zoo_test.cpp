// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Meshes of many formats, whole and broken, written here at run time.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "scenes/builders/cube.h"
#include "scenes/files/input_error.h"
#include "scenes/mesh/mesh_inspection.h"
#include "scenes/mesh/mesh_io.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// A unit cube in the positive octant; faces counter-clockwise from outside, indices from 0.
constexpr std::array<std::array<int, 3>, 8> kCorners = {
    {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}};
constexpr std::array<std::array<int, 4>, 6> kFaces = {
    {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {2, 3, 7, 6}, {1, 2, 6, 5}, {0, 4, 7, 3}}};

std::string corner_lines(const std::string& prefix) {
  std::string text;
  for (const auto& c : kCorners) text += fmt::format("{}{} {} {}\n", prefix, c[0], c[1], c[2]);
  return text;
}

std::string face_lines(const std::string& prefix, int first_index) {
  std::string text;
  for (const auto& f : kFaces) {
    text += fmt::format("{}{} {} {} {}\n", prefix, f[0] + first_index, f[1] + first_index,
                        f[2] + first_index, f[3] + first_index);
  }
  return text;
}

template <typename Visit>
void for_each_triangle(const Visit& visit) {
  for (const auto& f : kFaces) {
    visit(std::array<int, 3>{f[0], f[1], f[2]});
    visit(std::array<int, 3>{f[0], f[2], f[3]});
  }
}

std::string obj() {
  return "mtllib cube.mtl\no hull\nusemtl paint\n" + corner_lines("v ") + face_lines("f ", 1);
}

std::string ascii_stl() {
  std::string text = "solid hull\n";
  for_each_triangle([&](const std::array<int, 3>& triangle) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const int v : triangle) {
      text += fmt::format("vertex {} {} {}\n", kCorners[v][0], kCorners[v][1], kCorners[v][2]);
    }
    text += "endloop\nendfacet\n";
  });
  return text + "endsolid hull\n";
}

std::string binary_stl() {
  std::string bytes(80, ' ');
  const uint32_t count = 12;
  bytes.append(reinterpret_cast<const char*>(&count), 4);
  for_each_triangle([&](const std::array<int, 3>& triangle) {
    std::array<float, 12> numbers{};
    for (size_t i = 0; i < 9; ++i) {
      numbers[3 + i] = static_cast<float>(kCorners[triangle[i / 3]][i % 3]);
    }
    bytes.append(reinterpret_cast<const char*>(numbers.data()), sizeof numbers);
    bytes.append(2, '\0');
  });
  return bytes;
}

std::string ply() {
  return "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
         "property float z\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n" +
         corner_lines("") + face_lines("4 ", 0);
}

std::string off() {
  return "OFF\n8 6 12\n" + corner_lines("") + face_lines("4 ", 0);
}

std::string ac3d() {
  std::string text =
      "AC3Db\nMATERIAL \"paint\" rgb 0.5 0.5 0.5 amb 1 1 1 emis 0 0 0 spec 0 0 0 shi 0 trans 0\n"
      "OBJECT world\nkids 1\nOBJECT poly\nname \"hull\"\nnumvert 8\n" +
      corner_lines("") + "numsurf 6\n";
  for (const auto& f : kFaces) {
    text += "SURF 0x20\nmat 0\nrefs 4\n";  // 0x20: two-sided
    for (const int v : f) text += fmt::format("{} 0 0\n", v);
  }
  return text + "kids 0\n";
}

std::string collada() {
  std::string positions, indices;
  for (const auto& c : kCorners) positions += fmt::format("{} {} {} ", c[0], c[1], c[2]);
  for_each_triangle([&](const std::array<int, 3>& triangle) {
    for (const int v : triangle) indices += fmt::format("{} ", v);
  });
  return R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g" name="hull"><mesh>
<source id="p"><float_array id="a" count="24">)" +
         positions + R"(</float_array><technique_common><accessor source="#a" count="8" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="12"><input semantic="VERTEX" source="#v" offset="0"/><p>)" +
         indices + R"(</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n" name="hull">
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
)";
}

// Binary buffer: 8 positions as floats, then 36 indices as bytes.
std::string gltf_buffer() {
  std::string bytes;
  for (const auto& c : kCorners) {
    for (const int x : c) {
      const auto number = static_cast<float>(x);
      bytes.append(reinterpret_cast<const char*>(&number), 4);
    }
  }
  for_each_triangle([&](const std::array<int, 3>& triangle) {
    for (const int v : triangle) bytes += static_cast<char>(v);
  });
  return bytes;
}

std::string gltf(const std::string& buffer_uri, const std::string& buffer_bytes = "132",
                 const std::string& index_count = "36") {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"name":"hull","mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":8,"type":"VEC3",
"min":[0,0,0],"max":[1,1,1]},
{"bufferView":1,"componentType":5121,"count":)" +
         index_count + R"(,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteLength":96},{"buffer":0,"byteOffset":96,"byteLength":)" +
         index_count + R"(}],
"buffers":[{"byteLength":)" +
         buffer_bytes + R"(,"uri":")" + buffer_uri + R"("}]})";
}

class MeshZoo : public testing::Test {
 protected:
  std::string mesh_error(const fs::path& file) const {
    return error_of([&] { read_mesh(file); });
  }

  // One line that names the file; returned to say more of it.
  std::string clean_error_of(const fs::path& file) const {
    const std::string error = mesh_error(file);
    EXPECT_THAT(error, HasSubstr(file.filename().string()));
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    return error;
  }

  // Every format's cube, by file name.
  std::map<std::string, std::string> whole_files() const {
    folder_.write("cube.mtl", "newmtl paint\nKd 0.5 0.5 0.5\n");
    folder_.write("cube.bin", gltf_buffer());
    write_glb(build_cube().mesh, folder_.path() / "cube.glb");
    return {{"cube.obj", obj()},
            {"ascii.stl", ascii_stl()},
            {"binary.stl", binary_stl()},
            {"cube.ply", ply()},
            {"cube.off", off()},
            {"cube.ac", ac3d()},
            {"cube.dae", collada()},
            {"cube.gltf", gltf("cube.bin")},
            {"cube.GLB", read_whole(folder_.path() / "cube.glb")}};
  }

  TemporaryFolder folder_;
};

TEST_F(MeshZoo, ACubeIsACubeInEveryFormat) {
  for (const auto& [name, content] : whole_files()) {
    const LoadedMesh loaded = read_mesh(folder_.write(name, content));
    const MeshInspection mesh = inspect(loaded.mesh);
    EXPECT_EQ(mesh.triangles, 12) << name;
    EXPECT_EQ(mesh.vertices, 8) << name;
    EXPECT_EQ(mesh.closed_components, 1) << name;
    EXPECT_NEAR(mesh.volume_m3, 1, 1e-6) << name;  // also: outside is out
    EXPECT_EQ(mesh.sharp_edges, 12) << name;
  }
}

TEST_F(MeshZoo, NodesGivePartsTheirNamesAndMaterialsTheirAlbedo) {
  for (const auto& [name, content] : whole_files()) {
    const bool is_named =
        name == "cube.obj" || name == "cube.ac" || name == "cube.dae" || name == "cube.gltf";
    if (!is_named) continue;
    const Mesh mesh = read_mesh(folder_.write(name, content)).mesh;
    ASSERT_EQ(mesh.parts.size(), 1u) << name;
    EXPECT_EQ(mesh.parts[0].name, "hull") << name;
    if (name == "cube.obj" || name == "cube.ac") {
      EXPECT_NEAR(mesh.parts[0].albedo, 0.5, 1e-6) << name;
    }
  }
}

TEST_F(MeshZoo, TornFilesAreErrorsOrMeshesNeverCrashes) {
  for (const auto& [name, content] : whole_files()) {
    for (const size_t eighths : {1, 4, 7}) {
      if (name == "cube.ply" && eighths < 7) continue;  // see the next test
      const auto file = folder_.write(name, content.substr(0, content.size() * eighths / 8));
      const std::string error = mesh_error(file);
      if (error.empty()) continue;  // some formats end anywhere
      EXPECT_THAT(error, HasSubstr(name));
      EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    }
  }
}

TEST_F(MeshZoo, AFileItsReaderNeverEndsOnIsAnError) {
  // Assimp 5.2 looks for the rest of a torn ASCII .ply for ever.
  const auto file = folder_.write("torn.ply", ply().substr(0, ply().size() / 2));
  EXPECT_NE(clean_error_of(file), "");
}

TEST_F(MeshZoo, GarbageOfAnyNameIsAnError) {
  const std::string text = "The quick brown fox jumps over the lazy dog.\n\"'{[(<0>)]}'\"\n";
  std::string noise;
  for (uint32_t i = 0, state = 1; i < 4096; ++i, state = state * 1664525 + 1013904223) {
    noise += static_cast<char>(state >> 24);
  }
  for (const char* extension : {"obj", "stl", "ply", "off", "ac", "dae", "gltf", "glb", "3ds",
                                "fbx", "x", "blend", "txt", "nonsense"}) {
    for (const std::string& content : {text, noise, std::string(1, 'x')}) {
      EXPECT_NE(clean_error_of(folder_.write(fmt::format("bad.{}", extension), content)), "");
    }
  }
}

TEST_F(MeshZoo, AWrongExtensionIsAnErrorOrReadForWhatItIs) {
  for (const auto& [name, content] : whole_files()) {
    for (const char* extension : {"obj", "stl", "ply", "off", "ac", "dae", "gltf", "glb"}) {
      const auto file = folder_.write(fmt::format("wrong.{}", extension), content);
      const std::string error = mesh_error(file);
      if (error.empty()) {
        EXPECT_EQ(read_mesh(file).mesh.triangles.size(), 12u) << name << " as " << extension;
      } else {
        EXPECT_EQ(error.find('\n'), std::string::npos) << error;
      }
    }
  }
  // The two kinds of glTF are told apart by their content.
  EXPECT_EQ(mesh_error(folder_.write("text.glb", gltf("cube.bin"))), "");
}

TEST_F(MeshZoo, WhatIsNoFileIsRefusedUnopened) {
  const fs::path pipe = folder_.path() / "pipe.obj";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(clean_error_of(pipe), HasSubstr("not a regular file"));
  fs::create_directory(folder_.path() / "folder.glb");
  EXPECT_THAT(clean_error_of(folder_.path() / "folder.glb"), HasSubstr("not a regular file"));
  EXPECT_THAT(clean_error_of(folder_.path() / "absent.obj"), HasSubstr("no such"));
  EXPECT_THAT(clean_error_of(folder_.write("empty.obj", "")), HasSubstr("is empty"));
  const fs::path huge = folder_.write("huge.stl", "x");
  fs::resize_file(huge, uintmax_t{2} << 30);  // sparse
  EXPECT_THAT(clean_error_of(huge), HasSubstr("MiB"));
}

TEST_F(MeshZoo, VerticesThatAreNoNumbersAreRefused) {
  std::string stl = binary_stl();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(stl.data() + 84 + 12, &nan, 4);
  EXPECT_THAT(clean_error_of(folder_.write("nan.stl", stl)), HasSubstr("finite"));
  std::string buffer = gltf_buffer();
  std::memcpy(buffer.data() + 8, &nan, 4);
  folder_.write("nan.bin", buffer);
  EXPECT_THAT(clean_error_of(folder_.write("nan.gltf", gltf("nan.bin"))), HasSubstr("finite"));
}

TEST_F(MeshZoo, IndicesOutOfRangeAreRefused) {
  std::string buffer = gltf_buffer();
  buffer.back() = 8;
  folder_.write("index.bin", buffer);
  EXPECT_THAT(clean_error_of(folder_.write("index.gltf", gltf("index.bin"))),
              HasSubstr("out of range"));
  std::string text = ply();
  text.replace(text.rfind("4 0 4 7 3"), 9, "4 0 4 7 9");
  EXPECT_NE(clean_error_of(folder_.write("index.ply", text)), "");
}

TEST_F(MeshZoo, AGltfReachesNothingOutsideItsFolder) {
  const fs::path inner = folder_.path() / "inner";
  fs::create_directory(inner);
  folder_.write("cube.bin", gltf_buffer());
  for (const std::string& uri : {std::string("../cube.bin"), std::string("%2e%2e/cube.bin"),
                                 (folder_.path() / "cube.bin").string()}) {
    const auto file = folder_.write("inner/out.gltf", gltf(uri));
    EXPECT_NE(clean_error_of(file), "") << uri;
  }
  // A link in the folder is followed, a linked folder is not.
  fs::create_symlink("../cube.bin", inner / "link.bin");
  EXPECT_EQ(mesh_error(folder_.write("inner/link.gltf", gltf("link.bin"))), "");
  fs::create_directory_symlink("..", inner / "linked");
  EXPECT_NE(clean_error_of(folder_.write("inner/linked.gltf", gltf("linked/cube.bin"))), "");
  ASSERT_EQ(mkfifo((inner / "pipe.bin").c_str(), 0600), 0);
  EXPECT_NE(clean_error_of(folder_.write("inner/pipe.gltf", gltf("pipe.bin"))), "");
  // The same buffer within the folder is read.
  folder_.write("inner/cube.bin", gltf_buffer());
  EXPECT_EQ(mesh_error(folder_.write("inner/in.gltf", gltf("cube.bin"))), "");
  EXPECT_EQ(mesh_error(folder_.write("out.gltf", gltf("inner/cube.bin"))), "");
}

TEST_F(MeshZoo, AnObjTakesItsColoursFromItsOwnFolderOnly) {
  fs::create_directory(folder_.path() / "inner");
  folder_.write("cube.mtl", "newmtl paint\nKd 0.5 0.5 0.5\n");
  std::string text = obj();
  text.replace(text.find("cube.mtl"), 8, "../cube.mtl");
  const Mesh outside = read_mesh(folder_.write("inner/cube.obj", text)).mesh;
  EXPECT_NE(outside.parts[0].albedo, 0.5);
  const Mesh inside = read_mesh(folder_.write("cube.obj", obj())).mesh;
  EXPECT_NEAR(inside.parts[0].albedo, 0.5, 1e-6);
}

TEST_F(MeshZoo, AbsurdCountsEndInOneLine) {
  folder_.write("cube.bin", gltf_buffer());
  clean_error_of(folder_.write("bytes.gltf", gltf("cube.bin", "1000000000000000000")));
  clean_error_of(folder_.write("count.gltf", gltf("cube.bin", "132", "4000000000")));
  std::string stl = binary_stl();
  const uint32_t many = 0xfffffff0;
  std::memcpy(stl.data() + 80, &many, 4);
  clean_error_of(folder_.write("count.stl", stl));
  std::string text = ply();
  text.replace(text.find("vertex 8"), 8, "vertex 4000000000");
  clean_error_of(folder_.write("count.ply", text));
  text = off();
  text.replace(text.find("8 6 12"), 6, "4000000000 4000000000 1");
  clean_error_of(folder_.write("count.off", text));
  text = ac3d();
  text.replace(text.find("numvert 8"), 9, "numvert 4000000000");
  clean_error_of(folder_.write("count.ac", text));
}

TEST_F(MeshZoo, ManyMillionTrianglesAreRefused) {
  folder_.write("many.bin", gltf_buffer().substr(0, 96) + std::string(36'000'003, '\0'));
  const auto file = folder_.write("many.gltf", gltf("many.bin", "36000099", "36000003"));
  EXPECT_THAT(clean_error_of(file), HasSubstr("more than 12000000 triangles"));
}

TEST_F(MeshZoo, DeepNestsEndInOneLine) {
  clean_error_of(folder_.write("deep.gltf", std::string(1'000'000, '[')));
  std::string dae = collada();
  std::string nodes;
  for (int i = 0; i < 200'000; ++i) nodes += "<node>";
  dae.replace(dae.find("<instance_geometry"), 0, nodes);
  clean_error_of(folder_.write("deep.dae", dae));
}

TEST_F(MeshZoo, AGltfOfNodesThatUnfoldIsRefused) {
  // Each of 40 nodes has the next one twice as a child: 2^40 paths.
  std::string nodes = "{\"name\":\"hull\",\"children\":[1,1]}";
  for (int i = 2; i <= 40; ++i) nodes += fmt::format(",{{\"children\":[{},{}]}}", i, i);
  nodes += ",{\"mesh\":0}";
  folder_.write("cube.bin", gltf_buffer());
  std::string text = gltf("cube.bin");
  const std::string node = R"({"name":"hull","mesh":0})";
  text.replace(text.find(node), node.size(), nodes);
  EXPECT_THAT(clean_error_of(folder_.write("unfold.gltf", text)), HasSubstr("two parents"));
}

TEST_F(MeshZoo, FilesWithoutFacesAreRefused) {
  EXPECT_THAT(clean_error_of(folder_.write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\n")),
              testing::AnyOf(HasSubstr("no triangles"), HasSubstr("cannot be read")));
  clean_error_of(folder_.write("none.ply",
                               "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                               "property float y\nproperty float z\nend_header\n0 0 0\n"));
  clean_error_of(folder_.write("none.gltf", R"({"asset":{"version":"2.0"}})"));
}

TEST_F(MeshZoo, ASurfaceGivenOnceForEachSideIsOneSurface) {
  const auto file = folder_.write("sides.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n");
  const LoadedMesh loaded = read_mesh(file);
  EXPECT_EQ(loaded.mesh.triangles.size(), 1u);
  EXPECT_EQ(loaded.cleaning.duplicate_triangles, 1);
}

TEST_F(MeshZoo, NormalsAgainstTheWindingAreTurned) {
  for (const char* normal : {"0 0 1", "0 0 -1"}) {
    const auto file = folder_.write(
        "turned.obj", fmt::format("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn {}\nf 1//1 2//1 3//1\n", normal));
    const Mesh mesh = read_mesh(file).mesh;
    for (const Eigen::Vector3d& n : mesh.triangles[0].normal) {
      EXPECT_LT((n - face_normal(mesh, mesh.triangles[0])).norm(), 1e-6) << normal;
    }
  }
}

TEST_F(MeshZoo, ASoupThatIsNoManifoldIsRead) {
  // Three triangles on one edge, one of them wound the other way, and one apart.
  const auto file = folder_.write("soup.obj",
                                  "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 1\nv 0 -1 -1\nv 5 5 5\n"
                                  "v 6 5 5\nv 5 6 5\nf 1 2 3\nf 1 2 4\nf 2 1 5\nf 6 7 8\n");
  const Mesh mesh = read_mesh(file).mesh;
  const MeshInspection inspection = inspect(mesh);
  EXPECT_EQ(inspection.triangles, 4);
  EXPECT_EQ(inspection.components, 2);
  EXPECT_EQ(inspection.non_manifold_edges, 1);
  for (const Triangle& triangle : mesh.triangles) {
    for (const Eigen::Vector3d& normal : triangle.normal) EXPECT_NEAR(normal.norm(), 1, 1e-9);
  }
}

TEST_F(MeshZoo, UnitsHaveNames) {
  EXPECT_EQ(unit_named("m"), 1);
  EXPECT_EQ(unit_named("cm"), 0.01);
  EXPECT_EQ(unit_named("mm"), 0.001);
  EXPECT_EQ(unit_named("km"), 1000);
  EXPECT_EQ(unit_named("in"), 0.0254);
  EXPECT_EQ(unit_named("ft"), 0.3048);
  EXPECT_EQ(unit_named("0.5"), 0.5);
  for (const char* wrong : {"", "furlong", "1mm", "nan", "inf", "MM"}) {
    EXPECT_THROW(unit_named(wrong), InputError) << wrong;
  }
  const auto file = folder_.write("cube.off", off());
  EXPECT_NEAR(bounds(read_mesh(file, {.unit_m = unit_named("mm")}).mesh).max_m.x(), 0.001, 1e-12);
  EXPECT_THROW(read_mesh(file, {.unit_m = unit_named("-1")}), InputError);
}

TEST_F(MeshZoo, ReadsRealAircraftAlsoTorn) {
  const char* folder = std::getenv("SIGHTLINE_TEST_MESHES");
  if (folder == nullptr) GTEST_SKIP() << "SIGHTLINE_TEST_MESHES is not set";
  const fs::path file = fs::path(folder) / "737-800.ac";
  const Mesh mesh = read_mesh(file, {.forward = "-x", .up = "y"}).mesh;
  const Bounds box = bounds(mesh);
  EXPECT_NEAR(box.max_m.x() - box.min_m.x(), 39.5, 0.5);  // a 737-800 is 39.47 m long
  EXPECT_NEAR(box.max_m.y() - box.min_m.y(), 36, 1);      // and spans 35.79 m
  std::set<std::string> names;
  for (const Part& part : mesh.parts) names.insert(part.name);
  EXPECT_THAT(names, testing::Contains("Body"));
  const std::string whole = read_whole(file);
  for (const double share : {0.001, 0.3, 0.6, 0.9}) {
    const auto torn =
        folder_.write("torn.ac", whole.substr(0, static_cast<size_t>(share * whole.size())));
    const std::string error = mesh_error(torn);
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
}

}  // namespace
}  // namespace sightline
