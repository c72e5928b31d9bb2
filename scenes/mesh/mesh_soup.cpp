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

namespace sightline {
namespace {

constexpr std::string_view kMagic = "SLSOUP1\n";
constexpr size_t kMaxNameBytes = 256;
constexpr size_t kNumbersPerTriangle = 18;
constexpr size_t kBytesPerTriangle = kNumbersPerTriangle * sizeof(double) + sizeof(uint32_t);
constexpr double kLongestNormal = 1 + 1e-6;

template <typename T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// Invalid bytes dropped, control characters as underscores.
std::string printable(const std::string& name) {
  using nlohmann::json;
  const std::string quoted =
      json(name.substr(0, kMaxNameBytes)).dump(-1, ' ', false, json::error_handler_t::ignore);
  std::string text = json::parse(quoted).get<std::string>();
  for (char& c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 || code == 0x7f) c = '_';
  }
  return text;
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
    if (bytes_.size() != triangles * kBytesPerTriangle) fail("its reader sent a torn mesh");
    soup.triangles.reserve(triangles);
    for (uint64_t i = 0; i < triangles; ++i) soup.triangles.push_back(triangle(parts));
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
    Part out{.name = printable(std::string(take(length))), .albedo = number<double>()};
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

  Eigen::Vector3d vector() {
    Eigen::Vector3d v;
    std::memcpy(v.data(), take(3 * sizeof(double)).data(), 3 * sizeof(double));
    return v;
  }

  std::string_view bytes_;
  const std::filesystem::path& file_;
};

}  // namespace

bool is_inside(const std::filesystem::path& folder, const std::filesystem::path& path) {
  std::error_code error;
  const auto within = std::filesystem::weakly_canonical(folder, error);
  if (error) return false;
  const auto real = std::filesystem::weakly_canonical(path, error);
  if (error) return false;
  const auto [rest, unused] = std::mismatch(within.begin(), within.end(), real.begin(), real.end());
  return rest == within.end();
}

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
                kBytesPerTriangle * soup.triangles.size());
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
  return bytes;
}

MeshSoup decode(std::string_view bytes, const std::filesystem::path& file) {
  return Decoder(bytes, file).decode();
}

}  // namespace sightline
