// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/shadow_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include <Eigen/Geometry>

#include "renderer/visibility.h"

namespace sightline {

Eigen::Matrix3d light_axes(const Eigen::Vector3d& to_light) {
  Eigen::Matrix3d axes;
  const Eigen::Vector3d across = to_light.unitOrthogonal();
  axes << across.transpose(), to_light.cross(across).transpose(), to_light.transpose();
  return axes;
}

ShadowMap::ShadowMap(const std::vector<PlacedBody>& bodies, size_t receiver,
                     const Eigen::Vector3d& to_light_in_cam, double texel_m, int max_texels) {
  const Eigen::Matrix3d light_from_cam = light_axes(to_light_in_cam);
  const PlacedBody& body = bodies[receiver];
  light_from_body_ = light_from_cam * body.cam_from_body.rotation;
  Eigen::AlignedBox3d extent;
  for (const Eigen::Vector3d& vertex : body.mesh->vertices)
    extent.extend(light_from_body_ * vertex);
  const double size_m = extent.sizes().head<2>().maxCoeff();
  texel_m_ = std::max(texel_m, size_m / (max_texels - 2));
  if (!(texel_m_ > 0)) texel_m_ = 1;
  side_ = std::min(static_cast<int>(std::ceil(size_m / texel_m_)) + 2, max_texels);
  origin_ = extent.min();
  // Depths are written in single precision.
  double depth_m = extent.sizes().z();
  const PixelBox box{0, 0, side_, side_};
  ScreenMesh casters;
  for (const PlacedBody& caster : bodies) {
    const Eigen::Matrix3d turn = light_from_cam * caster.cam_from_body.rotation;
    const Eigen::Vector3d shift =
        light_from_cam * (caster.cam_from_body.translation - body.cam_from_body.translation) -
        origin_;
    const auto first = static_cast<uint32_t>(casters.points.size());
    for (const Eigen::Vector3d& vertex : caster.mesh->vertices) {
      const Eigen::Vector3d x = turn * vertex + shift;
      casters.points.push_back({x.x() / texel_m_, x.y() / texel_m_, x.z()});
      depth_m = std::max(depth_m, std::abs(x.z()));
    }
    for (const Triangle& triangle : caster.mesh->triangles) {
      const auto [a, b, c] = triangle.vertex;
      casters.triangles.push_back({{first + a, first + b, first + c}, 1});
    }
  }
  tolerance_m_ = 4 * std::numeric_limits<float>::epsilon() * depth_m + 1e-5 * size_m;
  nearest_.assign(static_cast<size_t>(side_) * side_, -std::numeric_limits<float>::max());
  VisibleStrip strip;
  const std::unique_ptr<SamplePainter> painter = make_own_painter();
  painter->start(casters, box, sample_pattern(1));
  while (painter->next(strip)) {
    const size_t first = static_cast<size_t>(strip.box.top) * side_;
    const size_t count = static_cast<size_t>(strip.box.height()) * side_;
    for (size_t i = 0; i < count; ++i) {
      if (strip.is_touched[i]) nearest_[first + i] = strip.nearness[i];
    }
  }
}

double ShadowMap::height_over_m(const Eigen::Vector3d& x) const {
  const Eigen::Vector3d at = light_from_body_ * x - origin_;
  const int column = static_cast<int>(std::lround(at.x() / texel_m_));
  const int line = static_cast<int>(std::lround(at.y() / texel_m_));
  if (column < 0 || line < 0 || column >= side_ || line >= side_) return -1;
  return row(line)[column] - at.z();
}

bool ShadowMap::is_lit(const Eigen::Vector3d& x, const Eigen::Vector3d& normal) const {
  const Eigen::Vector3d at = light_from_body_ * x - origin_;
  const int column = static_cast<int>(std::lround(at.x() / texel_m_));
  const int row = static_cast<int>(std::lround(at.y() / texel_m_));
  if (column < 0 || row < 0 || column >= side_ || row >= side_) return true;
  const Eigen::Vector3d n = light_from_body_ * normal;
  // Edge-on to the light a plane has no depth at the texel's centre, and takes no light.
  if (n.z() == 0) return true;
  const double plane_m =
      at.z() - (n.x() * (column * texel_m_ - at.x()) + n.y() * (row * texel_m_ - at.y())) / n.z();
  return nearest_[static_cast<size_t>(row) * side_ + column] <= plane_m + tolerance_m_;
}

}  // namespace sightline
