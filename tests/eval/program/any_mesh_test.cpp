// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Mesh files as people have them, through the program: where they lie, how they are called, and
// what of them is drawn.
#include <array>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "scenes/target/target.h"
#include "tests/eval/program.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// A wedge of that length, half as wide and high, with its nose at a place.
std::string wedge(double length, const Eigen::Vector3d& nose) {
  const auto vertex = [&](double x, double y, double z) {
    return fmt::format("v {:.6f} {:.6f} {:.6f}\n", nose.x() - length * x, nose.y() + length * y,
                       nose.z() + length * z);
  };
  return "o wedge\n" + vertex(0, 0, 0) + vertex(1, -0.25, 0) + vertex(1, 0.25, 0) +
         vertex(1, 0, 0.5) + "f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n";
}

class AnyMesh : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    return folder_.write(name, text).string();
  }
  // Quoted for the shell.
  static std::string quoted(const std::string& text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? "'\\''" : std::string(1, c);
    return out + "'";
  }
  Outcome render(const std::string& file, const std::string& out,
                 const std::string& more = "") const {
    return run("render " + quoted(file) +
               (more.find("--count") == std::string::npos ? " --count 2" : "") +
               " --quiet --set image.samples_per_pixel=1" + " --out " + path(out) + " " + more);
  }
  json first_box(const std::string& set) const {
    const auto file = folder_.path() / set / "test/000000/scene_gt_info.json";
    return json::parse(read_whole(file)).at("0").at(0);
  }
  TemporaryFolder folder_;
};

TEST_F(AnyMesh, TheDefaultSceneLooksAtTheMiddleWhereverTheOriginIs) {
  // At the origin, 12 lengths off it as in a CAD assembly, in UTM coordinates, and in millimetres
  // that are said to be metres: the same pictures, to the rounding of the coordinates.
  for (const auto& [name, length, nose] :
       {std::tuple("near", 2.0, Eigen::Vector3d(1, 0, 0)),
        std::tuple("cad", 2.0, Eigen::Vector3d(12, 4, 1)),
        std::tuple("utm", 2.0, Eigen::Vector3d(446789.25, 5411236.5, 312.125)),
        std::tuple("tiny", 0.003, Eigen::Vector3d(0.001, 0, 0))}) {
    const std::string file = write(fmt::format("{}.obj", name), wedge(length, nose));
    const Outcome outcome = render(file, name, "--seed 3");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
    const json box = first_box(name);
    // 0.3 to 0.7 of the width is the sphere round it, of which a wedge fills some.
    EXPECT_GT(box.at("px_count_visib").get<int>(), 3000) << name;
    EXPECT_NEAR(box.at("bbox_obj").at(0).get<double>(), first_box("near").at("bbox_obj").at(0), 3)
        << name;
    EXPECT_EQ(box.at("visib_fract").get<double>(), 1) << name;
    const bool is_moved =
        outcome.output.find("the target's origin is their middle") != std::string::npos;
    EXPECT_EQ(is_moved, std::string(name) == "utm") << outcome.output;
  }
}

TEST_F(AnyMesh, GeoreferencedCoordinatesKeepTheirMillimetres) {
  const std::string file = write("utm.obj", wedge(2, {446789.256, 5411236.511, 312.123}));
  const auto target = load_target(file);
  const Bounds box = bounds(target->mesh);
  const Eigen::Vector3d size = box.max_m - box.min_m;
  EXPECT_NEAR((size - Eigen::Vector3d(2, 1, 1)).norm(), 0, 1e-6);
  EXPECT_NEAR(middle_m(target->mesh).norm(), 0, 1e-6);
  // A part on a long arm stays where its file has it.
  const auto arm = load_target(write("arm.obj", wedge(2, {900, 0, 0})));
  EXPECT_NEAR(middle_m(arm->mesh).x(), 899, 1e-3);
}

TEST_F(AnyMesh, NamesMayHaveSpacesApostrophesAndAnyScript) {
  for (const std::string name : {"l'avion.obj", "航空機 \"x\".obj"}) {
    const std::string file = write(name, wedge(2, {0, 0, 0}));
    const Outcome outcome = render(file, "set");
    EXPECT_EQ(outcome.exit_code, 0) << name << ": " << outcome.output;
    EXPECT_EQ(run("render --quiet --verify " + path("set")).exit_code, 0) << name;
    fs::remove_all(path("set"));
    const Outcome proposal = run("target " + quoted(file) + " --propose " + path("proposal"));
    EXPECT_EQ(proposal.exit_code, 0) << name << ": " << proposal.output;
    EXPECT_EQ(run("target " + path("proposal/target.toml")).exit_code, 0) << name;
    fs::remove_all(path("proposal"));
  }
}

TEST_F(AnyMesh, ProposalsOfEmptyPartsAndTinyOnesAreTargets) {
  const std::string empty =
      write("empty.obj", wedge(2, {0, 0, 0}) + "o nothing\nv 5 5 5\nf 5 5 5\n");
  const std::string tiny = write("tiny.obj", wedge(0.003, {0, 0, 0}));
  for (const std::string& file : {empty, tiny}) {
    const Outcome outcome = run("target " + file + " --propose " + path("proposal"));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr("warning: 4 features are all there are"));
    const auto target = load_target(path("proposal/target.toml"));
    EXPECT_EQ(target->features.size(), 4u);
    const double size_m = (bounds(target->mesh).max_m - bounds(target->mesh).min_m).norm();
    for (const TargetFeature& feature : target->features) {
      EXPECT_LT(target->occluder.distance_m(feature.position_m), 1e-4 * size_m);
    }
    fs::remove_all(path("proposal"));
  }
}

TEST_F(AnyMesh, AFailedProposalLeavesNoFolderBehind) {
  const std::string file = write("wedge.obj", wedge(2, {0, 0, 0}));
  const std::string propose = "target " + file + " --propose " + path("new/proposal");
  const Outcome outcome = run(propose + " --picture " + path("picture.jpg"));
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.output, HasSubstr("must end in .png"));
  EXPECT_FALSE(fs::exists(path("new")));
  EXPECT_EQ(run(propose).exit_code, 0);
  EXPECT_TRUE(fs::exists(path("new/proposal/features.png")));
}

// A wedge of 2000 units with a disc of 6000 before its nose.
std::string wedge_with_disc() {
  return wedge(2000, {0, 0, 0}) +
         "o propeller.disc\nv 10 -3000 -3000\nv 10 3000 -3000\nv 10 0 3000\nf 5 6 7\n";
}

TEST_F(AnyMesh, UnitAxesAndPartsAreTakenAsAskedByEveryCommand) {
  const std::string file = write("plane.obj", wedge_with_disc());
  const std::string options = " --unit mm --forward x --up z --hide 'prop*'";
  const std::string taken =
      "taken in mm, with x forward and z up (--unit, --forward, --up); left out of it: prop*";
  const Outcome target = run("target " + file + options);
  EXPECT_THAT(target.output, AllOf(HasSubstr("2.000 x 1.000 x 1.000 m"), HasSubstr(taken)));
  EXPECT_THAT(run("target " + file + " --unit mm").output, HasSubstr("6.000"));

  const Outcome rendered = render(file, "set", options);
  ASSERT_EQ(rendered.exit_code, 0) << rendered.output;
  EXPECT_THAT(rendered.output, HasSubstr("note: plane: " + taken));
  const json models = json::parse(read_whole(path("set/models/models_info.json")));
  EXPECT_NEAR(models.at("1").at("size_x").get<double>(), 2000, 1e-3);
  EXPECT_EQ(run("render --quiet --verify " + path("set")).exit_code, 0);

  const Outcome proposal = run("target " + file + options + " --propose " + path("proposal"));
  ASSERT_EQ(proposal.exit_code, 0) << proposal.output;
  const std::string study =
      "study boeing-random --quiet --trials 1 --set features=all --set target=" +
      path("proposal/target.toml") + " --out ";
  const Outcome of_toml = run(study + path("a") + " --unit mm");
  EXPECT_EQ(of_toml.exit_code, 1);
  EXPECT_THAT(of_toml.output, HasSubstr("says itself how its mesh lies"));
}

TEST_F(AnyMesh, WhatCannotBeHiddenIsSaid) {
  const std::string file = write("plane.obj", wedge_with_disc());
  EXPECT_THAT(run("target " + file + " --hide wedgo").output,
              AllOf(HasSubstr("no part \"wedgo\""), HasSubstr("did you mean 'wedge'")));
  EXPECT_THAT(run("target " + file + " --hide '*'").output, HasSubstr("all its parts are hidden"));
  EXPECT_THAT(run("target " + file + " --unit furlong").output, HasSubstr("furlong"));
  EXPECT_THAT(render(file, "out", "--set mesh.hdie=1").output, HasSubstr("hdie"));
}

TEST_F(AnyMesh, NothingIsProposedOfWhatMovesByItsName) {
  const std::string file = write("plane.obj", wedge_with_disc());
  const Outcome outcome = run("target " + file + " --unit mm --propose " + path("proposal"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("what moves or blurs by its name"));
  const auto target = load_target(path("proposal/target.toml"));
  for (const TargetFeature& feature : target->features) {
    EXPECT_THAT(feature.name, Not(HasSubstr("prop")));
  }
}

TEST_F(AnyMesh, FromNearEveryPoseIsDrawn) {
  // Of a body of 2 m, 0.3 to 0.8 m before the camera, some reaches behind it at every pose.
  const std::string file = write("wedge.obj", wedge(2, {1, 0, 0}));
  const Outcome outcome = render(file, "set",
                                 "--count 6 --set poses.range_m=[0.3,0.8] --set "
                                 "poses.lateral_m=[-0.1,0.1] --set camera.f_px=300");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(run("render --quiet --verify " + path("set")).exit_code, 0);
}

TEST_F(AnyMesh, ACoarserMeshIsWritten) {
  const std::string coarse = path("coarse.glb");
  const Outcome outcome = run("target boeing707 --decimate 20 --out " + coarse);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("triangles, grey; read it with"));
  const auto target = load_target(coarse, {.forward = "z", .up = "y", .unit = ""});
  const auto whole = load_target("boeing707");
  const double kept = static_cast<double>(target->mesh.triangles.size()) /
                      static_cast<double>(whole->mesh.triangles.size());
  EXPECT_NEAR(kept, 0.2, 0.05);
  EXPECT_NEAR((bounds(target->mesh).max_m - bounds(whole->mesh).max_m).norm(), 0, 1);
  EXPECT_THAT(run("target boeing707 --decimate 20 --out " + coarse).output, HasSubstr("is kept"));
  EXPECT_EQ(run("target boeing707 --decimate 20").exit_code, 2);
}

// The files below a folder that a command opened, links followed; others it asked for in vain.
std::set<fs::path> opened_below(const fs::path& folder, const std::string& trace) {
  std::set<fs::path> opened;
  std::istringstream lines(trace);
  for (std::string line; std::getline(lines, line);) {
    const size_t begin = line.find('"');
    const size_t end = line.find('"', begin + 1);
    const bool is_open = begin != std::string::npos && line.find(" = -1 ") == std::string::npos;
    if (!is_open || line.find("O_DIRECTORY") != std::string::npos) continue;
    const fs::path real = fs::weakly_canonical(line.substr(begin + 1, end - begin - 1));
    const fs::path within = real.lexically_proximate(fs::canonical(folder));
    if (!within.string().starts_with("..")) opened.insert(within);
  }
  return opened;
}

// A triangle whose buffer and texture are named as told.
std::string gltf_with(const std::string& buffer, const std::string& picture) {
  return fmt::format(
      R"({{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"material":0}}]}}],
"materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],
"textures":[{{"source":0}}],"images":[{{"uri":"{}"}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
{{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}}],
"bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":24}}],
"buffers":[{{"byteLength":60,"uri":"{}"}}]}})",
      picture, buffer);
}

std::string triangle_bytes() {
  const std::array<float, 15> numbers = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1};
  return {reinterpret_cast<const char*>(numbers.data()), sizeof numbers};
}

TEST_F(AnyMesh, OnlyTheMeshsFolderAndWhatItsLinksLeadToIsOpened) {
  if (run_shell("strace -o /dev/null true").exit_code != 0) {
    GTEST_SKIP() << "strace is missing, or may not trace here";
  }
  for (const char* folder : {"mesh", "store", "outside"}) fs::create_directory(path(folder));
  write("store/buffer", triangle_bytes());
  write("outside/buffer.bin", triangle_bytes());
  write("outside/secret.png", "no picture");
  write("outside/secret.mtl", "newmtl paint\nKd 1 0 0\n");
  fs::create_symlink("../store/buffer", path("mesh/linked.bin"));
  fs::create_symlink("../outside", path("mesh/folder"));
  const auto opened = [&](const std::string& file) {
    run_shell("strace -f -e trace=open,openat,openat2 -o " + path("trace") + " " +
              SIGHTLINE_PROGRAM + " target " + quoted(path(file)));
    auto files = opened_below(folder_.path(), read_whole(path("trace")));
    files.erase("trace");
    return files;
  };
  using Files = std::set<fs::path>;
  write("mesh/linked.gltf", gltf_with("linked.bin", "../outside/secret.png"));
  EXPECT_EQ(opened("mesh/linked.gltf"), (Files{"mesh/linked.gltf", "store/buffer"}));
  for (const std::string& named : {std::string("../outside/buffer.bin"), path("outside/buffer.bin"),
                                   std::string("folder/buffer.bin")}) {
    write("mesh/curious.gltf", gltf_with(named, "none.png"));
    EXPECT_EQ(opened("mesh/curious.gltf"), Files{"mesh/curious.gltf"}) << named;
  }
  write("mesh/curious.obj", "mtllib ../outside/secret.mtl\nusemtl paint\n" + wedge(2, {0, 0, 0}));
  EXPECT_EQ(opened("mesh/curious.obj"), Files{"mesh/curious.obj"});
  // What lies outside is seen to be opened where a user asks for it.
  EXPECT_EQ(opened("outside/buffer.bin"), Files{"outside/buffer.bin"});
}

}  // namespace
}  // namespace sightline
