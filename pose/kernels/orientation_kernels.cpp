// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The kernels in one version for each kind of CPU, chosen at the first call.
// It is compiled with -ffp-contract=fast (pose/CMakeLists.txt): where the CPU has a
// fused multiply-add, sums of products are made of them.
// (GCC's target_clones would do the same in fewer lines, but builds every vector through memory.)

#include "pose/kernels/orientation_kernels.h"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define SIGHTLINE_CPU_VERSIONS 1
#else
#define SIGHTLINE_CPU_VERSIONS 0
#endif

namespace sightline {
namespace {

namespace any_cpu {
constexpr bool kHasEightLanes = false;
#include "pose/kernels/orientation_kernels_body.h"
}  // namespace any_cpu

#if SIGHTLINE_CPU_VERSIONS
#pragma GCC push_options
#pragma GCC target("avx2,fma")
namespace with_avx2 {
constexpr bool kHasEightLanes = false;
#include "pose/kernels/orientation_kernels_body.h"
}  // namespace with_avx2
#pragma GCC pop_options
#pragma GCC push_options
#pragma GCC target("avx2,fma,avx512f,avx512vl,avx512dq")
namespace with_avx512 {
constexpr bool kHasEightLanes = true;
#include "pose/kernels/orientation_kernels_body.h"
}  // namespace with_avx512
#pragma GCC pop_options
#endif

template <typename Scalar>
PairSums sum_by_plain_loops(const PairArrays<Scalar>& p) {
  PairSums sums = {};
  for (std::size_t k = 0; k < p.n; ++k) {
    double x[4] = {0, 0, 0, 1};
    double y[4] = {0, 0, 0, 1};
    for (int i = 0; i < 3; ++i) {
      x[i] = static_cast<double>(p.a[3 * k + i]) - p.origin_a[i];
      y[i] = static_cast<double>(p.b[3 * k + i]) - p.origin_b[i];
    }
    const double weight = p.weights ? p.weights[k] : 1.0;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) sums.rows[i][j] += weight * y[i] * x[j];
    }
  }
  return sums;
}

#if SIGHTLINE_CPU_VERSIONS
bool has_avx2() {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
}

bool has_avx512() {
  return has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
         __builtin_cpu_supports("avx512dq");
}
#endif

}  // namespace

const OrientationKernels* orientation_kernels(std::size_t rank) {
  std::size_t better = 0;
#if SIGHTLINE_CPU_VERSIONS
  if (has_avx512() && better++ == rank) return &with_avx512::kKernels;
  if (has_avx2() && better++ == rank) return &with_avx2::kKernels;
#endif
  return better == rank ? &any_cpu::kKernels : nullptr;
}

namespace {

const OrientationKernels& best() {
  static const OrientationKernels& kernels = *orientation_kernels(0);
  return kernels;
}

}  // namespace

PairSums sum_pairs(const PairArrays<double>& arrays) {
  return best().sum_double(arrays);
}

PairSums sum_pairs(const PairArrays<float>& arrays) {
  return best().sum_float(arrays);
}

PairSums sum_pairs_plainly(const PairArrays<double>& arrays) {
  return sum_by_plain_loops(arrays);
}

PairSums sum_pairs_plainly(const PairArrays<float>& arrays) {
  return sum_by_plain_loops(arrays);
}

CentredSums centred(const PairSums& sums) {
  return any_cpu::centre(sums, sums.rows[3][3]);
}

ClosedForm closed_form_rotation(const double b[9]) {
  return best().rotation(b);
}

bool closed_form_pose(const PairArrays<double>& arrays, double coordinate_epsilon,
                      double rotation[9], double translation[3]) {
  return best().pose_double(arrays, coordinate_epsilon, rotation, translation);
}

bool closed_form_pose(const PairArrays<float>& arrays, double coordinate_epsilon,
                      double rotation[9], double translation[3]) {
  return best().pose_float(arrays, coordinate_epsilon, rotation, translation);
}

}  // namespace sightline
