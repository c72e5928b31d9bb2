// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "renderer/brdf.h"
#include "renderer/environment.h"
#include "renderer/shading.h"
#include "renderer/texture.h"
#include "scenes/scene/scene.h"

namespace sightline {

/// What a triangle's corners carry, for rays from the camera (x/z, y/z, 1): all are linear in the
/// ray, and their ratios to the sum of `volumes` are what the ray meets.
struct SurfacePlane {
  Eigen::Matrix3d volumes;  ///< that the ray spans with the edges; negative seen from the front
  Eigen::Matrix<double, 4, 3> sum_and_uv;  ///< the sum of volumes, u, v, and zeros
  Eigen::Matrix<double, 4, 3> colours;     ///< red, green, blue, alpha
  Eigen::Vector2f least_uv, greatest_uv;
};

/// Where a ray meets a triangle.
struct SurfaceHit {
  int triangle = 0;
  Eigen::Vector3d weights;  ///< of its corners, their sum 1 and none negative
  Eigen::Vector3d ray;      ///< from the eye, in the camera's frame, of any length
  bool is_front = true;     ///< seen from the side that its winding calls outside
};

/// Light by channel, the fourth unused: a factor on the base colour, and what comes without it.
struct ColourLight {
  Eigen::Array4f of_base = Eigen::Array4f::Zero();
  Eigen::Array4f own = Eigen::Array4f::Zero();

  void add(const Reflection& light, const Eigen::Array4f& colour) {
    of_base += static_cast<float>(light.of_base) * colour;
    own += static_cast<float>(light.own) * colour;
  }
};

/// How a part of a mesh is drawn.
struct Paint {
  Material material;
  Eigen::Array4f factor = Eigen::Array4f::Ones();  ///< on the texture's colour
  Eigen::Array4f emitted = Eigen::Array4f::Zero();
  bool is_dull = true;                        ///< after Lambert, with the highlights of [light]
  bool is_painted = false;                    ///< the corners carry something that is drawn
  bool has_colours = false;                   ///< they carry colours that are not all white
  AlphaMode alpha_mode = AlphaMode::kOpaque;  ///< opaque in grey, whatever the material
  const TexturePyramid* base = nullptr;
  const TexturePyramid* gloss = nullptr;
  const TexturePyramid* emissive = nullptr;
  const TexturePyramid* normal = nullptr;
  const TexturePyramid* occlusion = nullptr;
  /// Where there is a texture, the size in texels, by the corners' coordinates, of the one whose
  /// levels are counted: the base colour's, if it has one. The others' levels are so much coarser.
  bool has_texture = false;
  Eigen::Matrix2f texels_from_uv = Eigen::Matrix2f::Zero();
  float gloss_shift = 0;
  float normal_shift = 0;
  float occlusion_shift = 0;
  float emissive_scale = 1;  ///< of texels' areas
  bool wants_level = false;  ///< light_at() looks a texture up
  TexelMap base_map, emissive_map;
  GlowCurve glow;  ///< of the factor of roughness, where there is gloss
};

/// The panorama about a body.
struct Surroundings {
  EnvironmentLight* light = nullptr;  ///< none: there is none
  float strength = 1;
  Eigen::Matrix3d environment_from_body = Eigen::Matrix3d::Identity();
};

/// The light that a material sends by itself, a factor on its texture if it has one that is drawn:
/// none where that is not.
Eigen::Array3d emission(const Material& material, bool draws_textures);

/// What one body sends to the camera, by channel. Where the scene is grey the surfaces are dull
/// ones of their base colour and emission, lit as Shader has them; in colour those with gloss
/// follow brdf.h. The ambient light is a glow from all sides, as the panorama's light is, and the
/// highlights of [light] are those of the dull.
class ColourShader {
 public:
  /// `panorama` must outlive it; none where the scene has no environment. Shadow and sky as in
  /// Shader.
  ColourShader(const PlacedBody& body, const Scene& scene, EnvironmentLight* panorama,
               std::unique_ptr<const Shadow> shadow, BodySky* sky, TextureCache& textures);

  SurfacePlane plane_of(int triangle) const;
  /// `ray` is (x/z, y/z, 1) in the camera; one that misses is moved into the triangle.
  SurfaceHit hit(const SurfacePlane& plane, int triangle, const Eigen::Vector3d& ray) const;

  /// The light where a ray hits. `uv` and `level` are where textures of the part are looked up that
  /// say how it is reflected; `sample` is the one of its pixel that the light is for, `sky` the
  /// share of glow and panorama that comes there.
  ColourLight light_at(const SurfaceHit& hit, const Eigen::Vector2f& uv, float level, int sample,
                       float sky) const;
  /// That share, by the mesh's own normals.
  float sky_share(const SurfaceHit& hit) const;

  /// Some part of it shows what is behind.
  bool is_see_through() const;
  const Paint& paint(int triangle) const { return paints_[part_of(triangle)]; }
  /// As in Shader: each sample wants its own light.
  bool has_detail() const { return has_detail_; }

 private:
  int part_of(int triangle) const { return hits_.body().mesh->triangles[triangle].part; }
  Paint paint_of(const Part& part, bool draws_textures, TextureCache& textures) const;
  bool find_detail() const;
  void find_colours();
  Eigen::Vector3d mesh_normal(const SurfaceHit& hit) const;
  Eigen::Vector3d normal_at(const SurfaceHit& hit, const Paint& paint, const Eigen::Vector2f& uv,
                            float level) const;
  Eigen::Vector3d tilted(const Paint& paint, int triangle, const Eigen::Vector3d& normal,
                         const Eigen::Vector2f& uv, float level) const;
  Reflection of_distant(const Paint& paint, const Gloss& gloss, double level,
                        const Eigen::Vector3d& to_light, const Eigen::Vector3d& normal,
                        const Eigen::Vector3d& to_eye) const;
  void add_surroundings(const Paint& paint, const Gloss& gloss, const Eigen::Vector3d& normal,
                        const Eigen::Vector3d& to_eye, ColourLight& light) const;
  Eigen::Array4f shown(const Eigen::Array4f& surroundings) const;
  Eigen::Vector3d in_body(const SurfaceHit& hit) const;
  double stripe_at(const SurfaceHit& hit) const;
  double lit_share(const SurfaceHit& hit, int sample) const;
  void add_lamps(const SurfaceHit& hit, const Paint& paint, const Gloss& gloss,
                 const Eigen::Vector3d& normal, const Eigen::Vector3d& to_eye,
                 ColourLight& light) const;

  RayHits hits_;
  Light light_;
  Surroundings surroundings_;
  std::vector<Lamp> lamps_;  // positions and directions in the body's frame
  bool is_grey_;
  Eigen::Vector3d to_light_;  // body's frame
  Eigen::Vector3d to_second_;
  Eigen::Array4f colour_, second_colour_;  // grey where the scene is
  Eigen::Matrix3d body_from_cam_;
  std::unique_ptr<const Shadow> shadow_;
  BodySky* sky_;
  bool has_detail_;
  std::vector<Paint> paints_;  // a part each
};

}  // namespace sightline
