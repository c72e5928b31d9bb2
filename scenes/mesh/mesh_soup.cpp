// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/mesh_soup.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenes/files/input_error.h"
#include "scenes/mesh/textures.h"

namespace sightline {
namespace {

constexpr std::string_view kMagic = "SLSOUP1\n";
constexpr size_t kMaxNameBytes = 256;
constexpr size_t kNumbersPerTriangle = 18;
constexpr size_t kBytesPerTriangle = kNumbersPerTriangle * sizeof(double) + sizeof(uint32_t);
constexpr double kLongestNormal = 1 + 1e-6;
// What follows the triangles of a mesh that has more than shape and grey.
constexpr std::string_view kSurfaceMagic = "SURFACE1";
constexpr size_t kMaxTextures = 4096;
constexpr size_t kMaxSentences = 1000;
constexpr size_t kMaxSentenceBytes = 1000;
constexpr double kLargestTextureCoordinate = 1e6;  // single precision still knows the texel's tenth

template <typename T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// Invalid bytes dropped, control characters as underscores.
std::string printable(const std::string& name, size_t most_bytes) {
  using nlohmann::json;
  const std::string quoted =
      json(name.substr(0, most_bytes)).dump(-1, ' ', false, json::error_handler_t::ignore);
  std::string text = json::parse(quoted).get<std::string>();
  for (char& c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 || code == 0x7f) c = '_';
  }
  return text;
}

void append_text(std::string& bytes, const std::string& text) {
  const std::string kept = text.substr(0, kMaxSentenceBytes);
  append(bytes, static_cast<uint32_t>(kept.size()));
  bytes += kept;
}

void append(std::string& bytes, const TextureRef& ref) {
  append(bytes, static_cast<int32_t>(ref.texture));
  append(bytes, static_cast<uint8_t>(ref.wrap_u));
  append(bytes, static_cast<uint8_t>(ref.wrap_v));
  append(bytes, static_cast<uint8_t>(ref.is_nearest));
  append(bytes, ref.texture_from_uv);
}

void append(std::string& bytes, const Material& material) {
  append(bytes, material.base);
  append(bytes, static_cast<uint8_t>(material.has_gloss));
  append(bytes, material.metallic);
  append(bytes, material.roughness);
  append(bytes, static_cast<uint8_t>(material.is_unlit));
  append(bytes, material.emissive);
  append(bytes, static_cast<uint8_t>(material.alpha_mode));
  append(bytes, material.alpha_cutoff);
  append(bytes, material.normal_scale);
  append(bytes, material.base_texture);
  append(bytes, material.gloss_texture);
  append(bytes, material.emissive_texture);
  append(bytes, material.normal_texture);
}

bool has_surface(const MeshSoup& soup) {
  return soup.has_coats || !soup.textures.empty() || !soup.lost_textures.empty() ||
         !soup.notes.empty() || soup.unit_m != 1 ||
         std::any_of(soup.parts.begin(), soup.parts.end(),
                     [](const Part& part) { return part.material.has_value(); });
}

void append_surface(std::string& bytes, const MeshSoup& soup) {
  bytes += kSurfaceMagic;
  append(bytes, static_cast<uint32_t>(soup.textures.size()));
  append(bytes, static_cast<uint32_t>(soup.lost_textures.size()));
  append(bytes, static_cast<uint32_t>(soup.notes.size()));
  append(bytes, soup.unit_m);
  append(bytes, static_cast<uint8_t>(soup.has_coats));
  for (const Texture& texture : soup.textures) {
    append_text(bytes, texture.name);
    append(bytes, static_cast<uint8_t>(texture.is_srgb));
    append(bytes, static_cast<int32_t>(texture.width));
    append(bytes, static_cast<int32_t>(texture.height));
    bytes.append(reinterpret_cast<const char*>(texture.rgba.data()), texture.rgba.size());
  }
  for (const std::string& sentence : soup.lost_textures) append_text(bytes, sentence);
  for (const std::string& note : soup.notes) append_text(bytes, note);
  for (const Part& part : soup.parts) {
    append(bytes, static_cast<uint8_t>(part.material.has_value()));
    if (part.material) append(bytes, *part.material);
  }
  if (!soup.has_coats) return;
  for (const SoupTriangle& triangle : soup.triangles) {
    for (const Eigen::Vector2f& uv : triangle.coat.uv) append(bytes, std::array{uv.x(), uv.y()});
    for (const Eigen::Vector4f& c : triangle.coat.colour) {
      append(bytes, std::array{c[0], c[1], c[2], c[3]});
    }
  }
}

// What the surface takes in bytes, about: textures are copied once.
size_t surface_bytes(const MeshSoup& soup) {
  size_t bytes = 512 * soup.parts.size() + 4096;
  for (const Texture& texture : soup.textures) bytes += texture.rgba.size() + kMaxSentenceBytes;
  return bytes + (soup.has_coats ? sizeof(Coat) * soup.triangles.size() : 0);
}

class Decoder {
 public:
  Decoder(std::string_view bytes, const std::filesystem::path& file) : bytes_(bytes), file_(file) {}

  MeshSoup decode() {
    if (take(kMagic.size()) != kMagic) fail("its reader sent no mesh");
    const auto parts = number<uint64_t>();
    const auto triangles = number<uint64_t>();
    if (parts > kMaxParts || triangles > kMaxTriangles) fail("its reader sent too large a mesh");
    MeshSoup soup;
    for (uint64_t i = 0; i < parts; ++i) soup.parts.push_back(part());
    if (bytes_.size() < triangles * kBytesPerTriangle) fail("its reader sent a torn mesh");
    soup.triangles.reserve(triangles);
    for (uint64_t i = 0; i < triangles; ++i) soup.triangles.push_back(triangle(parts));
    if (bytes_.starts_with(kSurfaceMagic)) read_surface(soup);
    if (!bytes_.empty()) fail("its reader sent a torn mesh");
    return soup;
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(fmt::format("{}: {}", file_.string(), reason));
  }

  std::string_view take(size_t count) {
    if (count > bytes_.size()) fail("its reader sent a torn mesh");
    const std::string_view taken = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return taken;
  }

  template <typename T>
  T number() {
    T value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }

  Part part() {
    const auto length = number<uint32_t>();
    if (length > kMaxNameBytes) fail("its reader sent a part with too long a name");
    Part out;
    out.name = printable(std::string(take(length)), kMaxNameBytes);
    out.albedo = number<double>();
    if (!(out.albedo >= 0 && out.albedo <= 1)) {
      fail(fmt::format("part \"{}\" has albedo {}, must be from 0 to 1", out.name, out.albedo));
    }
    return out;
  }

  SoupTriangle triangle(uint64_t parts) {
    SoupTriangle out;
    for (Eigen::Vector3d& corner : out.corner) {
      corner = vector();
      if (!corner.allFinite()) fail("a vertex is not a finite number");
      const double largest = corner.cwiseAbs().maxCoeff();
      if (largest > kLargestCoordinate) {
        fail(fmt::format("a coordinate is {:.3g}, must be at most {:.0e}", largest,
                         kLargestCoordinate));
      }
    }
    for (Eigen::Vector3d& normal : out.normal) {
      normal = vector();
      if (!(normal.norm() <= kLongestNormal)) fail("a normal is no unit vector");
    }
    const auto part = number<uint32_t>();
    if (part >= parts) fail("a triangle belongs to no part");
    out.part = static_cast<int>(part);
    return out;
  }

  void read_surface(MeshSoup& soup) {
    take(kSurfaceMagic.size());
    const auto textures = number<uint32_t>();
    const auto sentences = number<uint32_t>();
    const auto notes = number<uint32_t>();
    soup.unit_m = number<double>();
    if (!(soup.unit_m >= kSmallestUnitM && soup.unit_m <= kLargestUnitM)) {
      fail(fmt::format("states a unit of {} m, must be from {} to {}", soup.unit_m, kSmallestUnitM,
                       kLargestUnitM));
    }
    soup.has_coats = number<uint8_t>() != 0;
    if (textures > kMaxTextures || std::max(sentences, notes) > kMaxSentences) {
      fail("its reader sent too much");
    }
    for (uint32_t i = 0; i < textures; ++i) soup.textures.push_back(texture());
    for (uint32_t i = 0; i < sentences; ++i) {
      soup.lost_textures.push_back(printable(text(), kMaxSentenceBytes));
    }
    for (uint32_t i = 0; i < notes; ++i) soup.notes.push_back(printable(text(), kMaxSentenceBytes));
    for (Part& part : soup.parts) {
      if (number<uint8_t>() != 0) part.material = material(static_cast<int>(textures));
    }
    if (!soup.has_coats) return;
    for (SoupTriangle& triangle : soup.triangles) triangle.coat = coat();
  }

  std::string text() {
    const auto length = number<uint32_t>();
    if (length > kMaxSentenceBytes) fail("its reader sent too long a text");
    return std::string(take(length));
  }

  Texture texture() {
    Texture out;
    out.name = printable(text(), kMaxSentenceBytes);
    out.is_srgb = number<uint8_t>() != 0;
    out.width = number<int32_t>();
    out.height = number<int32_t>();
    const bool is_sized = out.width > 0 && out.height > 0 && out.width <= kMaxTextureSide &&
                          out.height <= kMaxTextureSide &&
                          int64_t{out.width} * out.height <= kMaxTexturePixels;
    if (!is_sized) fail("its reader sent a texture of a wrong size");
    const std::string_view bytes = take(size_t{4} * out.width * out.height);
    out.rgba.assign(bytes.begin(), bytes.end());
    return out;
  }

  double number_within(double low, double high) {
    const auto value = number<double>();
    if (!(value >= low && value <= high)) fail("its reader sent a material that cannot be");
    return value;
  }

  template <typename Enum>
  Enum choice(Enum last) {
    const auto value = number<uint8_t>();
    if (value > static_cast<uint8_t>(last)) fail("its reader sent a material that cannot be");
    return static_cast<Enum>(value);
  }

  TextureRef reference(int textures) {
    TextureRef out;
    out.texture = number<int32_t>();
    if (out.texture < -1 || out.texture >= textures) fail("its reader sent no such texture");
    out.wrap_u = choice(Wrap::kClamp);
    out.wrap_v = choice(Wrap::kClamp);
    out.is_nearest = number<uint8_t>() != 0;
    for (double& element : out.texture_from_uv) {
      element = number_within(-kLargestTextureCoordinate, kLargestTextureCoordinate);
    }
    return out;
  }

  Material material(int textures) {
    Material out;
    for (double& channel : out.base) channel = number_within(0, 1);
    out.has_gloss = number<uint8_t>() != 0;
    out.metallic = number_within(0, 1);
    out.roughness = number_within(0, 1);
    out.is_unlit = number<uint8_t>() != 0;
    for (double& channel : out.emissive) channel = number_within(0, kLargestEmission);
    out.alpha_mode = choice(AlphaMode::kBlend);
    out.alpha_cutoff = number_within(0, 1e6);
    out.normal_scale = number_within(-1e3, 1e3);
    for (TextureRef* ref : out.textures()) {
      *ref = reference(textures);
    }
    return out;
  }

  Coat coat() {
    Coat out;
    for (Eigen::Vector2f& uv : out.uv) {
      uv = {number<float>(), number<float>()};
      if (!(uv.cwiseAbs().maxCoeff() <= kLargestTextureCoordinate)) {
        fail("a texture coordinate is no number, or beyond 1e6");
      }
    }
    for (Eigen::Vector4f& colour : out.colour) {
      for (float& channel : colour) channel = number<float>();
      if (!(colour.minCoeff() >= 0 && colour.maxCoeff() <= 1)) {
        fail("the colour of a vertex is not from 0 to 1");
      }
    }
    return out;
  }

  Eigen::Vector3d vector() {
    Eigen::Vector3d v;
    std::memcpy(v.data(), take(3 * sizeof(double)).data(), 3 * sizeof(double));
    return v;
  }

  std::string_view bytes_;
  const std::filesystem::path& file_;
};

}  // namespace

double luminance(double red, double green, double blue) {
  const double y = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
  return y > 0 ? std::min(y, 1.0) : 0.0;  // 0 also where a file has no number
}

void add_transformed(MeshSoup& soup, const SoupTriangle& triangle,
                     const Eigen::Matrix4d& file_from_mesh) {
  const Eigen::Matrix3d linear = file_from_mesh.topLeftCorner<3, 3>();
  const Eigen::Vector3d offset = file_from_mesh.topRightCorner<3, 1>();
  const double determinant = linear.determinant();
  // Normals go by the cofactor matrix, which is also right for singular and mirroring transforms.
  Eigen::Matrix3d cofactors;
  cofactors.col(0) = linear.col(1).cross(linear.col(2));
  cofactors.col(1) = linear.col(2).cross(linear.col(0));
  cofactors.col(2) = linear.col(0).cross(linear.col(1));
  if (determinant < 0) cofactors = -cofactors;

  SoupTriangle moved{.corner = {}, .normal = {}, .part = triangle.part};
  for (int i = 0; i < 3; ++i) {
    const int from = determinant < 0 ? 2 - i : i;
    moved.corner[i] = linear * triangle.corner[from] + offset;
    moved.coat.uv[i] = triangle.coat.uv[from];
    moved.coat.colour[i] = triangle.coat.colour[from];
    moved.normal[i] = (cofactors * triangle.normal[from]).stableNormalized();
    if (!moved.normal[i].allFinite()) moved.normal[i].setZero();
  }
  soup.triangles.push_back(moved);
}

void require_room(const MeshSoup& soup, size_t more, const std::filesystem::path& file) {
  if (more > kMaxTriangles - soup.triangles.size()) {
    throw InputError(fmt::format("{}: has more than {} triangles; simplify it first", file.string(),
                                 kMaxTriangles));
  }
  if (soup.parts.size() >= kMaxParts) {
    throw InputError(fmt::format("{}: has more than {} parts", file.string(), kMaxParts));
  }
}

std::string encode(const MeshSoup& soup) {
  std::string bytes(kMagic);
  bytes.reserve(kMagic.size() + 64 * soup.parts.size() + 16 +
                kBytesPerTriangle * soup.triangles.size() +
                (has_surface(soup) ? surface_bytes(soup) : 0));
  append(bytes, static_cast<uint64_t>(soup.parts.size()));
  append(bytes, static_cast<uint64_t>(soup.triangles.size()));
  for (const Part& part : soup.parts) {
    const std::string name = part.name.substr(0, kMaxNameBytes);
    append(bytes, static_cast<uint32_t>(name.size()));
    bytes += name;
    append(bytes, part.albedo);
  }
  for (const SoupTriangle& triangle : soup.triangles) {
    append(bytes, triangle.corner);
    append(bytes, triangle.normal);
    append(bytes, static_cast<uint32_t>(triangle.part));
  }
  if (has_surface(soup)) append_surface(bytes, soup);
  return bytes;
}

MeshSoup decode(std::string_view bytes, const std::filesystem::path& file) {
  return Decoder(bytes, file).decode();
}

}  // namespace sightline
