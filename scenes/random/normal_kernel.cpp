// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Plain loops over arrays of one fixed length, which compilers turn into vector code: 2 ns a normal
// without any extension, 1 ns with AVX2. (Random123 and a libm call take ten times that.)
#include "scenes/random/normal_kernel.h"

#include <bit>
#include <cmath>

#include "pose/multiversion.h"

namespace sightline::kernel {
namespace {

constexpr int kBlocks = kNormalBatch / 4;

inline void philox(const uint32_t (&key)[2], const uint32_t (&counter)[4],
                   uint32_t (&words)[4][kBlocks]) {
  auto& [w0, w1, w2, w3] = words;
  for (uint32_t i = 0; i < kBlocks; ++i) {
    w0[i] = counter[0] + i;
    w1[i] = counter[1] + (w0[i] < counter[0] ? 1u : 0u);
    w2[i] = counter[2];
    w3[i] = counter[3];
  }
  uint32_t k0 = key[0];
  uint32_t k1 = key[1];
  for (int round = 0; round < 10; ++round) {
    for (int i = 0; i < kBlocks; ++i) {
      const uint64_t a = uint64_t{0xD2511F53u} * w0[i];
      const uint64_t b = uint64_t{0xCD9E8D57u} * w2[i];
      w0[i] = static_cast<uint32_t>(b >> 32) ^ w1[i] ^ k0;
      w1[i] = static_cast<uint32_t>(b);
      w2[i] = static_cast<uint32_t>(a >> 32) ^ w3[i] ^ k1;
      w3[i] = static_cast<uint32_t>(a);
    }
    k0 += 0x9E3779B9u;
    k1 += 0xBB67AE85u;
  }
}

// ln(x) of a positive normal number within 1 ulp: x = m 2^e with m in [sqrt(1/2), sqrt(2)), and the
// polynomial of Cephes' logf (Moshier 1992) for m.
inline float natural_log(float x) {
  constexpr uint32_t kRootHalf = 0x3f3504f3u;
  const uint32_t shifted = std::bit_cast<uint32_t>(x) - kRootHalf;
  const auto e = static_cast<float>(static_cast<int32_t>(shifted) >> 23);
  const float d = std::bit_cast<float>((shifted & 0x7fffffu) + kRootHalf) - 1;
  float p = 7.0376836292e-2f;
  p = p * d - 1.1514610310e-1f;
  p = p * d + 1.1676998740e-1f;
  p = p * d - 1.2420140846e-1f;
  p = p * d + 1.4249322787e-1f;
  p = p * d - 1.6668057665e-1f;
  p = p * d + 2.0000714765e-1f;
  p = p * d - 2.4999993993e-1f;
  p = p * d + 3.3333331174e-1f;
  return e * 0.693147181f + (d * d * (d * p - 0.5f) + d);
}

// Sine and cosine within +-pi/4 (Cephes' polynomials).
inline float short_sine(float t) {
  const float t2 = t * t;
  return t + t * t2 * (-1.6666654611e-1f + t2 * (8.3321608736e-3f + t2 * -1.9515295891e-4f));
}

inline float short_cosine(float t) {
  const float t2 = t * t;
  return 1 - 0.5f * t2 +
         t2 * t2 * (4.166664568e-2f + t2 * (-1.388731625e-3f + t2 * 2.443315712e-5f));
}

// Two independent normals of each pair of words: one is the radius, the other the angle. The upper
// two bits of that say which quarter of the circle, the other thirty where in it.
inline void box_muller(const uint32_t (&radius)[kBlocks], const uint32_t (&angle)[kBlocks],
                       float* x, float* y) {
  constexpr auto kAngleStep = static_cast<float>(3.14159265358979323846 * 0x1p-31);
  for (int i = 0; i < kBlocks; ++i) {
    const float uniform =
        (static_cast<float>(static_cast<int32_t>(radius[i] >> 1)) + 0.5f) * 0x1p-31f;
    const float r = std::sqrt(-2 * natural_log(uniform));
    const auto in_quarter = static_cast<float>(static_cast<int32_t>(angle[i] << 2) >> 2);
    const float t = (in_quarter + 0.5f) * kAngleStep;
    const auto sine = std::bit_cast<uint32_t>(short_sine(t));
    const uint32_t cosine = std::bit_cast<uint32_t>(short_cosine(t)) ^ (angle[i] & 0x80000000u);
    const uint32_t is_turned = 0 - (angle[i] >> 30 & 1u);
    x[i] = r * std::bit_cast<float>((cosine & ~is_turned) | (sine & is_turned));
    y[i] = r * std::bit_cast<float>((sine & ~is_turned) | (cosine & is_turned));
  }
}

}  // namespace

SIGHTLINE_MULTIVERSION
void fill_normals(const uint32_t (&key)[2], const uint32_t (&counter)[4],
                  float (&out)[kNormalBatch]) {
  uint32_t words[4][kBlocks];
  philox(key, counter, words);
  box_muller(words[0], words[1], out, out + kBlocks);
  box_muller(words[2], words[3], out + 2 * kBlocks, out + 3 * kBlocks);
}

}  // namespace sightline::kernel
