// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/model_file.h"

#include <bit>
#include <cstdint>
#include <exception>
#include <fstream>
#include <vector>

#include <CGAL/IO/PLY.h>
#include <CGAL/Simple_cartesian.h>
#include <fmt/format.h>

#include "eval/datasets/conventions.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"

namespace sightline {
namespace {

static_assert(std::endian::native == std::endian::little, "PLY is written as memory has it");

using Point = CGAL::Simple_cartesian<double>::Point_3;

[[noreturn]] void fail(const std::filesystem::path& file, const char* reason) {
  throw InputError(fmt::format("{}: {}", file.string(), reason));
}

template <typename Value>
void append(std::string& bytes, const Value& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

Eigen::Vector3f ply_vertex_mm(const Eigen::Vector3d& vertex_m) {
  return (kMillimetresPerMetre * vertex_m).cast<float>();
}

std::string ply_bytes(const Mesh& mesh) {
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment millimetres\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\nelement face {}\n"
      "property list uchar int vertex_indices\nend_header\n",
      mesh.vertices.size(), mesh.triangles.size());
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    const Eigen::Vector3f point = ply_vertex_mm(vertex);
    for (const float coordinate : {point.x(), point.y(), point.z()}) append(bytes, coordinate);
  }
  for (const Triangle& triangle : mesh.triangles) {
    append(bytes, uint8_t{3});
    for (const int vertex : triangle.vertex) append(bytes, int32_t{vertex});
  }
  return bytes;
}

Mesh read_ply_as_it_is(const std::filesystem::path& file) {
  std::ifstream stream = open_input_file(file, kMostModelBytes);
  std::vector<Point> points;
  std::vector<std::vector<size_t>> faces;
  bool is_read = false;
  try {
    is_read = CGAL::IO::read_PLY(stream, points, faces, CGAL::parameters::verbose(false));
  } catch (const std::exception&) {  // it is no promise of the reader that there is none
    is_read = false;
  }
  if (!is_read || points.empty()) fail(file, "cannot be read as a PLY mesh");
  Mesh mesh;
  mesh.parts.push_back({.name = file.stem().string()});
  for (const Point& point : points) {
    mesh.vertices.emplace_back(point.x(), point.y(), point.z());
    if (!mesh.vertices.back().allFinite()) fail(file, "a vertex is not a finite number");
  }
  for (const std::vector<size_t>& face : faces) {
    for (size_t i = 2; i < face.size(); ++i) {
      Triangle triangle;
      const size_t corners[] = {face[0], face[i - 1], face[i]};
      for (int corner = 0; corner < 3; ++corner) {
        if (corners[corner] >= points.size()) fail(file, "a face has a vertex that is not there");
        triangle.vertex[corner] = static_cast<int>(corners[corner]);
      }
      mesh.triangles.push_back(triangle);
    }
  }
  return mesh;
}

}  // namespace sightline
