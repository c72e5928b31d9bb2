// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/random/random.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <Random123/philox.h>

#include "scenes/random/normal_kernel.h"

namespace sightline {
namespace {

// The finaliser of SplitMix64 (Steele, Lea, Flood 2014): every input bit reaches every output bit.
uint64_t mix(uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

uint64_t key_of(uint64_t seed, std::string_view name) {
  uint64_t hash = 0xcbf29ce484222325ULL;  // FNV-1a
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return mix(mix(seed + 0x9e3779b97f4a7c15ULL) ^ hash);
}

}  // namespace

RandomStream::RandomStream(uint64_t seed, std::string_view name, uint64_t index) {
  const uint64_t key = key_of(seed, name);
  key_ = {static_cast<uint32_t>(key), static_cast<uint32_t>(key >> 32)};
  counter_ = {0, 0, static_cast<uint32_t>(index), static_cast<uint32_t>(index >> 32)};
}

void RandomStream::advance(uint32_t blocks) {
  counter_[0] += blocks;
  if (counter_[0] < blocks) ++counter_[1];
}

uint32_t RandomStream::bits() {
  if (used_ == 4) {
    const r123::Philox4x32 philox;
    const auto block =
        philox({{counter_[0], counter_[1], counter_[2], counter_[3]}}, {{key_[0], key_[1]}});
    for (int i = 0; i < 4; ++i) block_[i] = block[i];
    advance(1);
    used_ = 0;
  }
  return block_[used_++];
}

double RandomStream::uniform() {
  const uint64_t high = bits();
  const uint64_t mantissa = ((high << 32) | bits()) >> 12;  // 52 bits, then half a step off zero
  return (static_cast<double>(mantissa) + 0.5) * 0x1p-52;
}

double RandomStream::uniform(double low, double high) {
  return low + (high - low) * uniform();
}

double RandomStream::normal() {
  if (has_spare_normal_) {
    has_spare_normal_ = false;
    return spare_normal_;
  }
  const double radius = std::sqrt(-2 * std::log(uniform()));
  const double angle = 2 * std::numbers::pi * uniform();
  spare_normal_ = radius * std::sin(angle);
  has_spare_normal_ = true;
  return radius * std::cos(angle);
}

void RandomStream::normals(std::span<float> out) {
  const uint32_t key[2] = {key_[0], key_[1]};
  float batch[kernel::kNormalBatch];
  while (!out.empty()) {
    const uint32_t counter[4] = {counter_[0], counter_[1], counter_[2], counter_[3]};
    kernel::fill_normals(key, counter, batch);
    advance(kernel::kNormalBatch / 4);
    const size_t count = std::min<size_t>(out.size(), kernel::kNormalBatch);
    std::copy_n(batch, count, out.begin());
    out = out.subspan(count);
  }
}

Eigen::Vector3d RandomStream::normal3() {
  const double x = normal();
  const double y = normal();
  return {x, y, normal()};
}

Eigen::Vector3d RandomStream::direction_near(const Eigen::Vector3d& axis, double angle_rad) {
  const double cos_polar = uniform(std::cos(angle_rad), 1);
  const double sin_polar = std::sqrt(std::max(0.0, 1 - cos_polar * cos_polar));
  const double azimuth = 2 * std::numbers::pi * uniform();
  const Eigen::Vector3d side = axis.unitOrthogonal();
  return cos_polar * axis +
         sin_polar * (std::cos(azimuth) * side + std::sin(azimuth) * axis.cross(side));
}

Eigen::Matrix3d RandomStream::rotation() {
  // A normalised Gaussian quaternion is uniform on the sphere S3, hence on SO(3).
  const double w = normal();
  const Eigen::Vector3d v = normal3();
  return Eigen::Quaterniond(w, v.x(), v.y(), v.z()).normalized().toRotationMatrix();
}

}  // namespace sightline
