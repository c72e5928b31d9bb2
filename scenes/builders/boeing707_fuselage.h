// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "scenes/builders/boeing707.h"
#include "scenes/builders/solid.h"

namespace sightline {

constexpr double kNoseHeightM = -0.50;  ///< of the tip, above the fuselage's axis; estimate

/// Adds the starboard half of the fuselage with its painted parts.
void add_fuselage(Assembly& assembly, const Boeing707& dimensions);

}  // namespace sightline
