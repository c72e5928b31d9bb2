// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/lines/joint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "pose/consensus/cloud.h"

namespace sightline::lines {
namespace {

/// The inverse covariance of a point in pixels without lens.
Eigen::Matrix2d weight_of(const PoseProblem& problem, const consensus::UsablePoint& point) {
  if (!problem.covariances_px2.empty()) return point.whitening.transpose() * point.whitening;
  const Camera& camera = problem.camera;
  const double sigma_px = problem.sigma_px > 0 ? problem.sigma_px : 1;
  const double weight = 1 / (sigma_px * sigma_px);
  if (is_straight(camera)) return Eigen::Vector2d(weight, weight).asDiagonal();
  const Eigen::Vector2d ray(point.pixel.x() / camera.fx_px, point.pixel.y() / camera.fy_px);
  const Eigen::Matrix2d lens = lens_jacobian(camera, ray);
  return weight * lens.transpose() * lens;
}

void add_points(const PoseProblem& problem, Joint& joint) {
  joint.points.points_in_centred.reserve(problem.pixels.size());
  joint.points.pixels.reserve(problem.pixels.size());
  joint.point_weights.reserve(problem.pixels.size());
  for (std::size_t i = 0; i < problem.pixels.size(); ++i) {
    const auto point = consensus::usable_point(problem, i);
    if (!point) {
      joint.ignored.push_back(static_cast<int>(i));
      continue;
    }
    joint.observed.push_back({point->index, false, joint.points.size(), 2});
    joint.points.points_in_centred.push_back(point->x_in_target);
    joint.points.pixels.push_back(point->pixel);
    joint.point_weights.push_back(weight_of(problem, *point));
  }
}

void add_lines(const PoseProblem& problem, Joint& joint) {
  joint.edges.reserve(2 * problem.lines.size());
  for (std::size_t i = 0; i < problem.lines.size(); ++i) {
    const int index = static_cast<int>(i);
    const auto points = edge_points_of(problem.lines[i], problem.camera);
    if (!points) {
      joint.ignored_lines.push_back(index);
      continue;
    }
    joint.observed.push_back({index, true, joint.edges.size(), static_cast<int>(points->size())});
    joint.edges.insert(joint.edges.end(), points->begin(), points->end());
  }
}

/// Whether two observations are of one point, or of one edge.
bool is_same(const Joint& joint, const Observed& a, const Observed& b) {
  if (a.is_line != b.is_line) return false;
  if (!a.is_line) {
    return joint.points.points_in_centred[a.first] == joint.points.points_in_centred[b.first];
  }
  const EdgePoint& edge = joint.edges[a.first];
  const EdgePoint& other = joint.edges[b.first];
  return (edge.begin_in_target == other.begin_in_target &&
          edge.end_in_target == other.end_in_target) ||
         (edge.begin_in_target == other.end_in_target &&
          edge.end_in_target == other.begin_in_target);
}

/// Whether the observations say as many numbers of the pose as so many points, up to kFewest; what
/// is given twice says no more.
bool tells_as_much_as(const Joint& joint, std::size_t points) {
  struct Told {
    const Observed* observed = nullptr;
    int numbers = 0;
  };
  std::array<Told, 2 * kFewest> all;
  std::size_t count = 0;
  int numbers = 0;
  for (const Observed& observed : joint.observed) {
    const auto end = all.begin() + static_cast<std::ptrdiff_t>(count);
    const auto told = std::find_if(all.begin(), end, [&](const Told& other) {
      return is_same(joint, *other.observed, observed);
    });
    if (told == end) {
      *told = {&observed, 0};
      ++count;
    }
    const int more = std::min(observed.numbers, 2 - told->numbers);
    told->numbers += more;
    numbers += more;
    if (numbers >= 2 * static_cast<int>(points)) return true;
  }
  return false;
}

/// The middle of all that is seen of the target.
void centre(Joint& joint) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : joint.points.points_in_centred) sum += p;
  for (const EdgePoint& edge : joint.edges) {
    sum += (edge.begin_in_target + edge.end_in_target) / 2;
  }
  joint.points.centroid_in_target =
      sum / static_cast<double>(joint.points.size() + joint.edges.size());
  for (Eigen::Vector3d& p : joint.points.points_in_centred) p -= joint.points.centroid_in_target;
}

/// The packed observations, each of its weight.
struct Packed {
  PackedPoints points;
  PackedEdges edges;

  Packed(const Joint& joint, std::span<const double> weights)
      : points(joint.packed_points()), edges(joint.packed_edges()) {
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const Observed& observed = joint.observed[i];
      if (!observed.is_line) {
        points.scale_weight(observed.first, weights[i]);
        continue;
      }
      for (std::size_t k = observed.first; k < observed.first + observed.numbers; ++k) {
        edges.set_weight(k, weights[i] / joint.edges[k].variance_px2);
      }
    }
  }

  kernel::Observed observed() const {
    return {points.lanes().data(), points.lanes().size(), edges.lanes().data(),
            edges.lanes().size()};
  }
};

/// Attitudes spread evenly (Alexa, "Super-Fibonacci spirals", CVPR 2022).
Eigen::Matrix3d spread_attitude(int index, int count) {
  constexpr double kPsi = 1.533751168755204288118041;
  const double s = index + 0.5;
  const double inner = std::sqrt(s / count), outer = std::sqrt(1 - s / count);
  const double a = 2 * std::numbers::pi * s / std::numbers::sqrt2;
  const double b = 2 * std::numbers::pi * s / kPsi;
  return rotation_from_quaternion_wxyz(
      {inner * std::sin(a), inner * std::cos(a), outer * std::sin(b), outer * std::cos(b)});
}

/// The rows (a, b) of a . t = b that an attitude leaves of the position.
class PositionRows {
 public:
  void add(const Eigen::Vector3d& a, double b) {
    const double length2 = a.squaredNorm();
    if (!(length2 > 0)) return;
    normal_ += a * a.transpose() / length2;
    right_ += a * b / length2;
  }
  Eigen::Vector3d solution() const { return normal_.ldlt().solve(right_); }

 private:
  Eigen::Matrix3d normal_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_ = Eigen::Vector3d::Zero();
};

Eigen::Vector3d position_at(const Joint& joint, const Eigen::Matrix3d& rotation) {
  PositionRows rows;
  for (std::size_t i = 0; i < joint.points.size(); ++i) {
    const Eigen::Vector3d x = rotation * joint.points.points_in_centred[i];
    const Eigen::Vector2d& pixel = joint.points.pixels[i];
    const Eigen::Vector3d u(1, 0, -pixel.x() / joint.points.fx_px);
    const Eigen::Vector3d v(0, 1, -pixel.y() / joint.points.fy_px);
    rows.add(u, -u.dot(x));
    rows.add(v, -v.dot(x));
  }
  for (const EdgePoint& edge : joint.edges) {
    const Eigen::Vector3d begin =
        rotation * (edge.begin_in_target - joint.points.centroid_in_target);
    const Eigen::Vector3d along = rotation * (edge.end_in_target - edge.begin_in_target);
    const Eigen::Vector3d plane = along.cross(edge.ray.homogeneous());
    rows.add(plane, -plane.dot(begin));
  }
  return rows.solution();
}

/// The squared sine at which an observation's edge crosses the normals of its line, 1 of a point; 0
/// where it has no residual. A residual times the sine is the distance of the line from the edge,
/// which has no end however wrong the pose is.
double crossing2_of(const Joint& joint, const Observed& observed, const Pose& cam_from_centred) {
  if (!squares_of(joint, observed, cam_from_centred)) return 0;
  if (!observed.is_line) return 1;
  const Pose cam_from_target = from_centred(cam_from_centred, joint.points);
  double least = 1;
  for (std::size_t k = observed.first; k < observed.first + observed.numbers; ++k) {
    const EdgePoint& edge = joint.edges[k];
    const Eigen::Vector2d across =
        (cam_from_target * edge.begin_in_target)
            .cross(cam_from_target.rotation * (edge.end_in_target - edge.begin_in_target))
            .head<2>();
    const double along_normal = across.dot(edge.normal_per_px);
    least = std::min(least, along_normal * along_normal /
                                (across.squaredNorm() * edge.normal_per_px.squaredNorm()));
  }
  return least;
}

/// Least squares of these distances in a few rounds, from a pose at which many edges may be seen
/// along the normals of their lines: there residuals are huge, or there are none.
Pose pose_by_crossings(const Joint& joint, Pose pose) {
  // Of what is weaker a step might lose the residual, and with it be refused.
  constexpr double kLeastCrossing2 = 0.1;
  constexpr int kRounds = 15;
  constexpr int kStepsARound = 3;
  constexpr double kTolerance = 1e-4;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> weights;
    for (const Observed& observed : joint.observed) {
      const double crossing2 = crossing2_of(joint, observed, pose);
      weights.push_back(crossing2 > kLeastCrossing2 ? crossing2 : 0);
    }
    const kernel::Fit fitted = fit(joint, weights, pose, kStepsARound, kTolerance);
    if (fitted.status == kernel::FitStatus::kStartBehindCamera) break;
    const Pose next = pose_from(fitted.pose);
    if (!is_valid(next)) break;
    pose = next;
  }
  return pose;
}

}  // namespace

PreparedJoint prepare_joint(const PoseProblem& problem) {
  PreparedJoint prepared;
  Joint& joint = prepared.joint;
  const std::optional<Pose> initial = consensus::rigid_pose(problem.initial_cam_from_target);
  const std::size_t fewest = initial ? kFewestFromInitial : kFewest;
  if (problem.pixels.size() + problem.lines.size() < fewest) {
    prepared.status = PoseStatus::kTooFewPoints;
    return prepared;
  }
  const Camera& camera = problem.camera;
  const bool has_focal = camera.fx_px > 0 && camera.fy_px > 0 && std::isfinite(camera.fx_px) &&
                         std::isfinite(camera.fy_px);
  if (!has_focal || !(problem.sigma_px >= 0)) return prepared;
  joint.points.fx_px = camera.fx_px;
  joint.points.fy_px = camera.fy_px;
  joint.is_noise_known = is_noise_known(problem);
  joint.observed.reserve(problem.pixels.size() + problem.lines.size());
  add_points(problem, joint);
  add_lines(problem, joint);
  if (!tells_as_much_as(joint, fewest)) return prepared;
  centre(joint);
  if (initial) joint.initial_cam_from_centred = to_centred(*initial, joint.points);
  prepared.status = PoseStatus::kOk;
  return prepared;
}

bool is_noise_known(const PoseProblem& problem) {
  return !problem.covariances_px2.empty() || problem.sigma_px > 0 || problem.pixels.empty();
}

double image_unit_px(const Joint& joint) {
  std::vector<Eigen::Vector2d> pixels = joint.points.pixels;
  std::vector<double> noises_px;
  for (const Eigen::Matrix2d& weight : joint.point_weights) {
    noises_px.push_back(std::pow(weight.determinant(), -0.25));
  }
  for (const EdgePoint& edge : joint.edges) {
    pixels.emplace_back(joint.points.fx_px * edge.ray.x(), joint.points.fy_px * edge.ray.y());
    noises_px.push_back(std::sqrt(edge.variance_px2));
  }
  const auto middle = noises_px.begin() + static_cast<std::ptrdiff_t>(noises_px.size() / 2);
  std::ranges::nth_element(noises_px, middle);
  return consensus::image_unit_px(pixels, joint.is_noise_known ? *middle : 0);
}

std::optional<double> squares_of(const Joint& joint, const Observed& observed,
                                 const Pose& cam_from_centred) {
  if (!observed.is_line) {
    const auto r = residual_px(joint.points, observed.first, cam_from_centred);
    if (!r) return std::nullopt;
    return r->dot(joint.point_weights[observed.first] * *r);
  }
  const Pose cam_from_target = from_centred(cam_from_centred, joint.points);
  double squares = 0;
  for (std::size_t k = observed.first; k < observed.first + observed.numbers; ++k) {
    const auto r = edge_residual(joint.edges[k], cam_from_target);
    if (!r) return std::nullopt;
    squares += r->residual_px * r->residual_px / joint.edges[k].variance_px2;
  }
  return squares;
}

kernel::Fit fit(const Joint& joint, std::span<const double> weights, const Pose& start,
                int max_iterations, double step_tolerance) {
  const Packed packed(joint, weights);
  return kernel::fit(packed.observed(), rigid_from(start), max_iterations, step_tolerance);
}

kernel::Fit fit_all(const Joint& joint, const Pose& start, int max_iterations,
                    double step_tolerance, bool& has_all) {
  kernel::Fit fitted = fit(joint, {}, start, max_iterations, step_tolerance);
  if (fitted.status == kernel::FitStatus::kConverged) {
    has_all = true;
    return fitted;
  }
  kernel::Fit near =
      fit(joint, {}, pose_by_crossings(joint, start), max_iterations, step_tolerance);
  near.iterations += fitted.iterations;
  const bool is_none = fitted.status == kernel::FitStatus::kStartBehindCamera;
  const bool is_near_one = near.status != kernel::FitStatus::kStartBehindCamera;
  const bool is_better = is_near_one && (near.status == kernel::FitStatus::kConverged ||
                                         near.model.cost < fitted.model.cost);
  if (is_near_one && (is_none || is_better)) fitted = near;
  has_all = fitted.status != kernel::FitStatus::kStartBehindCamera;
  return fitted;
}

std::optional<Matrix6d> information_at(const Joint& joint, std::span<const double> weights,
                                       const Pose& cam_from_centred) {
  const Packed packed(joint, weights);
  kernel::NormalEquations model;
  if (!kernel::normal_equations(packed.observed(), rigid_from(cam_from_centred), model)) {
    return std::nullopt;
  }
  return hessian_of(model);
}

std::vector<Pose> starts_over_attitudes(const Joint& joint) {
  constexpr int kAttitudes = 80;  // none is farther than some 40 degrees from one of them
  std::vector<Pose> starts;
  for (int i = 0; i < kAttitudes; ++i) {
    Pose start;
    start.rotation = spread_attitude(i, kAttitudes);
    start.translation = position_at(joint, start.rotation);
    if (start.translation.allFinite() && start.translation.z() > 0) starts.push_back(start);
  }
  return starts;
}

std::vector<Pose> starts_of(const Joint& joint, const PoseEstimate& from_points) {
  std::vector<Pose> starts;
  if (from_points.status == PoseStatus::kOk) {
    starts.push_back(to_centred(from_points.cam_from_target, joint.points));
    if (from_points.second_cam_from_target) {
      starts.push_back(to_centred(*from_points.second_cam_from_target, joint.points));
    }
  }
  if (joint.initial_cam_from_centred) starts.push_back(*joint.initial_cam_from_centred);
  return starts;
}

PoseProblem points_of(PoseProblem problem) {
  problem.lines.clear();
  return problem;
}

}  // namespace sightline::lines
