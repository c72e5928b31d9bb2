// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Other libraries at tight tolerances find the same least-squares minimum as LSPE. OpenGV is not
// among them: it minimises the angle of the bearings, whose minimum is another.
#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "pose/solver.h"
#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

/// Angle between minima, and the part of the range.
constexpr double kSameMinimum = 1e-6;

Pose by_opencv(const PoseProblem& problem) {
  const Camera& camera = problem.camera;
  const cv::Matx33d matrix(camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1);
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (std::size_t i = 0; i < problem.pixels.size(); ++i) {
    const Eigen::Vector3d& p = problem.points_in_target[i];
    points.emplace_back(p.x(), p.y(), p.z());
    pixels.emplace_back(problem.pixels[i].x(), problem.pixels[i].y());
  }
  const Eigen::Vector3d w = vector_from_rotation(problem.initial_cam_from_target->rotation);
  const Eigen::Vector3d& t = problem.initial_cam_from_target->translation;
  cv::Vec3d rotation(w.x(), w.y(), w.z());
  cv::Vec3d translation(t.x(), t.y(), t.z());
  cv::solvePnPRefineLM(points, pixels, matrix, cv::noArray(), rotation, translation,
                       {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 500, 1e-15});
  return {rotation_from_vector({rotation[0], rotation[1], rotation[2]}),
          {translation[0], translation[1], translation[2]}};
}

struct CeresResidual {
  Eigen::Vector3d point;
  Eigen::Vector2d pixel;
  Camera camera;

  template <typename T>
  bool operator()(const T* rotation, const T* translation, T* residual) const {
    const T x_in_target[3] = {T(point.x()), T(point.y()), T(point.z())};
    T x[3];
    ceres::AngleAxisRotatePoint(rotation, x_in_target, x);
    for (int i = 0; i < 3; ++i) x[i] += translation[i];
    residual[0] = camera.fx_px * x[0] / x[2] + camera.cx_px - pixel.x();
    residual[1] = camera.fy_px * x[1] / x[2] + camera.cy_px - pixel.y();
    return true;
  }
};

Pose by_ceres(const PoseProblem& problem) {
  const Pose& start = *problem.initial_cam_from_target;
  Eigen::Vector3d w = vector_from_rotation(start.rotation);
  Eigen::Vector3d t = start.translation;
  ceres::Problem sum;
  for (std::size_t i = 0; i < problem.pixels.size(); ++i) {
    sum.AddResidualBlock(new ceres::AutoDiffCostFunction<CeresResidual, 2, 3, 3>(new CeresResidual{
                             problem.points_in_target[i], problem.pixels[i], problem.camera}),
                         nullptr, w.data(), t.data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 500;
  options.function_tolerance = options.gradient_tolerance = 1e-30;
  options.parameter_tolerance = 1e-13;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &sum, &summary);
  return {rotation_from_vector(w), t};
}

class Peers : public testing::TestWithParam<Pose (*)(const PoseProblem&)> {};

INSTANTIATE_TEST_SUITE_P(Libraries, Peers, testing::Values(by_opencv, by_ceres),
                         [](const auto& library) {
                           return library.index == 0 ? "OpenCV" : "Ceres";
                         });

TEST_P(Peers, FindTheSameMinimumAsLspe) {
  Draw draw(60);
  SolverOptions options;
  options.lspe.step_tolerance = 1e-9;
  for (int i = 0; i < 200; ++i) {
    Synthetic s = cube_problem(2, draw);
    s.problem.initial_cam_from_target = {
        draw.rotation_by(10 * kDegree) * s.cam_from_target.rotation,
        1.05 * s.cam_from_target.translation};
    const Pose ours = find_pose_solver("lspe")->solve(s.problem, options).cam_from_target;
    const double range_m = s.cam_from_target.translation.norm();
    EXPECT_TRUE(is_pose_near(GetParam()(s.problem), ours, kSameMinimum, kSameMinimum * range_m));
    // The negative twin: the truth is another pose.
    EXPECT_FALSE(is_pose_near(s.cam_from_target, ours, kSameMinimum, kSameMinimum * range_m));
  }
}

}  // namespace
}  // namespace sightline
