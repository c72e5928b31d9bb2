// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string>

#include <fmt/format.h>

namespace sightline {

/// Appends an ellipsoid of 64 rings to an .obj; `vertices` are those it has already.
inline std::string ellipsoid_obj(const std::string& name, const std::array<double, 3>& half_m,
                                 const std::array<double, 3>& centre_m, int& vertices) {
  constexpr int kRings = 64, kSteps = 2 * kRings;
  std::string obj = "o " + name + "\n";
  for (int ring = 0; ring <= kRings; ++ring) {
    for (int step = 0; step < kSteps; ++step) {
      const double polar = std::numbers::pi * ring / kRings;
      const double around = 2 * std::numbers::pi * step / kSteps;
      obj += fmt::format("v {:.6f} {:.6f} {:.6f}\n",
                         centre_m[0] + half_m[0] * std::sin(polar) * std::cos(around),
                         centre_m[1] + half_m[1] * std::sin(polar) * std::sin(around),
                         centre_m[2] + half_m[2] * std::cos(polar));
    }
  }
  for (int ring = 0; ring < kRings; ++ring) {
    for (int step = 0; step < kSteps; ++step) {
      const int next = (step + 1) % kSteps;
      const int here = vertices + 1 + ring * kSteps, below = here + kSteps;
      obj += fmt::format("f {} {} {} {}\n", here + step, below + step, below + next, here + next);
    }
  }
  vertices += (kRings + 1) * kSteps;
  return obj;
}

/// An aircraft of 8 m by 11 m without a straight edge: x forward, y starboard, z down.
inline void write_rounded_aircraft(const std::string& file) {
  int vertices = 0;
  std::ofstream out(file);
  out << ellipsoid_obj("fuselage", {4, 0.55, 0.6}, {0, 0, 0}, vertices);
  out << ellipsoid_obj("wing", {0.9, 5.5, 0.45}, {0.6, 0, 0.2}, vertices);
  out << ellipsoid_obj("tailplane", {0.45, 1.8, 0.2}, {-3.5, 0, -0.1}, vertices);
  out << ellipsoid_obj("fin", {0.5, 0.2, 1.1}, {-3.5, 0, -0.5}, vertices);
}

}  // namespace sightline
