// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/livery.h"

namespace sightline {

std::vector<Key> keys_of(LiveryLaw& law, Livery& livery) {
  return {
      {"livery",
       "contrast",
       &law.contrast,
       {0, 1},
       "",
       "how much darker every other stripe across the target's x axis is, of its part's albedo",
       &livery.contrast},
      {"livery",
       "stripe_m",
       &law.stripe_m,
       {1e-6, 1e6},
       "m",
       "width of a stripe",
       &livery.stripe_m},
  };
}

Livery draw_livery(LiveryLaw law, const Draws& draws) {
  Livery livery;
  draw_keys(keys_of(law, livery), draws);
  return livery;
}

std::vector<Fact> facts_of(Livery livery) {
  LiveryLaw law;
  return facts_of(keys_of(law, livery));
}

}  // namespace sightline
