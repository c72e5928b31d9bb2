// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/materials.h"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "scenes/picture/picture_file.h"
#include "tests/scenes/scene/laws_for_tests.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string kInColour = "[image]\ncolour = \"rgb\"\n";

std::string picture_of(const cv::Scalar& blue_green_red, int width = 4) {
  return png_bytes(cv::Mat(2, width, CV_8UC3, blue_green_red));
}

std::string textures_in(const std::filesystem::path& path, const std::string& more = "") {
  return "[material]\ntextures = \"" + path.string() + "\"\n" + more;
}

Scene scene_of(const std::string& more, int64_t index = 0) {
  return draw_scene(law_of(more), 0, 7, index).scene;
}

TEST(Materials, WithoutKeysTheTargetIsItself) {
  const SceneLaw law = law_of("");
  EXPECT_FALSE(law.materials.is_there());
  const Scene scene = draw_scene(law, 0, 7, 0).scene;
  EXPECT_EQ(scene.target, law.target);
  EXPECT_TRUE(scene.materials.empty());
}

TEST(Materials, AreDrawnFromStreamsOfTheirOwnAndStated) {
  const SceneLaw law = law_of(kInColour +
                              "[material]\nhue_deg = [0, 360]\nsaturation = [0.5, 1]\n"
                              "value = [0.2, 0.9]\nroughness = [0.1, 0.9]\nmetallic = 1\n"
                              "emission = 0.25");
  std::set<double> roughnesses;
  for (int64_t i = 0; i < 5; ++i) {
    const Scene scene = draw_scene(law, 0, 7, i).scene;
    EXPECT_EQ(scene.cam_from_target.translation, scene_of("", i).cam_from_target.translation);
    ASSERT_EQ(scene.materials.size(), 1u);
    const DrawnMaterial& drawn = scene.materials.front();
    for (const Part& part : scene.target->mesh.parts) {
      ASSERT_TRUE(part.material);
      EXPECT_TRUE(part.material->has_gloss);
      EXPECT_EQ(part.material->roughness, drawn.roughness);
      EXPECT_EQ(part.material->metallic, 1);
      EXPECT_THAT(part.material->emissive, ElementsAre(0.25, 0.25, 0.25));
      for (size_t c = 0; c < 3; ++c) EXPECT_EQ(part.material->base[c], (*drawn.base)[c]);
    }
    const auto [least, greatest] = std::minmax_element(drawn.base->begin(), drawn.base->end());
    EXPECT_GE(*greatest, 0.2);
    EXPECT_LE(*greatest, 0.9);
    EXPECT_LE(*least, 0.5 * *greatest);
    roughnesses.insert(*drawn.roughness);
    const Scene again = draw_scene(law, 0, 7, i).scene;
    EXPECT_EQ(again.materials.front().base, drawn.base);
  }
  EXPECT_EQ(roughnesses.size(), 5u);
  std::vector<std::string> names;
  for (const Fact& fact : facts_of(draw_scene(law, 0, 7, 0).scene.materials.front())) {
    names.push_back(fact.name);
  }
  EXPECT_THAT(names, ElementsAre("body", "base", "roughness", "metallic", "emission"));
}

TEST(Materials, HueSaturationAndValueAreThoseOfLinearLight) {
  const auto base = [](const std::string& keys) {
    return *scene_of("[material]\n" + keys).materials.front().base;
  };
  EXPECT_THAT(base("hue_deg = 0\nsaturation = 1\nvalue = 0.5"), ElementsAre(0.5, 0, 0));
  EXPECT_THAT(base("hue_deg = 120\nsaturation = 1\nvalue = 0.5"), ElementsAre(0, 0.5, 0));
  EXPECT_THAT(base("hue_deg = 240\nsaturation = 0.5\nvalue = 1"), ElementsAre(0.5, 0.5, 1));
  EXPECT_THAT(base("hue_deg = 30\nsaturation = 1\nvalue = 1"),
              ElementsAre(1, DoubleNear(0.5, 1e-12), 0));
  EXPECT_THAT(base("value = 0.3"), ElementsAre(0.3, 0.3, 0.3));
  // A grey picture has its luminance.
  const Scene blue = scene_of("[material]\nhue_deg = 240\nsaturation = 1\nvalue = 1");
  for (const Part& part : blue.target->mesh.parts) EXPECT_NEAR(part.albedo, 0.0722, 1e-12);
}

TEST(Materials, EachPartMayHaveItsOwn) {
  const SceneLaw law = law_of("[material]\nvalue = [0.1, 0.9]\nper = \"part\"\n");
  const Scene scene = draw_scene(law, 0, 7, 0).scene;
  const std::vector<Part>& parts = scene.target->mesh.parts;
  ASSERT_EQ(scene.materials.size(), parts.size());
  std::set<double> values;
  for (size_t i = 0; i < parts.size(); ++i) {
    EXPECT_EQ(scene.materials[i].part, parts[i].name);
    EXPECT_EQ((*scene.materials[i].base)[0], parts[i].material->base[0]);
    values.insert(parts[i].albedo);
  }
  EXPECT_EQ(values.size(), parts.size());
}

TEST(Materials, OthersHaveThemWhereAsked) {
  const std::string two = "[[other]]\ntarget = \"cube\"\nscale = 0.1\ncount = 2\n";
  const std::string value = "[material]\nvalue = [0.1, 0.9]\n";
  EXPECT_EQ(scene_of(value + two).materials.size(), 1u);
  const Scene all = scene_of(value + "bodies = \"all\"\n" + two);
  ASSERT_EQ(all.materials.size(), 3u);
  EXPECT_EQ(all.materials[0].base, scene_of(value).materials[0].base);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(all.materials[i + 1].body, static_cast<int>(i) + 1);
    EXPECT_EQ(all.others[i].target->mesh.parts[0].material->base[0],
              (*all.materials[i + 1].base)[0]);
  }
  EXPECT_NE(all.materials[1].base, all.materials[2].base);
}

TEST(Materials, APictureOfAFolderLiesOnABoxInMetres) {
  const TemporaryFolder folder;
  folder.write("a.png", picture_of({0, 0, 255}));
  folder.write("b.png", picture_of({0, 255, 0}));
  folder.write("notes.txt", "no picture");
  const SceneLaw law = law_of(textures_in(folder.path(), "texture_m = 0.5\n"));
  std::set<std::string> files;
  for (int64_t i = 0; i < 20; ++i) {
    const Scene scene = draw_scene(law, 0, 7, i).scene;
    const Mesh& mesh = scene.target->mesh;
    ASSERT_EQ(mesh.coats.size(), mesh.triangles.size());
    ASSERT_EQ(mesh.textures.size(), 1u);
    const DrawnMaterial& drawn = scene.materials.front();
    files.insert(drawn.texture);
    EXPECT_EQ(mesh.textures[0]->rgba[drawn.texture.ends_with("a.png") ? 0 : 1], 255);
    const Material& material = *mesh.parts[0].material;
    EXPECT_EQ(material.base_texture.texture, 0);
    EXPECT_THAT(material.base, ElementsAre(1, 1, 1, 1));
    // 0.5 m wide, and half as high, as the picture is.
    EXPECT_THAT(material.base_texture.texture_from_uv, ElementsAre(2, 0, 0, 0, 4, 0));
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& vertex = mesh.triangles[t].vertex;
      for (size_t c = 0; c < 3; ++c) {
        const size_t j = (c + 1) % 3;
        const double metres = (mesh.vertices[static_cast<size_t>(vertex[c])] -
                               mesh.vertices[static_cast<size_t>(vertex[j])])
                                  .norm();
        EXPECT_NEAR((mesh.coats[t].uv[c] - mesh.coats[t].uv[j]).norm(), metres, 1e-6);
      }
      // Not mirrored: the corners go round as from outside, and v points down.
      const Coat& coat = mesh.coats[t];
      const Eigen::Vector2f a = coat.uv[1] - coat.uv[0], b = coat.uv[2] - coat.uv[0];
      EXPECT_LT(a.x() * b.y() - a.y() * b.x(), 0);
    }
  }
  EXPECT_EQ(files.size(), 2u);
}

TEST(Materials, WithoutAWidthOnePictureReachesOverTheBody) {
  const TemporaryFolder folder;
  const auto file = folder.write("a.png", picture_of({9, 9, 9}));
  const Scene scene = scene_of(textures_in(file));
  const Bounds box = bounds(scene.target->mesh);
  EXPECT_EQ(scene.materials.front().texture_m, (box.max_m - box.min_m).maxCoeff());
  EXPECT_EQ(scene.materials.front().texture, file.string());
}

// The cells of a sweep are as many laws: a picture is in memory once, and goes with the last.
TEST(Materials, LawsOfOnePictureHaveOneTexture) {
  const TemporaryFolder folder;
  const auto file = folder.write("a.png", picture_of({9, 9, 9}));
  std::weak_ptr<const Texture> texture;
  {
    const SceneLaw one = law_of(textures_in(file));
    const SceneLaw other = law_of(textures_in(file, "texture_m = 0.5\n"));
    const auto worn = [](const SceneLaw& law) {
      return draw_scene(law, 0, 7, 0).scene.target->mesh.textures.back();
    };
    EXPECT_EQ(worn(one), worn(other));
    texture = worn(one);
    EXPECT_FALSE(texture.expired());
  }
  EXPECT_TRUE(texture.expired());
}

TEST(Materials, TextureCoordinatesOfTheFileAreKept) {
  const TemporaryFolder folder;
  const auto file = folder.write("a.png", picture_of({9, 9, 9}));
  const TomlTable table = TomlTable::read_text(
      "[camera]\nf_px = 400\n[poses]\nattitude = \"uniform\"\nlateral_m = [0, 0]\nrange_m = "
      "[200, 300]\n" +
          textures_in(file),
      "scene.toml");
  const auto livery = load_target("boeing707_livery");
  const Scene scene = draw_scene(read_scene_law(table, livery, {}), 0, 7, 0).scene;
  const Mesh& mesh = scene.target->mesh;
  int kept = 0;
  for (size_t t = 0; t < mesh.coats.size(); ++t)
    kept += mesh.coats[t].uv == livery->mesh.coats[t].uv;
  EXPECT_GT(kept, 0);
  EXPECT_EQ(mesh.textures.size(), livery->mesh.textures.size() + 1);
  for (const Part& part : mesh.parts) {
    EXPECT_EQ(part.material->base_texture.texture, static_cast<int>(mesh.textures.size()) - 1);
  }
}

// A cube with vertex colours, its first part a pane that a texture cuts out.
std::shared_ptr<const Target> coloured_cube() {
  auto cube = std::make_shared<Target>(*load_target("cube"));
  Mesh& mesh = cube->mesh;
  mesh.coats.resize(mesh.triangles.size());
  for (Coat& coat : mesh.coats) coat.colour.fill({0.1F, 0.2F, 0.3F, 0.5F});
  mesh.textures.push_back(std::make_shared<Texture>());
  for (Part& part : mesh.parts) part.material.emplace();
  mesh.parts[0].material->alpha_mode = AlphaMode::kMask;
  mesh.parts[0].material->base_texture.texture = 0;
  return cube;
}

// A cube whose parts lie at the middle of a palette's second texel, but the last, which has two.
std::shared_ptr<const Target> palette_cube() {
  auto cube = std::make_shared<Target>(*load_target("cube"));
  Mesh& mesh = cube->mesh;
  const int last = static_cast<int>(mesh.parts.size()) - 1;
  mesh.coats.resize(mesh.triangles.size());
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    mesh.coats[t].uv.fill({0.375F, 1.0F});
    if (mesh.triangles[t].part == last && t % 2 == 0) mesh.coats[t].uv.fill({0.875F, 0.5F});
  }
  mesh.textures.push_back(std::make_shared<Texture>(
      Texture{"palette", 2, 1, true, {10, 20, 30, 255, 40, 50, 60, 255}}));
  for (Part& part : mesh.parts) {
    Material& material = part.material.emplace();
    for (TextureRef* ref : material.textures()) {
      ref->texture = 0;
      ref->texture_from_uv = {2, 0, 1, 0, 1, 0};
    }
    material.emissive = {1, 1, 1};
  }
  return cube;
}

TEST(Materials, AreLitWhereTheirRoughnessIsDrawn) {
  auto cube = std::make_shared<Target>(*load_target("cube"));
  cube->mesh.parts[0].material.emplace().is_unlit = true;
  const auto is_unlit_with = [&](const std::string& keys) {
    const TomlTable table =
        TomlTable::read_text(kCubeScene + kInColour + "[material]\n" + keys, "a.toml");
    const Scene scene = draw_scene(read_scene_law(table, cube, {}), 0, 7, 0).scene;
    return scene.target->mesh.parts[0].material->is_unlit;
  };
  EXPECT_TRUE(is_unlit_with("value = 0.5"));
  EXPECT_FALSE(is_unlit_with("roughness = 0.5"));
  EXPECT_FALSE(is_unlit_with("metallic = 0.5"));
}

TEST(Materials, OtherTexturesOfAPaletteStayAtItsPoint) {
  const TemporaryFolder folder;
  const auto file = folder.write("a.png", picture_of({9, 9, 9}));
  const TomlTable table = TomlTable::read_text(kCubeScene + textures_in(file), "a.toml");
  const Scene scene = draw_scene(read_scene_law(table, palette_cube(), {}), 0, 7, 0).scene;
  const Mesh& mesh = scene.target->mesh;
  const Material& material = *mesh.parts.front().material;
  EXPECT_EQ(material.base_texture.texture, static_cast<int>(mesh.textures.size()) - 1);
  EXPECT_FALSE(material.normal_texture.is_there());
  for (const TextureRef& ref :
       {material.emissive_texture, material.gloss_texture, material.occlusion_texture}) {
    ASSERT_TRUE(ref.is_there());
    const Texture& texel = *mesh.textures[static_cast<size_t>(ref.texture)];
    EXPECT_EQ(texel.width * texel.height, 1);
    EXPECT_TRUE(texel.is_srgb);
    EXPECT_THAT(texel.rgba, ElementsAre(40, 50, 60, 255));
  }
  const Material& of_two = *mesh.parts.back().material;
  EXPECT_FALSE(of_two.emissive_texture.is_there());
  EXPECT_FALSE(of_two.gloss_texture.is_there());
  EXPECT_THAT(of_two.emissive, ElementsAre(0, 0, 0));
}

TEST(Materials, ReplaceTheColoursOfVerticesButNotWhatIsSeeThrough) {
  const auto cube = coloured_cube();
  const TomlTable table = TomlTable::read_text(kCubeScene + "[material]\nvalue = 0.5", "a.toml");
  const Scene scene = draw_scene(read_scene_law(table, cube, {}), 0, 7, 0).scene;
  const Mesh& mesh = scene.target->mesh;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const bool is_pane = mesh.triangles[t].part == 0;
    const Eigen::Vector4f& colour = mesh.coats[t].colour[1];
    EXPECT_EQ(colour[0], is_pane ? 0.1F : 1.0F);
    EXPECT_EQ(colour[3], 0.5F);
  }
  EXPECT_EQ(mesh.parts[0].material->base[0], 1);
  EXPECT_EQ(mesh.parts[0].material->base_texture.texture, 0);
  EXPECT_EQ(mesh.parts[1].material->base[0], 0.5);
}

TEST(Materials, MistakesGetOneClearLine) {
  const TemporaryFolder folder;
  EXPECT_THAT(law_error("[material]\nroughness = 0.5"), HasSubstr("image.colour"));
  EXPECT_THAT(law_error("[material]\nmetallic = 0.5"), HasSubstr("image.colour"));
  EXPECT_THAT(law_error("[material]\nemission = 0.5"), "");
  EXPECT_THAT(law_error(kInColour + "[material]\nroughness = [0.1, 1.5]"),
              HasSubstr("material.roughness"));
  EXPECT_THAT(law_error("[material]\nvalue = 2"), HasSubstr("0 to 1"));
  EXPECT_THAT(law_error("[material]\ntexture_m = 1"), HasSubstr("needs textures beside it"));
  EXPECT_THAT(law_error("[material]\nper = \"bodies\""), HasSubstr("known: body, part"));
  EXPECT_THAT(law_error("[material]\ncolour = 1"), HasSubstr("not a known key"));
  EXPECT_THAT(law_error(textures_in(folder.path())), HasSubstr("a folder without pictures"));
  EXPECT_THAT(law_error(textures_in(folder.path() / "none.png")), HasSubstr("is not there"));
  const auto file = folder.write("a.png", picture_of({9, 9, 9}));
  EXPECT_THAT(law_error(textures_in(file) + "[image]\ntextures = false"),
              HasSubstr("needs image.textures = true"));
}

// Of what a scene draws of a folder each file is read once, and a torn one named with its key.
TEST(DrawnFiles, AreCheckedBeforeTheyAreDrawn) {
  const TemporaryFolder folder;
  const std::string good = picture_of({9, 9, 9}, 64);
  folder.write("a.png", good);
  folder.write("b.png", good.substr(0, good.size() / 2));
  for (const std::string& keys :
       {textures_in(folder.path()),
        "[background]\nkind = \"image\"\nfile = \"" + folder.path().string() + "\"\n"}) {
    const SceneLaw law = law_of(keys);
    const std::string error = error_of([&] {
      CheckedFiles checked;
      for (int64_t i = 0; i < 20; ++i) check_drawn_files(law, 7, i, checked);
    });
    EXPECT_THAT(error, HasSubstr("scene.toml: "));
    EXPECT_THAT(error, HasSubstr(keys.starts_with("[material]") ? "material.textures is"
                                                                : "background.file is"));
    EXPECT_THAT(error, HasSubstr("whose b.png "));
  }
}

}  // namespace
}  // namespace sightline
