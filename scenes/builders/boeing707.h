// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "scenes/builders/target_file.h"

namespace sightline {

/// Dimensions of a Boeing 707-320B. A station is metres aft of the nose, a height is metres above
/// the fuselage's axis, which is the target's x axis. "Published" dimensions are those of the type
/// that reference works print; "estimate" is ours, chosen by eye for the look of the type.
struct Boeing707 {
  // The whole
  double length_m = 46.61;           ///< published: nose to the rear corner of the fin tip
  double span_m = 44.42;             ///< published
  double origin_station_m = 22.0;    ///< our choice
  double fuselage_length_m = 44.35;  ///< estimate
  double fuselage_width_m = 3.76;    ///< published
  // Wing
  double wing_root_y_m = 1.88;              ///< at the side of the fuselage
  double wing_root_station_m = 13.6;        ///< estimate: leading edge there
  double wing_root_height_m = -1.2;         ///< estimate
  double wing_root_chord_m = 10.33;         ///< estimate
  double wing_kink_y_m = 8.0;               ///< estimate: where the trailing edge bends
  double wing_kink_chord_m = 6.2;           ///< estimate
  double wing_tip_chord_m = 2.84;           ///< estimate
  double wing_sweep_slope = 0.759;          ///< leading edge; 35 degrees (published) at the quarter
                                            ///< chord of the outer wing
  double wing_dihedral_deg = 7.0;           ///< published
  double wing_root_thickness_ratio = 0.12;  ///< estimate, of the chord
  double wing_kink_thickness_ratio = 0.105;  ///< estimate
  double wing_tip_thickness_ratio = 0.09;    ///< estimate
  double tip_pinch_m = 0.35;  ///< our choice: wing, tailplane and fin thin out over this length
  // Tailplane
  double tailplane_span_m = 13.9;           ///< estimate
  double tailplane_root_y_m = 0.6;          ///< estimate
  double tailplane_root_station_m = 38.11;  ///< estimate
  double tailplane_root_chord_m = 5.6;      ///< estimate
  double tailplane_root_height_m = 0.9;     ///< estimate
  double tailplane_tip_station_m = 43.46;   ///< estimate
  double tailplane_tip_chord_m = 2.3;       ///< estimate
  double tailplane_tip_height_m = 1.7;      ///< estimate
  double tailplane_exposed_y_m = 1.25;      ///< its leading edge is outside the fuselage from here
  // Fin
  double fin_root_station_m = 36.6;    ///< estimate
  double fin_root_chord_m = 6.7;       ///< estimate
  double fin_root_height_m = 1.6;      ///< estimate
  double fin_tip_chord_m = 2.6;        ///< estimate
  double fin_tip_height_m = 9.3;       ///< published 12.93 above the ground, the axis 3.63 above it
  double fin_fillet_station_m = 33.0;  ///< estimate: where the dorsal fillet begins
  double fin_fillet_height_m = 4.1;    ///< estimate: where it meets the fin's leading edge
  double tail_thickness_ratio = 0.10;  ///< estimate, tailplane and fin
  // Engines: Pratt & Whitney JT3D turbofans
  std::array<double, 2> engine_y_m = {9.0, 15.2};  ///< estimate: inboard, outboard
  double engine_ahead_m = 4.1;       ///< estimate: intake lip ahead of the wing's leading edge
  double engine_below_m = 1.35;      ///< estimate: axis below the leading edge
  double nacelle_length_m = 5.9;     ///< estimate
  double fan_cowl_radius_m = 0.75;   ///< estimate
  double core_cowl_radius_m = 0.60;  ///< estimate
  // The belly under the wing: estimates
  double fairing_front_station_m = 8.5;
  double fairing_rear_station_m = 30.0;
  double fairing_exponent = 2.7;  ///< of the superelliptic section

  /// A point of the target's frame: x forward, y starboard, z down.
  Eigen::Vector3d point(double station_m, double starboard_m, double height_m) const;

  /// The tip of the nose, below the axis.
  Eigen::Vector3d nose() const;

  /// The edges of the starboard wing, in the dihedral plane, continued inside the fuselage.
  Eigen::Vector3d wing_leading_edge(double y_m) const;
  Eigen::Vector3d wing_trailing_edge(double y_m) const;
  Eigen::Vector3d tailplane_leading_edge(double y_m) const;
  Eigen::Vector3d tailplane_trailing_edge(double y_m) const;
  Eigen::Vector3d fin_leading_edge(double height_m) const;
  Eigen::Vector3d fin_trailing_edge(double height_m) const;
};

/// A Boeing 707-320B, gear up. The tips of wing, tailplane and fin are pinched to one straight
/// crease from the leading- to the trailing-edge corner, so that each corner is one vertex from
/// wherever it is seen.
Mesh build_boeing707(const Boeing707& dimensions = {});

/// The first five are p1 to p5 of the ORPE paper: the corners of the wing tips and the nose.
std::vector<TargetFeature> boeing707_features(const Boeing707& dimensions = {});

BuiltTarget build_boeing707_target(const Boeing707& dimensions = {});

}  // namespace sightline
