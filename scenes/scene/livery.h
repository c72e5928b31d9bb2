// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Paint on the main target: the keys of [livery].
#pragma once

#include <vector>

#include "scenes/scene/keys.h"

namespace sightline {

/// Paint on every surface of the main target: stripes across its x axis.
struct Livery {
  double contrast = 0;  ///< how much darker every other stripe is, of its part's albedo
  double stripe_m = 2;
};

/// What a file says of the paint. The defaults are those of a frame.
struct LiveryLaw {
  Range contrast = Livery{}.contrast;
  Range stripe_m = Livery{}.stripe_m;
};

std::vector<Key> keys_of(LiveryLaw& law, Livery& livery);

Livery draw_livery(LiveryLaw law, const Draws& draws);

/// What the truth states of the paint.
std::vector<Fact> facts_of(Livery livery);

}  // namespace sightline
