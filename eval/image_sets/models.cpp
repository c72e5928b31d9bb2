// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/image_sets/models.h"

#include <bit>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "scenes/mesh/diameter.h"

namespace sightline {
namespace {

static_assert(std::endian::native == std::endian::little, "PLY is written as memory has it");

Eigen::Vector3f in_mm(const Eigen::Vector3d& vertex_m) {
  return (1000 * vertex_m).cast<float>();
}

template <typename Value>
void append(std::string& bytes, const Value& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

std::string ply_bytes(const Mesh& mesh) {
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment millimetres\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\nelement face {}\n"
      "property list uchar int vertex_indices\nend_header\n",
      mesh.vertices.size(), mesh.triangles.size());
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    const Eigen::Vector3f point = in_mm(vertex);
    for (const float coordinate : {point.x(), point.y(), point.z()}) append(bytes, coordinate);
  }
  for (const Triangle& triangle : mesh.triangles) {
    append(bytes, uint8_t{3});
    for (const int vertex : triangle.vertex) append(bytes, int32_t{vertex});
  }
  return bytes;
}

Json model_info(const Mesh& mesh) {
  std::vector<Eigen::Vector3d> points;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    points.emplace_back(in_mm(vertex).cast<double>());
    box.extend(points.back());
  }
  const Eigen::Vector3d size = box.sizes();
  return {{"diameter", diameter(std::move(points))},
          {"min_x", box.min().x()},
          {"min_y", box.min().y()},
          {"min_z", box.min().z()},
          {"size_x", size.x()},
          {"size_y", size.y()},
          {"size_z", size.z()}};
}

}  // namespace sightline
