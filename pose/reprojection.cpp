// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/reprojection.h"

#include <algorithm>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace sightline {
namespace {

using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

std::size_t lanes_for(std::size_t points) {
  return (points + kernel::kLanes - 1) / kernel::kLanes;
}

/// From an upper triangle row by row.
Matrix6d symmetric_from(const double (&upper)[21]) {
  Matrix6d m;
  const double* next = upper;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) m(row, column) = m(column, row) = *next++;
  }
  return m;
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Vector3d mean(std::span<const Eigen::Vector3d> points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

Eigen::Matrix3d scatter_of_centred(std::span<const Eigen::Vector3d> points) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) scatter.noalias() += p * p.transpose();
  return scatter;
}

/// Sum of the products of two eigenvalues of a symmetric matrix.
double second_invariant(const Eigen::Matrix3d& m) {
  return m(0, 0) * m(1, 1) - m(0, 1) * m(0, 1) + m(0, 0) * m(2, 2) - m(0, 2) * m(0, 2) +
         m(1, 1) * m(2, 2) - m(1, 2) * m(1, 2);
}

/// As PointSpread::is_collinear, but most clouds are seen not to be without their eigenvalues.
bool is_collinear(const Correspondences& c) {
  const Eigen::Matrix3d scatter = scatter_of_centred(c.points_in_centred);
  const double trace = scatter.trace();
  // The second eigenvalue over the first is at least half this ratio less its rounding.
  if (second_invariant(scatter) > 1e-8 * trace * trace) return false;
  return spread_of(c.points_in_centred).is_collinear();
}

bool is_usable(const Camera& camera) {
  return std::isfinite(camera.fx_px) && std::isfinite(camera.fy_px) && camera.fx_px > 0 &&
         camera.fy_px > 0;
}

}  // namespace

PreparedProblem prepare(const PoseProblem& problem) {
  const std::size_t n = problem.points_in_target.size();
  const std::optional<Pose>& initial = problem.initial_cam_from_target;
  const std::size_t minimum = initial ? kMinimumPosePointsFromInitial : kMinimumPosePoints;
  if (n < minimum || problem.pixels.size() != n) return {PoseStatus::kTooFewPoints, {}};
  if (!is_usable(problem.camera)) return {PoseStatus::kDegenerate, {}};
  if (initial && !is_valid(*initial)) return {PoseStatus::kDegenerate, {}};

  PreparedProblem prepared;
  Correspondences& c = prepared.correspondences;
  c.fx_px = problem.camera.fx_px;
  c.fy_px = problem.camera.fy_px;
  c.centroid_in_target = mean(problem.points_in_target);
  if (!c.centroid_in_target.allFinite()) return prepared;
  c.points_in_centred.reserve(n);
  c.pixels.reserve(n);
  const Eigen::Vector2d principal_point(problem.camera.cx_px, problem.camera.cy_px);
  const bool has_lens = !problem.camera.distortion.is_zero();
  for (std::size_t i = 0; i < n; ++i) {
    c.points_in_centred.push_back(problem.points_in_target[i] - c.centroid_in_target);
    Eigen::Vector2d pixel = problem.pixels[i] - principal_point;
    if (!pixel.allFinite()) return prepared;
    if (has_lens) {
      const auto ray = normalised_from_pixel(problem.camera, problem.pixels[i]);
      if (!ray) return prepared;
      pixel = {c.fx_px * ray->x(), c.fy_px * ray->y()};
    }
    c.pixels.push_back(pixel);
  }
  if (!is_collinear(c)) prepared.status = PoseStatus::kOk;
  return prepared;
}

Correspondences without(const Correspondences& all, std::size_t index) {
  Correspondences rest = all;
  rest.points_in_centred.erase(rest.points_in_centred.begin() + static_cast<std::ptrdiff_t>(index));
  rest.pixels.erase(rest.pixels.begin() + static_cast<std::ptrdiff_t>(index));
  return rest;
}

Pose to_centred(const Pose& cam_from_target, const Correspondences& c) {
  return {cam_from_target.rotation, cam_from_target * c.centroid_in_target};
}

Pose from_centred(const Pose& cam_from_centred, const Correspondences& c) {
  return {cam_from_centred.rotation, cam_from_centred * -c.centroid_in_target};
}

Matrix6d covariance_from_centred(const Matrix6d& covariance, const Pose& cam_from_centred,
                                 const Correspondences& c) {
  // t_target = t_centred - R centroid, so that dt_target = dt_centred + C w, C = [R centroid]x.
  const Eigen::Matrix3d transfer = cross_matrix(cam_from_centred.rotation * c.centroid_in_target);
  const Eigen::Matrix3d w = covariance.topLeftCorner<3, 3>();
  const Eigen::Matrix3d t_w = covariance.bottomLeftCorner<3, 3>();
  const Eigen::Matrix3d moved_t_w = t_w + transfer * w;
  const Eigen::Matrix3d half = transfer * (t_w + 0.5 * transfer * w).transpose();
  Matrix6d moved;
  moved.topLeftCorner<3, 3>() = w;
  moved.bottomLeftCorner<3, 3>() = moved_t_w;
  moved.topRightCorner<3, 3>() = moved_t_w.transpose();
  moved.bottomRightCorner<3, 3>() = covariance.bottomRightCorner<3, 3>() + half + half.transpose();
  return moved;
}

PointSpread spread_of(std::span<const Eigen::Vector3d> points) {
  PointSpread spread;
  spread.mean = mean(points);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d d = p - spread.mean;
    scatter += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);  // ascending
  spread.axes.col(0) = eigen.eigenvectors().col(2);
  spread.axes.col(1) = eigen.eigenvectors().col(1);
  spread.axes.col(2) = spread.axes.col(0).cross(spread.axes.col(1));
  spread.sd = eigen.eigenvalues().reverse().cwiseMax(0.0).cwiseSqrt();
  return spread;
}

std::vector<Pose> starting_poses(const Correspondences& c,
                                 const std::optional<Pose>& initial_cam_from_target) {
  if (initial_cam_from_target) return {to_centred(*initial_cam_from_target, c)};
  if (const std::optional<Pose> pose = weak_perspective_start(c)) return {*pose};
  return centred_starts(c, {.max_iterations = 20, .relative_tolerance = 1e-3});
}

std::optional<Eigen::Vector2d> residual_px(const Correspondences& c, std::size_t index,
                                           const Pose& cam_from_centred) {
  const Eigen::Vector3d x_in_cam = cam_from_centred * c.points_in_centred[index];
  if (!(x_in_cam.z() > 0)) return std::nullopt;
  return Eigen::Vector2d(c.fx_px * x_in_cam.x() / x_in_cam.z() - c.pixels[index].x(),
                         c.fy_px * x_in_cam.y() / x_in_cam.z() - c.pixels[index].y());
}

std::optional<Reprojection> reproject(const Correspondences& c, std::size_t index,
                                      const Pose& cam_from_centred) {
  const Eigen::Vector3d q = cam_from_centred.rotation * c.points_in_centred[index];
  const Eigen::Vector3d x_in_cam = q + cam_from_centred.translation;
  if (!(x_in_cam.z() > 0)) return std::nullopt;
  const double inverse_z = 1 / x_in_cam.z();
  const double u = x_in_cam.x() * inverse_z;
  const double v = x_in_cam.y() * inverse_z;
  const double su = c.fx_px * inverse_z;
  const double sv = c.fy_px * inverse_z;
  Reprojection result;
  result.residual_px << c.fx_px * u - c.pixels[index].x(), c.fy_px * v - c.pixels[index].y();
  result.jacobian << -su * u * q.y(), su * (q.z() + u * q.x()), -su * q.y(), su, 0, -su * u,  //
      -sv * (q.z() + v * q.y()), sv * v * q.x(), sv * q.x(), 0, sv, -sv * v;
  return result;
}

Pose retract(const Pose& pose, const Vector6d& delta) {
  return {rotation_from_vector(delta.head<3>()) * pose.rotation,
          pose.translation + delta.tail<3>()};
}

std::optional<Vector6d> marquardt_step(const LocalModel& model, double damping) {
  Matrix6d damped = model.hessian;
  damped.diagonal() *= 1 + damping;
  const Eigen::LLT<Matrix6d> cholesky(damped);
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  const Vector6d delta = -cholesky.solve(model.gradient);
  return delta.allFinite() ? std::optional(delta) : std::nullopt;
}

bool is_short_step(const Vector6d& delta, const Pose& pose, double tolerance) {
  return delta.head<3>().norm() < tolerance &&
         delta.tail<3>().norm() < tolerance * pose.translation.norm();
}

double promised_decrease(const LocalModel& model, const Vector6d& delta) {
  return -delta.dot(model.gradient) - 0.5 * delta.dot(model.hessian * delta);
}

std::optional<Matrix6d> inverse_information(const Matrix6d& information) {
  /// Of the correlation matrix: the part of a parameter's information that the others leave it.
  /// Rounding in the sums leaves about 1e-15.
  constexpr double kSmallestPivot = 1e-13;
  const Vector6d diagonal = information.diagonal();
  if (!information.allFinite() || !(diagonal.minCoeff() > 0)) return std::nullopt;
  const Vector6d scale = diagonal.cwiseSqrt().cwiseInverse();
  const Matrix6d correlation = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::LLT<Matrix6d> cholesky(correlation);
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  const Matrix6d root = cholesky.matrixL();
  if (!(root.diagonal().minCoeff() > std::sqrt(kSmallestPivot))) return std::nullopt;
  const Matrix6d inverse = cholesky.solve(Matrix6d::Identity());
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

PackedPoints::PackedPoints(const Correspondences& c, std::size_t lanes) : count_(lanes) {
  if (lanes > kInline) heap_.resize(lanes);
  const auto place = [&](std::size_t i) -> std::pair<kernel::PointLanes&, std::size_t> {
    return {data()[i / kernel::kLanes], i % kernel::kLanes};
  };
  const Eigen::Vector2d normalised_from_px(1 / c.fx_px, 1 / c.fy_px);
  for (std::size_t i = 0; i < c.size(); ++i) {
    const auto [p, lane] = place(i);
    p.x[lane] = c.points_in_centred[i].x();
    p.y[lane] = c.points_in_centred[i].y();
    p.z[lane] = c.points_in_centred[i].z();
    p.u[lane] = c.pixels[i].x() * normalised_from_px.x();
    p.v[lane] = c.pixels[i].y() * normalised_from_px.y();
  }
  for (std::size_t i = c.size(); i < lanes * kernel::kLanes; ++i) {
    const auto [p, lane] = place(i);
    p.x[lane] = p.y[lane] = p.z[lane] = p.u[lane] = p.v[lane] = 0;
    p.w_uu[lane] = p.w_uv[lane] = p.w_vv[lane] = 0;
  }
}

PackedPoints::PackedPoints(const Correspondences& c, std::span<const double> weights)
    : PackedPoints(c, lanes_for(c.size())) {
  for (std::size_t i = 0; i < c.size(); ++i) {
    kernel::PointLanes& p = data()[i / kernel::kLanes];
    const std::size_t lane = i % kernel::kLanes;
    const double weight = weights.empty() ? 1.0 : weights[i];
    p.w_uu[lane] = weight * c.fx_px * c.fx_px;
    p.w_uv[lane] = 0;
    p.w_vv[lane] = weight * c.fy_px * c.fy_px;
  }
}

PackedPoints::PackedPoints(const Correspondences& c, std::span<const Eigen::Matrix2d> weights)
    : PackedPoints(c, lanes_for(c.size())) {
  for (std::size_t i = 0; i < c.size(); ++i) {
    kernel::PointLanes& p = data()[i / kernel::kLanes];
    const std::size_t lane = i % kernel::kLanes;
    p.w_uu[lane] = weights[i](0, 0) * c.fx_px * c.fx_px;
    p.w_uv[lane] = weights[i](0, 1) * c.fx_px * c.fy_px;
    p.w_vv[lane] = weights[i](1, 1) * c.fy_px * c.fy_px;
  }
}

kernel::Fit PackedPoints::fit(const Pose& start, int max_iterations, double step_tolerance) const {
  return kernel::fit(data(), count_, rigid_from(start), max_iterations, step_tolerance);
}

void PackedPoints::scale_weight(std::size_t point, double factor) {
  kernel::PointLanes& p = data()[point / kernel::kLanes];
  const std::size_t lane = point % kernel::kLanes;
  p.w_uu[lane] *= factor;
  p.w_uv[lane] *= factor;
  p.w_vv[lane] *= factor;
}

Pose pose_from(const kernel::RigidPose& pose) {
  return {Eigen::Map<const RowMajor3d>(pose.rotation),
          Eigen::Map<const Eigen::Vector3d>(pose.translation)};
}

kernel::RigidPose rigid_from(const Pose& pose) {
  kernel::RigidPose rigid;
  Eigen::Map<RowMajor3d>(rigid.rotation) = pose.rotation;
  Eigen::Map<Eigen::Vector3d>(rigid.translation) = pose.translation;
  return rigid;
}

std::optional<Matrix6d> inverse_of(const kernel::NormalEquations& model) {
  double upper[21];
  if (!kernel::invert(model.hessian, upper)) return std::nullopt;
  return symmetric_from(upper);
}

std::optional<Matrix6d> information_at(const PackedPoints& points, const Pose& cam_from_centred) {
  kernel::NormalEquations model;
  const auto lanes = points.lanes();
  if (!kernel::normal_equations(lanes.data(), lanes.size(), rigid_from(cam_from_centred), model)) {
    return std::nullopt;
  }
  return symmetric_from(model.hessian);
}

}  // namespace sightline
