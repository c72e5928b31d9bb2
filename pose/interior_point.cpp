// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/interior_point.h"

#include <algorithm>
#include <cmath>

namespace sightline::interior_point {
namespace {

void fix_part(Eigen::Matrix<double, 2, 6>& jacobian, FreePart free) {
  if (free == FreePart::kRotation) jacobian.rightCols<3>().setZero();
  if (free == FreePart::kTranslation) jacobian.leftCols<3>().setZero();
}

}  // namespace

bool evaluate(const FitPoints& points, const Pose& pose, FreePart free,
              std::vector<Constraint>& constraints) {
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const std::optional<Reprojection> r = reproject(points, i, pose);
    if (!r) return false;
    Constraint& c = constraints[i];
    c.residual = r->residual_px;
    c.jacobian = r->jacobian;
    if (free != FreePart::kPose) fix_part(c.jacobian, free);
    c.slope.noalias() = c.jacobian.transpose() * (2 * c.residual);
    c.f = r->residual_px.squaredNorm();
    if (!std::isfinite(c.f)) return false;
  }
  return true;
}

double largest_of(const std::vector<Constraint>& constraints) {
  double largest = 0;
  for (const Constraint& c : constraints) largest = std::max(largest, c.f);
  return largest;
}

double mean_product(const std::vector<Constraint>& constraints) {
  double sum = 0;
  for (const Constraint& c : constraints) sum += c.multiplier * c.slack;
  return sum / static_cast<double>(constraints.size());
}

Matrix6d residual_curvature(const FitPoints& points, const Pose& pose, FreePart free,
                            const std::vector<Constraint>& constraints) {
  const Correspondences& camera = points.correspondences;
  Matrix6d sum = Matrix6d::Zero();
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const std::size_t index = points.index(i);
    const Eigen::Vector3d q = pose.rotation * camera.points_in_centred[index];
    const Eigen::Vector3d x = q + pose.translation;
    Eigen::Vector2d pull = 2 * constraints[i].multiplier * constraints[i].residual;
    if (!points.whitening.empty()) pull = (points.whitening[index].transpose() * pull).eval();
    // Of a x / z + b y / z by the point: gradient and second derivative.
    const double inverse_z = 1 / x.z();
    const double a = pull.x() * camera.fx_px * inverse_z;
    const double b = pull.y() * camera.fy_px * inverse_z;
    const double c = (a * x.x() + b * x.y()) * inverse_z;
    const Eigen::Vector3d gradient(a, b, -c);
    Eigen::Matrix3d second;
    second << 0, 0, -a, 0, 0, -b, -a, -b, 2 * c;
    second *= inverse_z;
    // x moves by w x q + dt, and by w x (w x q) / 2 at second order.
    Eigen::Matrix<double, 3, 6> motion;
    motion << 0, q.z(), -q.y(), 1, 0, 0, -q.z(), 0, q.x(), 0, 1, 0, q.y(), -q.x(), 0, 0, 0, 1;
    sum.noalias() += motion.transpose() * second * motion;
    sum.topLeftCorner<3, 3>() += 0.5 * (gradient * q.transpose() + q * gradient.transpose()) -
                                 gradient.dot(q) * Eigen::Matrix3d::Identity();
  }
  if (free == FreePart::kRotation) sum.rightCols<3>().setZero(), sum.bottomRows<3>().setZero();
  if (free == FreePart::kTranslation) sum.leftCols<3>().setZero(), sum.topRows<3>().setZero();
  return sum;
}

std::optional<NewtonSystem> newton_system(const std::vector<Constraint>& constraints,
                                          const Matrix6d& curvature, double least_ridge) {
  NewtonSystem system;
  Matrix6d matrix = Matrix6d::Zero();
  for (const Constraint& c : constraints) {
    const double weight = c.multiplier / c.slack;
    system.coupling += weight * c.slope;
    system.weight_sum += weight;
    // 2 l J^T J + w g g^T = J^T (2 l I + 4 w r r^T) J
    Eigen::Matrix2d core = (4 * weight) * c.residual * c.residual.transpose();
    core.diagonal().array() += 2 * c.multiplier;
    const Eigen::Matrix<double, 2, 6> cored = core * c.jacobian;
    matrix.noalias() += c.jacobian.transpose() * cored;
  }
  matrix.noalias() -= system.coupling * (system.coupling / system.weight_sum).transpose();
  matrix += curvature;
  for (const double ridge : {1e-13, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0}) {
    if (ridge < least_ridge) continue;
    system.ridge = ridge;
    system.matrix.emplace(matrix, ridge);
    if (system.matrix->is_ok()) return system;
  }
  return std::nullopt;
}

double length(const Step& step, const Pose& pose) {
  return std::max(step.delta.head<3>().norm(),
                  step.delta.tail<3>().norm() / pose.translation.norm());
}

Step newton_step(const NewtonSystem& system, std::vector<Constraint>& constraints, double mu) {
  Vector6d right = Vector6d::Zero();
  double excess = -1;
  for (const Constraint& c : constraints) {
    const double pull = (mu - c.correction + c.multiplier * c.miss) / c.slack;
    right -= pull * c.slope;
    excess += pull;
  }
  Step step;
  step.delta = system.matrix->solve(right + (excess / system.weight_sum) * system.coupling);
  step.bound_change = (excess + system.coupling.dot(step.delta)) / system.weight_sum;
  for (Constraint& c : constraints) {
    c.slack_change = step.bound_change - c.slope.dot(step.delta) - c.miss;
    c.multiplier_change =
        (mu - c.correction - c.multiplier * c.slack_change) / c.slack - c.multiplier;
  }
  return step;
}

StepLengths longest_steps(const std::vector<Constraint>& constraints, double part) {
  StepLengths lengths;
  for (const Constraint& c : constraints) {
    if (c.slack_change < 0) {
      lengths.primal = std::min(lengths.primal, -part * c.slack / c.slack_change);
    }
    if (c.multiplier_change < 0) {
      lengths.dual = std::min(lengths.dual, -part * c.multiplier / c.multiplier_change);
    }
  }
  return lengths;
}

double predict(std::vector<Constraint>& constraints, const Step& step, double products) {
  const StepLengths lengths = longest_steps(constraints, 1);
  double predicted = 0;
  for (Constraint& c : constraints) {
    predicted += (c.slack + lengths.primal * c.slack_change) *
                 (c.multiplier + lengths.dual * c.multiplier_change);
    c.correction = c.slack_change * c.multiplier_change;
    // The residual is nearly linear in the pose, f its square.
    c.miss += (c.jacobian * step.delta).squaredNorm();
  }
  const double part = predicted / static_cast<double>(constraints.size()) / products;
  return products * part * part * part;
}

double relative_gap(const std::vector<Constraint>& constraints) {
  double sum = 0;
  for (const Constraint& c : constraints) sum += c.multiplier;
  double largest = 0;
  double weighted = 0;
  Vector6d gradient = Vector6d::Zero();
  Matrix6d hessian = Matrix6d::Zero();
  for (const Constraint& c : constraints) {
    const double weight = c.multiplier / sum;
    largest = std::max(largest, c.f);
    weighted += weight * c.f;
    gradient += weight * c.slope;
    hessian.noalias() += c.jacobian.transpose() * (2 * weight * c.jacobian);
  }
  constexpr double kRidge = 1e-14;
  const ScaledCholesky cholesky(hessian, kRidge);
  if (!cholesky.is_ok()) return 1;
  const double bound = weighted - 0.5 * gradient.dot(cholesky.solve(gradient));
  const double gap = (largest - bound) / largest;
  return gap < 1 ? std::max(gap, 0.0) : 1;
}

}  // namespace sightline::interior_point
