// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/box_uv.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "scenes/mesh/mesh_soup.h"

namespace sightline {
namespace {

double uv_area(const Coat& coat) {
  const Eigen::Vector2f a = coat.uv[1] - coat.uv[0], b = coat.uv[2] - coat.uv[0];
  return std::abs(a.x() * b.y() - a.y() * b.x());
}

// From outside, u grows to the right where v grows downwards, so that no picture is mirrored.
void set_box_uv(const Mesh& mesh, const Triangle& triangle, Coat& coat) {
  const Eigen::Vector3d normal = face_normal(mesh, triangle);
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  const double sign = normal[axis] < 0 ? 1 : -1;
  for (size_t corner = 0; corner < 3; ++corner) {
    const Eigen::Vector3d& at = mesh.vertices[static_cast<size_t>(triangle.vertex[corner])];
    coat.uv[corner] = Eigen::Vector2d(sign * at[(axis + 1) % 3], at[(axis + 2) % 3]).cast<float>();
  }
}

// Where all corners of a part lie in its textures; nothing where they are not at one point.
std::optional<Eigen::Vector2f> uv_point(const Mesh& mesh, size_t part) {
  std::optional<Eigen::Vector2f> point;
  for (size_t t = 0; t < mesh.coats.size(); ++t) {
    if (static_cast<size_t>(mesh.triangles[t].part) != part) continue;
    for (const Eigen::Vector2f& uv : mesh.coats[t].uv) {
      if (point && *point != uv) return std::nullopt;
      point = uv;
    }
  }
  return point;
}

int texel_of(double place, Wrap wrap, int count) {
  const double period = std::floor(place);
  double within = wrap == Wrap::kClamp ? place : place - period;
  if (wrap == Wrap::kMirror && std::fmod(period, 2) != 0) within = 1 - within;
  // The last where it is not a number.
  return static_cast<int>(std::max(0.0, std::min(count - 1.0, within * count)));
}

// The texel at a point, as a picture: levels of a larger one would blend it with its neighbours.
Texture texel_at(const Texture& picture, const TextureRef& ref, const Eigen::Vector2f& uv) {
  const auto& m = ref.texture_from_uv;
  const int x = texel_of(m[0] * uv.x() + m[1] * uv.y() + m[2], ref.wrap_u, picture.width);
  const int y = texel_of(m[3] * uv.x() + m[4] * uv.y() + m[5], ref.wrap_v, picture.height);
  const auto first = picture.rgba.begin() + 4 * (std::ptrdiff_t{y} * picture.width + x);
  return {picture.name, 1, 1, picture.is_srgb, {first, first + 4}};
}

void keep_point(const std::optional<Eigen::Vector2f>& point, Material& material, Mesh& mesh) {
  material.normal_texture = {};  // a point has no directions to tilt along
  if (!point && material.emissive_texture.is_there()) material.emissive.fill(0);
  for (TextureRef* ref : material.textures()) {
    if (!ref->is_there()) continue;
    if (!point) {
      *ref = {};
      continue;
    }
    const Texture& picture = *mesh.textures[static_cast<size_t>(ref->texture)];
    mesh.textures.push_back(std::make_shared<Texture>(texel_at(picture, *ref, *point)));
    ref->texture = static_cast<int>(mesh.textures.size()) - 1;
  }
}

}  // namespace

std::vector<bool> parts_without_uv(const Mesh& mesh) {
  std::vector<bool> is_without(mesh.parts.size(), true);
  for (size_t t = 0; t < mesh.coats.size(); ++t) {
    if (uv_area(mesh.coats[t]) > 0) is_without[static_cast<size_t>(mesh.triangles[t].part)] = false;
  }
  return is_without;
}

void lay_box_uv(const std::vector<bool>& is_boxed, Mesh& mesh) {
  for (size_t i = 0; i < mesh.parts.size(); ++i) {
    std::optional<Material>& material = mesh.parts[i].material;
    if (is_boxed[i] && material) keep_point(uv_point(mesh, i), *material, mesh);
  }
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& triangle = mesh.triangles[t];
    if (is_boxed[static_cast<size_t>(triangle.part)]) set_box_uv(mesh, triangle, mesh.coats[t]);
  }
}

}  // namespace sightline
