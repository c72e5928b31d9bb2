// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/materials.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "scenes/mesh/mesh_soup.h"
#include "scenes/picture/picture_file.h"
#include "scenes/scene/box_uv.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr int kMostTexels = 512;  // of a picture's longer side, as it is kept
constexpr size_t kKeptTextures = 32;

struct FileTexture {
  std::shared_ptr<const Texture> texture;
  std::string problem;  // to stand after the file's name; empty where there is none
};

FileTexture read_texture(const fs::path& file) {
  auto [pixels, problem] = read_picture_file(file, PictureChannels::kColour);
  if (!problem.empty()) return {nullptr, problem};
  const double factor = static_cast<double>(kMostTexels) / std::max(pixels.cols, pixels.rows);
  if (factor < 1) {
    const cv::Size size(std::max(1, static_cast<int>(std::lround(factor * pixels.cols))),
                        std::max(1, static_cast<int>(std::lround(factor * pixels.rows))));
    cv::Mat smaller;
    cv::resize(pixels, smaller, size, 0, 0, cv::INTER_AREA);
    pixels = smaller;
  }
  cv::Mat rgba;
  cv::cvtColor(pixels, rgba, cv::COLOR_BGR2RGBA);
  auto texture = std::make_shared<Texture>();
  texture->name = file.filename().string();
  texture->width = rgba.cols;
  texture->height = rgba.rows;
  texture->rgba.assign(rgba.datastart, rgba.dataend);
  return {texture, {}};
}

// Linear red, green and blue of a hue, all numbers but the hue from 0 to 1.
std::array<double, 3> linear_of_hsv(double hue_deg, double saturation, double value) {
  std::array<double, 3> rgb{};
  const std::array<double, 3> offset = {5, 3, 1};
  for (size_t c = 0; c < 3; ++c) {
    const double k = std::fmod(offset[c] + hue_deg / 60, 6);
    rgb[c] = value * (1 - saturation * std::clamp(std::min(k, 4 - k), 0.0, 1.0));
  }
  return rgb;
}

// The shape of a see-through part lies in its texture.
bool keeps_paint(const Part& part) {
  return part.material && part.material->alpha_mode != AlphaMode::kOpaque &&
         part.material->base_texture.is_there();
}

bool changes_coats(const MaterialLaw& law, const Mesh& mesh) {
  return !law.textures.empty() || (law.has_colour && !mesh.coats.empty());
}

// Without the colours of vertices where materials have colours of their own; their alpha stays.
void prepare_coats(const MaterialLaw& law, const std::vector<bool>& has_box_uv, Mesh& mesh) {
  mesh.coats.resize(mesh.triangles.size());
  for (size_t t = 0; t < mesh.coats.size(); ++t) {
    if (keeps_paint(mesh.parts[static_cast<size_t>(mesh.triangles[t].part)])) continue;
    for (Eigen::Vector4f& colour : mesh.coats[t].colour) colour.head<3>().setOnes();
  }
  if (!law.textures.empty()) lay_box_uv(has_box_uv, mesh);
}

DressedBody prepared_body(const MaterialLaw& law, const std::shared_ptr<const Target>& target) {
  const Mesh& mesh = target->mesh;
  DressedBody body{.target = target, .prepared = target, .has_box_uv = {}, .side_m = 0};
  const Bounds box = bounds(mesh);
  body.side_m = (box.max_m - box.min_m).maxCoeff();
  body.has_box_uv = parts_without_uv(mesh);
  for (size_t i = 0; i < mesh.parts.size(); ++i) {
    if (keeps_paint(mesh.parts[i])) body.has_box_uv[i] = false;
  }
  if (!changes_coats(law, mesh)) return body;
  const auto prepared = std::make_shared<Target>(*target);
  prepare_coats(law, body.has_box_uv, prepared->mesh);
  body.prepared = prepared;
  return body;
}

// Streams of one scene: what is drawn for one body or part after the other comes from each in turn.
struct MaterialStreams {
  explicit MaterialStreams(const Draws& draws)
      : hue(draws.stream("material.hue_deg")),
        saturation(draws.stream("material.saturation")),
        value(draws.stream("material.value")),
        roughness(draws.stream("material.roughness")),
        metallic(draws.stream("material.metallic")),
        emission(draws.stream("material.emission")),
        textures(draws.stream("material.textures")),
        texture_m(draws.stream("material.texture_m")) {}

  RandomStream hue, saturation, value, roughness, metallic, emission, textures, texture_m;
};

std::optional<double> drawn_of(const std::optional<Range>& range, RandomStream& stream) {
  return range ? std::optional(range->draw(stream)) : std::nullopt;
}

struct DrawnSurface {
  DrawnMaterial stated;
  fs::path file;  // of its texture
};

DrawnSurface draw_surface(const MaterialLaw& law, double side_m, MaterialStreams& streams) {
  DrawnSurface surface;
  DrawnMaterial& stated = surface.stated;
  if (law.has_colour) {
    const double hue = law.hue_deg.draw(streams.hue);
    const double saturation = law.saturation.draw(streams.saturation);
    stated.base = linear_of_hsv(hue, saturation, law.value.draw(streams.value));
  }
  stated.roughness = drawn_of(law.roughness, streams.roughness);
  stated.metallic = drawn_of(law.metallic, streams.metallic);
  stated.emission = drawn_of(law.emission, streams.emission);
  if (law.files.is_there()) {
    surface.file = law.files.draw(streams.textures);
    stated.texture = law.files.stated(surface.file);
    stated.texture_m = drawn_of(law.texture_m, streams.texture_m).value_or(side_m);
  }
  return surface;
}

// All surfaces of a scene, body after body; of each part where the law says so.
std::vector<DrawnSurface> draw_surfaces(const MaterialLaw& law, const Draws& draws) {
  MaterialStreams streams(draws);
  std::vector<DrawnSurface> surfaces;
  for (size_t b = 0; b < law.bodies.size(); ++b) {
    const std::vector<Part>& parts = law.bodies[b].target->mesh.parts;
    const size_t count = law.is_per_part ? parts.size() : 1;
    for (size_t i = 0; i < count; ++i) {
      DrawnSurface& surface =
          surfaces.emplace_back(draw_surface(law, law.bodies[b].side_m, streams));
      surface.stated.body = static_cast<int>(b);
      if (!law.is_per_part) continue;
      surface.stated.part = parts[i].name;
      surface.stated.part_index = static_cast<int>(i);
    }
  }
  return surfaces;
}

Material own_material(const Part& part) {
  Material grey;
  grey.base = {part.albedo, part.albedo, part.albedo, 1};
  return part.material.value_or(grey);
}

TextureRef ref_to(int texture, const Texture& picture, const DrawnMaterial& drawn, bool is_box) {
  TextureRef ref;
  ref.texture = texture;
  if (!is_box) return ref;
  const double across = 1 / drawn.texture_m;
  ref.texture_from_uv = {across, 0, 0, 0, across * picture.width / picture.height, 0};
  // Pictures that do not go on at their other side show no seam.
  ref.wrap_u = ref.wrap_v = Wrap::kMirror;
  return ref;
}

void paint(Part& part, const DrawnMaterial& drawn, const TextureRef& texture, Material& material) {
  if ((!drawn.base && !texture.is_there()) || keeps_paint(part)) return;
  const std::array<double, 3> base = drawn.base.value_or(std::array<double, 3>{1, 1, 1});
  std::copy(base.begin(), base.end(), material.base.begin());
  material.base_texture = texture;
  part.albedo = luminance(base[0], base[1], base[2]);
}

void wear(Part& part, const DrawnMaterial& drawn, const TextureRef& texture) {
  Material material = own_material(part);
  paint(part, drawn, texture, material);
  if (drawn.roughness || drawn.metallic) {
    material.is_unlit = false;
    material.has_gloss = true;
    material.roughness = drawn.roughness.value_or(material.roughness);
    material.metallic = drawn.metallic.value_or(material.metallic);
    material.gloss_texture = {};
  }
  if (drawn.emission) {
    material.emissive.fill(*drawn.emission);
    material.emissive_texture = {};
  }
  part.material = material;
}

void require_colour(const TomlTable& table, const ColouringLaw& colouring) {
  if (colouring.mode != ColourMode::kGrey) return;
  for (const char* key : {"roughness", "metallic"}) {
    if (!table.has(key)) continue;
    table.fail(key, "needs image.colour = \"rgb\" or \"bayer\": in grey all surfaces are dull");
  }
}

FileDraw pictures_to_draw(const TomlTable& table, const std::string& given) {
  const fs::path found = named_path(table, given);
  std::error_code error;
  if (fs::is_directory(found, error)) {
    const auto is_picture = [](const fs::path& one) { return picture_size(one).has_value(); };
    return files_of(table, "material", "textures", found, given, is_picture, "pictures");
  }
  const std::string problem = read_texture(found).problem;
  if (!problem.empty()) {
    table.fail("textures", fmt::format("is \"{}\", which {}", given, problem));
  }
  return {.key = fmt::format("{}: material.textures", table.file().string()),
          .given = fs::path(given).parent_path().string(),
          .files = {found}};
}

}  // namespace

// Textures of files: while few are drawn, a renderer meets the same ones again.
class FileTextures {
 public:
  // One for all laws while any of them lives, so that a sweep's cells have the same textures.
  static std::shared_ptr<FileTextures> shared() {
    static std::mutex mutex;
    static std::weak_ptr<FileTextures> current;
    const std::lock_guard<std::mutex> lock(mutex);
    auto textures = current.lock();
    if (!textures) current = textures = std::make_shared<FileTextures>();
    return textures;
  }

  std::shared_ptr<const Texture> get(const FileDraw& files, const fs::path& file) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto known = textures_.find(file);
    if (known != textures_.end()) return known->second;
    auto [texture, problem] = read_texture(file);
    if (!problem.empty()) files.fail(file, problem);
    if (textures_.size() == kKeptTextures) textures_.clear();
    return textures_[file] = texture;
  }

 private:
  std::mutex mutex_;
  std::map<fs::path, std::shared_ptr<const Texture>> textures_;
};

bool MaterialLaw::is_there() const {
  return has_colour || roughness || metallic || emission || !textures.empty();
}

std::vector<Key> keys_of(MaterialLaw& law) {
  return {
      {"material",
       "hue_deg",
       &law.hue_deg,
       {0, 360},
       "deg",
       "hue of the base colour in linear light: 0 is red, 120 green, 240 blue. Any of hue_deg, "
       "saturation and value gives all surfaces a colour, in the place of their own and of their "
       "textures",
       {},
       "base"},
      {"material",
       "saturation",
       &law.saturation,
       {0, 1},
       "",
       "of the base colour: 0 is grey",
       {},
       "base"},
      {"material",
       "value",
       &law.value,
       {0, 1},
       "",
       "of the base colour: the largest of its red, green and blue",
       {},
       "base"},
      {"material",
       "roughness",
       &law.roughness,
       {0, 1},
       "",
       "of all surfaces, which are glossy then, as glTF has it; for pictures in colour",
       {},
       "roughness",
       false,
       "the part's own"},
      {"material",
       "metallic",
       &law.metallic,
       {0, 1},
       "",
       "how much of a metal they are, as glTF has it; for pictures in colour",
       {},
       "metallic",
       false,
       "the part's own"},
      {"material",
       "emission",
       &law.emission,
       {0, kLargestEmission},
       "",
       "white light that they send, 1 is white",
       {},
       "emission",
       false,
       "the part's own"},
      {"material",
       "textures",
       &law.textures,
       {},
       "",
       "a picture that lies on all surfaces, beside this file, or a folder, of whose pictures one "
       "is drawn; the base colour is a factor on it, 1 where none is given. Parts whose own "
       "texture is see-through keep it",
       {},
       "texture",
       false,
       "the part's own"},
      {"material",
       "texture_m",
       &law.texture_m,
       {1e-6, 1e6},
       "m",
       "width of a picture on parts without texture coordinates, where it lies along the two axes "
       "across the one that a triangle faces, and is mirrored at its borders",
       {},
       "texture_m",
       false,
       "the longest side of the body's box"},
      {"material",
       "per",
       choice(law.is_per_part, {{"body", false}, {"part", true}}),
       {},
       "",
       "whether all parts of a body are alike, or each is drawn by itself",
       {},
       "part"},
      {"material",
       "bodies",
       choice(law.is_of_all, {{"target", false}, {"all", true}}),
       {},
       "",
       "whose surfaces: of the main target, or of those beside it too",
       {},
       "body"},
  };
}

MaterialLaw read_materials(const TomlTable& file, const ColouringLaw& colouring,
                           const std::shared_ptr<const Target>& target,
                           const std::vector<OtherLaw>& others) {
  MaterialLaw law;
  read_keys(file, keys_of(law));
  const TomlTable table = file.table("material");
  law.has_colour = table.has("hue_deg") || table.has("saturation") || table.has("value");
  require_colour(table, colouring);
  if (law.texture_m && law.textures.empty()) table.fail("texture_m", "needs textures beside it");
  if (!law.is_there()) return law;
  if (!law.textures.empty()) {
    if (!colouring.draws_textures) table.fail("textures", "needs image.textures = true");
    law.files = pictures_to_draw(table, law.textures);
  }
  law.shelf = FileTextures::shared();
  law.bodies.push_back(prepared_body(law, target));
  if (!law.is_of_all) return law;
  for (const OtherLaw& other : others) {
    const DressedBody body = prepared_body(law, other.target);
    law.bodies.insert(law.bodies.end(), static_cast<size_t>(other.count), body);
  }
  return law;
}

std::vector<DrawnMaterial> dress(const MaterialLaw& law, const Draws& draws,
                                 std::shared_ptr<const Target>& target,
                                 std::vector<OtherBody>& others) {
  std::vector<DrawnMaterial> drawn;
  if (!law.is_there()) return drawn;
  std::vector<std::shared_ptr<Target>> dressed;
  for (const DrawnSurface& surface : draw_surfaces(law, draws)) {
    const DrawnMaterial& stated = surface.stated;
    const auto b = static_cast<size_t>(stated.body);
    const DressedBody& body = law.bodies[b];
    if (b > others.size()) break;  // it found no place
    if (dressed.size() == b) dressed.push_back(std::make_shared<Target>(*body.prepared));
    Mesh& mesh = dressed[b]->mesh;
    if (!surface.file.empty()) mesh.textures.push_back(law.shelf->get(law.files, surface.file));
    for (size_t i = 0; i < mesh.parts.size(); ++i) {
      if (stated.part_index >= 0 && stated.part_index != static_cast<int>(i)) continue;
      TextureRef texture;
      if (!surface.file.empty()) {
        const auto last = static_cast<int>(mesh.textures.size()) - 1;
        texture = ref_to(last, *mesh.textures.back(), stated, body.has_box_uv[i]);
      }
      wear(mesh.parts[i], stated, texture);
    }
    drawn.push_back(stated);
  }
  for (size_t b = 0; b < dressed.size(); ++b) {
    (b == 0 ? target : others[b - 1].target) = std::move(dressed[b]);
  }
  return drawn;
}

void check_drawn_files(const MaterialLaw& law, const Draws& draws, CheckedFiles& checked) {
  if (!law.files.is_there()) return;
  for (const DrawnSurface& surface : draw_surfaces(law, draws)) {
    if (checked.insert(surface.file).second) law.shelf->get(law.files, surface.file);
  }
}

std::vector<Fact> facts_of(const DrawnMaterial& drawn) {
  std::vector<Fact> facts{{"body", int64_t{drawn.body}}};
  if (!drawn.part.empty()) facts.push_back({"part", drawn.part});
  if (drawn.base) facts.push_back({"base", std::vector(drawn.base->begin(), drawn.base->end())});
  if (drawn.roughness) facts.push_back({"roughness", *drawn.roughness});
  if (drawn.metallic) facts.push_back({"metallic", *drawn.metallic});
  if (drawn.emission) facts.push_back({"emission", *drawn.emission});
  if (drawn.texture.empty()) return facts;
  facts.push_back({"texture", drawn.texture});
  facts.push_back({"texture_m", drawn.texture_m});
  return facts;
}

}  // namespace sightline
