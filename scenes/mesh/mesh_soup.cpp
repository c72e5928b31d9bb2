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

constexpr std::string_view kMagic = "SLSOUP2\n";
constexpr size_t kMaxNameBytes = 256;
constexpr size_t kPieceBytes = size_t{1} << 18;  // what is handed on at once
constexpr size_t kBlockElements = 4096;          // what is taken into memory at once
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
  append(bytes, static_cast<uint8_t>(material.is_two_sided));
  append(bytes, material.normal_scale);
  append(bytes, material.occlusion_strength);
  append(bytes, material.base_texture);
  append(bytes, material.gloss_texture);
  append(bytes, material.emissive_texture);
  append(bytes, material.normal_texture);
  append(bytes, material.occlusion_texture);
}

bool has_surface(const MeshSoup& soup) {
  return soup.has_coats || !soup.textures.empty() || !soup.lost_textures.empty() ||
         !soup.notes.empty() || soup.unit_m != 1 ||
         std::any_of(soup.parts.begin(), soup.parts.end(),
                     [](const Part& part) { return part.material.has_value(); });
}

void append(std::string& bytes, const Coat& coat) {
  for (const Eigen::Vector2f& uv : coat.uv) append(bytes, std::array{uv.x(), uv.y()});
  for (const Eigen::Vector4f& c : coat.colour) append(bytes, std::array{c[0], c[1], c[2], c[3]});
}

void append_part(std::string& bytes, const Part& part, bool is_flat) {
  const std::string name = part.name.substr(0, kMaxNameBytes);
  append(bytes, static_cast<uint32_t>(name.size()));
  bytes += name;
  append(bytes, part.albedo);
  append(bytes, static_cast<uint8_t>(is_flat));
}

// Triangles and points cross as they lie in memory: the other process is this very program.

template <typename T>
std::string_view bytes_of(const std::vector<T>& elements) {
  return {reinterpret_cast<const char*>(elements.data()), elements.size() * sizeof(T)};
}

// Hands on what has been gathered in pieces.
class Pieces {
 public:
  explicit Pieces(const std::function<void(std::string_view)>& write) : write_(write) {}

  std::string& gathered() { return gathered_; }
  void pass_when_full() {
    if (gathered_.size() >= kPieceBytes) pass();
  }
  void pass() {
    write_(gathered_);
    gathered_.clear();
  }

 private:
  const std::function<void(std::string_view)>& write_;
  std::string gathered_;
};

void append_surface(Pieces& pieces, const MeshSoup& soup) {
  std::string& bytes = pieces.gathered();
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
    pieces.pass_when_full();
  }
  for (const std::string& sentence : soup.lost_textures) append_text(bytes, sentence);
  for (const std::string& note : soup.notes) append_text(bytes, note);
  for (const Part& part : soup.parts) {
    append(bytes, static_cast<uint8_t>(part.material.has_value()));
    if (part.material) append(bytes, *part.material);
  }
  if (!soup.has_coats) return;
  for (size_t i = 0; i < soup.triangles.size(); ++i) {
    append(bytes, i < soup.coats.size() ? soup.coats[i] : Coat{});
    pieces.pass_when_full();
  }
}

class Decoder {
 public:
  Decoder(const ByteSource& source, const std::filesystem::path& file)
      : source_(source), file_(file) {}

  MeshSoup decode() {
    if (text_of(kMagic.size()) != kMagic) fail("its reader sent no mesh");
    const auto parts = number<uint64_t>();
    const auto triangles = number<uint64_t>();
    const auto points = number<uint64_t>();
    const auto normals = number<uint64_t>();
    const bool is_too_large = parts > kMaxParts || triangles > kMaxTriangles ||
                              points > 3 * kMaxTriangles || normals > triangles;
    if (is_too_large) fail("its reader sent too large a mesh");
    MeshSoup soup;
    for (uint64_t i = 0; i < parts; ++i) {
      soup.parts.push_back(part());
      soup.is_flat.push_back(number<uint8_t>());
    }
    read_all(points, soup.points, [this](const Eigen::Vector3d& x) { check_point(x); });
    read_all(triangles, soup.triangles, [&](const SoupFace& face) {
      check_face(face, static_cast<int>(points), static_cast<int>(parts));
    });
    read_all(normals, soup.normals, [this](const auto& corners) { check_normals(corners); });
    if (has_more()) read_surface(soup);
    if (has_more()) fail("its reader sent a torn mesh");
    return soup;
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(fmt::format("{}: {}", file_.string(), reason));
  }

  // Takes the next bytes, whether they have been fetched already or not.
  void take(char* to, size_t count) {
    while (count > 0) {
      if (!has_more()) fail("its reader sent a torn mesh");
      const size_t size = std::min(count, fetched_.size() - at_);
      std::memcpy(to, fetched_.data() + at_, size);
      at_ += size;
      to += size;
      count -= size;
    }
  }

  bool has_more() {
    if (at_ < fetched_.size()) return true;
    fetched_.resize(kPieceBytes);
    fetched_.resize(source_(fetched_.data(), fetched_.size()));
    at_ = 0;
    return !fetched_.empty();
  }

  std::string text_of(size_t count) {
    std::string text(count, '\0');
    take(text.data(), count);
    return text;
  }

  template <typename T>
  T number() {
    T value;
    take(reinterpret_cast<char*>(&value), sizeof value);
    return value;
  }

  // A count may lie: memory is filled as elements come.
  template <typename T, typename Check>
  void read_all(uint64_t count, std::vector<T>& elements, const Check& check) {
    elements.reserve(count);
    while (elements.size() < count) {
      const size_t begin = elements.size();
      elements.resize(std::min<size_t>(count, begin + kBlockElements));
      take(reinterpret_cast<char*>(elements.data() + begin), (elements.size() - begin) * sizeof(T));
      for (size_t i = begin; i < elements.size(); ++i) check(elements[i]);
    }
  }

  Part part() {
    const auto length = number<uint32_t>();
    if (length > kMaxNameBytes) fail("its reader sent a part with too long a name");
    Part out;
    out.name = printable(text_of(length), kMaxNameBytes);
    out.albedo = number<double>();
    if (!(out.albedo >= 0 && out.albedo <= 1)) {
      fail(fmt::format("part \"{}\" has albedo {}, must be from 0 to 1", out.name, out.albedo));
    }
    return out;
  }

  void check_point(const Eigen::Vector3d& point) const {
    if (!point.allFinite()) fail("a vertex is not a finite number");
    const double largest = point.cwiseAbs().maxCoeff();
    if (largest <= kLargestCoordinate) return;
    fail(
        fmt::format("a coordinate is {:.3g}, must be at most {:.0e}", largest, kLargestCoordinate));
  }

  void check_face(const SoupFace& face, int points, int parts) const {
    for (const int point : face.point) {
      if (point < 0 || point >= points) fail("a triangle has a corner that is nowhere");
    }
    if (face.part < 0 || face.part >= parts) fail("a triangle belongs to no part");
  }

  void check_normals(const std::array<Eigen::Vector3d, 3>& corners) const {
    for (const Eigen::Vector3d& normal : corners) {
      if (!(normal.norm() <= kLongestNormal)) fail("a normal is no unit vector");
    }
  }

  void read_surface(MeshSoup& soup) {
    if (text_of(kSurfaceMagic.size()) != kSurfaceMagic) fail("its reader sent a torn mesh");
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
    soup.coats.reserve(soup.triangles.size());
    for (size_t i = 0; i < soup.triangles.size(); ++i) soup.coats.push_back(coat());
  }

  std::string text() {
    const auto length = number<uint32_t>();
    if (length > kMaxSentenceBytes) fail("its reader sent too long a text");
    return text_of(length);
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
    out.rgba.resize(size_t{4} * out.width * out.height);
    take(reinterpret_cast<char*>(out.rgba.data()), out.rgba.size());
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
    out.is_two_sided = number<uint8_t>() != 0;
    out.normal_scale = number_within(-1e3, 1e3);
    out.occlusion_strength = number_within(0, 1);
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

  const ByteSource& source_;
  const std::filesystem::path& file_;
  std::string fetched_;  // of the source, up to here:
  size_t at_ = 0;
};

}  // namespace

double luminance(double red, double green, double blue) {
  const double y =
      kLuminanceShares[0] * red + kLuminanceShares[1] * green + kLuminanceShares[2] * blue;
  return y > 0 ? std::min(y, 1.0) : 0.0;  // 0 also where a file has no number
}

std::array<Eigen::Vector3d, 3> no_normals() {
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  return {none, none, none};
}

SoupTransform::SoupTransform(const Eigen::Matrix4d& file_from_mesh, size_t triangles,
                             size_t vertices)
    : numbers_(vertices < 3 * triangles ? vertices : 0, -1),
      linear_(file_from_mesh.topLeftCorner<3, 3>()),
      offset_(file_from_mesh.topRightCorner<3, 1>()),
      is_mirroring_(linear_.determinant() < 0) {
  cofactors_.col(0) = linear_.col(1).cross(linear_.col(2));
  cofactors_.col(1) = linear_.col(2).cross(linear_.col(0));
  cofactors_.col(2) = linear_.col(0).cross(linear_.col(1));
  if (is_mirroring_) cofactors_ = -cofactors_;
}

int SoupTransform::number_of(const SoupTriangle& triangle, int corner, MeshSoup& soup) {
  const int vertex = triangle.vertex[corner];
  const bool is_kept = vertex >= 0 && static_cast<size_t>(vertex) < numbers_.size();
  if (is_kept && numbers_[vertex] >= 0) return numbers_[vertex];
  const int number =
      soup.numbers.index_of(linear_ * triangle.corner[corner] + offset_, soup.points);
  if (is_kept) numbers_[vertex] = number;
  return number;
}

void SoupTransform::add(MeshSoup& soup, const SoupTriangle& triangle) {
  SoupFace face{.part = triangle.part};
  std::array<Eigen::Vector3d, 3> normal;
  Coat coat;
  bool has_normal = false;
  for (int i = 0; i < 3; ++i) {
    const int from = is_mirroring_ ? 2 - i : i;
    face.point[i] = number_of(triangle, from, soup);
    coat.uv[i] = triangle.coat.uv[from];
    coat.colour[i] = triangle.coat.colour[from];
    normal[i].setZero();
    if (triangle.normal[from].isZero(0)) continue;
    normal[i] = (cofactors_ * triangle.normal[from]).stableNormalized();
    if (!normal[i].allFinite()) normal[i].setZero();
    has_normal = has_normal || !normal[i].isZero(0);
  }
  if (has_normal) {
    soup.normals.resize(soup.triangles.size(), no_normals());
    soup.normals.push_back(normal);
  }
  if (soup.has_coats) {
    soup.coats.resize(soup.triangles.size());
    soup.coats.push_back(coat);
  }
  soup.triangles.push_back(face);
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

void encode(const MeshSoup& soup, const std::function<void(std::string_view)>& write) {
  Pieces pieces(write);
  std::string& bytes = pieces.gathered();
  bytes += kMagic;
  append(bytes, static_cast<uint64_t>(soup.parts.size()));
  append(bytes, static_cast<uint64_t>(soup.triangles.size()));
  append(bytes, static_cast<uint64_t>(soup.points.size()));
  append(bytes, static_cast<uint64_t>(soup.normals.size()));
  for (size_t i = 0; i < soup.parts.size(); ++i) {
    append_part(bytes, soup.parts[i], i < soup.is_flat.size() && soup.is_flat[i] != 0);
  }
  pieces.pass();
  write(bytes_of(soup.points));
  write(bytes_of(soup.triangles));
  write(bytes_of(soup.normals));
  if (has_surface(soup)) append_surface(pieces, soup);
  pieces.pass();
}

std::string encode(const MeshSoup& soup) {
  std::string bytes;
  encode(soup, [&](std::string_view piece) { bytes += piece; });
  return bytes;
}

MeshSoup decode(const ByteSource& bytes, const std::filesystem::path& file) {
  return Decoder(bytes, file).decode();
}

MeshSoup decode(std::string_view bytes, const std::filesystem::path& file) {
  const auto next = [&](char* to, size_t most) {
    const size_t size = bytes.copy(to, most);
    bytes.remove_prefix(size);
    return size;
  };
  return decode(ByteSource(next), file);
}

}  // namespace sightline
