// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/builders/boeing707_fuselage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "pose/angles.h"

namespace sightline {
namespace {

// Outline of the fuselage: a cross-section is half an ellipse above its widest line and half
// another below. Heights are above the fuselage axis. All rows are estimates, by eye.
struct Outline {
  double distance_m;    // from the tip of the nose or the tail
  double top_m;         // height of the crown
  double bottom_m;      // height of the keel
  double widest_m;      // height of the widest line
  double width_factor;  // of the greatest width
};

constexpr std::array<Outline, 13> kNose = {{
    {0, kNoseHeightM, kNoseHeightM, kNoseHeightM, 0},
    {0.3, -0.16, -0.81, -0.48, 0.175},
    {0.8, 0.17, -1.12, -0.45, 0.365},
    {1.4, 0.42, -1.37, -0.40, 0.525},
    {1.95, 0.62, -1.52, -0.34, 0.620},
    {2.45, 0.94, -1.64, -0.28, 0.700},
    {2.95, 1.28, -1.75, -0.22, 0.765},
    {3.6, 1.55, -1.86, -0.16, 0.830},
    {4.5, 1.76, -1.99, -0.10, 0.893},
    {6.0, 1.94, -2.14, -0.04, 0.955},
    {8.0, 2.03, -2.25, -0.01, 0.992},
    {10.0, 2.05, -2.28, 0, 1},
    {12.0, 2.05, -2.28, 0, 1},
}};

constexpr std::array<Outline, 11> kTail = {{
    {0, 0.98, 0.98, 0.98, 0},
    {0.2, 1.20, 0.75, 0.97, 0.115},
    {0.6, 1.35, 0.54, 0.94, 0.200},
    {1.5, 1.53, 0.22, 0.86, 0.315},
    {3.0, 1.71, -0.28, 0.70, 0.470},
    {5.0, 1.86, -0.88, 0.48, 0.650},
    {7.5, 1.97, -1.50, 0.25, 0.815},
    {10.0, 2.03, -1.94, 0.10, 0.925},
    {13.0, 2.05, -2.21, 0.02, 0.985},
    {16.0, 2.05, -2.28, 0, 1},
    {18.0, 2.05, -2.28, 0, 1},
}};

// Slope of a monotone cubic through three points (Fritsch and Butland 1984).
double monotone_slope(double before, double after) {
  if (before * after <= 0) return 0;
  return 2 * before * after / (before + after);
}

// Monotone cubic interpolation of one column of a table. The abscissa is the square root of the
// distance, so that the tip is round.
double interpolate(std::span<const Outline> table, double Outline::*column, double distance_m) {
  const auto x = [&](size_t i) { return std::sqrt(table[i].distance_m); };
  const auto y = [&](size_t i) { return table[i].*column; };
  const auto secant = [&](size_t i) { return (y(i + 1) - y(i)) / (x(i + 1) - x(i)); };
  const auto slope = [&](size_t i) {
    if (i == 0) return secant(0);
    if (i + 1 == table.size()) return secant(i - 1);
    return monotone_slope(secant(i - 1), secant(i));
  };
  const double at = std::min(std::sqrt(std::max(distance_m, 0.0)), x(table.size() - 1));
  size_t i = 0;
  while (i + 2 < table.size() && at > x(i + 1)) ++i;
  const double h = x(i + 1) - x(i);
  const double t = (at - x(i)) / h;
  const double u = 1 - t;
  return u * u * (1 + 2 * t) * y(i) + t * t * (3 - 2 * t) * y(i + 1) +
         h * t * u * (u * slope(i) - t * slope(i + 1));
}

Outline outline_at(const Boeing707& d, double station_m) {
  const double from_tail_m = d.fuselage_length_m - station_m;
  const bool is_nose = station_m < from_tail_m;
  const std::span<const Outline> table =
      is_nose ? std::span<const Outline>(kNose) : std::span<const Outline>(kTail);
  const double distance_m = is_nose ? station_m : from_tail_m;
  return {distance_m, interpolate(table, &Outline::top_m, distance_m),
          interpolate(table, &Outline::bottom_m, distance_m),
          interpolate(table, &Outline::widest_m, distance_m),
          interpolate(table, &Outline::width_factor, distance_m)};
}

double smoothstep(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// The belly fills out where it carries the wing: its section goes from an ellipse (exponent 2) to a
// superellipse, pushed outwards along rays from the middle of the widest line.
double fairing_factor(const Boeing707& d, double station_m, double angle_rad) {
  constexpr double kFadeM = 7;
  const double weight =
      smoothstep(d.fairing_front_station_m, d.fairing_front_station_m + kFadeM, station_m) *
      (1 - smoothstep(d.fairing_rear_station_m - kFadeM, d.fairing_rear_station_m, station_m));
  const double exponent = 2 + weight * (d.fairing_exponent - 2);
  const double c = std::pow(std::abs(std::cos(angle_rad)), exponent);
  const double s = std::pow(std::abs(std::sin(angle_rad)), exponent);
  return std::pow(c + s, -1 / exponent);
}

// The point of the hull at an angle from the crown (0) over starboard to the keel (180 degrees).
Eigen::Vector3d hull_point(const Boeing707& d, double station_m, double angle_rad) {
  const Outline o = outline_at(d, station_m);
  const double c = std::cos(angle_rad);
  const double half_width = o.width_factor * d.fuselage_width_m / 2;
  const double half_height = c > 0 ? o.top_m - o.widest_m : o.widest_m - o.bottom_m;
  const double factor = c > 0 ? 1 : fairing_factor(d, station_m, angle_rad);
  return d.point(station_m, factor * half_width * std::sin(angle_rad),
                 o.widest_m + factor * half_height * c);
}

// Lines along the hull, degrees from the crown: in the cabin, and at the sill and the brow of the
// windshield, where they bound its panes. The cheat line lies between lines 8 and 9.
using HullLines = std::array<double, 19>;
constexpr HullLines kCabinLines = {0,  9,   18,  27,  36,  45,  54,  63,    71.5, 82,
                                   90, 102, 113, 124, 135, 146, 157, 168.5, 180};
constexpr HullLines kSillLines = {0,  3,   18,  34,  37,  50,  53,  63,    71.5, 82,
                                  90, 102, 113, 124, 135, 146, 157, 168.5, 180};
constexpr HullLines kBrowLines = {0,  3,   16,  30,  33,  43,  46,  56,    71.5, 82,
                                  90, 102, 113, 124, 135, 146, 157, 168.5, 180};
constexpr int kCheatLine = 8;
constexpr int kBellyLine = 12;

// 1 around the cockpit, 0 in the nose cone and in the cabin.
double cockpit_weight(double station_m) {
  return smoothstep(1.3, 1.95, station_m) * (1 - smoothstep(2.9, 9.5, station_m));
}

// Where the windshield's sill and brow cross the crown, metres aft of the nose.
constexpr double kSillStationM = 1.95;
constexpr double kBrowStationM = 2.7;

double line_angle_rad(int line, double crown_station_m) {
  const double cockpit = cockpit_weight(crown_station_m);
  const double brow =
      std::clamp((crown_station_m - kSillStationM) / (kBrowStationM - kSillStationM), 0.0, 1.0);
  const double pane_deg = brow * kBrowLines[line] + (1 - brow) * kSillLines[line];
  return (cockpit * pane_deg + (1 - cockpit) * kCabinLines[line]) * kDegree;
}

// Around the cockpit the rings sweep aft towards the sides, along sill and brow of the windshield.
double swept_station_m(double crown_station_m, double angle_rad) {
  constexpr double kSweepM = 1.95;
  const double side = std::sin(angle_rad);
  return crown_station_m + kSweepM * cockpit_weight(crown_station_m) * side * side;
}

// Where the rings cross the crown, metres aft of the nose. The radome ends at ring kRadome; the
// windshield lies between rings kSill and kBrow. The first ring makes the tip of the nose a cone of
// some 50 degrees to its axis, so that the tip is still seen when the nose points 35 degrees away.
constexpr int kRadome = 5;
constexpr int kSill = 7;
constexpr int kBrow = 9;
constexpr int kCheatStart = 7;

std::vector<double> ring_stations_m(const Boeing707& d) {
  std::vector<double> stations = {0,    0.22,          0.45, 0.75,          1.05, 1.35,
                                  1.65, kSillStationM, 2.3,  kBrowStationM, 3.1,  3.6,
                                  4.2,  5.0,           6.2,  8.0,           10};
  const std::array<double, 15> from_tail = {15,  13,  11.2, 9.5, 7.9,  6.4,  5.0, 3.8,
                                            2.8, 1.9, 1.2,  0.6, 0.25, 0.07, 0};
  const double cabin_end_m = d.fuselage_length_m - 17.5;
  constexpr int kCabinRings = 11;
  for (int i = 1; i <= kCabinRings; ++i) {
    stations.push_back(10 + (cabin_end_m - 10) * i / kCabinRings);
  }
  for (const double distance_m : from_tail) stations.push_back(d.fuselage_length_m - distance_m);
  return stations;
}

struct FuselagePaint {
  int nose_cone, upper, windows, cheat_line, belly, tail_cone;
};

bool is_pane(int ring, int line) {
  const bool is_post = line == 0 || line == 3 || line == 5;
  return ring >= kSill && ring < kBrow && line <= 6 && !is_post;
}

// Paint between a ring and the next, a line and the next.
int paint_of(const FuselagePaint& paint, int ring, int ring_count, int line) {
  constexpr int kTailConeRings = 5;
  constexpr int kCheatEndRings = 8;  // where the tailplane hides its end
  if (ring < kRadome) return paint.nose_cone;
  if (ring + 1 >= ring_count - kTailConeRings) return paint.tail_cone;
  if (is_pane(ring, line)) return paint.windows;
  const bool has_cheat_line = ring >= kCheatStart && ring < ring_count - kCheatEndRings;
  if (line == kCheatLine && has_cheat_line) return paint.cheat_line;
  return line < kBellyLine ? paint.upper : paint.belly;
}

Solid hull(const Boeing707& d, const FuselagePaint& paint) {
  Solid solid;
  const std::vector<double> stations = ring_stations_m(d);
  const int ring_count = static_cast<int>(stations.size());
  Row before;
  for (int ring = 0; ring < ring_count; ++ring) {
    Row row;
    if (ring == 0 || ring == ring_count - 1) {
      row.assign(kCabinLines.size(), solid.add_vertex(hull_point(d, stations[ring], 0)));
    } else {
      for (int line = 0; line < static_cast<int>(kCabinLines.size()); ++line) {
        const double angle_rad = line_angle_rad(line, stations[ring]);
        const double station_m = swept_station_m(stations[ring], angle_rad);
        row.push_back(solid.add_vertex(hull_point(d, station_m, angle_rad)));
      }
    }
    if (ring > 0) {
      solid.add_strip(before, row,
                      [&](int line) { return paint_of(paint, ring - 1, ring_count, line); });
    }
    before = std::move(row);
  }
  solid.orient_outwards();
  return solid;
}

}  // namespace

HullSection hull_section(const Boeing707& dimensions, double station_m) {
  const Outline o = outline_at(dimensions, station_m);
  return {o.top_m, o.bottom_m, o.widest_m};
}

CheatLine cheat_line() {
  return {std::cos(kCabinLines[kCheatLine] * kDegree),
          std::cos(kCabinLines[kCheatLine + 1] * kDegree)};
}

void add_fuselage(Assembly& assembly, const Boeing707& dimensions) {
  FuselagePaint paint{};
  paint.nose_cone = assembly.add_part("nose_cone", 0.72);
  paint.upper = assembly.add_part("fuselage_upper", 0.90);
  paint.windows = assembly.add_part("cockpit_windows", 0.04);
  paint.cheat_line = assembly.add_part("cheat_line", 0.08);
  paint.belly = assembly.add_part("fuselage_belly", 0.74);
  paint.tail_cone = assembly.add_part("tail_cone", 0.76);
  assembly.add(hull(dimensions, paint));
}

}  // namespace sightline
