// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What others' files say: results and models in BOP's formats.
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/datasets/bop/read.h"
#include "eval/datasets/bop/results_csv.h"
#include "eval/datasets/model_file.h"
#include "eval/datasets/ply_reader.h"
#include "scenes/files/input_error.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string kHeader = "scene_id,im_id,obj_id,score,R,t,time\n";
const std::string kQuarterTurn = "0 -1 0 1 0 0 0 0 1";

TEST(BopResults, AreReadAsTheyStand) {
  const TemporaryFolder folder;
  const auto file =
      folder.write("r.csv", kHeader + "1,2,3,0.5," + kQuarterTurn + ",10 -20.5 1e3,0.25\r\n\n" +
                                "0,0,1,-2,1 0 0 0 1 0 0 0 1, +1  2 3 ,-1");
  const auto estimates = read_bop_results(file);
  ASSERT_EQ(estimates.size(), 2u);
  EXPECT_EQ(estimates[0].scene_id, 1);
  EXPECT_EQ(estimates[0].im_id, 2);
  EXPECT_EQ(estimates[0].obj_id, 3);
  EXPECT_EQ(estimates[0].score, 0.5);
  EXPECT_EQ(estimates[0].time_s, 0.25);
  EXPECT_EQ(estimates[0].line, 2);
  EXPECT_EQ(estimates[0].cam_from_model.rotation(0, 1), -1);  // row by row
  EXPECT_EQ(estimates[0].cam_from_model.translation, Eigen::Vector3d(10, -20.5, 1000));
  EXPECT_EQ(estimates[1].line, 4);
  EXPECT_EQ(estimates[1].cam_from_model.translation, Eigen::Vector3d(1, 2, 3));
}

TEST(BopResults, WhatIsWrongIsSaidWithItsLine) {
  const TemporaryFolder folder;
  const auto error = [&folder](const std::string& text) {
    const auto file = folder.write("r.csv", text);
    return error_of([&] { read_bop_results(file); });
  };
  const std::string good = "0,0,1,1," + kQuarterTurn + ",1 2 3,-1\n";
  EXPECT_EQ(error(kHeader + good), "");
  EXPECT_EQ(error(kHeader), "");  // nothing was found in any image
  EXPECT_THAT(error(""), HasSubstr("r.csv: is empty"));
  EXPECT_THAT(error("a,b\n" + good),
              AllOf(HasSubstr("r.csv: line 1"), HasSubstr("scene_id,im_id")));
  EXPECT_THAT(error(kHeader + good + "0,0,1,1,1 2 3,-1\n"),
              AllOf(HasSubstr("line 3"), HasSubstr("6 fields")));
  EXPECT_THAT(error(kHeader + "0,0,1,1,1 0 0 0 1 0 0 0,1 2 3,-1\n"), HasSubstr("8 numbers for R"));
  EXPECT_THAT(error(kHeader + "0,0,1,1," + kQuarterTurn + ",1 2,-1\n"),
              HasSubstr("2 numbers for t"));
  EXPECT_THAT(error(kHeader + "0,0,1,best," + kQuarterTurn + ",1 2 3,-1\n"), HasSubstr("score"));
  EXPECT_THAT(error(kHeader + "0,x,1,1," + kQuarterTurn + ",1 2 3,-1\n"), HasSubstr("im_id 'x'"));
  EXPECT_THAT(error_of([&] { read_bop_results(folder.path() / "none.csv"); }),
              HasSubstr("none.csv: is missing or cannot be read"));
}

// Two triangles that share an edge, its vertices given twice, and one vertex that nothing uses.
const std::string kPly =
    "ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\nproperty float y\n"
    "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0 1 2 3\n1 0 0 1 2 3\n0 1 0 1 2 3\n1 0 0 1 2 3\n0 1 0 1 2 3\n1 1 0 1 2 3\n9 9 9 1 2 3\n"
    "3 0 1 2\n3 3 5 4\n";

TEST(BopModelFile, KeepsEveryVertex) {
  const TemporaryFolder folder;
  const Mesh mesh = read_ply_as_it_is(folder.write("m.ply", kPly));
  ASSERT_EQ(mesh.vertices.size(), 7u);
  EXPECT_EQ(mesh.vertices[6], Eigen::Vector3d(9, 9, 9));
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.triangles[1].vertex, (std::array<int, 3>{3, 5, 4}));
}

TEST(BopModelFile, ReadsWhatWeWrite) {
  const TemporaryFolder folder;
  Mesh ours;
  ours.vertices = {{0.001, 0, 0}, {0, 0.002, 0}, {0, 0, 0.0035}};
  ours.triangles = {{.vertex = {0, 1, 2}}};
  const Mesh mesh = read_ply_as_it_is(folder.write("m.ply", ply_bytes(ours)));
  ASSERT_EQ(mesh.vertices.size(), 3u);
  EXPECT_EQ(mesh.vertices[2], Eigen::Vector3d(0, 0, 3.5));
  ASSERT_EQ(mesh.triangles.size(), 1u);
}

// Two triangles that share an edge, of parts in two colours; the first has a texture whose left
// half is black.
TEST(BopModelFile, InColourHasTheSameVerticesWithTheirMeans) {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  Material white, red;
  white.base_texture.texture = 0;
  red.base = {1, 0, 0, 1};
  mesh.parts = {{"white", 1, white}, {"red", 0.2, red}};
  mesh.triangles = {{.vertex = {0, 1, 2}, .part = 0}, {.vertex = {3, 2, 1}, .part = 1}};
  Texture halves{.name = "h", .width = 2, .height = 1, .rgba = {0, 0, 0, 255, 255, 255, 255, 255}};
  mesh.textures = {std::make_shared<const Texture>(halves)};
  mesh.coats.resize(2);
  mesh.coats[0].uv = {Eigen::Vector2f(0.25f, 0), Eigen::Vector2f(0.75f, 0),
                      Eigen::Vector2f(0.75f, 0)};
  compute_corner_normals(mesh, 0.1);
  const std::string bytes = coloured_ply_bytes(mesh);
  const TemporaryFolder folder;
  EXPECT_EQ(read_ply_as_it_is(folder.write("c.ply", bytes)).vertices,
            read_ply_as_it_is(folder.write("p.ply", ply_bytes(mesh))).vertices);
  // Three coordinates and three of the normal, then the colour.
  const size_t first = bytes.find("end_header\n") + 11;
  const auto colour_of = [&](size_t vertex) {
    const size_t at = first + vertex * 27 + 24;
    return std::array<int, 3>{static_cast<uint8_t>(bytes[at]), static_cast<uint8_t>(bytes[at + 1]),
                              static_cast<uint8_t>(bytes[at + 2])};
  };
  EXPECT_EQ(colour_of(0), (std::array{0, 0, 0}));        // on the texture's dark half
  EXPECT_EQ(colour_of(3), (std::array{255, 0, 0}));      // red alone
  EXPECT_EQ(colour_of(1), (std::array{255, 188, 188}));  // half of each light, as sRGB has it
}

// Beyond its borders a texture is what its sampler says: here at 1.25 of its width.
TEST(BopModelFile, TakesTexelsBeyondTheBordersAsTheSamplerSays) {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{.vertex = {0, 1, 2}}};
  mesh.textures = {std::make_shared<const Texture>(
      Texture{.name = "h", .width = 2, .height = 1, .rgba = {9, 9, 9, 255, 99, 99, 99, 255}})};
  mesh.coats.resize(1);
  mesh.coats[0].uv.fill(Eigen::Vector2f(1.25f, 0));
  compute_corner_normals(mesh, 0.1);
  const auto red_with = [&mesh](Wrap wrap) {
    Material material;
    material.base_texture = {.texture = 0, .wrap_u = wrap};
    mesh.parts = {{"part", 1, material}};
    const std::string bytes = coloured_ply_bytes(mesh);
    return static_cast<int>(static_cast<uint8_t>(bytes[bytes.find("end_header\n") + 11 + 24]));
  };
  EXPECT_EQ(red_with(Wrap::kRepeat), 9);
  EXPECT_EQ(red_with(Wrap::kClamp), 99);
  EXPECT_EQ(red_with(Wrap::kMirror), 99);
  mesh.coats[0].uv.fill(Eigen::Vector2f(-0.75f, 0));
  EXPECT_EQ(red_with(Wrap::kRepeat), 9);
  EXPECT_EQ(red_with(Wrap::kClamp), 9);
  EXPECT_EQ(red_with(Wrap::kMirror), 99);
}

TEST(BopModelFile, ABrokenOneIsSaid) {
  const TemporaryFolder folder;
  const auto error = [&folder](const std::string& text) {
    const auto file = folder.write("m.ply", text);
    return error_of([&] { read_ply_as_it_is(file); });
  };
  EXPECT_EQ(error(kPly), "");
  EXPECT_THAT(error(kPly.substr(0, kPly.size() - 30)), HasSubstr("m.ply"));
  EXPECT_THAT(error("solid cube\n"), HasSubstr("m.ply"));
  std::string beyond = kPly;
  beyond.replace(beyond.find("3 3 5 4"), 7, "3 3 5 7");
  EXPECT_THAT(error(beyond), HasSubstr("a vertex that is not there"));
}

TEST(BopSymmetries, AreTheIdentityWhereThereAreNone) {
  const auto symmetries = bop_symmetries(R"({"diameter": 1})");
  ASSERT_EQ(symmetries.size(), 1u);
  EXPECT_EQ(symmetries[0].rotation, Eigen::Matrix3d::Identity());
}

TEST(BopSymmetries, AreRowWiseMatrices) {
  const auto symmetries =
      bop_symmetries(R"({"symmetries_discrete": [[0,-1,0,5, 1,0,0,6, 0,0,1,7, 0,0,0,1]]})");
  ASSERT_EQ(symmetries.size(), 2u);
  EXPECT_EQ(symmetries[1] * Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(5, 7, 7));
}

// ceil(pi / 0.01) = 315 steps: a vertex at half a diameter from the axis moves by
// 2 pi / 315 x 1/2 = 0.00997 diameters in one, just below 0.01.
TEST(BopSymmetries, TurnAboutTheirAxisInSteps) {
  const auto symmetries = bop_symmetries(
      R"({"symmetries_continuous": [{"axis": [0, 0, 2], "offset": [10, 0, 0]}],
          "symmetries_discrete": [[1,0,0,0, 0,-1,0,0, 0,0,-1,0, 0,0,0,1]]})");
  ASSERT_EQ(symmetries.size(), 2u * 315);
  const Eigen::Vector3d on_axis(10, 0, 3);
  const Eigen::Vector3d off_axis(11, 0, 3);
  for (size_t i = 0; i < 315; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / 315;
    EXPECT_LT((symmetries[i] * on_axis - on_axis).norm(), 1e-12);
    const Eigen::Vector3d turned(10 + std::cos(angle), std::sin(angle), 3);
    EXPECT_LT((symmetries[i] * off_axis - turned).norm(), 1e-12);
    // Upside down first, then turned.
    EXPECT_LT((symmetries[315 + i] * off_axis - turned + Eigen::Vector3d(0, 0, 6)).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace sightline
