// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/colour_shading.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace sightline {
namespace {

// u and v of a texture, from those that the corners carry.
Eigen::Vector2f in_texture(const TextureRef& ref, const Eigen::Vector2f& uv) {
  const auto& m = ref.texture_from_uv;
  return {static_cast<float>(m[0] * uv.x() + m[1] * uv.y() + m[2]),
          static_cast<float>(m[3] * uv.x() + m[4] * uv.y() + m[5])};
}

Eigen::Array4f looked_up(const TexturePyramid& pyramid, const TextureRef& ref,
                         const Eigen::Vector2f& uv, float level) {
  const Eigen::Vector2f at = in_texture(ref, uv);
  return pyramid.at(ref, at.x(), at.y(), level);
}

// The cosine between normal and eye; interpolated normals may turn away from what sees them.
double facing_eye(const Eigen::Vector3d& normal, const Eigen::Vector3d& to_eye) {
  return std::clamp(normal.dot(to_eye), 1e-3, 1.0);
}

Eigen::Array3f factors_of(const Eigen::Vector3d& colour, bool is_grey) {
  if (is_grey) return Eigen::Array3f::Ones();
  return colour.cast<float>().array();
}

Material grey_material(double albedo) {
  Material material;
  material.base = {albedo, albedo, albedo, 1};
  return material;
}

}  // namespace

ColourShader::ColourShader(const PlacedBody& body, const Light& light, bool is_grey,
                           bool draws_textures, std::unique_ptr<const ShadowMap> shadow,
                           TextureCache& textures)
    : hits_(body),
      light_(light),
      is_grey_(is_grey),
      to_light_(body.cam_from_body.rotation.transpose() * light.to_light_in_cam),
      to_second_(body.cam_from_body.rotation.transpose() * light.to_second_in_cam),
      colour_(factors_of(light.colour, is_grey)),
      second_colour_(factors_of(light.second_colour, is_grey)),
      body_from_cam_(body.cam_from_body.rotation.transpose()),
      shadow_(std::move(shadow)) {
  paints_.reserve(body.mesh->parts.size());
  for (const Part& part : body.mesh->parts) {
    paints_.push_back(paint_of(part, draws_textures, textures));
    count_levels(paints_.back());  // where it stays: it points into itself
  }
  find_colours();
}

ColourShader::Paint ColourShader::paint_of(const Part& part, bool draws_textures,
                                           TextureCache& textures) const {
  Paint paint;
  paint.material = part.material.value_or(grey_material(part.albedo));
  const Mesh& mesh = *hits_.body().mesh;
  paint.is_painted = part.material && draws_textures && !mesh.coats.empty();
  for (size_t c = 0; c < 4; ++c) {
    paint.factor[static_cast<Eigen::Index>(c)] = static_cast<float>(paint.material.base[c]);
  }
  paint.emits = !is_grey_ && paint.material.emissive != Material{}.emissive;
  const auto pyramid = [&](const TextureRef& ref, bool weighs_alpha) -> const TexturePyramid* {
    const bool is_drawn = draws_textures && ref.is_there() && !mesh.coats.empty();
    return is_drawn ? &textures.pyramid(mesh.textures[ref.texture], weighs_alpha) : nullptr;
  };
  const Material& material = paint.material;
  paint.base = pyramid(material.base_texture, material.alpha_mode != AlphaMode::kOpaque);
  if (is_grey_) return paint;
  paint.gloss = pyramid(material.gloss_texture, false);
  paint.emissive = pyramid(material.emissive_texture, false);
  paint.normal = pyramid(material.normal_texture, false);
  return paint;
}

bool ColourShader::has_detail() const {
  return shadow_ != nullptr || light_.specular > 0 || hits_.body().stripe_contrast > 0;
}

CarriedValues ColourShader::carried(int triangle) const {
  const Mesh& mesh = *hits_.body().mesh;
  const auto& corner = mesh.triangles[triangle].vertex;
  const Eigen::Vector3d a = mesh.vertices[corner[0]] - hits_.eye_in_body();
  const Eigen::Vector3d b = mesh.vertices[corner[1]] - hits_.eye_in_body();
  const Eigen::Vector3d c = mesh.vertices[corner[2]] - hits_.eye_in_body();
  // The volumes that a ray spans with the edges, as RayHits::on has them, are linear in the ray.
  Eigen::Matrix3d volumes;
  volumes.row(0) = b.cross(c);
  volumes.row(1) = c.cross(a);
  volumes.row(2) = a.cross(b);
  volumes *= body_from_cam_;
  const Coat& coat = mesh.coats[triangle];
  Eigen::Matrix3d uv;
  Eigen::Matrix<double, 4, 3> colours;
  for (int i = 0; i < 3; ++i) {
    uv.col(i) << coat.uv[i].cast<double>(), 1;
    colours.col(i) = coat.colour[i].cast<double>();
  }
  const Eigen::Matrix<double, 2, 3> at_corners = uv.topRows<2>();
  return {uv * volumes, colours * volumes, at_corners.rowwise().minCoeff(),
          at_corners.rowwise().maxCoeff()};
}

void ColourShader::count_levels(Paint& paint) {
  const Material& material = paint.material;
  for (const auto& [pyramid, ref] : {std::pair{paint.base, &material.base_texture},
                                     {paint.gloss, &material.gloss_texture},
                                     {paint.emissive, &material.emissive_texture},
                                     {paint.normal, &material.normal_texture}}) {
    if (pyramid == nullptr || paint.first != nullptr) continue;
    paint.first = pyramid;
    paint.first_ref = ref;
  }
  const auto shift = [&](const TexturePyramid* pyramid) {
    if (pyramid == nullptr) return 0.0f;
    return static_cast<float>(
        std::log2(static_cast<double>(pyramid->width()) / paint.first->width()));
  };
  paint.gloss_shift = shift(paint.gloss);
  paint.emissive_shift = shift(paint.emissive);
  paint.normal_shift = shift(paint.normal);
}

const TextureRef* ColourShader::finest_texture(int triangle) const {
  return paints_[part_of(triangle)].first_ref;
}

Eigen::Vector2d ColourShader::texels(int triangle) const {
  const TexturePyramid* first = paints_[part_of(triangle)].first;
  if (first == nullptr) return Eigen::Vector2d::Zero();
  return {static_cast<double>(first->width()), static_cast<double>(first->height())};
}

Eigen::Array4f ColourShader::texel_at(int triangle, const Eigen::Vector2f& uv, float level) const {
  const Paint& paint = paints_[part_of(triangle)];
  if (paint.base == nullptr) return Eigen::Array4f::Ones();
  return looked_up(*paint.base, paint.material.base_texture, uv, level);
}

void ColourShader::find_colours() {
  const Mesh& mesh = *hits_.body().mesh;
  for (size_t i = 0; i < mesh.coats.size(); ++i) {
    Paint& paint = paints_[part_of(static_cast<int>(i))];
    if (paint.has_colours || !paint.is_painted) continue;
    const auto& colour = mesh.coats[i].colour;
    paint.has_colours = std::any_of(colour.begin(), colour.end(), [](const Eigen::Vector4f& c) {
      return c != Eigen::Vector4f::Ones();
    });
  }
}

Eigen::Array3f ColourShader::emission_at(int triangle, const Eigen::Vector2f& uv,
                                         float level) const {
  if (is_grey_) return Eigen::Array3f::Zero();
  const Paint& paint = paints_[part_of(triangle)];
  const auto& factor = paint.material.emissive;
  const Eigen::Array3f out(static_cast<float>(factor[0]), static_cast<float>(factor[1]),
                           static_cast<float>(factor[2]));
  if (paint.emissive == nullptr) return out;
  return out * looked_up(*paint.emissive, paint.material.emissive_texture, uv,
                         level + paint.emissive_shift)
                   .head<3>();
}

Gloss ColourShader::gloss_at(const Paint& paint, const Eigen::Vector2f& uv, float level) const {
  Gloss gloss{paint.material.metallic, paint.material.roughness};
  if (paint.gloss == nullptr) return gloss;
  const Eigen::Array4f texel =
      looked_up(*paint.gloss, paint.material.gloss_texture, uv, level + paint.gloss_shift);
  gloss.roughness *= texel[1];
  gloss.metallic *= texel[2];
  return gloss;
}

double ColourShader::stripe_at(const Eigen::Vector3d& x) const {
  const PlacedBody& body = hits_.body();
  if (!(body.stripe_contrast > 0)) return 1;
  const bool is_dark = static_cast<int64_t>(std::floor(x.x() / body.stripe_m)) % 2 != 0;
  return is_dark ? 1 - body.stripe_contrast : 1;
}

// The normal that a normal texture makes of the surface's own. Its axes are the triangle's: where u
// grows, and where v falls (glTF's green is up, its v down).
Eigen::Vector3d ColourShader::tilted(const Paint& paint, int triangle,
                                     const Eigen::Vector3d& normal, const Eigen::Vector2f& uv,
                                     float level) const {
  if (paint.normal == nullptr) return normal;
  const Mesh& mesh = *hits_.body().mesh;
  const auto& corner = mesh.triangles[triangle].vertex;
  const Coat& coat = mesh.coats[triangle];
  const TextureRef& ref = paint.material.normal_texture;
  Eigen::Matrix<double, 3, 2> edges;
  edges << mesh.vertices[corner[1]] - mesh.vertices[corner[0]],
      mesh.vertices[corner[2]] - mesh.vertices[corner[0]];
  const Eigen::Vector2f origin = in_texture(ref, coat.uv[0]);
  Eigen::Matrix2d in_picture;
  in_picture << (in_texture(ref, coat.uv[1]) - origin).cast<double>(),
      (in_texture(ref, coat.uv[2]) - origin).cast<double>();
  if (in_picture.determinant() == 0) return normal;  // the triangle is a line of the picture
  const Eigen::Matrix<double, 3, 2> axes = edges * in_picture.inverse();
  const Eigen::Vector3d right = (axes.col(0) - normal * normal.dot(axes.col(0))).stableNormalized();
  const Eigen::Vector3d beside = normal.cross(right);
  const Eigen::Vector3d up = beside.dot(axes.col(1)) > 0 ? Eigen::Vector3d(-beside) : beside;
  const Eigen::Array4f texel = looked_up(*paint.normal, ref, uv, level + paint.normal_shift);
  const Eigen::Array3d t = 2 * texel.head<3>().cast<double>() - 1;
  const double scale = paint.material.normal_scale;
  return (scale * (t[0] * right + t[1] * up) + t[2] * normal).stableNormalized();
}

// Of a distant light that nothing shades; dull surfaces have no highlight of it.
Reflection ColourShader::of_distant(const Paint& paint, const Gloss& gloss, double level,
                                    const Eigen::Vector3d& to_light, const Eigen::Vector3d& normal,
                                    const Eigen::Vector3d& to_eye) const {
  const double n_l = normal.dot(to_light);
  if (!(n_l > 0 && level > 0)) return {};
  if (!paint.material.has_gloss || is_grey_) return {.of_base = level * n_l, .own = 0};
  const Eigen::Vector3d half_way = (to_eye + to_light).normalized();
  return reflected(gloss, level, n_l, facing_eye(normal, to_eye), normal.dot(half_way),
                   to_eye.dot(half_way));
}

ColourLight ColourShader::light_at(const SurfacePoint& point, const Eigen::Vector2f& uv,
                                   float level) const {
  const Mesh& mesh = *hits_.body().mesh;
  const Triangle& triangle = mesh.triangles[point.triangle];
  const Paint& paint = paints_[triangle.part];
  if (paint.material.is_unlit && !is_grey_) return {.of_base = Eigen::Array3f::Ones()};
  Eigen::Vector3d normal = point.weights[0] * triangle.normal[0] +
                           point.weights[1] * triangle.normal[1] +
                           point.weights[2] * triangle.normal[2];
  // A back face is the inside of an open mesh: it is lit as a sheet of paper is.
  if (!point.is_front) normal = -normal;
  normal = tilted(paint, point.triangle, normal.stableNormalized(), uv, level);
  const Eigen::Vector3d x = hits_.in_body(point);
  const Eigen::Vector3d to_eye = (hits_.eye_in_body() - x).normalized();
  const bool is_dull = !paint.material.has_gloss || is_grey_;
  const Gloss gloss = is_dull ? Gloss{} : gloss_at(paint, uv, level);

  ColourLight light;
  const Eigen::Array3f white = Eigen::Array3f::Ones();
  light.add(is_dull ? Reflection{light_.ambient, 0}
                    : reflected_glow(gloss, light_.ambient, facing_eye(normal, to_eye)),
            white);
  light.add(of_distant(paint, gloss, light_.second, to_second_, normal, to_eye), second_colour_);
  const bool is_lit = normal.dot(to_light_) > 0 &&
                      (shadow_ == nullptr || shadow_->is_lit(x, winding_normal(mesh, triangle)));
  if (is_lit) {
    Reflection direct = of_distant(paint, gloss, light_.directional, to_light_, normal, to_eye);
    if (is_dull && light_.specular > 0) {
      const double n_h = std::max(0.0, normal.dot((to_eye + to_light_).normalized()));
      direct.own += light_.specular * std::pow(n_h, light_.shininess);
    }
    light.add(direct, colour_);
  }
  light.of_base *= static_cast<float>(stripe_at(x));
  return light;
}

}  // namespace sightline
