// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace sightline::kernel {

/// The normals made at once, from a quarter as many blocks of Philox.
inline constexpr int kNormalBatch = 256;

/// kNormalBatch independent Gaussians of mean 0 and standard deviation 1, from the Philox 4x32-10
/// blocks of `counter` and the kNormalBatch / 4 - 1 that follow it (Salmon et al. 2011), by the
/// transform of Box and Muller (1958) in single precision. No |x| exceeds 6.66. Additions,
/// multiplications and square roots only: the same bits on every processor of IEEE arithmetic.
void fill_normals(const uint32_t (&key)[2], const uint32_t (&counter)[4],
                  float (&out)[kNormalBatch]);

}  // namespace sightline::kernel
