// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/mesh_io.h"

#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/builders/cube.h"
#include "scenes/files/input_error.h"
#include "scenes/mesh/mesh_inspection.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::HasSubstr;

const MeshFrame kGltfFrame{"+z", "+y", 1};

// A unit square of two triangles in the z = 0 plane, each with its own copy of the vertices, then
// one degenerate and one duplicate triangle.
constexpr const char* kSquareObj =
    "o square\n"
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0 0\n"
    "f 1 2 3\nf 4 5 6\nf 1 2 7\nf 3 1 2\n";

std::string mesh_error(const std::filesystem::path& file, const MeshFrame& frame = {}) {
  return error_of([&] { read_mesh(file, frame); });
}

TEST(MeshIo, GlbComesBackAsItWentOut) {
  const TemporaryFolder folder;
  const Mesh mesh = build_cube().mesh;
  write_glb(mesh, folder.path() / "cube.glb");
  const Mesh back = read_mesh(folder.path() / "cube.glb", kGltfFrame).mesh;
  ASSERT_EQ(back.vertices.size(), mesh.vertices.size());
  ASSERT_EQ(back.triangles.size(), mesh.triangles.size());
  ASSERT_EQ(back.parts.size(), mesh.parts.size());
  for (size_t part = 0; part < mesh.parts.size(); ++part) {
    EXPECT_EQ(back.parts[part].name, mesh.parts[part].name);
    EXPECT_NEAR(back.parts[part].albedo, mesh.parts[part].albedo, 1e-6);
  }
  for (const Triangle& triangle : back.triangles) {
    for (const Eigen::Vector3d& normal : triangle.normal) {
      EXPECT_LT((normal - face_normal(back, triangle)).norm(), 1e-6);
    }
  }
  EXPECT_EQ(inspect(back).inward_components, 0);
  EXPECT_NEAR(inspect(back).volume_m3, 1, 1e-6);
}

// The mesh of a file that has the square twice, front and back of another part each.
Mesh sheet(bool has_two_sides) {
  const TemporaryFolder folder;
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  mesh.parts = {{"front", 1}, {"back", 1}};
  for (Part& part : mesh.parts) part.material.emplace().is_two_sided = has_two_sides;
  mesh.triangles = {{{0, 1, 2}, 0}, {{2, 1, 0}, 1}, {{1, 0, 2}, 1}, {{1, 2, 0}, 1}};
  compute_corner_normals(mesh, 0.1);
  write_glb(mesh, folder.path() / "sheet.glb");
  return read_mesh(folder.path() / "sheet.glb").mesh;
}

TEST(MeshIo, FrontAndBackOfASheetAreTwoWhereEachHasOneSide) {
  const Mesh mesh = sheet(false);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.triangles[0].part, 0);
  EXPECT_EQ(mesh.triangles[1].part, 1);
  EXPECT_LT(face_normal(mesh, mesh.triangles[0]).dot(face_normal(mesh, mesh.triangles[1])), -0.999);
  EXPECT_EQ(sheet(true).triangles.size(), 1u);
}

TEST(MeshIo, ATextureComesBackAsItWentOut) {
  const TemporaryFolder folder;
  Mesh mesh = build_cube().mesh;
  mesh.textures = {std::make_shared<const Texture>(
      Texture{.name = "two", .width = 2, .height = 1, .rgba = {1, 2, 3, 255, 40, 50, 60, 255}})};
  mesh.parts[2].material.emplace();
  mesh.parts[2].material->base = {0.5, 0.25, 1, 1};
  mesh.parts[2].material->base_texture = {.texture = 0,
                                          .wrap_u = Wrap::kMirror,
                                          .is_nearest = true,
                                          .texture_from_uv = {2, 0, 1, 0, 1, 0}};
  mesh.coats.resize(mesh.triangles.size());
  for (Coat& coat : mesh.coats) coat.uv = {{{0, 0}, {0.25f, 0}, {0, 0.5f}}};
  write_glb(mesh, folder.path() / "cube.glb");
  const Mesh back = read_mesh(folder.path() / "cube.glb", kGltfFrame).mesh;
  EXPECT_EQ(back.vertices.size(), mesh.vertices.size());
  ASSERT_EQ(back.textures.size(), 1u);
  EXPECT_EQ(back.textures[0]->rgba, mesh.textures[0]->rgba);
  ASSERT_EQ(back.coats.size(), mesh.coats.size());
  for (size_t t = 0; t < back.triangles.size(); ++t) {
    const bool is_printed = back.triangles[t].part == 2;
    EXPECT_EQ(back.parts[back.triangles[t].part].material->base_texture.is_there(), is_printed);
    if (!is_printed) continue;
    EXPECT_EQ(back.coats[t].uv[1], Eigen::Vector2f(1.5f, 0));
  }
  const Material& material = *back.parts[2].material;
  EXPECT_EQ(material.base, mesh.parts[2].material->base);
  EXPECT_EQ(material.base_texture.wrap_u, Wrap::kMirror);
  EXPECT_EQ(material.base_texture.wrap_v, Wrap::kRepeat);
  EXPECT_TRUE(material.base_texture.is_nearest);
}

TEST(MeshIo, TheSameMeshGivesTheSameBytes) {
  const TemporaryFolder folder;
  write_glb(build_cube().mesh, folder.path() / "a.glb");
  write_glb(build_cube().mesh, folder.path() / "b.glb");
  EXPECT_EQ(read_whole(folder.path() / "a.glb"), read_whole(folder.path() / "b.glb"));
}

TEST(MeshIo, WeldsAndCleans) {
  const TemporaryFolder folder;
  const LoadedMesh loaded = read_mesh(folder.write("square.obj", kSquareObj));
  EXPECT_EQ(loaded.mesh.triangles.size(), 2u);
  EXPECT_EQ(loaded.cleaning.degenerate_triangles, 1);
  EXPECT_EQ(loaded.cleaning.duplicate_triangles, 1);
  EXPECT_EQ(inspect(loaded.mesh).components, 1);  // welded along the diagonal
}

TEST(MeshIo, TurnsAxesAndScalesUnits) {
  const TemporaryFolder folder;
  // Two points on the file's x (aft) and y (up) axes, in millimetres.
  const auto file = folder.write("axes.obj", "v 0 0 0\nv 1000 0 0\nv 0 2000 0\nf 1 2 3\n");
  const Bounds box = bounds(read_mesh(file, {"-x", "+y", 0.001}).mesh);
  EXPECT_NEAR(box.min_m.x(), -1, 1e-12);  // aft is -x
  EXPECT_NEAR(box.min_m.z(), -2, 1e-12);  // up is -z
  EXPECT_NEAR(box.max_m.cwiseAbs().maxCoeff(), 0, 1e-12);
}

TEST(MeshIo, KeepsOutsideOutWhateverTheAxes) {
  const TemporaryFolder folder;
  write_glb(build_cube().mesh, folder.path() / "cube.glb");
  for (const char* forward : {"+x", "-x", "+z", "-z"}) {
    for (const char* up : {"+y", "-y"}) {
      const Mesh mesh = read_mesh(folder.path() / "cube.glb", {forward, up, 1}).mesh;
      EXPECT_GT(inspect(mesh).volume_m3, 0) << forward << " " << up;
    }
  }
}

TEST(MeshIo, ErrorsNameTheFileInOneLine) {
  const TemporaryFolder folder;
  const auto broken_glb = folder.write("broken.glb", "this is not glTF");
  const auto broken_obj = folder.write("broken.ply", "ply\nnonsense\n");
  const auto empty = folder.write("empty.obj", "o nothing\nv 0 0 0\n");
  for (const auto& file : {folder.path() / "absent.glb", broken_glb, broken_obj, empty}) {
    const std::string error = mesh_error(file);
    EXPECT_THAT(error, HasSubstr(file.string()));
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
}

TEST(MeshIo, ATruncatedGlbIsAnErrorNotACrash) {
  const TemporaryFolder folder;
  write_glb(build_cube().mesh, folder.path() / "cube.glb");
  const std::string whole = read_whole(folder.path() / "cube.glb");
  for (const size_t size : {whole.size() / 8, whole.size() / 2, whole.size() - 4}) {
    EXPECT_NE(mesh_error(folder.write("torn.glb", whole.substr(0, size)), kGltfFrame), "") << size;
  }
}

TEST(MeshIo, PointsThatCoincideAreOneVertexAlsoInACrowdedCell) {
  const TemporaryFolder folder;
  // Two vertices in one cell of the grid but farther apart than the tolerance (1e-6 of the size,
  // about 1.4e-6 here), each given twice.
  const auto file = folder.write("crowded.obj",
                                 "v 0.2e-6 0.2e-6 0.2e-6\nv 1.2e-6 1.2e-6 1.2e-6\n"
                                 "v 0.2e-6 0.2e-6 0.2e-6\nv 1.2e-6 1.2e-6 1.2e-6\n"
                                 "v 1 0 0\nv 0 1 0\nv 1 1 0\n"
                                 "f 1 5 7\nf 2 7 6\nf 3 6 5\nf 4 5 6\n");
  const Mesh mesh = read_mesh(file).mesh;
  EXPECT_EQ(mesh.vertices.size(), 5u);
}

TEST(MeshIo, AMeshWithoutSizeIsDegenerate) {
  const TemporaryFolder folder;
  for (const char* vertex : {"v 0 0 0\n", "v 1e8 1e8 1e8\n"}) {
    const auto file =
        folder.write("point.obj", std::string(vertex) + vertex + vertex + "f 1 2 3\n");
    EXPECT_THAT(mesh_error(file), HasSubstr("degenerate"));
  }
  const auto huge = folder.write("huge.obj", "v 0 0 0\nv 1e30 0 0\nv 0 1e30 0\nf 1 2 3\n");
  EXPECT_THAT(mesh_error(huge), HasSubstr("at most"));
}

TEST(MeshIo, AGltfWithoutScenesIsReadFromItsRoots) {
  const TemporaryFolder folder;
  // One triangle in a child node that its parent moves by 10 along x; no "scenes" at all.
  const std::string gltf = R"({"asset":{"version":"2.0"},
    "nodes":[{"children":[1],"translation":[10,0,0]},{"mesh":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
                  "min":[0,0,0],"max":[1,1,0]}],
    "bufferViews":[{"buffer":0,"byteLength":36}],
    "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
  const Mesh mesh = read_mesh(folder.write("child.gltf", gltf)).mesh;
  ASSERT_EQ(mesh.triangles.size(), 1u);
  EXPECT_NEAR(bounds(mesh).min_m.x(), 10, 1e-6);

  std::string bad_scene = gltf;
  bad_scene.replace(bad_scene.find("\"nodes\""), 0, "\"scene\":7,\"scenes\":[{\"nodes\":[0]}],");
  EXPECT_THAT(mesh_error(folder.write("scene.gltf", bad_scene)), HasSubstr("scene"));
}

TEST(MeshIo, TornFilesAreErrorsOrMeshesNeverCrashes) {
  const TemporaryFolder folder;
  const std::string obj = kSquareObj;
  for (size_t size = 1; size < obj.size(); size += 7) {
    mesh_error(folder.write("torn.obj", obj.substr(0, size)));
  }
  const auto bad_index = folder.write("index.obj", "v 0 0 0\nv 1 0 0\nf 1 2 99\n");
  EXPECT_NE(mesh_error(bad_index), "");
}

TEST(MeshIo, RejectsAFrameThatIsNone) {
  const TemporaryFolder folder;
  const auto file = folder.write("square.obj", kSquareObj);
  EXPECT_THAT(mesh_error(file, {"w", "+y", 1}), HasSubstr("allowed: +x"));
  EXPECT_THAT(mesh_error(file, {"+x", "-x", 1}), HasSubstr("different axes"));
  EXPECT_THAT(mesh_error(file, {"+x", "+y", 0}), HasSubstr("unit_m"));
}

TEST(MeshIo, AFolderThatIsNotThereCannotBeWritten) {
  EXPECT_THROW(write_glb(build_cube().mesh, "/nonexistent/folder/cube.glb"), InputError);
}

TEST(MeshIo, ReadsRealAircraft) {
  const char* folder = std::getenv("SIGHTLINE_TEST_MESHES");
  if (folder == nullptr) GTEST_SKIP() << "SIGHTLINE_TEST_MESHES is not set";
  const MeshFrame frame{"-x", "+y", 1};  // FlightGear's .ac: x aft, y up
  const Mesh mesh = read_mesh(std::filesystem::path(folder) / "727-200.ac", frame).mesh;
  const Bounds box = bounds(mesh);
  EXPECT_NEAR(box.max_m.x() - box.min_m.x(), 46.7, 0.2);  // a 727-200 is 46.69 m long
  EXPECT_NEAR(box.max_m.y() - box.min_m.y(), 32.9, 0.6);  // and spans 32.92 m
  EXPECT_GT(mesh.triangles.size(), 10000u);
  const MeshInspection inspection = inspect(mesh);
  EXPECT_LT(inspection.closed_components, inspection.components);  // a triangle soup
}

}  // namespace
}  // namespace sightline
