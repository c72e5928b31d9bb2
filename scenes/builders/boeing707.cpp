// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/builders/boeing707.h"

#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "pose/angles.h"
#include "scenes/builders/boeing707_fuselage.h"
#include "scenes/builders/solid.h"

namespace sightline {
namespace {

// Above the turn between neighbouring facets of a round surface (46 degrees at the leading edges of
// wing and tail), below every crease.
constexpr double kCreaseAngleRad = 55 * kDegree;

// Linear reflectances. Each part is either above 0.70 or below 0.12: the backgrounds' level of 0.15
// of white then lies between every shade of the light parts and of the dark ones.
constexpr double kWingAlbedo = 0.78;
constexpr double kOuterWingAlbedo = 0.80;
constexpr double kTailAlbedo = 0.82;
constexpr double kFinAlbedo = 0.88;
constexpr double kNacelleAlbedo = 0.76;
constexpr double kPylonAlbedo = 0.72;
constexpr double kDarkAlbedo = 0.05;

// Beyond 35 degrees the nose's own flank hides its tip, but shows an outline in its place.
constexpr double kNoseClearanceM = 0.5;
// Aft of this the windshield makes the outline hollow.
constexpr double kNoseReachM = 2.2;
// The centre of an intake lies in the open; the cowl around it is no farther.
constexpr double kNacelleClearanceM = 0.8;
constexpr double kNacelleReachM = 2.0;

Eigen::Vector3d along(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double t) {
  return a + t * (b - a);
}

double line_through(double x0, double y0, double x1, double y1, double x) {
  return y0 + (y1 - y0) * (x - x0) / (x1 - x0);
}

double wing_thickness_ratio(const Boeing707& d, double y_m) {
  const double tip_y_m = d.span_m / 2;
  if (y_m < d.wing_kink_y_m) {
    return line_through(d.wing_root_y_m, d.wing_root_thickness_ratio, d.wing_kink_y_m,
                        d.wing_kink_thickness_ratio, y_m);
  }
  return line_through(d.wing_kink_y_m, d.wing_kink_thickness_ratio, tip_y_m,
                      d.wing_tip_thickness_ratio, y_m);
}

void add_wing(Assembly& assembly, const Boeing707& d) {
  const int inner = assembly.add_part("wing_starboard_inner", kWingAlbedo);
  const int outer = assembly.add_part("wing_starboard_outer", kOuterWingAlbedo);
  const double tip_y_m = d.span_m / 2;
  const double kink_y_m = d.wing_kink_y_m;
  std::vector<AirfoilSection> sections;
  const auto add = [&](double y_m, double thickness_ratio) {
    sections.push_back({d.wing_leading_edge(y_m), d.wing_trailing_edge(y_m), thickness_ratio,
                        y_m <= kink_y_m ? inner : outer});
  };
  constexpr double kInsideFuselageM = 0.6;
  constexpr int kPanels = 4;
  for (const double y_m : {kInsideFuselageM, d.wing_root_y_m}) {
    add(y_m, d.wing_root_thickness_ratio);
  }
  for (const auto& [from_m, to_m] :
       {std::pair{d.wing_root_y_m, kink_y_m}, std::pair{kink_y_m, tip_y_m - d.tip_pinch_m}}) {
    for (int i = 1; i <= kPanels; ++i) {
      const double y_m = from_m + (to_m - from_m) * i / kPanels;
      add(y_m, wing_thickness_ratio(d, y_m));
    }
  }
  add(tip_y_m, 0);
  assembly.add(lifting_surface(sections, -Eigen::Vector3d::UnitZ(), Extent::kWhole));
}

void add_tailplane(Assembly& assembly, const Boeing707& d) {
  const int part = assembly.add_part("tailplane_starboard", kTailAlbedo);
  const double tip_y_m = d.tailplane_span_m / 2;
  constexpr double kInsideFuselageM = 0.12;
  std::vector<AirfoilSection> sections;
  for (const double y_m : {kInsideFuselageM, d.tailplane_root_y_m, d.tailplane_exposed_y_m, 3.0,
                           4.8, tip_y_m - d.tip_pinch_m, tip_y_m}) {
    sections.push_back({d.tailplane_leading_edge(y_m), d.tailplane_trailing_edge(y_m),
                        y_m == tip_y_m ? 0 : d.tail_thickness_ratio, part});
  }
  assembly.add(lifting_surface(sections, -Eigen::Vector3d::UnitZ(), Extent::kWhole));
}

void add_fin(Assembly& assembly, const Boeing707& d) {
  const int part = assembly.add_part("fin", kFinAlbedo);
  constexpr double kInsideFuselageM = 0.8;
  std::vector<AirfoilSection> sections;
  for (const double height_m : {kInsideFuselageM, d.fin_root_height_m, d.fin_fillet_height_m, 5.8,
                                7.4, d.fin_tip_height_m - d.tip_pinch_m, d.fin_tip_height_m}) {
    sections.push_back({d.fin_leading_edge(height_m), d.fin_trailing_edge(height_m),
                        height_m == d.fin_tip_height_m ? 0 : d.tail_thickness_ratio, part});
  }
  assembly.add(lifting_surface(sections, Eigen::Vector3d::UnitY(), Extent::kStarboardHalf));
}

// A thin swept blade from the crown of the fuselage to the fin's leading edge; its rear and its tip
// are hidden in the fin.
void add_dorsal_fillet(Assembly& assembly, const Boeing707& d) {
  const int part = assembly.add_part("dorsal_fillet", kFinAlbedo);
  const double foot_m = d.fin_root_height_m;
  const Eigen::Vector3d aft = d.point(0.5, 0, 0) - d.point(0, 0, 0);
  const Eigen::Vector3d front = d.point(d.fin_fillet_station_m, 0, foot_m);
  const Eigen::Vector3d top = d.fin_leading_edge(d.fin_fillet_height_m) + 0.3 * aft;
  const Eigen::Vector3d rear = d.fin_leading_edge(foot_m) + 5 * aft;
  constexpr int kPanels = 3;
  std::vector<AirfoilSection> sections;
  for (int i = 0; i <= kPanels; ++i) {
    const double t = static_cast<double>(i) / kPanels;
    sections.push_back({along(front, top, t), along(rear, top + 2 * aft, t),
                        i == kPanels ? 0 : 0.07 * (1 - 0.4 * t), part});
  }
  assembly.add(lifting_surface(sections, Eigen::Vector3d::UnitY(), Extent::kStarboardHalf));
}

struct NacellePaint {
  int cowl, intake, exhaust;
};

// From the intake's face round its lip, along the fan cowl, over the fan's nozzle to the core cowl
// and into the exhaust. Distances are aft of the lip.
std::vector<ProfilePoint> nacelle_profile(const Boeing707& d, const NacellePaint& paint) {
  const double fan = d.fan_cowl_radius_m;
  const double core = d.core_cowl_radius_m;
  const double end = d.nacelle_length_m;
  const int cowl = paint.cowl;
  return {
      {-0.25, 0, paint.intake},
      {-0.45, 0.20, paint.intake},
      {-0.55, 0.80 * fan, paint.intake},
      {-0.12, 0.80 * fan, paint.intake},
      {-0.03, 0.83 * fan, cowl},
      {0, 0.86 * fan, cowl},
      {-0.04, 0.895 * fan, cowl},
      {-0.14, 0.93 * fan, cowl},
      {-0.40, 0.975 * fan, cowl},
      {-0.80, fan, cowl},
      {-1.30, 0.995 * fan, cowl},
      {-1.85, 0.95 * fan, cowl},
      {-1.88, core * 1.04, paint.exhaust},
      {-2.50, core * 1.02, cowl},
      {-3.30, core, cowl},
      {-4.20, 0.92 * core, cowl},
      {-5.00, 0.79 * core, cowl},
      {-end, 0.62 * core, cowl},
      {-end + 0.04, 0.55 * core, paint.exhaust},
      {-end + 0.50, 0.50 * core, paint.exhaust},
      {-end + 0.15, 0, paint.exhaust},
  };
}

Eigen::Vector3d nacelle_front(const Boeing707& d, double y_m) {
  return d.wing_leading_edge(y_m) + Eigen::Vector3d(d.engine_ahead_m, 0, d.engine_below_m);
}

// From inside the nacelle up into the wing, a little aft of its leading edge.
Solid pylon(const Boeing707& d, double y_m, int part) {
  const Eigen::Vector3d front = nacelle_front(d, y_m);
  const Eigen::Vector3d leading = d.wing_leading_edge(y_m);
  const Eigen::Vector3d chord = d.wing_trailing_edge(y_m) - leading;
  const Eigen::Vector3d forward = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d up = -Eigen::Vector3d::UnitZ();
  const double fan_top = 0.9 * d.fan_cowl_radius_m;
  const std::vector<AirfoilSection> sections = {
      {front - 1.0 * forward, front - 5.3 * forward, 0.06, part},
      {front - 1.1 * forward + fan_top * up, front - 5.75 * forward + fan_top * up, 0.055, part},
      {leading - 0.04 * chord, leading + 0.45 * chord, 0.09, part},
  };
  return lifting_surface(sections, Eigen::Vector3d::UnitY(), Extent::kWhole);
}

void add_engine(Assembly& assembly, const Boeing707& d, int number, double y_m) {
  constexpr int kSegments = 24;
  const auto add_part = [&](const char* kind, double albedo) {
    return assembly.add_part(fmt::format("{}_{}", kind, number), albedo);
  };
  const NacellePaint paint{add_part("nacelle", kNacelleAlbedo), add_part("intake", kDarkAlbedo),
                           add_part("exhaust", kDarkAlbedo)};
  assembly.add(body_of_revolution(nacelle_front(d, y_m), nacelle_profile(d, paint), kSegments));
  assembly.add(pylon(d, y_m, add_part("pylon", kPylonAlbedo)));
}

// wing_starboard_inner -> wing_port_inner, nacelle_4 -> nacelle_1, fin -> fin.
std::string mirrored_part_name(std::string_view name) {
  std::string mirrored(name);
  constexpr std::string_view kStarboard = "starboard";
  if (const size_t at = mirrored.find(kStarboard); at != std::string::npos) {
    mirrored.replace(at, kStarboard.size(), "port");
  }
  if (mirrored.back() == '3') mirrored.back() = '2';
  if (mirrored.back() == '4') mirrored.back() = '1';
  return mirrored;
}

Eigen::Vector3d to_port(const Eigen::Vector3d& p) {
  return {p.x(), -p.y(), p.z()};
}

TargetFeature to_port(TargetFeature feature, std::string name) {
  feature.name = std::move(name);
  for (std::string& part : feature.parts) part = mirrored_part_name(part);
  feature.position_m = to_port(feature.position_m);
  for (Edge& edge : feature.edges) edge = {to_port(edge.begin_m), to_port(edge.end_m)};
  return feature;
}

// The same feature on either side, port first.
void add_pair(std::vector<TargetFeature>& features, const std::string& name,
              const Eigen::Vector3d& corner, const Eigen::Vector3d& end_a,
              const Eigen::Vector3d& end_b) {
  const TargetFeature starboard =
      line_intersection(name + "_starboard", corner, std::array{end_a, end_b});
  features.push_back(to_port(starboard, name + "_port"));
  features.push_back(starboard);
}

// The centres of the intakes, engine 1 (outboard, port) first.
void add_nacelle_fronts(std::vector<TargetFeature>& features, const Boeing707& d) {
  const auto front = [&](int number, double y_m) {
    return outlined_feature(fmt::format("nacelle_front_{}", number), FeatureKind::kContour,
                            nacelle_front(d, y_m), kNacelleClearanceM,
                            {fmt::format("nacelle_{}", number)}, kNacelleReachM);
  };
  const TargetFeature inboard = front(3, d.engine_y_m[0]);
  const TargetFeature outboard = front(4, d.engine_y_m[1]);
  features.push_back(to_port(outboard, "nacelle_front_1"));
  features.push_back(to_port(inboard, "nacelle_front_2"));
  features.push_back(inboard);
  features.push_back(outboard);
}

}  // namespace

Eigen::Vector3d Boeing707::point(double station_m, double starboard_m, double height_m) const {
  return {origin_station_m - station_m, starboard_m, -height_m};
}

Eigen::Vector3d Boeing707::nose() const {
  return point(0, 0, kNoseHeightM);
}

Eigen::Vector3d Boeing707::wing_leading_edge(double y_m) const {
  const double outboard_m = y_m - wing_root_y_m;
  return point(wing_root_station_m + outboard_m * wing_sweep_slope, y_m,
               wing_root_height_m + outboard_m * std::tan(wing_dihedral_deg * kDegree));
}

Eigen::Vector3d Boeing707::wing_trailing_edge(double y_m) const {
  const auto edge = [this](double at_y_m, double chord_m) {
    const Eigen::Vector3d leading = wing_leading_edge(at_y_m);
    return Eigen::Vector3d(leading.x() - chord_m, leading.y(), leading.z());
  };
  const Eigen::Vector3d kink = edge(wing_kink_y_m, wing_kink_chord_m);
  if (y_m <= wing_kink_y_m) {
    const Eigen::Vector3d root = edge(wing_root_y_m, wing_root_chord_m);
    return along(root, kink, (y_m - wing_root_y_m) / (wing_kink_y_m - wing_root_y_m));
  }
  const Eigen::Vector3d tip = edge(span_m / 2, wing_tip_chord_m);
  return along(kink, tip, (y_m - wing_kink_y_m) / (span_m / 2 - wing_kink_y_m));
}

Eigen::Vector3d Boeing707::tailplane_leading_edge(double y_m) const {
  const double t = (y_m - tailplane_root_y_m) / (tailplane_span_m / 2 - tailplane_root_y_m);
  return along(point(tailplane_root_station_m, tailplane_root_y_m, tailplane_root_height_m),
               point(tailplane_tip_station_m, tailplane_span_m / 2, tailplane_tip_height_m), t);
}

Eigen::Vector3d Boeing707::tailplane_trailing_edge(double y_m) const {
  const double t = (y_m - tailplane_root_y_m) / (tailplane_span_m / 2 - tailplane_root_y_m);
  const double chord_m =
      tailplane_root_chord_m + t * (tailplane_tip_chord_m - tailplane_root_chord_m);
  return tailplane_leading_edge(y_m) - chord_m * Eigen::Vector3d::UnitX();
}

Eigen::Vector3d Boeing707::fin_leading_edge(double height_m) const {
  const double t = (height_m - fin_root_height_m) / (fin_tip_height_m - fin_root_height_m);
  return along(point(fin_root_station_m, 0, fin_root_height_m),
               point(length_m - fin_tip_chord_m, 0, fin_tip_height_m), t);
}

Eigen::Vector3d Boeing707::fin_trailing_edge(double height_m) const {
  const double t = (height_m - fin_root_height_m) / (fin_tip_height_m - fin_root_height_m);
  return along(point(fin_root_station_m + fin_root_chord_m, 0, fin_root_height_m),
               point(length_m, 0, fin_tip_height_m), t);
}

Mesh build_boeing707(const Boeing707& dimensions) {
  Assembly assembly;
  add_fuselage(assembly, dimensions);
  add_wing(assembly, dimensions);
  add_tailplane(assembly, dimensions);
  add_fin(assembly, dimensions);
  add_dorsal_fillet(assembly, dimensions);
  add_engine(assembly, dimensions, 3, dimensions.engine_y_m[0]);
  add_engine(assembly, dimensions, 4, dimensions.engine_y_m[1]);
  Mesh mesh = assembly.mirrored(mirrored_part_name);
  compute_corner_normals(mesh, kCreaseAngleRad);
  return mesh;
}

std::vector<TargetFeature> boeing707_features(const Boeing707& d) {
  const double tip_y_m = d.span_m / 2;
  const double tail_y_m = d.tailplane_span_m / 2;
  const Eigen::Vector3d wing_le = d.wing_leading_edge(tip_y_m);
  const Eigen::Vector3d wing_te = d.wing_trailing_edge(tip_y_m);
  const Eigen::Vector3d kink = d.wing_trailing_edge(d.wing_kink_y_m);
  const Eigen::Vector3d tail_le = d.tailplane_leading_edge(tail_y_m);
  const Eigen::Vector3d tail_te = d.tailplane_trailing_edge(tail_y_m);
  const Eigen::Vector3d fin_le = d.fin_leading_edge(d.fin_tip_height_m);
  const Eigen::Vector3d fin_te = d.fin_trailing_edge(d.fin_tip_height_m);
  std::vector<TargetFeature> features;
  add_pair(features, "wing_tip_le", wing_le, d.wing_leading_edge(d.wing_root_y_m), wing_te);
  add_pair(features, "wing_tip_te", wing_te, kink, wing_le);
  std::swap(features[1], features[2]);  // p1 to p4: both corners of the port tip come first
  features.push_back(outlined_feature(
      "nose", FeatureKind::kCorner, d.nose(), kNoseClearanceM,
      {"nose_cone", "fuselage_upper", "cheat_line", "fuselage_belly"}, kNoseReachM));
  add_pair(features, "kink_te", kink, wing_te, d.wing_trailing_edge(d.wing_root_y_m));
  add_pair(features, "tailplane_tip_le", tail_le, d.tailplane_leading_edge(d.tailplane_exposed_y_m),
           tail_te);
  add_pair(features, "tailplane_tip_te", tail_te, d.tailplane_trailing_edge(d.tailplane_root_y_m),
           tail_le);
  features.push_back(line_intersection(
      "fin_tip_le", fin_le, std::array{d.fin_leading_edge(d.fin_fillet_height_m), fin_te}));
  features.push_back(line_intersection(
      "fin_tip_te", fin_te, std::array{d.fin_trailing_edge(d.fin_root_height_m), fin_le}));
  add_nacelle_fronts(features, d);
  return features;
}

BuiltTarget build_boeing707_target(const Boeing707& dimensions) {
  return {"boeing707",
          "Boeing 707-320B, gear up: a parametric model from published dimensions and estimates",
          build_boeing707(dimensions), boeing707_features(dimensions)};
}

}  // namespace sightline
