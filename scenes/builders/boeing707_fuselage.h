// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "scenes/builders/boeing707.h"
#include "scenes/builders/solid.h"

namespace sightline {

constexpr double kNoseHeightM = -0.50;  ///< of the tip, above the fuselage's axis; estimate

/// A cross-section of the fuselage: heights above its axis, metres.
struct HullSection {
  double crown_m;
  double keel_m;
  double widest_m;

  /// The cosine of the angle from the crown over the side (90 degrees at the widest line) at which
  /// the hull has a height, the belly's fairing left out; beyond 1 above the crown.
  double cosine_at(double height_m) const {
    const double half_m = height_m > widest_m ? crown_m - widest_m : widest_m - keel_m;
    return half_m > 0 ? (height_m - widest_m) / half_m : 0;
  }
};

HullSection hull_section(const Boeing707& dimensions, double station_m);

/// Cosines of the angles from the crown between which the cheat line lies.
struct CheatLine {
  double upper;
  double lower;
};

CheatLine cheat_line();

/// Adds the starboard half of the fuselage with its painted parts.
void add_fuselage(Assembly& assembly, const Boeing707& dimensions);

}  // namespace sightline
