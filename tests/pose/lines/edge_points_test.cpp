// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/edge_points.h"

#include <cmath>
#include <limits>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "pose/bounds.h"
#include "pose/packed_points.h"
#include "tests/pose/lines/seen_lines.h"
#include "tests/pose/matchers.h"

namespace sightline {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// An edge of a target of a metre some fifty metres away, and a pixel near its image.
EdgePoint random_edge_point(const Pose& pose, Draw& draw) {
  EdgePoint point;
  point.begin_in_target = draw.in_box(0.5);
  point.end_in_target = draw.in_box(0.5);
  const Eigen::Vector3d begin = pose * point.begin_in_target, end = pose * point.end_in_target;
  const Eigen::Vector2d a = begin.head<2>() / begin.z(), b = end.head<2>() / end.z();
  const Eigen::Vector2d along = (b - a).normalized();
  point.ray = a + draw.uniform(0, 1) * (b - a) + 2e-4 * draw.vector().head<2>();
  const double turn_rad = draw.uniform(-1, 1);
  const Eigen::Vector2d normal(-along.y(), along.x());
  point.normal_per_px = (std::cos(turn_rad) * normal + std::sin(turn_rad) * along) / 15000;
  point.variance_px2 = draw.uniform(0.1, 2);
  return point;
}

TEST(EdgePoints, TheDerivativeIsThatOfDifferences) {
  // Central differences of a step of 1e-6: their own error is its square times third derivatives,
  // and rounding of 1e-9 px over the step.
  constexpr double kStep = 1e-6, kTolerance = 1e-5;
  Draw draw(70);
  for (int k = 0; k < 50; ++k) {
    const Pose pose = cube_pose(draw);
    const EdgePoint point = random_edge_point(pose, draw);
    const auto residual = edge_residual(point, pose);
    ASSERT_TRUE(residual) << k;
    for (int i = 0; i < 6; ++i) {
      Vector6d change = Vector6d::Zero();
      change[i] = kStep;
      const auto after = edge_residual(point, retract(pose, change));
      const auto before = edge_residual(point, retract(pose, -change));
      ASSERT_TRUE(after && before);
      const double slope = (after->residual_px - before->residual_px) / (2 * kStep);
      EXPECT_NEAR(residual->jacobian[i], slope, kTolerance * residual->jacobian.norm()) << k;
    }
  }
}

TEST(EdgePoints, TheResidualIsTheWayToTheProjectedEdge) {
  Draw draw(71);
  const Camera camera = centred_camera(512, 512, 15000);
  for (int k = 0; k < 20; ++k) {
    const Pose pose = cube_pose(draw);
    const Segment edge{draw.in_box(0.5), draw.in_box(0.5)};
    LineObservation line = exact_line(camera, pose, edge, 1);
    shift(line, 3.5);
    line.covariance = Eigen::Vector2d(1, kInfinity).asDiagonal();
    const auto points = edge_points_of(line, camera);
    ASSERT_TRUE(points);
    ASSERT_EQ(points->size(), 1U);
    EXPECT_NEAR(edge_residual((*points)[0], pose)->residual_px, -3.5, 1e-8) << k;
  }
}

TEST(EdgePoints, NoneIsSeenAlongTheNormalOrBehindTheCamera) {
  Pose pose;
  pose.translation.z() = 10;
  EdgePoint point;
  point.begin_in_target = {0, 0, 0};
  point.end_in_target = {1, 0, 0};
  point.normal_per_px = {0, 1e-3};
  EXPECT_TRUE(edge_residual(point, pose));
  point.normal_per_px = {1e-3, 0};
  EXPECT_FALSE(edge_residual(point, pose));
  point.normal_per_px = {0, 1e-3};
  pose.translation.z() = -10;
  EXPECT_FALSE(edge_residual(point, pose));
}

TEST(EdgePoints, TheKernelSumsWhatThePlainVersionSays) {
  constexpr double kSumRounding = 1e-11;
  Draw draw(72);
  for (const int n : {1, 2, 4, 5, 16, 17, 23}) {
    const Pose pose = cube_pose(draw);
    std::vector<EdgePoint> points;
    double cost = 0;
    Matrix6d hessian = Matrix6d::Zero();
    Vector6d gradient = Vector6d::Zero();
    for (int i = 0; i < n; ++i) {
      points.push_back(random_edge_point(pose, draw));
      const EdgeResidual r = edge_residual(points.back(), pose).value();
      const double weight = 1 / points.back().variance_px2;
      cost += 0.5 * weight * r.residual_px * r.residual_px;
      gradient += weight * r.residual_px * r.jacobian.transpose();
      hessian += weight * r.jacobian.transpose() * r.jacobian;
    }
    const PackedEdges packed(points, Eigen::Vector3d::Zero());
    const kernel::Observed observed{.edges = packed.lanes().data(),
                                    .edge_count = packed.lanes().size()};
    kernel::NormalEquations model;
    ASSERT_TRUE(kernel::normal_equations(observed, rigid_from(pose), model)) << n;
    EXPECT_NEAR(model.cost, cost, kSumRounding * cost) << n;
    EXPECT_TRUE(is_matrix_near(Vector6d(Eigen::Map<const Vector6d>(model.gradient)), gradient,
                               kSumRounding * gradient.norm()));
    EXPECT_TRUE(is_matrix_near(hessian_of(model), hessian, kSumRounding * hessian.norm()));
  }
}

TEST(EdgePoints, AnUndefinedEdgeCountsInTheKernelOnlyWithWeight) {
  Draw draw(73);
  Pose pose = cube_pose(draw);
  const std::vector<EdgePoint> points{random_edge_point(pose, draw), random_edge_point(pose, draw)};
  pose.translation.z() *= -1;
  PackedEdges packed(points, Eigen::Vector3d::Zero());
  const auto is_defined = [&] {
    kernel::NormalEquations model;
    return kernel::normal_equations({.edges = packed.lanes().data(), .edge_count = 1},
                                    rigid_from(pose), model);
  };
  EXPECT_FALSE(is_defined());
  for (const size_t i : {0, 1}) packed.set_weight(i, 0);
  EXPECT_TRUE(is_defined());
}

// Of two edge points the covariance of offset and slope at the line's pixel.
Eigen::Matrix2d covariance_of(const EdgePoints& points, const LineObservation& line,
                              const Camera& camera) {
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  for (const EdgePoint& point : points) {
    const auto pixel = pixel_from_normalised(camera, point.ray);
    const Eigen::Vector2d row(1, line.direction.dot(pixel - line.pixel));
    information += row * row.transpose() / point.variance_px2;
  }
  return information.inverse();
}

TEST(EdgePoints, TwoOfThemSayWhatTheLineSays) {
  Draw draw(74);
  const Camera camera = centred_camera(512, 512, 15000);
  for (int k = 0; k < 20; ++k) {
    LineObservation line =
        exact_line(camera, cube_pose(draw), {draw.in_box(0.5), draw.in_box(0.5)}, 1);
    const double offset_sd = draw.uniform(0.05, 1), slope_sd = draw.uniform(1e-3, 1e-1);
    const double correlation = draw.uniform(-0.95, 0.95);
    const double mixed = correlation * offset_sd * slope_sd;
    line.covariance << offset_sd * offset_sd, mixed, mixed, slope_sd * slope_sd;
    const auto points = edge_points_of(line, camera);
    ASSERT_TRUE(points);
    EXPECT_TRUE(is_matrix_near(covariance_of(*points, line, camera), line.covariance,
                               1e-8 * line.covariance.norm()));
  }
}

TEST(EdgePoints, ALensIsUndoneWithTheNoise) {
  Camera camera = centred_camera(640, 480, 600);
  camera.lens = BrownConrady{.k1 = -0.25};
  LineObservation line = line_through({500, 90}, {520, 130}, 0.5);
  line.end_in_target = {1, 0, 0};
  const auto points = edge_points_of(line, camera);
  ASSERT_TRUE(points);
  const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
  const Eigen::Vector2d ray = *normalised_from_pixel(camera, line.pixel);
  // At the line's pixel a step across it moves the ray by the normal's way, up to moves along it.
  constexpr double kStepPx = 1e-4;
  const auto moved = [&](const Eigen::Vector2d& way) -> Eigen::Vector2d {
    return (*normalised_from_pixel(camera, line.pixel + kStepPx * way) - ray) / kStepPx;
  };
  for (const EdgePoint& point : *points) {
    const Eigen::Vector2d across = point.normal_per_px.normalized();
    EXPECT_NEAR(across.dot(moved(normal)), point.normal_per_px.norm(), 1e-6 * moved(normal).norm());
    EXPECT_NEAR(across.dot(moved(line.direction).normalized()), 0, 1e-6);
    EXPECT_NEAR(across.dot((point.ray - ray).normalized()), 0, 1e-6);  // they lie along it
  }
}

// Where it touches the curve that a lens makes of a straight edge, a line has no residual at all,
// however long the edge.
TEST(EdgePoints, WhatTouchesTheImageOfAnEdgeIsItsLine) {
  Camera camera = centred_camera(640, 480, 300);
  camera.lens = BrownConrady{.k1 = -0.2, .k2 = 0.02};
  Pose pose;
  pose.translation = {0.3, -0.4, 2};
  LineObservation line;
  line.begin_in_target = {-1, 0.1, 0.3};
  line.end_in_target = {0.8, -0.3, -0.2};
  const auto seen = [&](double t) {
    const Eigen::Vector3d along = line.end_in_target - line.begin_in_target;
    return project(camera, pose * Eigen::Vector3d(line.begin_in_target + t * along)).value();
  };
  constexpr double kAt = 0.3, kStep = 1e-5;
  line.pixel = seen(kAt);
  line.direction = seen(kAt + kStep) - seen(kAt - kStep);
  line.covariance = Eigen::Vector2d(1, 1e-4).asDiagonal();  // edge points 100 px to either side
  const auto points = edge_points_of(line, camera);
  ASSERT_TRUE(points);
  for (const EdgePoint& point : *points) {
    EXPECT_NEAR(edge_residual(point, pose).value().residual_px, 0, 1e-5);
  }
  const auto chord = edge_points_of(line, centred_camera(640, 480, 300));  // without the lens
  EXPECT_GT(std::abs(edge_residual((*chord)[0], pose).value().residual_px), 0.5);
}

TEST(LineObservation, EdgePixelsMakeTheCovarianceOfAFittedLine) {
  // 200 edge pixels over 100 px: sums against the integrals that stand for them.
  double n = 0, squares = 0;
  for (int i = 0; i < 200; ++i) {
    const double along = (i + 0.5) / 2 - 50;
    n += 1;
    squares += along * along;
  }
  const Eigen::Matrix2d covariance = covariance_of_edge_pixels(100, 2, 0.7);
  EXPECT_NEAR(covariance(0, 0), 0.49 / n, 1e-12);
  EXPECT_NEAR(covariance(1, 1), 0.49 / squares, 1e-4 * 0.49 / squares);
  const LineObservation line = line_through({0, 0}, {10, 0}, 1);
  EXPECT_DOUBLE_EQ(line.covariance(0, 0) + 25 * line.covariance(1, 1), 1);  // at either end
}

TEST(LineObservation, WhatCannotBeUsedIsTold) {
  const LineObservation good = line_through({0, 0}, {10, 0}, 1);
  ASSERT_TRUE(is_usable(good));
  LineObservation bad = good;
  bad.end_in_target = bad.begin_in_target;
  EXPECT_FALSE(is_usable(bad)) << "an edge of no length";
  bad = good;
  bad.direction = {0, 0};
  EXPECT_FALSE(is_usable(bad));
  bad = good;
  bad.pixel.x() = std::nan("");
  EXPECT_FALSE(is_usable(bad));
  bad = good;
  bad.covariance(0, 0) = 0;
  EXPECT_FALSE(is_usable(bad));
  bad = good;
  bad.covariance(0, 1) = bad.covariance(1, 0) = 10;
  EXPECT_FALSE(is_usable(bad)) << "not positive definite";
  bad = good;
  bad.covariance = Eigen::Vector2d(1, kInfinity).asDiagonal();
  EXPECT_TRUE(is_usable(bad)) << "the slope is not known";
  bad.covariance(0, 1) = bad.covariance(1, 0) = 0.1;
  EXPECT_FALSE(is_usable(bad));
}

TEST(LineBound, LinesAddTheirInformationToThatOfPoints) {
  Draw draw(75);
  const Synthetic s = cube_with_lines(1, 1, draw);
  const PoseProblem& p = s.problem;
  const std::vector<Eigen::Matrix2d> covariances(p.pixels.size(), Eigen::Matrix2d::Identity());
  const auto both =
      cramer_rao_bound(p.camera, p.points_in_target, s.cam_from_target, covariances, p.lines);
  const auto points = cramer_rao_bound(p.camera, p.points_in_target, s.cam_from_target, 1);
  const auto lines = cramer_rao_bound(p.camera, {}, s.cam_from_target, {}, p.lines);
  ASSERT_TRUE(both && points && lines);
  const Matrix6d sum = points->covariance.inverse() + lines->covariance.inverse();
  const Matrix6d product = both->covariance * sum;
  EXPECT_TRUE(is_matrix_near(product, Matrix6d(Matrix6d::Identity()), 1e-4));
}

// The kernel's model of lines at the true pose.
kernel::NormalEquations model_of(const std::vector<LineObservation>& lines, const Synthetic& s) {
  std::vector<EdgePoint> edges;
  for (const LineObservation& line : lines) {
    const EdgePoints points = edge_points_of(line, s.problem.camera).value();
    edges.insert(edges.end(), points.begin(), points.end());
  }
  const PackedEdges packed(edges, Eigen::Vector3d::Zero());
  kernel::NormalEquations model{};
  kernel::normal_equations({.edges = packed.lanes().data(), .edge_count = packed.lanes().size()},
                           rigid_from(s.cam_from_target), model);
  return model;
}

TEST(LineBound, ParallelEdgesDetermineNoPose) {
  for (int seed = 70; seed < 90; ++seed) {
    Draw draw(seed);
    const Synthetic s = cube_with_lines(1, 1, draw);
    std::vector<LineObservation> lines = s.problem.lines;
    std::erase_if(lines, [](const LineObservation& line) {
      return line.begin_in_target.x() == line.end_in_target.x();
    });
    ASSERT_EQ(lines.size(), 4U);  // eight numbers, none of which says where along x
    // Also where rounding leaves a pivot of some 1e-12.
    EXPECT_FALSE(cramer_rao_bound(s.problem.camera, {}, s.cam_from_target, {}, lines)) << seed;
    EXPECT_FALSE(inverse_of(model_of(lines, s))) << seed;
    lines.push_back(s.problem.lines[0]);
    lines.push_back(s.problem.lines[1]);
    EXPECT_TRUE(cramer_rao_bound(s.problem.camera, {}, s.cam_from_target, {}, lines)) << seed;
    EXPECT_TRUE(inverse_of(model_of(lines, s))) << seed;
  }
}

}  // namespace
}  // namespace sightline
