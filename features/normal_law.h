// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// How much of a Gaussian falls to one side of an edge, and of an edge that ends: by tables, for
// fits that ask it of every pixel.
#pragma once

#include <algorithm>
#include <array>

namespace sightline {

/// The normal law's cumulative and density, by linear interpolation to 1e-5.
class NormalLaw {
 public:
  struct Value {
    double cumulative, density;
  };

  NormalLaw();

  Value at(double z) const {
    const double x = std::clamp((z + kReach) * kPerUnit, 0.0, kSize - 1.001);
    const int i = static_cast<int>(x);
    const double part = x - i;
    const Value& a = values_[i];
    const Value& b = values_[i + 1];
    return {a.cumulative + part * (b.cumulative - a.cumulative),
            a.density + part * (b.density - a.density)};
  }

 private:
  static constexpr int kReach = 6;
  static constexpr double kPerUnit = 64;
  static constexpr int kSize = 2 * kReach * 64 + 1;
  std::array<Value, kSize> values_;
};

/// The one table of it.
const NormalLaw& normal_law();

/// Owen's T(d, t / d) (Ann. Math. Stat. 27, 1956) for d >= 0, to 1e-4: the mass of a unit Gaussian
/// beyond a line at distance d from its centre, between the line's foot and the direction to its
/// point t along. Odd in t.
double owens_t(double d, double t);

}  // namespace sightline
