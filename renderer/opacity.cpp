// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/opacity.h"

#include <algorithm>

#include "renderer/truth.h"

namespace sightline {

float opacity(AlphaMode mode, double cutoff, float alpha) {
  switch (mode) {
    case AlphaMode::kMask:
      return static_cast<double>(alpha) >= cutoff ? 1.0f : 0.0f;
    case AlphaMode::kBlend:
      return std::max(0.0f, alpha);
    case AlphaMode::kOpaque:
      break;
  }
  return 1;
}

SurfaceOpacity::SurfaceOpacity(const std::vector<PlacedBody>& bodies, bool draws_textures,
                               TextureCache& textures)
    : bodies_(bodies), draws_textures_(draws_textures), textures_(textures) {
  for (const PlacedBody& body : bodies) hits_.emplace_back(body);
}

float SurfaceOpacity::at(uint32_t id, const Eigen::Vector2d& normalised) {
  const size_t b = body_of(bodies_, id);
  const Mesh& mesh = *bodies_[b].mesh;
  const int triangle = static_cast<int>(id - bodies_[b].first_id);
  const std::optional<Material>& material = mesh.parts[mesh.triangles[triangle].part].material;
  if (!material || material->alpha_mode == AlphaMode::kOpaque) return 1;
  return opacity(material->alpha_mode, material->alpha_cutoff,
                 alpha_at(mesh, *material, hits_[b].on(triangle, normalised)));
}

float SurfaceOpacity::alpha_at(const Mesh& mesh, const Material& material,
                               const SurfacePoint& point) {
  auto alpha = static_cast<float>(material.base[3]);
  if (!draws_textures_ || mesh.coats.empty()) return alpha;
  const Coat& coat = mesh.coats[point.triangle];
  Eigen::Vector2f uv = Eigen::Vector2f::Zero();
  float carried = 0;
  for (int corner = 0; corner < 3; ++corner) {
    const auto weight = static_cast<float>(point.weights[corner]);
    uv += weight * coat.uv[corner];
    carried += weight * coat.colour[corner][3];
  }
  alpha *= carried;
  const TextureRef& ref = material.base_texture;
  if (!ref.is_there()) return alpha;
  return alpha * textures_.pyramid(mesh.textures[ref.texture], true).at(ref, uv.x(), uv.y(), 0)[3];
}

}  // namespace sightline
