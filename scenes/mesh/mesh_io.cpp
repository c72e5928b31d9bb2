// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/mesh_io.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "scenes/files/input_error.h"
#include "scenes/mesh/mesh_soup.h"
#include "scenes/mesh/mesh_text.h"
#include "scenes/mesh/point_table.h"

namespace sightline {
namespace {

constexpr double kDefaultCreaseAngleRad = 45 * std::numbers::pi / 180;
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << 30;
constexpr double kWeldFraction = 1e-6;  // of the mesh's size: float files carry 1e-7

Eigen::Vector3d axis_named(const std::string& name, const char* key,
                           const std::filesystem::path& file) {
  const std::string signed_name = name.size() == 1 ? "+" + name : name;
  const bool is_axis = signed_name.size() == 2 && (name[0] == '-' || signed_name[0] == '+') &&
                       signed_name[1] >= 'x' && signed_name[1] <= 'z';
  if (!is_axis) {
    throw InputError(fmt::format("{}: {} = \"{}\" is no axis (allowed: +x, -x, +y, -y, +z, -z)",
                                 file.string(), key, name));
  }
  return (name[0] == '-' ? -1.0 : 1.0) * Eigen::Vector3d::Unit(signed_name[1] - 'x');
}

Eigen::Matrix3d target_from_file_rotation(const MeshFrame& frame,
                                          const std::filesystem::path& file) {
  const Eigen::Vector3d forward = axis_named(frame.forward, "forward", file);
  const Eigen::Vector3d up = axis_named(frame.up, "up", file);
  if (forward.dot(up) != 0) {
    throw InputError(fmt::format("{}: forward = \"{}\" and up = \"{}\" must be different axes",
                                 file.string(), frame.forward, frame.up));
  }
  if (!(frame.unit_m >= kSmallestUnitM && frame.unit_m <= kLargestUnitM)) {
    throw InputError(fmt::format("{}: unit_m = {} must be from {} to {}", file.string(),
                                 frame.unit_m, kSmallestUnitM, kLargestUnitM));
  }
  Eigen::Matrix3d rotation;
  rotation.row(0) = forward;
  rotation.row(1) = forward.cross(up);  // starboard
  rotation.row(2) = -up;
  return rotation;
}

double size_of(const MeshSoup& soup) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : soup.points) box.extend(point);
  return box.diagonal().norm();
}

// A triangle whose height over its longest side is within the welding tolerance has no area to
// speak of and no normal to trust.
bool is_degenerate(const Mesh& mesh, const std::array<int, 3>& v, double tolerance_m) {
  if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) return true;
  const Eigen::Vector3d a = mesh.vertices[v[1]] - mesh.vertices[v[0]];
  const Eigen::Vector3d b = mesh.vertices[v[2]] - mesh.vertices[v[0]];
  const double longest = std::max({a.norm(), b.norm(), (b - a).norm()});
  return a.cross(b).norm() <= tolerance_m * longest;
}

// Keeps the normals that the file has, on the side where the triangle is counter-clockwise: there a
// soup's normals and windings may disagree, and both sides are drawn.
void turn_normals_outward(Mesh& mesh) {
  for (Triangle& triangle : mesh.triangles) {
    const Eigen::Vector3d outward = face_normal(mesh, triangle);
    for (Eigen::Vector3d& normal : triangle.normal) {
      if (normal.dot(outward) < 0) normal = -normal;
    }
  }
}

// The triangles that have been kept, each once, whichever corner it begins with. Front and back of
// a sheet are two where each has one side. Neighbours, which
// files tell one after the other, lie near each other in memory too: a triangle's slot goes by the
// sum of its corners and, that many alike do not share one, a little by chance.
class KeptTriangles {
 public:
  KeptTriangles(size_t most, size_t vertices, std::vector<bool> one_sided)
      : one_sided_(std::move(one_sided)),
        slots_(std::bit_ceil(most + 1), -1),
        slots_a_step_(std::max<uint64_t>(1, slots_.size() / (3 * vertices + 1))) {
    before_.reserve(most);
  }

  // False when the last of the list has the corners of one that was added before.
  bool add_last(const std::vector<Triangle>& triangles) {
    const std::array<int, 3> corners = sorted(triangles.back());
    int& slot = slots_[slot_of(corners)];
    for (int at = slot; at >= 0; at = before_[at]) {
      if (sorted(triangles[at]) != corners) continue;
      if (!are_front_and_back(triangles[at], triangles.back())) return false;
    }
    before_.push_back(slot);
    slot = static_cast<int>(triangles.size()) - 1;
    return true;
  }

 private:
  // Of two triangles with the same corners.
  bool are_front_and_back(const Triangle& one, const Triangle& other) const {
    if (one_sided_.empty() || !one_sided_[one.part] || !one_sided_[other.part]) return false;
    const auto& a = one.vertex;
    const auto& b = other.vertex;
    const auto begin = std::find(b.begin(), b.end(), a[0]);
    return *(begin + 1 == b.end() ? b.begin() : begin + 1) != a[1];
  }

  static std::array<int, 3> sorted(const Triangle& triangle) {
    std::array<int, 3> corners = triangle.vertex;
    std::sort(corners.begin(), corners.end());
    return corners;
  }

  size_t slot_of(const std::array<int, 3>& corners) const {
    constexpr uint64_t kStepsByChance = 1 << 16;
    uint64_t sum = 0;
    uint64_t hash = 0;
    for (const int corner : corners) {
      sum += static_cast<uint64_t>(corner);
      hash = (hash ^ static_cast<uint64_t>(corner)) * 0x9e3779b97f4a7c15ULL;
      hash ^= hash >> 32;
    }
    const uint64_t slot = slots_a_step_ * sum + hash % (slots_a_step_ * kStepsByChance);
    return slot & (slots_.size() - 1);
  }

  std::vector<bool> one_sided_;  // by part
  std::vector<int> slots_;       // the last triangle of each, or -1; a power of two of them
  std::vector<int> before_;      // of every triangle the one before it in its slot, or -1
  uint64_t slots_a_step_;        // of the sum
};

// The shape of a soup, without what is no triangle.
LoadedMesh weld(MeshSoup& soup) {
  LoadedMesh loaded;
  Mesh& mesh = loaded.mesh;
  CleaningSummary& cleaning = loaded.cleaning;
  mesh.parts = std::move(soup.parts);
  const double tolerance_m = kWeldFraction * size_of(soup);
  Welder welder(tolerance_m);
  std::vector<int> vertex_of;
  vertex_of.reserve(soup.points.size());
  for (const Eigen::Vector3d& point : soup.points) vertex_of.push_back(welder.index_of(point));
  soup.points = {};  // a large mesh has no memory to spare
  mesh.vertices = std::move(welder.vertices);
  cleaning.welded_vertices = static_cast<int>(3 * soup.triangles.size() - mesh.vertices.size());

  KeptTriangles kept(soup.triangles.size(), mesh.vertices.size(), one_sided_parts(mesh));
  mesh.triangles.reserve(soup.triangles.size());
  for (size_t i = 0; i < soup.triangles.size(); ++i) {
    const SoupFace& face = soup.triangles[i];
    const auto& [a, b, c] = face.point;
    const std::array<int, 3> corners = {vertex_of[a], vertex_of[b], vertex_of[c]};
    if (is_degenerate(mesh, corners, tolerance_m)) {
      ++cleaning.degenerate_triangles;
      continue;
    }
    mesh.triangles.push_back(
        {corners, face.part, i < soup.normals.size() ? soup.normals[i] : no_normals()});
    const bool is_flat =
        static_cast<size_t>(face.part) < soup.is_flat.size() && soup.is_flat[face.part] != 0;
    if (is_flat) mesh.triangles.back().normal.fill(face_normal(mesh, mesh.triangles.back()));
    if (!kept.add_last(mesh.triangles)) {
      ++cleaning.duplicate_triangles;
      mesh.triangles.pop_back();
      continue;
    }
    if (soup.has_coats) mesh.coats.push_back(i < soup.coats.size() ? soup.coats[i] : Coat{});
  }
  if (!soup.normals.empty()) turn_normals_outward(mesh);
  add_missing_normals(mesh, kDefaultCreaseAngleRad);
  return loaded;
}

void transform(MeshSoup& soup, const Eigen::Matrix3d& rotation, double unit_m) {
  for (Eigen::Vector3d& point : soup.points) point = unit_m * (rotation * point);
  for (auto& corners : soup.normals) {
    for (Eigen::Vector3d& normal : corners) normal = rotation * normal;
  }
}

constexpr double kSmallestSizeFraction = 1e-9;  // of the greatest coordinate

void require_size(const MeshSoup& soup, const std::filesystem::path& file) {
  if (soup.triangles.empty()) {
    throw InputError(fmt::format("{}: holds no triangles", file.string()));
  }
  double largest = 0;
  for (const Eigen::Vector3d& point : soup.points) {
    largest = std::max(largest, point.cwiseAbs().maxCoeff());
  }
  const double size = size_of(soup);
  if (!(size > kSmallestSizeFraction * largest)) {
    throw InputError(fmt::format("{}: all its triangles are degenerate (its size is {:.3g})",
                                 file.string(), size));
  }
}

bool is_gltf(const std::filesystem::path& file) {
  const std::string extension = lower_extension(file);
  return extension == ".glb" || extension == ".gltf";
}

// Files that hold a mesh only for people are named for what they are.
void require_mesh_format(const std::filesystem::path& file) {
  std::array<char, 4096> bytes{};
  std::ifstream stream(file, std::ios::binary);
  stream.read(bytes.data(), bytes.size());
  const std::string what = why_no_mesh(file, {bytes.data(), static_cast<size_t>(stream.gcount())});
  if (!what.empty()) throw InputError(fmt::format("{}: is {}", file.string(), what));
}

// Returns its size. What a path names is known before it is opened: a pipe would wait for ever.
std::uintmax_t require_file(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    const bool exists = std::filesystem::exists(file, error);
    throw InputError(fmt::format("{}: {}", file.string(),
                                 exists ? "is not a regular file" : "no such mesh file"));
  }
  const std::uintmax_t bytes = std::filesystem::file_size(file, error);
  if (error || bytes == 0) throw InputError(fmt::format("{}: is empty", file.string()));
  if (bytes > kMaxFileBytes) {
    throw InputError(fmt::format("{}: has {} MiB, must have at most {}", file.string(), bytes >> 20,
                                 kMaxFileBytes >> 20));
  }
  return bytes;
}

}  // namespace

double unit_named(const std::string& unit) {
  static const std::map<std::string, double> kUnits = {
      {"km", 1000}, {"m", 1}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}};
  if (const auto found = kUnits.find(unit); found != kUnits.end()) return found->second;
  double metres = 0;
  const auto [end, error] = std::from_chars(unit.data(), unit.data() + unit.size(), metres);
  if (error != std::errc() || end != unit.data() + unit.size() || !std::isfinite(metres)) {
    throw InputError(fmt::format(
        "unit \"{}\" is not known (allowed: m, cm, mm, km, in, ft or metres in one as a number)",
        unit));
  }
  return metres;
}

LoadedMesh clean(MeshSoup soup, const MeshFrame& frame, const std::filesystem::path& file) {
  const Eigen::Matrix3d target_from_file = target_from_file_rotation(frame, file);
  require_size(soup, file);
  // A unit that is given stands in the place of what the file says; the metre is no word of anyone.
  transform(soup, target_from_file, frame.unit_m == 1 ? soup.unit_m : frame.unit_m);
  LoadedMesh loaded = weld(soup);
  for (Texture& texture : soup.textures) {
    loaded.mesh.textures.push_back(std::make_shared<const Texture>(std::move(texture)));
  }
  loaded.mesh.lost_textures = std::move(soup.lost_textures);
  loaded.mesh.notes = std::move(soup.notes);
  if (loaded.mesh.triangles.empty()) {
    throw InputError(fmt::format("{}: all its triangles are degenerate", file.string()));
  }
  loaded.target_from_file = target_from_file;
  return loaded;
}

LoadedMesh read_mesh(const std::filesystem::path& file, const MeshFrame& frame) {
  target_from_file_rotation(frame, file);  // a wrong frame is known before the file is read
  const ReaderLimits limits = limits_for(require_file(file));
  require_mesh_format(file);
  return clean(read_in_child(file, is_gltf(file) ? read_gltf : read_with_assimp, limits), frame,
               file);
}

}  // namespace sightline
