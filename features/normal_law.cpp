// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/normal_law.h"

#include <cmath>
#include <numbers>

namespace sightline {
namespace {

// Beyond it a Gaussian has nothing left: 3e-6.
constexpr double kFar = 4.5;

// The mass of a unit Gaussian over the right triangle with one corner at its centre, whose legs d
// and t meet in a right angle: atan(t / d) / 2 pi - T(d, t / d). Unlike both it is smooth.
class TriangleMass {
 public:
  TriangleMass() {
    for (int i = 0; i < kSize; ++i) {
      const double d = i * kStep;
      double mass = 0;
      for (int k = 0; k < kSize; ++k) {
        mass_[i][k] = static_cast<float>(mass);
        const double t = k * kStep;
        // Simpson's rule.
        mass += kStep / 6 * (by_t(d, t) + 4 * by_t(d, t + kStep / 2) + by_t(d, t + kStep));
      }
    }
  }

  double at(double d, double t) const {
    const double x = std::min(d / kStep, kSize - 1.001);
    const double y = std::min(t / kStep, kSize - 1.001);
    const int i = static_cast<int>(x);
    const int k = static_cast<int>(y);
    const double p = x - i;
    const double q = y - k;
    return (1 - p) * ((1 - q) * mass_[i][k] + q * mass_[i][k + 1]) +
           p * ((1 - q) * mass_[i + 1][k] + q * mass_[i + 1][k + 1]);
  }

 private:
  static constexpr double kStep = 1.0 / 16;
  static constexpr int kSize = 97;

  static double by_t(double d, double t) {
    const double squares = d * d + t * t;
    return squares == 0 ? 0 : d / squares * -std::expm1(-squares / 2) / (2 * std::numbers::pi);
  }

  std::array<std::array<float, kSize>, kSize> mass_;
};

}  // namespace

NormalLaw::NormalLaw() {
  for (int i = 0; i < kSize; ++i) {
    const double z = i / kPerUnit - kReach;
    values_[i] = {0.5 * std::erfc(-z / std::numbers::sqrt2),
                  std::exp(-0.5 * z * z) * (std::numbers::inv_sqrtpi / std::numbers::sqrt2)};
  }
}

const NormalLaw& normal_law() {
  static const NormalLaw law;
  return law;
}

double owens_t(double d, double t) {
  static const TriangleMass kMass;
  const double far = std::abs(t);
  const double mass = far > kFar ? 0.5 * normal_law().at(-d).cumulative
                                 : std::atan2(far, d) / (2 * std::numbers::pi) - kMass.at(d, far);
  return t < 0 ? -mass : mass;
}

}  // namespace sightline
