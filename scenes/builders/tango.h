// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "scenes/builders/target_file.h"

namespace sightline {

/// Tango, the satellite of the PRISMA mission that the sets SPEED and SPEED+ show, in their axes
/// and with their eleven keypoints in their order: the four corners of the solar panel, the four of
/// the base, and the tips of three antennas (Park, Märtens, Lecuyer, Izzo, D'Amico: SPEED+, IEEE
/// Aerospace Conference 2022; the points as their baseline publishes them). What lies between the
/// keypoints is estimated: a box below a panel 20 mm thick with 18 x 9 solar cells, foil as a
/// surface of random tilts, straight rods.
BuiltTarget build_tango();

}  // namespace sightline
