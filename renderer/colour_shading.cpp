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

// The cosine between normal and eye; interpolated normals may turn away from what sees them.
double facing_eye(const Eigen::Vector3d& normal, const Eigen::Vector3d& to_eye) {
  return std::clamp(normal.dot(to_eye), 1e-3, 1.0);
}

Eigen::Array4f factors_of(const Eigen::Vector3d& colour, bool is_grey) {
  if (is_grey) return Eigen::Array4f::Constant(static_cast<float>(grey_of(colour)));
  Eigen::Array4f factors = Eigen::Array4f::Ones();
  factors.head<3>() = colour.cast<float>().array();
  return factors;
}

Eigen::Matrix2f texels_from_uv(const TexturePyramid& pyramid, const TextureRef& ref) {
  const auto& m = ref.texture_from_uv;
  Eigen::Matrix2d texels;
  texels << pyramid.width() * m[0], pyramid.width() * m[1], pyramid.height() * m[3],
      pyramid.height() * m[4];
  return texels.cast<float>();
}

// Levels of the part's textures are those of the first that it has.
void count_levels(Paint& paint) {
  const Material& material = paint.material;
  double first_width = 0;
  const auto shift = [&](const TexturePyramid* pyramid, const TextureRef& ref) {
    if (pyramid == nullptr) return 0.0f;
    if (!paint.has_texture) {
      paint.has_texture = true;
      paint.texels_from_uv = texels_from_uv(*pyramid, ref);
      first_width = pyramid->width();
    }
    return static_cast<float>(std::log2(pyramid->width() / first_width));
  };
  shift(paint.base, material.base_texture);
  paint.gloss_shift = shift(paint.gloss, material.gloss_texture);
  paint.emissive_scale = std::exp2(2 * shift(paint.emissive, material.emissive_texture));
  paint.normal_shift = shift(paint.normal, material.normal_texture);
  paint.occlusion_shift = shift(paint.occlusion, material.occlusion_texture);
  paint.wants_level =
      paint.gloss != nullptr || paint.normal != nullptr || paint.occlusion != nullptr;
}

Gloss gloss_at(const Paint& paint, const Eigen::Vector2f& uv, float level) {
  Gloss gloss{paint.material.metallic, paint.material.roughness};
  if (paint.gloss == nullptr) return gloss;
  const Eigen::Array4f texel =
      paint.gloss->at(paint.material.gloss_texture, uv.x(), uv.y(), level + paint.gloss_shift);
  gloss.roughness *= texel[1];
  gloss.metallic *= texel[2];
  return gloss;
}

// The share of the light from all around that the occlusion texture leaves.
float unoccluded(const Paint& paint, const Eigen::Vector2f& uv, float level) {
  if (paint.occlusion == nullptr) return 1;
  const Eigen::Array4f texel = paint.occlusion->at(paint.material.occlusion_texture, uv.x(), uv.y(),
                                                   level + paint.occlusion_shift);
  return 1 + static_cast<float>(paint.material.occlusion_strength) * (texel[0] - 1);
}

// What the even glow gives where it is seen at cosine n_v.
Reflection of_glow(const Paint& paint, const Gloss& gloss, double level, double n_v) {
  if (paint.is_dull) return {level, 0};
  if (paint.gloss != nullptr) return reflected_glow(gloss, level, n_v);
  return reflected_shares(paint.glow.at(n_v), gloss.metallic, level);
}

Surroundings surroundings_of(const PlacedBody& body, const Scene& scene,
                             EnvironmentLight* panorama) {
  return {.light = panorama,
          .strength = static_cast<float>(scene.environment.strength),
          .environment_from_body =
              cam_from_environment(scene.environment).transpose() * body.cam_from_body.rotation};
}

std::vector<Lamp> lamps_about(const PlacedBody& body, const Scene& scene) {
  std::vector<Lamp> lamps = scene.lamps;
  const Pose body_from_cam = inverse(body.cam_from_body);
  for (Lamp& lamp : lamps) {
    lamp.position_in_cam_m = body_from_cam * lamp.position_in_cam_m;
    lamp.direction_in_cam = body_from_cam.rotation * lamp.direction_in_cam;
  }
  return lamps;
}

Material grey_material(double albedo) {
  Material material;
  material.base = {albedo, albedo, albedo, 1};
  return material;
}

}  // namespace

Eigen::Array3d emission(const Material& material, bool draws_textures) {
  // A texture's factor alone says nothing: it is mostly 1, of a texture that is mostly black.
  if (material.emissive_texture.is_there() && !draws_textures) return Eigen::Array3d::Zero();
  return Eigen::Map<const Eigen::Array3d>(material.emissive.data());
}

ColourShader::ColourShader(const PlacedBody& body, const Scene& scene, EnvironmentLight* panorama,
                           std::unique_ptr<const Shadow> shadow, BodySky* sky,
                           TextureCache& textures)
    : hits_(body),
      light_(scene.light),
      surroundings_(surroundings_of(body, scene, panorama)),
      lamps_(lamps_about(body, scene)),
      is_grey_(scene.colouring.mode == ColourMode::kGrey),
      to_light_(body.cam_from_body.rotation.transpose() * light_.to_light_in_cam),
      to_second_(body.cam_from_body.rotation.transpose() * light_.to_second_in_cam),
      colour_(factors_of(light_.colour, is_grey_)),
      second_colour_(factors_of(light_.second_colour, is_grey_)),
      body_from_cam_(body.cam_from_body.rotation.transpose()),
      shadow_(std::move(shadow)),
      sky_(sky),
      has_detail_(find_detail()) {
  paints_.reserve(body.mesh->parts.size());
  for (const Part& part : body.mesh->parts) {
    paints_.push_back(paint_of(part, scene.colouring.draws_textures, textures));
    count_levels(paints_.back());
  }
  find_colours();
}

Paint ColourShader::paint_of(const Part& part, bool draws_textures, TextureCache& textures) const {
  Paint paint;
  paint.material = part.material.value_or(grey_material(part.albedo));
  const Material& material = paint.material;
  const Mesh& mesh = *hits_.body().mesh;
  paint.is_painted = part.material && draws_textures && !mesh.coats.empty();
  for (Eigen::Index c = 0; c < 4; ++c) {
    paint.factor[c] = static_cast<float>(material.base[static_cast<size_t>(c)]);
  }
  const auto pyramid = [&](const TextureRef& ref, bool weighs_alpha) -> const TexturePyramid* {
    const bool is_drawn = draws_textures && ref.is_there() && !mesh.coats.empty();
    return is_drawn ? &textures.pyramid(mesh.textures[ref.texture], weighs_alpha) : nullptr;
  };
  paint.base = pyramid(material.base_texture, material.alpha_mode != AlphaMode::kOpaque);
  if (paint.base != nullptr) paint.base_map = paint.base->map(material.base_texture);
  const Eigen::Array3d emitted = emission(material, draws_textures);
  paint.emitted.head<3>() = emitted.cast<float>();
  paint.emissive = pyramid(material.emissive_texture, false);
  if (paint.emissive != nullptr) {
    paint.emissive_map = paint.emissive->map(material.emissive_texture);
  }
  if (is_grey_) return paint;
  paint.is_dull = !material.has_gloss;
  if (material.has_gloss) paint.glow = GlowCurve(material.roughness * material.roughness);
  paint.alpha_mode = material.alpha_mode;
  paint.gloss = pyramid(material.gloss_texture, false);
  paint.normal = pyramid(material.normal_texture, false);
  paint.occlusion = pyramid(material.occlusion_texture, false);
  return paint;
}

bool ColourShader::find_detail() const {
  const bool has_rim = std::any_of(lamps_.begin(), lamps_.end(),
                                   [](const Lamp& lamp) { return lamp.cone_deg < 180; });
  return shadow_ != nullptr || light_.specular > 0 || hits_.body().stripe_contrast > 0 || has_rim;
}

bool ColourShader::is_see_through() const {
  return std::any_of(paints_.begin(), paints_.end(),
                     [](const Paint& paint) { return paint.alpha_mode != AlphaMode::kOpaque; });
}

SurfacePlane ColourShader::plane_of(int triangle) const {
  const Mesh& mesh = *hits_.body().mesh;
  const auto& corner = mesh.triangles[triangle].vertex;
  const Eigen::Vector3d a = mesh.vertices[corner[0]] - hits_.eye_in_body();
  const Eigen::Vector3d b = mesh.vertices[corner[1]] - hits_.eye_in_body();
  const Eigen::Vector3d c = mesh.vertices[corner[2]] - hits_.eye_in_body();
  SurfacePlane plane;
  // RayHits::on has them for one ray.
  plane.volumes.row(0) = b.cross(c);
  plane.volumes.row(1) = c.cross(a);
  plane.volumes.row(2) = a.cross(b);
  plane.volumes *= body_from_cam_;
  const Paint& paint = this->paint(triangle);
  if (!paint.is_painted) return plane;
  const Coat& coat = mesh.coats[triangle];
  Eigen::Matrix<double, 4, 3> corners;
  for (int i = 0; i < 3; ++i) corners.col(i) << 1, coat.uv[i].x(), coat.uv[i].y(), 0;
  plane.sum_and_uv = corners * plane.volumes;
  plane.least_uv = coat.uv[0].cwiseMin(coat.uv[1]).cwiseMin(coat.uv[2]);
  plane.greatest_uv = coat.uv[0].cwiseMax(coat.uv[1]).cwiseMax(coat.uv[2]);
  if (!paint.has_colours) return plane;
  for (int i = 0; i < 3; ++i) corners.col(i) = coat.colour[i].cast<double>();
  plane.colours = corners * plane.volumes;
  return plane;
}

SurfaceHit ColourShader::hit(const SurfacePlane& plane, int triangle,
                             const Eigen::Vector3d& ray) const {
  const SurfacePoint point = surface_point(triangle, plane.volumes * ray);
  return {.triangle = triangle, .weights = point.weights, .ray = ray, .is_front = point.is_front};
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

Eigen::Vector3d ColourShader::in_body(const SurfaceHit& hit) const {
  const Mesh& mesh = *hits_.body().mesh;
  const auto& corner = mesh.triangles[hit.triangle].vertex;
  return hit.weights[0] * mesh.vertices[corner[0]] + hit.weights[1] * mesh.vertices[corner[1]] +
         hit.weights[2] * mesh.vertices[corner[2]];
}

double ColourShader::stripe_at(const SurfaceHit& hit) const {
  const PlacedBody& body = hits_.body();
  if (!(body.stripe_contrast > 0)) return 1;
  const double along = in_body(hit).x();
  const bool is_dark = static_cast<int64_t>(std::floor(along / body.stripe_m)) % 2 != 0;
  return is_dark ? 1 - body.stripe_contrast : 1;
}

double ColourShader::lit_share(const SurfaceHit& hit, int sample) const {
  if (shadow_ == nullptr) return 1;
  const Mesh& mesh = *hits_.body().mesh;
  return shadow_->lit_share(in_body(hit), winding_normal(mesh, mesh.triangles[hit.triangle]),
                            hit.triangle, sample);
}

float ColourShader::sky_share(const SurfaceHit& hit) const {
  if (sky_ == nullptr) return 1;
  const Mesh& mesh = *hits_.body().mesh;
  const Triangle& triangle = mesh.triangles[hit.triangle];
  return static_cast<float>(
      sky_->share(in_body(hit), facing_normal(mesh, triangle, hit.is_front), mesh_normal(hit)));
}

// The normal that a normal texture makes of the surface's own. Its axes are the triangle's: where u
// grows, and where v falls (glTF's green is up, its v down).
Eigen::Vector3d ColourShader::tilted(const Paint& paint, int triangle,
                                     const Eigen::Vector3d& normal, const Eigen::Vector2f& uv,
                                     float level) const {
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
  const Eigen::Array4f texel = paint.normal->at(ref, uv.x(), uv.y(), level + paint.normal_shift);
  const Eigen::Array3d t = 2 * texel.head<3>().cast<double>() - 1;
  const double scale = paint.material.normal_scale;
  return (scale * (t[0] * right + t[1] * up) + t[2] * normal).stableNormalized();
}

Eigen::Vector3d ColourShader::mesh_normal(const SurfaceHit& hit) const {
  const auto& corners = hits_.body().mesh->triangles[hit.triangle].normal;
  Eigen::Vector3d normal =
      hit.weights[0] * corners[0] + hit.weights[1] * corners[1] + hit.weights[2] * corners[2];
  // A back face is the inside of an open mesh: it is lit as a sheet of paper is.
  if (!hit.is_front) normal = -normal;
  const double length = normal.norm();
  if (length > 0) normal *= 1 / length;
  return normal;
}

Eigen::Vector3d ColourShader::normal_at(const SurfaceHit& hit, const Paint& paint,
                                        const Eigen::Vector2f& uv, float level) const {
  const Eigen::Vector3d normal = mesh_normal(hit);
  return paint.normal == nullptr ? normal : tilted(paint, hit.triangle, normal, uv, level);
}

// Of a distant light that nothing shades; dull surfaces have no highlight of it.
Reflection ColourShader::of_distant(const Paint& paint, const Gloss& gloss, double level,
                                    const Eigen::Vector3d& to_light, const Eigen::Vector3d& normal,
                                    const Eigen::Vector3d& to_eye) const {
  const double n_l = normal.dot(to_light);
  if (!(n_l > 0 && level > 0)) return {};
  if (paint.is_dull) return {.of_base = level * n_l, .own = 0};
  const Eigen::Vector3d half_way = (to_eye + to_light).normalized();
  return reflected(gloss, level, n_l, facing_eye(normal, to_eye), normal.dot(half_way),
                   to_eye.dot(half_way));
}

// A panorama's light as the picture has it.
Eigen::Array4f ColourShader::shown(const Eigen::Array4f& surroundings) const {
  if (!is_grey_) return surroundings_.strength * surroundings;
  const auto grey = static_cast<float>(grey_of(surroundings.head<3>().matrix().cast<double>()));
  return Eigen::Array4f::Constant(surroundings_.strength * grey);
}

// As the even glow, but for where the light comes from.
void ColourShader::add_surroundings(const Paint& paint, const Gloss& gloss,
                                    const Eigen::Vector3d& normal, const Eigen::Vector3d& to_eye,
                                    ColourLight& light) const {
  EnvironmentLight& panorama = *surroundings_.light;
  const Eigen::Matrix3d& turn = surroundings_.environment_from_body;
  const Eigen::Array4f dull = shown(panorama.dull(turn * normal));
  if (paint.is_dull) {
    light.of_base += dull;
    return;
  }
  const double n_v = facing_eye(normal, to_eye);
  const GlowParts parts =
      glow_parts(paint.gloss == nullptr ? paint.glow.at(n_v)
                                        : glow_shares(gloss.roughness * gloss.roughness, n_v),
                 gloss.metallic);
  const Eigen::Vector3d mirrored = 2 * normal.dot(to_eye) * normal - to_eye;
  const Eigen::Array4f mirror = shown(panorama.glossy(turn * mirrored, gloss.roughness));
  light.of_base += static_cast<float>(parts.dull_of_base) * dull +
                   static_cast<float>(parts.mirror_of_base) * mirror;
  light.own += static_cast<float>(parts.mirror_own) * mirror;
}

void ColourShader::add_lamps(const SurfaceHit& hit, const Paint& paint, const Gloss& gloss,
                             const Eigen::Vector3d& normal, const Eigen::Vector3d& to_eye,
                             ColourLight& light) const {
  const Eigen::Vector3d x = in_body(hit);
  for (const Lamp& lamp : lamps_) {
    const Eigen::Vector3d way = lamp.position_in_cam_m - x;
    const double squared_m = way.squaredNorm();
    if (!(squared_m > 0)) continue;
    const Eigen::Vector3d to_lamp = way / std::sqrt(squared_m);
    const double level = lamp.strength * lamp.distance_m * lamp.distance_m / squared_m *
                         cone_share(lamp, -to_lamp.dot(lamp.direction_in_cam));
    light.add(of_distant(paint, gloss, level, to_lamp, normal, to_eye),
              factors_of(lamp.colour, is_grey_));
  }
}

ColourLight ColourShader::light_at(const SurfaceHit& hit, const Eigen::Vector2f& uv, float level,
                                   int sample, float sky) const {
  const Paint& paint = this->paint(hit.triangle);
  if (paint.material.is_unlit && !is_grey_) return {.of_base = Eigen::Array4f::Ones()};
  const Eigen::Vector3d normal = normal_at(hit, paint, uv, level);
  const bool wants_eye = !paint.is_dull || light_.specular > 0;
  const Eigen::Vector3d to_eye =
      wants_eye ? -(body_from_cam_ * hit.ray).normalized() : Eigen::Vector3d(0, 0, 0);
  const Gloss gloss = paint.is_dull ? Gloss{} : gloss_at(paint, uv, level);

  ColourLight light;
  light.add(of_glow(paint, gloss, light_.ambient, facing_eye(normal, to_eye)),
            Eigen::Array4f::Ones());
  if (surroundings_.light != nullptr) add_surroundings(paint, gloss, normal, to_eye, light);
  const float share = sky * unoccluded(paint, uv, level);
  light.of_base *= share;
  light.own *= share;
  if (light_.second > 0) {
    light.add(of_distant(paint, gloss, light_.second, to_second_, normal, to_eye), second_colour_);
  }
  if (!lamps_.empty()) add_lamps(hit, paint, gloss, normal, to_eye, light);
  const double lit = normal.dot(to_light_) > 0 ? lit_share(hit, sample) : 0;
  if (lit > 0) {
    Reflection direct =
        of_distant(paint, gloss, lit * light_.directional, to_light_, normal, to_eye);
    if (paint.is_dull && light_.specular > 0) {
      const double n_h = std::max(0.0, normal.dot((to_eye + to_light_).normalized()));
      direct.own += lit * light_.specular * std::pow(n_h, light_.shininess);
    }
    light.add(direct, colour_);
  }
  light.of_base *= static_cast<float>(stripe_at(hit));
  return light;
}

}  // namespace sightline
