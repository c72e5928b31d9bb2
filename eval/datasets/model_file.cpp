// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/model_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "eval/datasets/conventions.h"
#include "scenes/mesh/textures.h"

namespace sightline {
namespace {

static_assert(std::endian::native == std::endian::little, "PLY is written as memory has it");

template <typename Value>
void append(std::string& bytes, const Value& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void append_vector(std::string& bytes, const Eigen::Vector3f& v) {
  for (const float coordinate : v) append(bytes, coordinate);
}

std::string ply_head(const Mesh& mesh, std::string_view more_of_vertices) {
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment millimetres\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n{}element face {}\n"
      "property list uchar int vertex_indices\nend_header\n",
      mesh.vertices.size(), more_of_vertices, mesh.triangles.size());
}

void append_faces(std::string& bytes, const Mesh& mesh) {
  for (const Triangle& triangle : mesh.triangles) {
    append(bytes, uint8_t{3});
    for (const int vertex : triangle.vertex) append(bytes, int32_t{vertex});
  }
}

// Sums over the corners of triangles that meet at a vertex.
struct VertexLook {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Array3d colour = Eigen::Array3d::Zero();  // linear
  int corners = 0;
};

// Where a coordinate that may lie beyond the texture's borders falls, from 0 to 1.
double within(double at, Wrap wrap) {
  switch (wrap) {
    case Wrap::kClamp:
      return std::clamp(at, 0.0, 1.0);
    case Wrap::kMirror: {
      const double from_even = at - 2 * std::floor(at / 2);
      return from_even <= 1 ? from_even : 2 - from_even;
    }
    case Wrap::kRepeat:
      break;
  }
  return at - std::floor(at);
}

// The texel at texture coordinates, linear.
Eigen::Array3d texel_at(const Texture& texture, const TextureRef& ref, const Eigen::Vector2f& uv) {
  const auto& m = ref.texture_from_uv;
  const auto place = [](double at, Wrap wrap, int size) {
    return static_cast<size_t>(std::clamp(within(at, wrap) * size, 0.0, size - 1.0));
  };
  const size_t column = place(m[0] * uv.x() + m[1] * uv.y() + m[2], ref.wrap_u, texture.width);
  const size_t row = place(m[3] * uv.x() + m[4] * uv.y() + m[5], ref.wrap_v, texture.height);
  Eigen::Array3d light;
  for (size_t c = 0; c < 3; ++c) {
    const double code =
        texture.rgba[4 * (row * static_cast<size_t>(texture.width) + column) + c] / 255.0;
    light[static_cast<Eigen::Index>(c)] = texture.is_srgb ? linear_from_srgb(code) : code;
  }
  return light;
}

Eigen::Array3d colour_of(const Mesh& mesh, size_t triangle, size_t corner) {
  const Part& part = mesh.parts[static_cast<size_t>(mesh.triangles[triangle].part)];
  if (!part.material) return Eigen::Array3d::Constant(part.albedo);
  const Material& material = *part.material;
  Eigen::Array3d colour(material.base[0], material.base[1], material.base[2]);
  if (mesh.coats.empty()) return colour;
  const Coat& coat = mesh.coats[triangle];
  colour *= coat.colour[corner].head<3>().cast<double>().array();
  const TextureRef& ref = material.base_texture;
  if (!ref.is_there()) return colour;
  return colour * texel_at(*mesh.textures[static_cast<size_t>(ref.texture)], ref, coat.uv[corner]);
}

std::vector<VertexLook> looks_of(const Mesh& mesh) {
  std::vector<VertexLook> looks(mesh.vertices.size());
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (size_t corner = 0; corner < 3; ++corner) {
      VertexLook& look = looks[static_cast<size_t>(mesh.triangles[t].vertex[corner])];
      look.normal += mesh.triangles[t].normal[corner];
      look.colour += colour_of(mesh, t, corner);
      ++look.corners;
    }
  }
  return looks;
}

uint8_t srgb_code(double linear) {
  return static_cast<uint8_t>(std::lround(255 * srgb_from_linear(std::clamp(linear, 0.0, 1.0))));
}

}  // namespace

Eigen::Vector3f ply_vertex_mm(const Eigen::Vector3d& vertex_m) {
  return (kMillimetresPerMetre * vertex_m).cast<float>();
}

std::string ply_bytes(const Mesh& mesh) {
  std::string bytes = ply_head(mesh, "");
  for (const Eigen::Vector3d& vertex : mesh.vertices) append_vector(bytes, ply_vertex_mm(vertex));
  append_faces(bytes, mesh);
  return bytes;
}

std::string coloured_ply_bytes(const Mesh& mesh) {
  std::string bytes = ply_head(mesh,
                               "property float nx\nproperty float ny\nproperty float nz\n"
                               "property uchar red\nproperty uchar green\nproperty uchar blue\n");
  const std::vector<VertexLook> looks = looks_of(mesh);
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    append_vector(bytes, ply_vertex_mm(mesh.vertices[i]));
    append_vector(bytes, looks[i].normal.stableNormalized().cast<float>());
    const double corners = std::max(1, looks[i].corners);
    for (const double channel : looks[i].colour) append(bytes, srgb_code(channel / corners));
  }
  append_faces(bytes, mesh);
  return bytes;
}

}  // namespace sightline
