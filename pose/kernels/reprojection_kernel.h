// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The inner loop of everything that minimises reprojection errors. It works on plain arrays, so
// that it may be compiled for several kinds of processor (pose/multiversion.h). PackedPoints
// (pose/packed_points.h) is its face; reproject() in pose/reprojection.h is the plain version that
// the tests hold this one to.
#pragma once

#include <cstddef>

#include "pose/kernels/marquardt.h"

namespace sightline::kernel {

inline constexpr std::size_t kLanes = 4;

/// Four points side by side. Image coordinates are normalised (x/z, y/z); (w_uu, w_uv, w_vv) is the
/// symmetric matrix that weighs a residual: r^T W r in squared pixels. A lane whose w_uu and w_vv
/// are zero is not looked at.
struct alignas(32) PointLanes {
  double x[kLanes], y[kLanes], z[kLanes];
  double u[kLanes], v[kLanes];
  double w_uu[kLanes], w_uv[kLanes], w_vv[kLanes];
};

/// Four straight edges side by side, each at one pixel that it was seen to pass. The edge goes
/// through (x, y, z) along (dx, dy, dz); the pixel (u, v) is normalised, and (nu, nv) is one pixel
/// across the line that was seen there, in the same coordinates. The residual is the way from the
/// pixel to the edge along that normal, in pixels; `weight` multiplies its square. A lane whose
/// weight is zero is not looked at.
struct alignas(32) EdgeLanes {
  double x[kLanes], y[kLanes], z[kLanes];
  double dx[kLanes], dy[kLanes], dz[kLanes];
  double u[kLanes], v[kLanes];
  double nu[kLanes], nv[kLanes];
  double weight[kLanes];
};

/// An edge that is seen to run nearly along the normal, by a squared sine less than this, has no
/// residual.
inline constexpr double kLeastCrossing2 = 0.05 * 0.05;

/// What a pose is fitted to.
struct Observed {
  const PointLanes* points = nullptr;
  std::size_t point_count = 0;  ///< of lanes, four points each
  const EdgeLanes* edges = nullptr;
  std::size_t edge_count = 0;
};

/// x_in_cam = rotation x + translation; the rotation row by row.
struct RigidPose {
  double rotation[9];
  double translation[3];
};

/// Half the weighed sum of squares and its Gauss-Newton model in delta = (w, dt), where the pose is
/// (Exp(w) R, t + dt). The Hessian's upper triangle row by row.
struct NormalEquations {
  double cost;
  double gradient[6];
  double hessian[21];
};

/// False when a point that counts is at or behind the camera's plane.
bool normal_equations(const PointLanes* lanes, std::size_t count, const RigidPose& pose,
                      NormalEquations& model);

/// The same with edges, of which one without a residual counts as a point behind the camera.
bool normal_equations(const Observed& observed, const RigidPose& pose, NormalEquations& model);

struct Fit {
  FitStatus status;
  int iterations;
  RigidPose pose;
  NormalEquations model;  ///< one step, shorter than the tolerance, before `pose`
};

/// Marquardt's method (pose/kernels/marquardt.h) from one start. A step is short when it turns by
/// less than `step_tolerance` radians and moves by less than that part of the range. The short step
/// with which it converges is still taken, unless it leads behind the camera, and not looked at
/// again. Of a start behind the camera no model is given.
Fit fit(const Observed& observed, const RigidPose& start, int max_iterations,
        double step_tolerance);

/// By how much its correlation with the others may inflate the variance of a number before what is
/// left of its information is rounding, which leaves about 1e-15 in the sums.
inline constexpr double kLargestInflation = 1e13;

/// The inverse of a symmetric positive definite 6x6 matrix, upper triangles row by row. False where
/// it is singular to rounding (kLargestInflation). A pivot may stay well above rounding in a
/// matrix that is singular to it; the inverse does not.
bool invert(const double (&hessian)[21], double (&inverse)[21]);

/// ln det of a symmetric positive definite 6x6 matrix, upper triangle row by row; NaN otherwise.
double log_determinant(const double (&hessian)[21]);

}  // namespace sightline::kernel
