// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "scenes/random/random.h"

namespace sightline {

/// The range a quantity is drawn from, uniformly. A number is a range of no width.
struct Range {
  double min = 0;
  double max = 0;

  Range() = default;
  Range(double value) : min(value), max(value) {}
  Range(double low, double high) : min(low), max(high) {}

  double draw(RandomStream& stream) const { return stream.uniform(min, max); }
};

}  // namespace sightline
