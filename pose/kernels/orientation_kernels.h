// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The hot loops of absolute orientation on plain arrays. orientation_kernels.cpp is compiled for
// several CPUs and must not see Eigen, which picks its instructions once for the whole program.
#pragma once

#include <cstddef>

namespace sightline {

/// n >= 1 matched points, each three numbers in a row; their weights (null: all 1); and what is
/// taken off them before anything is multiplied: x = a - origin_a, y = b - origin_b.
template <typename Scalar>
struct PairArrays {
  const Scalar* a;
  const Scalar* b;
  const double* weights;
  std::size_t n;
  double origin_a[3];
  double origin_b[3];
};

/// sum w (y, 1) (x, 1)^T, a 4x4 matrix, row by row. Its corner is the sum of the weights, its last
/// row and column are the weighted sums of the points.
struct PairSums {
  double rows[4][4];
};

/// The sums in double arithmetic for points in either precision, by the best instructions that this
/// CPU has. Sums over many points are taken in blocks, so that rounding hardly grows with n. Not
/// finite input gives sums that are not finite.
PairSums sum_pairs(const PairArrays<double>& arrays);
PairSums sum_pairs(const PairArrays<float>& arrays);

/// The same sums by plain loops: what sum_pairs is tested against.
PairSums sum_pairs_plainly(const PairArrays<double>& arrays);
PairSums sum_pairs_plainly(const PairArrays<float>& arrays);

/// Means of x and y, and B = sum w (y - mean y)(x - mean x)^T, column by column.
struct CentredSums {
  double weight;
  double mean_x[3];
  double mean_y[3];
  double cross[9];
  double norm2;             ///< |B|^2
  double subtracted_norm2;  ///< |W mean_y mean_x^T|^2: what was taken off the sums to centre them
};

CentredSums centred(const PairSums& sums);

/// The sums of that much larger means than B have lost precision by it; a first point among the
/// others stays below 10.
inline constexpr double kTolerableCancellation = 32;

/// Within these bounds of |B|^2, products of nine elements of B stay well inside the range of
/// double.
inline constexpr double kSmallestNorm2 = 1e-60;
inline constexpr double kLargestNorm2 = 1e60;

/// The rotation A that maximises tr(A^T B), column by column, by the closed form that
/// pose/orientation/fast.cpp explains.
struct ClosedForm {
  bool is_precise;      ///< false: B has too small a gap (or no finite norm); `rotation` is rubbish
  double smallest_gap;  ///< s2 + sign(det B) s3 to a factor of 2
  double rotation[9];
};

ClosedForm closed_form_rotation(const double b[9]);

/// Sums, rotation (column by column) and translation in one go, for the good case, written where
/// they shall be: copying what has just been written stalls. False, and nothing written, when
/// cancellation, range, gap or input need care. coordinate_epsilon is what the coordinates are
/// rounded to, relative.
bool closed_form_pose(const PairArrays<double>& arrays, double coordinate_epsilon,
                      double rotation[9], double translation[3]);
bool closed_form_pose(const PairArrays<float>& arrays, double coordinate_epsilon,
                      double rotation[9], double translation[3]);

/// The functions above in one version.
struct OrientationKernels {
  PairSums (*sum_double)(const PairArrays<double>&);
  PairSums (*sum_float)(const PairArrays<float>&);
  ClosedForm (*rotation)(const double b[9]);
  bool (*pose_double)(const PairArrays<double>&, double coordinate_epsilon, double rotation[9],
                      double translation[3]);
  bool (*pose_float)(const PairArrays<float>&, double coordinate_epsilon, double rotation[9],
                     double translation[3]);
};

/// The versions that this CPU can run, rank 0 the best, which the functions above call; null beyond
/// the last. For tests.
const OrientationKernels* orientation_kernels(std::size_t rank);

}  // namespace sightline
