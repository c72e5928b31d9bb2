// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/builders/boeing707_livery.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "scenes/builders/boeing707_fuselage.h"
#include "scenes/builders/painting.h"

namespace sightline {
namespace {

// Inks are factors on the albedos of the parts, which stay those of the plain target.
const Ink kWhite{1, 1, 1};
const Ink kBlue{0.107, 0.292, 0.743};  // on fuselage_upper as the part cheat_line is
const Ink kGold{1, 0.80, 0.25};
const Ink kGlass{0.16, 0.18, 0.22};
const Ink kDark{0.25, 0.27, 0.32};
const Ink kLine{0.50, 0.51, 0.54};   // around what opens
const Ink kMetal{0.84, 0.85, 0.88};  // bare
constexpr double kLineM = 0.05;
constexpr double kSeam = 0.88;  // how bright a joint of panels is
constexpr double kSeamM = 0.04;

constexpr std::string_view kTitle = "SIGHTLINE";
constexpr std::string_view kRegistration = "SL-707";

constexpr int kTextureWidth = 2048;
constexpr int kTextureHeight = 1024;
constexpr int kPadding = 6;  // texels around a chart that are painted as it goes on

enum ChartName {
  kPortSide,  // of the fuselage: metres aft of the nose, and below the axis
  kStarboardSide,
  kFinSide,
  kUpperPort,  // of a wing: metres from the middle, and aft of the leading edge
  kUpperStarboard,
  kLowerPort,
  kLowerStarboard,
  kTailplane,  // alike, both sides and both halves
  kNacelle,    // metres aft of the lip, and below the engine's axis
  kChartCount,
};

// A rectangle of the texture, on which a part of the target lies flat.
struct Chart {
  Eigen::Vector2d corner_px;  // its upper left
  Eigen::Vector2d corner_m;   // what lies there
  Eigen::Vector2d size_m;
  double px_per_m;
  bool is_mirrored = false;  // its first coordinate runs to the left

  Eigen::Vector2d texture_px(const Eigen::Vector2d& at_m) const {
    Eigen::Vector2d px = px_per_m * (at_m - corner_m);
    if (is_mirrored) px.x() = px_per_m * size_m.x() - px.x();
    return corner_px + px;
  }
  Eigen::Vector2d at_m(const Eigen::Vector2d& texture_px) const {
    Eigen::Vector2d m = (texture_px - corner_px) / px_per_m;
    if (is_mirrored) m.x() = size_m.x() - m.x();
    return corner_m + m;
  }
};

constexpr double kSidePxPerM = 43.5;
constexpr double kWingPxPerM = 24;
constexpr double kTailPxPerM = 40;

const std::array<Chart, kChartCount>& charts() {
  const Eigen::Vector2d side_corner(-0.05, -2.3), side(46.7, 4.75);
  const Eigen::Vector2d wing_corner(0.5, -0.1), wing(21.8, 11.4);
  static const std::array<Chart, kChartCount> kCharts = {{
      {{8, 8}, side_corner, side, kSidePxPerM},
      {{8, 228}, side_corner, side, kSidePxPerM, true},
      {{8, 450}, {32.8, -9.4}, {13.95, 8.7}, kTailPxPerM},
      {{584, 450}, wing_corner, wing, kWingPxPerM, true},
      {{1124, 450}, wing_corner, wing, kWingPxPerM},
      {{584, 740}, wing_corner, wing, kWingPxPerM},
      {{1124, 740}, wing_corner, wing, kWingPxPerM, true},
      {{1670, 450}, {0.1, -0.1}, {7, 6}, kTailPxPerM},
      {{1670, 710}, {-0.05, -0.85}, {6.05, 1.7}, kTailPxPerM},
  }};
  return kCharts;
}

using Painter = std::function<Ink(const Eigen::Vector2d& at_m)>;

// Neighbouring panels are not of one shade.
double panel_tone(int i, int j) {
  return 1 - 0.008 * ((i * 5 + j * 3 + 70) % 7);
}

// To the nearest of lines that stand `pitch` apart.
double comb_distance(double at, double first, double pitch, double width) {
  return border_distance(at - first - pitch * std::round((at - first) / pitch), width);
}

// Gold sweeps up from the tail over the fin, a blue band before it.
Ink tail_ink(double texel_m, double station_m, double height_m) {
  const double aft_m = (station_m - 36.6 + 0.9 * (height_m - 2.05)) / std::sqrt(1 + 0.9 * 0.9);
  return Texel(texel_m, kWhite)
      .cover(-0.9 - aft_m, kBlue)
      .cover(-aft_m, kWhite)
      .cover(0.25 - aft_m, kGold)
      .ink();
}

// Windows, doors and letters lie on lines that follow the hull; their heights are those in the
// cabin.
class SidePaint {
 public:
  SidePaint(const Boeing707& d, const Chart& chart, bool is_port)
      : chart_(chart), is_port_(is_port) {
    const int columns = static_cast<int>(chart.size_m.x() * chart.px_per_m) + 2 * kPadding + 2;
    for (int i = 0; i < columns; ++i) {
      const double station_m = chart.corner_m.x() + (i - kPadding) / chart.px_per_m;
      sections_.push_back(hull_section(d, std::clamp(station_m, 0.0, d.fuselage_length_m)));
    }
    crown_m_ = hull_section(d, d.fuselage_length_m / 2).crown_m;
    cheat_ = {cheat_line().upper * crown_m_, cheat_line().lower * crown_m_};
  }

  Ink operator()(const Eigen::Vector2d& at_m) const {
    const double texel_m = 1 / chart_.px_per_m;
    const double station_m = at_m.x();
    const double level_m = section(station_m).cosine_at(-at_m.y()) * crown_m_;
    Texel texel(texel_m, tail_ink(texel_m, station_m, -at_m.y()));
    add_seams(texel, station_m, level_m);
    add_stripes(texel, station_m, level_m);
    add_openings(texel, station_m, level_m);
    add_words(texel, station_m, level_m);
    return texel.ink();
  }

 private:
  const HullSection& section(double station_m) const {
    const double column = (station_m - chart_.corner_m.x()) * chart_.px_per_m + kPadding;
    const auto i = std::clamp(std::lround(column), 0L, static_cast<long>(sections_.size()) - 1);
    return sections_[static_cast<size_t>(i)];
  }

  static void add_seams(Texel& texel, double station_m, double level_m) {
    texel.shade(comb_distance(station_m, 3.0, 3.2, kSeamM), kSeam);
    texel.shade(border_distance(level_m - 1.2, kSeamM), kSeam);
    texel.shade(border_distance(level_m + 0.5, kSeamM), kSeam);
  }

  // The cheat line is a part of its own, but for its ends.
  void add_stripes(Texel& texel, double station_m, double level_m) const {
    const double rear_m = station_m - 38.5;
    const Eigen::Vector2d at(station_m, level_m);
    texel.cover(box_distance(at, {-1, cheat_.lower}, {39.5, cheat_.upper}), kBlue);
    texel.cover(std::max(rear_m, box_distance(at, {-1, 0.06}, {39, 0.18})), kGold);
  }

  static void add_openings(Texel& texel, double station_m, double level_m) {
    constexpr double kFirstM = 7.2, kPitchM = 0.508, kLastM = 35.0;
    const double number = std::round((std::clamp(station_m, kFirstM, kLastM) - kFirstM) / kPitchM);
    const Eigen::Vector2d from_window(station_m - kFirstM - number * kPitchM, level_m - 0.94);
    const Eigen::Vector2d half(0.10, 0.15);
    texel.cover(box_distance(from_window, -half, half) - 0.02, kGlass);
    const Eigen::Vector2d at(station_m, level_m);
    for (const double left_m : {5.6, 35.6}) {
      const double door = box_distance(at, {left_m, -0.72}, {left_m + 0.86, 1.16});
      texel.cover(border_distance(door, kLineM), kLine);
      texel.cover(disc_distance(at, {left_m + 0.43, 0.9}, 0.1), kGlass);
    }
    for (const double left_m : {17.72, 19.75}) {  // over the wing, around a window each
      const double exit = box_distance(at, {left_m, 0.68}, {left_m + 0.5, 1.4});
      texel.cover(border_distance(exit, kLineM), kLine);
    }
  }

  // Words are read from the left on both sides.
  void add_words(Texel& texel, double station_m, double level_m) const {
    const auto add = [&](std::string_view word, double first_m, double base_m, double height_m,
                         const Ink& ink) {
      const double length_m = word_length(word, height_m);
      const double along_m = is_port_ ? station_m - first_m : first_m + length_m - station_m;
      texel.cover(word_distance({along_m, -level_m}, word, {0, -base_m}, height_m), ink);
    };
    add(kTitle, 8.4, 1.27, 0.56, kBlue);
    add(kRegistration, 31.2, -0.44, 0.34, kDark);
  }

  Chart chart_;
  bool is_port_;
  double crown_m_;
  CheatLine cheat_;
  std::vector<HullSection> sections_;
};

// A ring sight.
void add_mark(Texel& texel, const Eigen::Vector2d& at, double radius_m, const Ink& ground) {
  const double off = at.norm();
  texel.cover(off - radius_m, kWhite);
  texel.cover(border_distance(off - 0.66 * radius_m, 0.2 * radius_m), kBlue);
  const double bar = 0.07 * radius_m;
  const double cross = std::min(std::abs(at.x()), std::abs(at.y())) - bar;
  texel.cover(std::max({cross, 0.3 * radius_m - off, off - 0.95 * radius_m}), kBlue);
  texel.cover(off - 0.14 * radius_m, ground);
}

Ink fin_ink(const Boeing707& d, const Eigen::Vector2d& at_m) {
  constexpr double kTexelM = 1 / kTailPxPerM;
  const double station_m = at_m.x(), height_m = -at_m.y();
  Texel texel(kTexelM, tail_ink(kTexelM, station_m, height_m));
  const auto station_of = [&](const Eigen::Vector3d& p) { return d.origin_station_m - p.x(); };
  const double aft_m = station_m - station_of(d.fin_leading_edge(height_m));
  const double chord_m = station_of(d.fin_trailing_edge(height_m)) - station_m + aft_m;
  const double share = aft_m / chord_m;
  const double in_height = std::max(2.3 - height_m, height_m - 9.0);
  texel.cover(std::max(border_distance(aft_m - 0.15, 0.3), in_height), kMetal);
  texel.shade(std::max(border_distance((share - 0.7) * chord_m, kLineM), in_height), 0.6);
  for (const double hinge_m : {2.3, 5.4, 9.0}) {
    texel.shade(std::max(border_distance(height_m - hinge_m, kLineM), (0.7 - share) * chord_m),
                0.7);
  }
  const double middle_m = 5.5;
  const double front_m = station_of(d.fin_leading_edge(middle_m));
  const double rear_m = station_of(d.fin_trailing_edge(middle_m));
  add_mark(texel, {station_m - front_m - 0.37 * (rear_m - front_m), height_m - middle_m}, 1.25,
           kGold);
  return texel.ink();
}

// Panels of a wing or tailplane between ribs, and what moves at its rear: from inboard to outboard,
// metres, and the share of the chord where it begins.
struct Flap {
  double from_m;
  double to_m;
  double share;
};

struct SurfacePaint {
  double px_per_m;
  double rib_pitch_m;
  double metal_m;  // along the leading edge
  std::vector<Flap> flaps;
};

Texel surface_texel(const SurfacePaint& paint, double out_m, double aft_m, double chord_m) {
  const double share = aft_m / chord_m;
  const int rib = static_cast<int>(std::floor(out_m / paint.rib_pitch_m));
  const int band = static_cast<int>(std::floor(share * 4));
  Texel texel(1 / paint.px_per_m, kWhite * panel_tone(rib, band));
  texel.shade(comb_distance(out_m, 0, paint.rib_pitch_m, kSeamM), kSeam);
  for (const double spar : {0.15, 0.42}) {
    texel.shade(border_distance((share - spar) * chord_m, kSeamM), kSeam);
  }
  texel.cover(aft_m - paint.metal_m, kMetal);
  for (const Flap& flap : paint.flaps) {
    const double inside =
        std::max({flap.from_m - out_m, out_m - flap.to_m, (flap.share - share) * chord_m});
    texel.shade(border_distance(inside, 0.07), 0.6);
  }
  return texel;
}

double wing_chord_m(const Boeing707& d, double out_m) {
  return d.wing_leading_edge(out_m).x() - d.wing_trailing_edge(out_m).x();
}

Ink wing_ink(const Boeing707& d, bool is_upper, bool has_word, const Eigen::Vector2d& at_m) {
  static const SurfacePaint kPaint{
      kWingPxPerM,
      2.3,
      0.3,
      {{2.2, 7.6, 0.76}, {7.8, 9.4, 0.72}, {9.6, 14.8, 0.74}, {15.2, 21.0, 0.78}}};
  const double out_m = at_m.x(), aft_m = at_m.y();
  const double chord_m = wing_chord_m(d, out_m);
  const double share = aft_m / chord_m;
  Texel texel = surface_texel(kPaint, out_m, aft_m, chord_m);
  if (is_upper) {
    for (const Flap& spoilers : {Flap{2.6, 7.2, 0.62}, Flap{9.8, 14.4, 0.6}}) {
      const double inside =
          std::max({spoilers.from_m - out_m, out_m - spoilers.to_m,
                    (spoilers.share - share) * chord_m, (share - spoilers.share - 0.09) * chord_m});
      texel.shade(border_distance(inside, 0.06), 0.7);
    }
    const double walk =
        std::max({-out_m, out_m - 7.4, (0.2 - share) * chord_m, (share - 0.56) * chord_m});
    texel.cover(border_distance(walk, 0.12), kDark);
  } else {
    const Eigen::Vector2d lid(out_m - 0.8 * std::round(out_m / 0.8), (share - 0.36) * chord_m);
    const double in_tank = std::max(2.4 - out_m, out_m - 20.4);
    texel.shade(std::max(in_tank, box_distance(lid, {-0.2, -0.12}, {0.2, 0.12})), 0.72);
  }
  if (has_word) {  // below between the engines
    const Eigen::Vector2d base = is_upper ? Eigen::Vector2d(11.2, 2.75) : Eigen::Vector2d(9.9, 2.6);
    texel.cover(word_distance(at_m, kRegistration, base, is_upper ? 1.3 : 0.95), kBlue);
  }
  return texel.ink();
}

Ink tailplane_ink(const Boeing707& d, const Eigen::Vector2d& at_m) {
  static const SurfacePaint kPaint{kTailPxPerM, 1.5, 0.2, {{1.3, 6.5, 0.7}}};
  const double chord_m =
      d.tailplane_leading_edge(at_m.x()).x() - d.tailplane_trailing_edge(at_m.x()).x();
  return surface_texel(kPaint, at_m.x(), at_m.y(), chord_m).ink();
}

Ink nacelle_ink(const Eigen::Vector2d& at_m) {
  constexpr double kFanEndM = 1.86;
  const double aft_m = at_m.x();
  Texel texel(1 / kTailPxPerM, kWhite);
  texel.cover(kFanEndM - aft_m, kMetal);
  texel.cover(box_distance(at_m, {0.45, -0.16}, {kFanEndM, 0.06}), kBlue);
  texel.cover(box_distance(at_m, {0.45, 0.11}, {kFanEndM, 0.17}), kGold);
  texel.cover(aft_m - 0.22, kMetal);
  for (const double seam_m : {0.22, 1.1, 3.3, 4.6}) {
    texel.shade(border_distance(aft_m - seam_m, kLineM), 0.75);
  }
  texel.shade(kFanEndM + 1.2 - aft_m, 0.9);  // where it is hot
  return texel.ink();
}

std::array<Painter, kChartCount> painters(const Boeing707& d) {
  const auto wing = [&d](bool is_upper, bool has_word) {
    return [&d, is_upper, has_word](const Eigen::Vector2d& at_m) {
      return wing_ink(d, is_upper, has_word, at_m);
    };
  };
  return {SidePaint(d, charts()[kPortSide], true),
          SidePaint(d, charts()[kStarboardSide], false),
          [&d](const Eigen::Vector2d& at_m) { return fin_ink(d, at_m); },
          wing(true, false),
          wing(true, true),
          wing(false, true),
          wing(false, false),
          [&d](const Eigen::Vector2d& at_m) { return tailplane_ink(d, at_m); },
          nacelle_ink};
}

void paint_chart(Texture& texture, const Chart& chart, const Painter& painter) {
  const auto range = [](double corner_px, double size_px, int limit) {
    return std::pair{std::max(0, static_cast<int>(corner_px) - kPadding),
                     std::min(limit, static_cast<int>(corner_px + size_px) + 1 + kPadding)};
  };
  const Eigen::Vector2d size_px = chart.px_per_m * chart.size_m;
  const auto [left, right] = range(chart.corner_px.x(), size_px.x(), texture.width);
  const auto [top, bottom] = range(chart.corner_px.y(), size_px.y(), texture.height);
  for (int v = top; v < bottom; ++v) {
    for (int u = left; u < right; ++u) {
      const Ink ink = painter(chart.at_m({u + 0.5, v + 0.5}));
      uint8_t* texel = texture.rgba.data() + 4 * (static_cast<size_t>(v) * texture.width + u);
      for (int c = 0; c < 3; ++c) texel[c] = static_cast<uint8_t>(std::lround(255 * ink[c]));
    }
  }
}

std::shared_ptr<const Texture> livery_texture(const Boeing707& d) {
  Texture texture{.name = "livery", .width = kTextureWidth, .height = kTextureHeight, .rgba = {}};
  texture.rgba.assign(size_t{4} * kTextureWidth * kTextureHeight, 255);
  const std::array<Painter, kChartCount> paint = painters(d);
  for (size_t i = 0; i < paint.size(); ++i) paint_chart(texture, charts()[i], paint[i]);
  return std::make_shared<const Texture>(std::move(texture));
}

// Lays the texture on the mesh.
class Wrapping {
 public:
  Wrapping(const Boeing707& d, const Mesh& mesh) : d_(d), mesh_(mesh) {
    boxes_.resize(mesh.parts.size());
    for (const Triangle& triangle : mesh.triangles) {
      for (const int v : triangle.vertex) boxes_[triangle.part].extend(mesh.vertices[v]);
    }
  }

  static bool is_painted(std::string_view part) {
    constexpr std::array kBare = {"cheat_line", "cockpit", "intake", "exhaust", "pylon"};
    return std::none_of(kBare.begin(), kBare.end(),
                        [&](std::string_view bare) { return part.starts_with(bare); });
  }

  Coat coat(const Triangle& triangle) const {
    Coat coat;
    if (!is_painted(mesh_.parts[triangle.part].name)) return coat;
    const ChartName name = chart_of(triangle);
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector2d px =
          charts()[name].texture_px(place(name, triangle.part, mesh_.vertices[triangle.vertex[c]]));
      coat.uv[c] = {static_cast<float>(px.x() / kTextureWidth),
                    static_cast<float>(px.y() / kTextureHeight)};
    }
    return coat;
  }

 private:
  ChartName chart_of(const Triangle& triangle) const {
    const std::string_view part = mesh_.parts[triangle.part].name;
    double starboard_m = 0;
    for (const int v : triangle.vertex) starboard_m += mesh_.vertices[v].y();
    const bool is_port = starboard_m < 0;
    if (part == "fin" || part == "dorsal_fillet") return kFinSide;
    if (part.starts_with("tailplane")) return kTailplane;
    if (part.starts_with("nacelle")) return kNacelle;
    if (!part.starts_with("wing")) return is_port ? kPortSide : kStarboardSide;
    const bool is_upper = face_normal(mesh_, triangle).z() < 0;
    if (is_upper) return is_port ? kUpperPort : kUpperStarboard;
    return is_port ? kLowerPort : kLowerStarboard;
  }

  Eigen::Vector2d place(ChartName chart, int part, const Eigen::Vector3d& p) const {
    const double out_m = std::abs(p.y());
    switch (chart) {
      case kTailplane:
        return {out_m, d_.tailplane_leading_edge(out_m).x() - p.x()};
      case kNacelle:
        return {boxes_[part].max().x() - p.x(), p.z() - boxes_[part].center().z()};
      case kPortSide:
      case kStarboardSide:
      case kFinSide:
        return {d_.origin_station_m - p.x(), p.z()};
      default:
        return {out_m, d_.wing_leading_edge(out_m).x() - p.x()};
    }
  }

  const Boeing707& d_;
  const Mesh& mesh_;
  std::vector<Eigen::AlignedBox3d> boxes_;  // of the parts
};

// Semi-gloss paint, bare metal and glass; the luminance of each is the albedo of the plain part.
Material material_of(const Part& part) {
  Material material;
  material.has_gloss = true;
  material.roughness = 0.4;
  material.base = {part.albedo, part.albedo, part.albedo, 1};
  const auto tint = [&](double red, double blue) {
    constexpr double kRed = 0.2126, kGreen = 0.7152, kBlueShare = 0.0722;  // Rec. 709
    material.base = {red, (part.albedo - kRed * red - kBlueShare * blue) / kGreen, blue, 1};
  };
  if (part.name == "cheat_line") tint(0.010, 0.46);
  if (part.name == "fuselage_belly") tint(0.71, 0.80);
  if (part.name == "cockpit_windows") material.roughness = 0.15;
  if (Wrapping::is_painted(part.name)) {
    material.base_texture = {.texture = 0, .wrap_u = Wrap::kClamp, .wrap_v = Wrap::kClamp};
  }
  return material;
}

}  // namespace

BuiltTarget build_boeing707_livery_target(const Boeing707& dimensions) {
  BuiltTarget target = build_boeing707_target(dimensions);
  target.name = "boeing707_livery";
  target.description =
      "The Boeing 707 in a livery of our own as a texture: same shape, parts and features as "
      "boeing707";
  Mesh& mesh = target.mesh;
  const Wrapping wrapping(dimensions, mesh);
  for (const Triangle& triangle : mesh.triangles) mesh.coats.push_back(wrapping.coat(triangle));
  for (Part& part : mesh.parts) part.material = material_of(part);
  mesh.textures.push_back(livery_texture(dimensions));
  return target;
}

}  // namespace sightline
