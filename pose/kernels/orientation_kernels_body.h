// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The kernels of orientation_kernels.cpp, which includes this file once for each kind of CPU, every
// time in another namespace. No #pragma once, no other include.
//
// The sums: one pass, four lanes. Lane j of row i sums y_i x_j; x_3 = 1 gives the sums of the
// points for nothing. Point k is one load of x (with the number after it, which lane 3 discards)
// and three broadcast loads of y. CPUs with eight lanes take many points eight at a time.

using Vector4d [[gnu::vector_size(4 * sizeof(double))]] = double;
using Vector4f [[gnu::vector_size(4 * sizeof(float))]] = float;

struct Rows {
  Vector4d row[4] = {};
};

/// Reads four numbers at `from`, the last of which does not matter.
inline Vector4d load3(const double* from) {
  Vector4d v;
  __builtin_memcpy(&v, from, sizeof(v));
  return v;
}

inline Vector4d load3(const float* from) {
  Vector4f v;
  __builtin_memcpy(&v, from, sizeof(v));
  return __builtin_convertvector(v, Vector4d);
}

/// Reads no further than the three.
template <typename Scalar>
inline Vector4d load_last3(const Scalar* from) {
  return Vector4d{static_cast<double>(from[0]), static_cast<double>(from[1]),
                  static_cast<double>(from[2]), 0};
}

/// What is taken off the points, laid out for add_pair.
struct Origins {
  Vector4d minus_a_and_one;
  Vector4d b[3];
};

inline Origins origins_of(const double* a, const double* b) {
  Origins origins;
  origins.minus_a_and_one = Vector4d{-a[0], -a[1], -a[2], 1};
  for (int i = 0; i < 3; ++i) {
    // A fourth lane that GCC cannot know to be the same; or it subtracts before it broadcasts,
    // which takes an instruction more.
    double same = b[i];
#ifdef __x86_64__
    __asm__("" : "+x"(same));
#endif
    origins.b[i] = Vector4d{b[i], b[i], b[i], same};
  }
  return origins;
}

template <bool kWeighted, typename Scalar>
[[gnu::always_inline]] inline void add_pair(const Vector4d& a, const Scalar* b, double weight,
                                            const Origins& origins, Rows& rows) {
  constexpr Vector4d kFirstThree = {1, 1, 1, 0};
  Vector4d x = a * kFirstThree + origins.minus_a_and_one;  // exact products: rounded but once
  if constexpr (kWeighted) x *= weight;
  for (int i = 0; i < 3; ++i) {
    const double y = static_cast<double>(b[i]);
    rows.row[i] += (Vector4d{y, y, y, y} - origins.b[i]) * x;
  }
  rows.row[3] += x;
}

/// Chains of sums that hide the latency of the additions; there are registers for two.
constexpr std::size_t kChains = 2;

/// Sums over so many points are added up by themselves: the rounding of a sum grows with the square
/// root of a million points at most, not with the million.
constexpr std::size_t kBlock = 8192;

/// Adds the points from begin to before end; reads one number beyond the last of a.
template <bool kWeighted, typename Scalar>
inline void add_block(const PairArrays<Scalar>& p, std::size_t begin, std::size_t end,
                      const Origins& origins, Rows& rows) {
  const auto add = [&](std::size_t k, Rows& to) {
    add_pair<kWeighted>(load3(p.a + 3 * k), p.b + 3 * k, kWeighted ? p.weights[k] : 1.0, origins,
                        to);
  };
  std::size_t k = begin;
  if (end - begin >= 2 * kChains) {
    Rows chains[kChains];
    for (; k + kChains <= end; k += kChains) {
#pragma GCC unroll 8
      for (std::size_t c = 0; c < kChains; ++c) add(k + c, chains[c]);
    }
    for (const Rows& chain : chains) {
      for (int i = 0; i < 4; ++i) rows.row[i] += chain.row[i];
    }
  }
  for (; k < end; ++k) add(k, rows);
}

template <bool kWeighted, typename Scalar>
inline PairSums sum_in_lanes(const PairArrays<Scalar>& p) {
  PairSums sums;
  const Origins origins = origins_of(p.origin_a, p.origin_b);
  // Nothing follows the last point, and four numbers cannot be read there.
  const std::size_t last = p.n - 1;
  Rows rows;
  add_pair<kWeighted>(load_last3(p.a + 3 * last), p.b + 3 * last, kWeighted ? p.weights[last] : 1.0,
                      origins, rows);
  for (std::size_t begin = 0; begin < last; begin += kBlock) {
    const std::size_t end = last - begin < kBlock ? last : begin + kBlock;
    add_block<kWeighted>(p, begin, end, origins, rows);
  }
  for (int i = 0; i < 4; ++i) __builtin_memcpy(sums.rows[i], &rows.row[i], sizeof(rows.row[i]));
  return sums;
}

// Eight points at a time, for CPUs with eight lanes: three vectors hold them as they lie in memory,
// x y z x y z x y | z x y z x y z x | y z x y z x y z. Each is multiplied with the other cloud's,
// and with that turned by one and by two places within every point: nine products a point, none
// wasted.

using Vector8d [[gnu::vector_size(8 * sizeof(double))]] = double;

struct EightPoints {
  Vector8d part[3];
};

[[gnu::always_inline]] inline EightPoints minus(const double* from, const EightPoints& origin) {
  // One by one: a copy of all three at once would pass through memory.
  Vector8d first, second, third;
  __builtin_memcpy(&first, from, sizeof(first));
  __builtin_memcpy(&second, from + 8, sizeof(second));
  __builtin_memcpy(&third, from + 16, sizeof(third));
  return {{first - origin.part[0], second - origin.part[1], third - origin.part[2]}};
}

/// y z x of every point.
[[gnu::always_inline]] inline EightPoints turned_by_one(const EightPoints& p) {
  const Vector8d middle = __builtin_shufflevector(p.part[1], p.part[0], 14, 2, 3, 1, 5, 6, 4, 0);
  return {{__builtin_shufflevector(p.part[0], p.part[1], 1, 2, 0, 4, 5, 3, 7, 8),
           __builtin_shufflevector(middle, p.part[2], 0, 1, 2, 3, 4, 5, 6, 8),
           __builtin_shufflevector(p.part[2], p.part[1], 1, 15, 3, 4, 2, 6, 7, 5)}};
}

/// z x y of every point.
[[gnu::always_inline]] inline EightPoints turned_by_two(const EightPoints& p) {
  const Vector8d middle = __builtin_shufflevector(p.part[1], p.part[0], 15, 3, 1, 2, 6, 4, 5, 0);
  return {{__builtin_shufflevector(p.part[0], p.part[1], 2, 0, 1, 5, 3, 4, 8, 6),
           __builtin_shufflevector(middle, p.part[2], 0, 1, 2, 3, 4, 5, 6, 9),
           __builtin_shufflevector(p.part[2], p.part[1], 15, 0, 4, 2, 3, 7, 5, 6)}};
}

inline EightPoints eight_times(const double point[3]) {
  double flat[24];
  for (int i = 0; i < 24; ++i) flat[i] = point[i % 3];
  EightPoints points;
  __builtin_memcpy(&points, flat, sizeof(points));
  return points;
}

/// Adds up to three numbers, those of x, y and z.
inline void add_up(const EightPoints& points, double& x, double& y, double& z) {
  double flat[24];
  __builtin_memcpy(flat, &points, sizeof(points));
  for (int i = 0; i < 24; i += 3) {
    x += flat[i];
    y += flat[i + 1];
    z += flat[i + 2];
  }
}

/// Adds eights of unweighted points from begin to before end; returns the first not added.
inline std::size_t add_eights(const PairArrays<double>& p, std::size_t begin, std::size_t end,
                              PairSums& sums) {
  const EightPoints origin_a = eight_times(p.origin_a);
  const EightPoints origin_b = eight_times(p.origin_b);
  EightPoints sum_a = {}, sum_b = {}, straight = {}, by_one = {}, by_two = {};
  std::size_t k = begin;
  for (; k + 8 <= end; k += 8) {
    const EightPoints x = minus(p.a + 3 * k, origin_a);
    const EightPoints y = minus(p.b + 3 * k, origin_b);
    const EightPoints y_by_one = turned_by_one(y);
    const EightPoints y_by_two = turned_by_two(y);
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
      sum_a.part[i] += x.part[i];
      sum_b.part[i] += y.part[i];
      straight.part[i] += x.part[i] * y.part[i];
      by_one.part[i] += x.part[i] * y_by_one.part[i];
      by_two.part[i] += x.part[i] * y_by_two.part[i];
    }
  }
  auto& s = sums.rows;
  add_up(sum_a, s[3][0], s[3][1], s[3][2]);
  add_up(sum_b, s[0][3], s[1][3], s[2][3]);
  add_up(straight, s[0][0], s[1][1], s[2][2]);
  add_up(by_one, s[1][0], s[2][1], s[0][2]);
  add_up(by_two, s[2][0], s[0][1], s[1][2]);
  s[3][3] += static_cast<double>(k - begin);
  return k;
}

/// From so many points on the eights gain more than their adding up in the end costs.
constexpr std::size_t kManyPoints = 200;

inline PairSums sum_in_eights(const PairArrays<double>& p) {
  PairSums sums = {};
  std::size_t k = 0;
  while (k + 8 <= p.n) k = add_eights(p, k, p.n - k < kBlock ? p.n : k + kBlock, sums);
  const PairArrays<double> rest = {p.a + 3 * k,
                                   p.b + 3 * k,
                                   nullptr,
                                   p.n - k,
                                   {p.origin_a[0], p.origin_a[1], p.origin_a[2]},
                                   {p.origin_b[0], p.origin_b[1], p.origin_b[2]}};
  if (rest.n == 0) return sums;
  const PairSums last = sum_in_lanes<false>(rest);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) sums.rows[i][j] += last.rows[i][j];
  }
  return sums;
}

template <typename Scalar>
inline PairSums sums(const PairArrays<Scalar>& arrays) {
  if constexpr (kHasEightLanes && sizeof(Scalar) == sizeof(double)) {
    if (!arrays.weights && arrays.n >= kManyPoints) return sum_in_eights(arrays);
  }
  return arrays.weights ? sum_in_lanes<true>(arrays) : sum_in_lanes<false>(arrays);
}

/// `weight` is the corner of the sums; who knows it beforehand gains the time of a division.
[[gnu::always_inline]] inline CentredSums centre(const PairSums& sums, double weight) {
  const auto& s = sums.rows;
  CentredSums c;
  c.weight = weight;
  const double per_weight = 1 / c.weight;
  for (int i = 0; i < 3; ++i) {
    c.mean_x[i] = per_weight * s[3][i];
    c.mean_y[i] = per_weight * s[i][3];
  }
  double column_norm2[3];
  for (int j = 0; j < 3; ++j) {
    double* column = c.cross + 3 * j;
    for (int i = 0; i < 3; ++i) column[i] = s[i][j] - c.mean_y[i] * s[3][j];
    column_norm2[j] = column[0] * column[0] + column[1] * column[1] + column[2] * column[2];
  }
  c.norm2 = column_norm2[0] + column_norm2[1] + column_norm2[2];
  const double mean_x2 =
      c.mean_x[0] * c.mean_x[0] + c.mean_x[1] * c.mean_x[1] + c.mean_x[2] * c.mean_x[2];
  const double mean_y2 =
      c.mean_y[0] * c.mean_y[0] + c.mean_y[1] * c.mean_y[1] + c.mean_y[2] * c.mean_y[2];
  c.subtracted_norm2 = (c.weight * mean_x2) * (c.weight * mean_y2);
  return c;
}

struct Vector3 {
  double x, y, z;
};

inline Vector3 operator*(double s, const Vector3& v) {
  return {s * v.x, s * v.y, s * v.z};
}
inline Vector3 operator+(const Vector3& u, const Vector3& v) {
  return {u.x + v.x, u.y + v.y, u.z + v.z};
}
inline double dot(const Vector3& u, const Vector3& v) {
  return u.x * v.x + u.y * v.y + u.z * v.z;
}
inline Vector3 cross(const Vector3& u, const Vector3& v) {
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}

/// A 3x3 matrix by its columns.
struct Matrix3 {
  Vector3 x, y, z;
};

struct Symmetric3 {
  double xx, yy, zz, xy, yz, zx;
};

inline Symmetric3 gram(const Matrix3& m) {
  return {dot(m.x, m.x), dot(m.y, m.y), dot(m.z, m.z), dot(m.x, m.y), dot(m.y, m.z), dot(m.z, m.x)};
}

inline Vector3 operator*(const Matrix3& m, const Vector3& v) {
  return v.x * m.x + v.y * m.y + v.z * m.z;
}
inline Matrix3 operator*(const Matrix3& m, const Symmetric3& s) {
  return {m * Vector3{s.xx, s.xy, s.zx}, m * Vector3{s.xy, s.yy, s.yz},
          m * Vector3{s.zx, s.yz, s.zz}};
}
/// adj(M)^T.
inline Matrix3 cofactors(const Matrix3& m) {
  return {cross(m.y, m.z), cross(m.z, m.x), cross(m.x, m.y)};
}

/// |M|^2, added in pairs: one after the other takes longer.
inline double norm2_of(const Matrix3& m) {
  const double x = m.x.x * m.x.x + m.x.y * m.x.y, y = m.y.x * m.y.x + m.y.y * m.y.y;
  const double z = m.z.x * m.z.x + m.z.y * m.z.y, last = m.x.z * m.x.z + m.y.z * m.y.z;
  return (x + y) + (z + (last + m.z.z * m.z.z));
}

/// A step of Newton and Schulz from M = m / divisor towards the nearest orthonormal matrix,
/// M (3 I - M^T M) / 2: an error e becomes e^2.
[[gnu::always_inline]] inline Matrix3 nearer_to_orthonormal(const Matrix3& m, double divisor = 1) {
  const Symmetric3 g = gram(m);
  const double c = 1 / divisor;
  const double d = -0.5 / (divisor * divisor);  // does not wait for c
  const Matrix3 scaled = {c * m.x, c * m.y, c * m.z};
  return scaled *
         Symmetric3{1.5 + d * g.xx, 1.5 + d * g.yy, 1.5 + d * g.zz, d * g.xy, d * g.yz, d * g.zx};
}

/// One Newton step on SO(3) for tr(A^T B) -> max, A <- Exp(w) A. With A^T B = N, in the axes of a:
/// gradient vee(N - N^T), Hessian -(tr(N) I - sym(N)). The step is far below 1e-6 rad, where I +
/// [w] is Exp(w) to rounding once made orthonormal.
inline Matrix3 polished(const Matrix3& rough, const Matrix3& b) {
  const Matrix3 a = nearer_to_orthonormal(rough);
  const double xx = dot(a.x, b.x), yx = dot(a.y, b.x), zx = dot(a.z, b.x);
  const double xy = dot(a.x, b.y), yy = dot(a.y, b.y), zy = dot(a.z, b.y);
  const double xz = dot(a.x, b.z), yz = dot(a.y, b.z), zz = dot(a.z, b.z);
  const Vector3 gradient = {zy - yz, xz - zx, yx - xy};
  const double off_xy = -0.5 * (xy + yx), off_yz = -0.5 * (yz + zy), off_zx = -0.5 * (zx + xz);
  const Matrix3 curvature = {
      {yy + zz, off_xy, off_zx}, {off_xy, zz + xx, off_yz}, {off_zx, off_yz, xx + yy}};
  const Matrix3 adjugate = cofactors(curvature);
  const Vector3 w = (1 / dot(curvature.x, adjugate.x)) * (adjugate * gradient);
  // A (I + [w])
  const Matrix3 turned = {a.x + w.z * a.y + (-w.y) * a.z, a.y + w.x * a.z + (-w.z) * a.x,
                          a.z + w.y * a.x + (-w.x) * a.y};
  return nearer_to_orthonormal(turned);
}

/// Where xi / lambda^3, a third to one times the gap (s2 + s3)/s1, is below this, the closed form
/// fails.
constexpr double kSvdGap = 1e-4;
/// Where (s2 + s3)/sqrt(s2^2 + s3^2) is below this, s3 nearly cancels s2: the cloud is mirrored,
/// and the closed form errs with the inverse square of the gap. A Newton step restores the digits.
/// With these two the root-mean-square error was 0.2 to 1.1 times the SVD's at every gap from 1 to
/// 1e-12, for both signs of det B (the tests hold it to 2).
constexpr double kMirrorGap = 0.2;

struct Root {
  bool is_simple;
  double lambda, xi;
};

/// The largest root of h(mu) = kappa^2 - |adj|^2 - 2 det lambda, a quarter of (23). All four roots
/// are real; the start lies above the largest, and Householder's steps of third order (error e
/// becomes e^4) end at it. h' = 2 xi is a quarter of the product of its distances from the other
/// roots, so that xi / lambda^2 measures the nearest. An error of the root, in that measure, is how
/// much too long or short A becomes along its axes, which the step towards orthonormal squares:
/// 1e-8 is enough. Not simple: (nearly) a double root.
inline Root largest_root(double norm2, double det, double adjugate_norm2) {
  constexpr double kSqrt3 = 1.7320508075688772;  // lambda <= sqrt(3) |B|
  // What kappa / |B|^2 and lambda / |B| are in most clouds: there the tangents of the roots kappa =
  // sqrt(kappa^2) and lambda = sqrt(|B|^2 + 2 kappa) are taken, which lie above them.
  constexpr double kKappa = 0.8;
  constexpr double kLambda = 1.6;
  constexpr double kLastStep = 1.5e-2;
  constexpr double kSettled = 2e-9;
  constexpr int kMaxIterations = 12;
  const double norm = __builtin_sqrt(norm2);
  const double per_norm2 = 1 / norm2;
  const double two_det = det + __builtin_fabs(det);  // no branch: n = 3 tosses coins
  const double lambda_bound = (adjugate_norm2 + two_det * (kSqrt3 * norm)) *
                                  (0.5 / (kKappa * kLambda) * per_norm2 * per_norm2 * norm) +
                              (0.5 * (1 + kKappa) / kLambda + 0.5 * kLambda) * norm;
  const double kappa_above = __builtin_sqrt(adjugate_norm2 + two_det * lambda_bound);
  double lambda = __builtin_sqrt(norm2 + 2 * kappa_above);
  double mu = lambda - norm;
  double kappa = mu * (norm + 0.5 * mu);
  double xi = kappa * lambda - det;
  for (int i = 0; i < kMaxIterations; ++i) {
    const double h = kappa * kappa - adjugate_norm2 - 2 * det * lambda;
    const double lambda2 = lambda * lambda;
    if (__builtin_fabs(h) * lambda2 <= kSettled * (xi * xi)) return {true, lambda, xi};
    const double hq = h * (lambda2 + kappa);
    const double halley = 4 * xi * xi - hq;
    const double step = h * halley / (2 * xi * (halley - hq) + lambda * h * h);
    const bool is_last = __builtin_fabs(step) * lambda2 <= kLastStep * xi;
    mu -= step;
    lambda -= step;
    kappa = mu * (norm + 0.5 * mu);
    xi = kappa * lambda - det;
    if (is_last) return {true, lambda, xi};
  }
  return {};
}

struct Rotation {
  bool is_precise;
  double smallest_gap;
  Matrix3 a;
};

[[gnu::always_inline]] inline Rotation closed_form(const Matrix3& b, double norm2) {
  const Matrix3 adjugate_t = cofactors(b);
  const double det = dot(b.x, adjugate_t.x);
  const Matrix3 b_gram = b * gram(b);
  const double adjugate_norm2 = norm2_of(adjugate_t);
  const auto [is_simple, lambda, xi] = largest_root(norm2, det, adjugate_norm2);
  const double lambda2 = lambda * lambda;
  const double lambda3 = lambda2 * lambda;
  if (!(is_simple && xi >= kSvdGap * lambda3)) return {};

  // (16), with kappa + |B|^2 = (lambda^2 + |B|^2) / 2. The division by xi waits, so that the
  // processor need not.
  const double first = 0.5 * lambda2 + 0.5 * norm2;
  const Matrix3 xi_a = {
      (lambda * adjugate_t.x + (-1.0) * b_gram.x) + first * b.x,
      (lambda * adjugate_t.y + (-1.0) * b_gram.y) + first * b.y,
      (lambda * adjugate_t.z + (-1.0) * b_gram.z) + first * b.z,
  };
  const Matrix3 a = nearer_to_orthonormal(xi_a, xi);
  const double smallest_gap = xi / lambda2;
  if (xi * xi >= kMirrorGap * kMirrorGap * lambda2 * adjugate_norm2) return {true, smallest_gap, a};
  return {true, smallest_gap, polished(a, b)};
}

inline Matrix3 matrix_from(const double columns[9]) {
  return {{columns[0], columns[1], columns[2]},
          {columns[3], columns[4], columns[5]},
          {columns[6], columns[7], columns[8]}};
}

inline void write(const Matrix3& m, double columns[9]) {
  const Vector3 in_turn[3] = {m.x, m.y, m.z};
  for (int j = 0; j < 3; ++j) {
    columns[3 * j] = in_turn[j].x;
    columns[3 * j + 1] = in_turn[j].y;
    columns[3 * j + 2] = in_turn[j].z;
  }
}

template <typename Scalar>
inline bool pose_by_closed_form(const PairArrays<Scalar>& p, double coordinate_epsilon,
                                double columns[9], double translation[3]) {
  const PairSums s = sums(p);
  const CentredSums c = centre(s, p.weights ? s.rows[3][3] : static_cast<double>(p.n));
  if (!(c.norm2 >= kSmallestNorm2 && c.norm2 <= kLargestNorm2)) return false;
  if (c.subtracted_norm2 > kTolerableCancellation * kTolerableCancellation * c.norm2) return false;
  const Rotation rotation = closed_form(matrix_from(c.cross), c.norm2);
  if (!rotation.is_precise) return false;
  const Vector3 mean_a = {p.origin_a[0] + c.mean_x[0], p.origin_a[1] + c.mean_x[1],
                          p.origin_a[2] + c.mean_x[2]};
  const Vector3 mean_b = {p.origin_b[0] + c.mean_y[0], p.origin_b[1] + c.mean_y[1],
                          p.origin_b[2] + c.mean_y[2]};
  const double rounding_per_length2 = coordinate_epsilon * coordinate_epsilon * c.weight;
  const double gap = rotation.smallest_gap;
  // The clouds' extents, for which the first points' distances from the means stand, are rounded
  // too.
  const Vector3 from_a = {c.mean_x[0], c.mean_x[1], c.mean_x[2]};
  const Vector3 from_b = {c.mean_y[0], c.mean_y[1], c.mean_y[2]};
  const double size2_a = dot(mean_a, mean_a) + dot(from_a, from_a);
  const double size2_b = dot(mean_b, mean_b) + dot(from_b, from_b);
  if (!(gap * gap > rounding_per_length2 * rounding_per_length2 * size2_a * size2_b)) return false;
  const Vector3 t = mean_b + (-1.0) * (rotation.a * mean_a);
  write(rotation.a, columns);
  translation[0] = t.x;
  translation[1] = t.y;
  translation[2] = t.z;
  return true;
}

inline ClosedForm rotation_by_closed_form(const double b[9]) {
  const Matrix3 columns = matrix_from(b);
  const double norm2 =
      dot(columns.x, columns.x) + dot(columns.y, columns.y) + dot(columns.z, columns.z);
  ClosedForm result;
  result.is_precise = false;
  if (!(norm2 >= kSmallestNorm2 && norm2 <= kLargestNorm2)) return result;
  const Rotation rotation = closed_form(columns, norm2);
  result.is_precise = rotation.is_precise;
  result.smallest_gap = rotation.smallest_gap;
  write(rotation.a, result.rotation);
  return result;
}

constexpr OrientationKernels kKernels = {sums<double>, sums<float>, rotation_by_closed_form,
                                         pose_by_closed_form<double>, pose_by_closed_form<float>};
