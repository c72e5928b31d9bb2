// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// With the depths l_i along the unit rays y_i and the squared sides a_ij, the law of cosines reads
//
//   (l_i - l_j)^2 + l_i l_j k_ij = a_ij,   k_ij = |y_i - y_j|^2.
//
// The papers take the ratios of depths as unknowns and k_ij from cosines. Under weak perspective
// all ratios are near 1 and all cosines near 1, and most digits are lost. Here the unknowns are
//
//   l_2 = l_1 (1 + e p),  l_3 = l_1 (1 + e q),   e^2 = max k_ij,  h_ij = k_ij / e^2,
//
//   E_12 = p^2       + h_12 (1 + e p)           = a_12 s
//   E_13 = q^2       + h_13 (1 + e q)           = a_13 s,   s = 1 / (e l_1)^2
//   E_23 = (p - q)^2 + h_23 (1 + e p) (1 + e q) = a_23 s,
//
// which stays well-conditioned as e -> 0 and becomes the weak-perspective problem there. The
// equation of the longest side gives s; the other two are conics A, B in (p, q). Some A + g B is a
// pair of lines, det(A + g B) = 0; each line meets B in two points.

#include "pose/p3p.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace sightline {
namespace {

/// Sine of the smallest angle of a triangle below which its points count as collinear, and length
/// of the shortest chord between unit rays below which they count as one.
constexpr double kCollinear = 1e-9;
constexpr double kSameRay = 1e-10;

using Conic = Eigen::Matrix3d;  ///< symmetric: (p, q, 1) C (p, q, 1)^T = 0

struct ConicPair {
  Conic a, b;
};

/// coefficient of p^2, pq, q^2, p, q, 1.
Conic conic(double pp, double pq, double qq, double p, double q, double one) {
  Conic c;
  c << pp, pq / 2, p / 2, pq / 2, qq, q / 2, p / 2, q / 2, one;
  return c;
}

/// The three sides in the order 12, 13, 23.
using Sides = std::array<double, 3>;

std::array<Conic, 3> side_conics(const Sides& h, double e) {
  return {conic(1, 0, 0, e * h[0], 0, h[0]), conic(0, 0, 1, 0, e * h[1], h[1]),
          conic(1, e * e * h[2] - 2, 1, e * h[2], e * h[2], h[2])};
}

/// `a` are the squared sides, the longest scaled to 1.
ConicPair eliminate_scale(const std::array<Conic, 3>& sides, const Sides& a) {
  const auto longest = static_cast<std::size_t>(std::ranges::max_element(a) - a.begin());
  const std::size_t i = longest == 0 ? 1 : 0;
  const std::size_t j = longest == 2 ? 1 : 2;
  return {sides[i] - a[i] * sides[longest], sides[j] - a[j] * sides[longest]};
}

/// Of a symmetric matrix.
Eigen::Matrix3d adjugate(const Conic& c) {
  Eigen::Matrix3d adjugate;
  adjugate.col(0) = c.col(1).cross(c.col(2));
  adjugate.col(1) = c.col(2).cross(c.col(0));
  adjugate.col(2) = c.col(0).cross(c.col(1));
  return adjugate;
}

struct Roots {
  std::array<double, 3> values;
  int count = 0;
};

/// The real roots of g^3 + b g^2 + c g + d: the trigonometric and the Cardano form, then Newton.
Roots real_roots(double b, double c, double d) {
  const double q = (b * b - 3 * c) / 9;
  const double r = (2 * b * b * b - 9 * b * c + 27 * d) / 54;
  Roots roots;
  if (r * r < q * q * q) {
    const double angle_rad = std::acos(std::clamp(r / std::sqrt(q * q * q), -1.0, 1.0));
    constexpr double kThirdTurn = 2.0943951023931953;
    for (const double turn : {0.0, kThirdTurn, -kThirdTurn}) {
      roots.values[roots.count++] = -2 * std::sqrt(q) * std::cos(angle_rad / 3 + turn) - b / 3;
    }
  } else {
    const double s = -std::copysign(std::cbrt(std::abs(r) + std::sqrt(r * r - q * q * q)), r);
    roots.values[roots.count++] = s + (s == 0 ? 0 : q / s) - b / 3;
  }
  for (int k = 0; k < roots.count; ++k) {
    double& g = roots.values[k];
    for (int step = 0; step < 2; ++step) {
      const double slope = (3 * g + 2 * b) * g + c;
      if (slope != 0) g -= (((g + b) * g + c) * g + d) / slope;
    }
  }
  return roots;
}

/// How far a singular conic is from being a single point: positive for two real lines.
struct LinePair {
  double reality = -1;
  Eigen::Vector3d first, second;
};

/// The lines of a singular conic C. The adjugate is -x x^T, x the point in which they meet, and
/// C + [x]_x = first second^T (Richter-Gebert, "Perspectives on projective geometry", 11.1).
LinePair split(const Conic& c) {
  const Eigen::Matrix3d adj = adjugate(c);
  Eigen::Index pivot;
  (-adj.diagonal()).maxCoeff(&pivot);
  LinePair pair;
  pair.reality = -adj(pivot, pivot) / c.squaredNorm();
  if (!(pair.reality > 0)) return pair;
  const Eigen::Vector3d x = adj.col(pivot) / std::sqrt(-adj(pivot, pivot));
  Eigen::Matrix3d product = c;
  product(0, 1) -= x[2];
  product(1, 0) += x[2];
  product(0, 2) += x[1];
  product(2, 0) -= x[1];
  product(1, 2) -= x[0];
  product(2, 1) += x[0];
  Eigen::Index row, column;
  product.cwiseAbs().maxCoeff(&row, &column);
  pair.first = product.col(column).normalized();
  pair.second = product.row(row).transpose().normalized();
  return pair;
}

/// The most real line pair of the pencil a + g b.
LinePair best_line_pair(const ConicPair& conics) {
  const Eigen::Matrix3d adj_a = adjugate(conics.a);
  const Eigen::Matrix3d adj_b = adjugate(conics.b);
  const double c0 = conics.a.col(0).dot(adj_a.col(0));
  const double c1 = adj_a.cwiseProduct(conics.b).sum();
  const double c2 = adj_b.cwiseProduct(conics.a).sum();
  const double c3 = conics.b.col(0).dot(adj_b.col(0));
  /// Below this part of the others c3, and with it c0, is rounding: a itself is singular.
  constexpr double kNoCubicTerm = 1e-14;
  if (!(std::abs(c3) > kNoCubicTerm * std::max(std::abs(c1), std::abs(c2)))) return split(conics.a);
  LinePair best;
  const Roots roots = real_roots(c2 / c3, c1 / c3, c0 / c3);
  for (int k = 0; k < roots.count; ++k) {
    const LinePair pair = split(conics.a + roots.values[k] * conics.b);
    if (pair.reality > best.reality) best = pair;
  }
  return best;
}

struct Candidates {
  std::array<Eigen::Vector2d, 4> values;
  std::size_t count = 0;
};

/// Adds the points in which a line meets a conic. A discriminant that rounding has made negative
/// counts as zero: Newton's iteration finds the solution, or there is none.
void intersect(const Eigen::Vector3d& line, const Conic& c, Candidates& candidates) {
  constexpr double kRounding = 1e-7;
  const double length = line.head<2>().norm();
  if (!(length > 0)) return;
  const Eigen::Vector3d base(-line[2] * line[0] / (length * length),
                             -line[2] * line[1] / (length * length), 1);
  const Eigen::Vector3d along(-line[1] / length, line[0] / length, 0);
  const double square = along.dot(c * along);
  const double half = along.dot(c * base);
  const double constant = base.dot(c * base);
  double discriminant = half * half - square * constant;
  const double scale = half * half + std::abs(square * constant);
  if (!(discriminant > -kRounding * scale)) return;
  discriminant = std::sqrt(std::max(discriminant, 0.0));
  const double stable = -(half + std::copysign(discriminant, half));  // no cancellation
  for (const double t : {stable / square, constant / stable}) {
    const Eigen::Vector2d x = (base + t * along).head<2>();
    if (x.allFinite()) candidates.values[candidates.count++] = x;
  }
}

/// Newton's iteration on both conics. None where it does not end on a common point.
std::optional<Eigen::Vector2d> polished(const ConicPair& conics, Eigen::Vector2d x) {
  constexpr int kMaxSteps = 30;  // a double root is approached by halving
  constexpr double kOnConic = 1e-11;
  double error = std::numeric_limits<double>::infinity();
  Eigen::Vector2d best = x;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::Vector3d a = conics.a * x.homogeneous();
    const Eigen::Vector3d b = conics.b * x.homogeneous();
    const Eigen::Vector2d value(a.dot(x.homogeneous()), b.dot(x.homogeneous()));
    const double next_error = value.cwiseAbs().maxCoeff();
    if (!(next_error < error)) break;
    error = next_error;
    best = x;
    Eigen::Matrix2d slope;
    slope << 2 * a.head<2>().transpose(), 2 * b.head<2>().transpose();
    const double determinant = slope.determinant();
    if (determinant == 0) break;
    x -= Eigen::Vector2d(slope(1, 1) * value[0] - slope(0, 1) * value[1],
                         slope(0, 0) * value[1] - slope(1, 0) * value[0]) /
         determinant;
  }
  if (!(error <= kOnConic * (1 + best.squaredNorm()))) return std::nullopt;
  return best;
}

/// The orthonormal frame of a triangle from two of its sides.
Eigen::Matrix3d triangle_frame(const Eigen::Vector3d& d12, const Eigen::Vector3d& d13) {
  Eigen::Matrix3d frame;
  frame.col(0) = d12.normalized();
  Eigen::Vector3d across = d13 - d13.dot(frame.col(0)) * frame.col(0);
  across -= across.dot(frame.col(0)) * frame.col(0);  // once more, for slivers
  frame.col(1) = across.normalized();
  frame.col(2) = frame.col(0).cross(frame.col(1));
  return frame;
}

bool is_triangle(const Eigen::Vector3d& d12, const Eigen::Vector3d& d13) {
  return d12.cross(d13).norm() > kCollinear * std::max(d12.squaredNorm(), d13.squaredNorm());
}

Sides scaled(const Sides& sides, double by) {
  return {sides[0] / by, sides[1] / by, sides[2] / by};
}

/// The problem in the variables of the head of this file.
struct Setup {
  Eigen::Vector3d point_1_in_target, d12_in_target, d13_in_target;
  std::array<Eigen::Vector3d, 3> rays;  ///< unit
  Sides sides;                          ///< squared
  Sides h;
  double e = 0;
};

std::optional<Setup> set_up(const std::array<Eigen::Vector3d, 3>& points_in_target,
                            const std::array<Eigen::Vector3d, 3>& rays_in_cam) {
  for (const Eigen::Vector3d& ray : rays_in_cam) {
    if (!(ray.z() > 0)) return std::nullopt;
  }
  Setup s;
  s.point_1_in_target = points_in_target[0];
  s.d12_in_target = points_in_target[1] - points_in_target[0];
  s.d13_in_target = points_in_target[2] - points_in_target[0];
  for (std::size_t i = 0; i < 3; ++i) s.rays[i] = rays_in_cam[i].normalized();
  s.sides = {s.d12_in_target.squaredNorm(), s.d13_in_target.squaredNorm(),
             (points_in_target[2] - points_in_target[1]).squaredNorm()};
  const Sides chords = {(s.rays[1] - s.rays[0]).squaredNorm(),
                        (s.rays[2] - s.rays[0]).squaredNorm(),
                        (s.rays[2] - s.rays[1]).squaredNorm()};
  if (!is_triangle(s.d12_in_target, s.d13_in_target)) return std::nullopt;
  if (!std::isfinite(s.sides[0] + s.sides[1] + s.sides[2])) return std::nullopt;
  for (const double chord : chords) {
    if (!(chord > kSameRay * kSameRay)) return std::nullopt;
  }
  s.e = std::sqrt(std::ranges::max(chords));
  s.h = scaled(chords, s.e * s.e);
  return s;
}

/// The pose at a common point (p, q) of the conics; none where a point is not in front.
std::optional<Pose> pose_at(const Setup& s, double p, double q) {
  const double u = 1 + s.e * p;
  const double v = 1 + s.e * q;
  // All three equations together, so that no side that is short spoils the scale.
  const double sum = p * p + s.h[0] * u + q * q + s.h[1] * v + (p - q) * (p - q) + s.h[2] * u * v;
  const double depth = std::sqrt((s.sides[0] + s.sides[1] + s.sides[2]) / sum) / s.e;
  if (!(u > 0 && v > 0 && depth > 0 && std::isfinite(depth))) return std::nullopt;
  const Eigen::Vector3d d12_in_cam = depth * (s.e * p * s.rays[1] + (s.rays[1] - s.rays[0]));
  const Eigen::Vector3d d13_in_cam = depth * (s.e * q * s.rays[2] + (s.rays[2] - s.rays[0]));
  if (!is_triangle(d12_in_cam, d13_in_cam)) return std::nullopt;
  Pose cam_from_target;
  cam_from_target.rotation = triangle_frame(d12_in_cam, d13_in_cam) *
                             triangle_frame(s.d12_in_target, s.d13_in_target).transpose();
  cam_from_target.translation = depth * s.rays[0] - cam_from_target.rotation * s.point_1_in_target;
  return cam_from_target;
}

}  // namespace

P3pPoses p3p(const std::array<Eigen::Vector3d, 3>& points_in_target,
             const std::array<Eigen::Vector3d, 3>& rays_in_cam) {
  P3pPoses poses;
  const std::optional<Setup> s = set_up(points_in_target, rays_in_cam);
  if (!s) return poses;
  ConicPair conics = eliminate_scale(side_conics(s->h, s->e),
                                     scaled(s->sides, *std::ranges::max_element(s->sides)));
  // The pencil's parameter then stays finite.
  if (std::abs(conics.a.determinant()) > std::abs(conics.b.determinant())) {
    std::swap(conics.a, conics.b);
  }
  const LinePair lines = best_line_pair(conics);
  if (!(lines.reality > 0)) return poses;
  Candidates candidates;
  intersect(lines.first, conics.b, candidates);
  intersect(lines.second, conics.b, candidates);
  for (std::size_t k = 0; k < candidates.count; ++k) {
    const std::optional<Eigen::Vector2d> x = polished(conics, candidates.values[k]);
    const std::optional<Pose> pose = x ? pose_at(*s, x->x(), x->y()) : std::nullopt;
    if (pose) poses.cam_from_target[poses.count++] = *pose;
  }
  return poses;
}

}  // namespace sightline
