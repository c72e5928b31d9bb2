// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// How surfaces of glTF 2.0's metallic-roughness model reflect light (appendix B of its
// specification): microfacets after Trowbridge and Reitz (GGX) with Smith's height-correlated
// masking and Schlick's Fresnel term, above a Lambertian base where they are not metal.
#pragma once

#include <array>
#include <cstdint>

namespace sightline {

/// Van der Corput's sequence, from 0 to 1: with i / n the points of Hammersley.
double radical_inverse(uint32_t bits);

/// Microfacets' distribution times visibility, V D, for a = roughness^2; cosines to the normal of
/// the light, the eye and the direction half way between them. 0 where either is below the horizon.
double microfacets(double a, double n_l, double n_v, double n_h);

/// The share of an even glow that the microfacets send to an eye at cosine n_v: a mirror of
/// reflectance f at normal incidence sends f * `plain` + `grazing`.
struct GlowShares {
  double plain = 0;
  double grazing = 0;
};

/// Interpolated in a table of integrals by 1024 fixed directions, each true to 0.001.
GlowShares glow_shares(double a, double n_v);

/// glow_shares() of one `a` by the eye's cosine, for whoever asks often.
class GlowCurve {
 public:
  GlowCurve() = default;  ///< all zero
  explicit GlowCurve(double a);
  GlowShares at(double n_v) const;

  static constexpr int kSteps = 33;  ///< cosines from 0 to 1

 private:
  std::array<GlowShares, kSteps> shares_{};
};

/// Light as a factor on a surface's base colour, and what comes without it.
struct Reflection {
  double of_base = 0;
  double own = 0;

  Reflection& operator+=(const Reflection& more) {
    of_base += more.of_base;
    own += more.own;
    return *this;
  }
};

/// A surface's gloss.
struct Gloss {
  double metallic = 0;
  double roughness = 1;
};

/// What a distant light of `level` gives, which is the grey of a white Lambertian surface facing
/// it; cosines as above, and v_h that between the eye and the half-way direction.
Reflection reflected(const Gloss& gloss, double level, double n_l, double n_v, double n_h,
                     double v_h);

/// What comes back of light from all around, by the kind of reflection: of what falls on the
/// surface dully, and of what falls on the mirror of its gloss.
struct GlowParts {
  double dull_of_base = 0;
  double mirror_of_base = 0;
  double mirror_own = 0;
};
GlowParts glow_parts(const GlowShares& shares, double metallic);

/// What an even glow of `level` from all sides gives; a white surface that is no metal sends all of
/// it back.
Reflection reflected_glow(const Gloss& gloss, double level, double n_v);
/// The same, where the shares of the gloss's roughness are known.
Reflection reflected_shares(const GlowShares& shares, double metallic, double level);

}  // namespace sightline
