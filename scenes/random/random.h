// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include <Eigen/Core>

namespace sightline {

/// A counter-based stream of random numbers (Philox 4x32-10, Salmon et al. 2011, from Random123),
/// keyed by (seed, name, index): trial 17's noise is the same alone or among shards, in any
/// order, and streams of different names or indices are independent. The distributions are our
/// own, so that a standard library's choice of algorithm changes nothing.
class RandomStream {
 public:
  RandomStream(uint64_t seed, std::string_view name, uint64_t index);

  /// 32 random bits.
  uint32_t bits();
  /// Uniform in (0, 1), 52 bits; never 0 or 1.
  double uniform();
  double uniform(double low, double high);
  /// Gaussian of mean 0 and standard deviation 1 (Box-Muller).
  double normal();
  /// Fills `out` with as many independent Gaussians of single precision, for whole rows of pixels:
  /// twenty times as fast as normal(), and others than that would draw.
  void normals(std::span<float> out);
  /// Three independent normal().
  Eigen::Vector3d normal3();
  /// A unit vector within `angle_rad` of `axis` (a unit vector), uniform in solid angle.
  Eigen::Vector3d direction_near(const Eigen::Vector3d& axis, double angle_rad);
  /// Uniform on SO(3).
  Eigen::Matrix3d rotation();

 private:
  void advance(uint32_t blocks);

  std::array<uint32_t, 2> key_;
  std::array<uint32_t, 4> counter_;
  std::array<uint32_t, 4> block_{};
  int used_ = 4;
  double spare_normal_ = 0;
  bool has_spare_normal_ = false;
};

}  // namespace sightline
