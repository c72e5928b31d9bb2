// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "scenes/builders/target_file.h"

namespace sightline {

/// The cube of the ORPE paper's numeric study: centred at the origin, each face its own part and
/// shade. Features vertex_0 to vertex_7: bits 0, 1, 2 of the number are set where x, y, z are
/// positive.
BuiltTarget build_cube(double edge_m = 1);

}  // namespace sightline
