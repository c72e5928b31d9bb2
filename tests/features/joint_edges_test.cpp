// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/joint_edges.h"

#include <gtest/gtest.h>

#include "pose/line_observation.h"
#include "scenes/random/random.h"

namespace sightline {
namespace {

Camera looking_camera() {
  Camera camera;
  camera.width_px = camera.height_px = 512;
  camera.fx_px = camera.fy_px = 1000;
  camera.cx_px = camera.cy_px = 255.5;
  return camera;
}

// A line along an edge of the target as it is seen from a pose, moved across itself by `off_px`.
LineCandidate seen(const Eigen::Vector3d& begin, const Eigen::Vector3d& end, const Pose& pose,
                   double off_px) {
  constexpr double kSdPx = 0.3;
  LineObservation line = sightline::line_through(*project(looking_camera(), pose * begin),
                                                 *project(looking_camera(), pose * end), kSdPx);
  line.begin_in_target = begin;
  line.end_in_target = end;
  const Eigen::Vector2d along = line.direction.normalized();
  line.pixel += off_px * Eigen::Vector2d(-along.y(), along.x());
  LineCandidate candidate;
  constexpr double kSearchedPx2 = 400;
  candidate.weight_px2 = kSearchedPx2;
  for (size_t i = 0; i < 2; ++i) {
    candidate.ends[i] = *edge_point_at(line, looking_camera(), i == 0 ? -40 : 40);
    candidate.ends[i].variance_px2 = kSdPx * kSdPx;
  }
  return candidate;
}

// The edges of a cube; beside each runs a line of the print, mostly nearer to the prior than it and
// to either side. Only together do they say which is which.
TEST(JointEdges, LinesThatOnePoseExplainsAreTakenAndPrintIsNot) {
  const Pose truth{rotation_from_vector({0.5, 0.3, 0.2}), {0, 0, 10}};
  constexpr double kTurn = 0.03;
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal() << kTurn * kTurn, kTurn * kTurn, kTurn * kTurn, 2.5e-3, 2.5e-3, 1e-2;
  Vector6d error;
  error << kTurn, -kTurn, kTurn, 0.05, -0.05, 0.1;
  const PosePrior prior{retract(truth, error), covariance};
  std::vector<StretchCandidates> stretches;
  RandomStream random(1, "print", 0);
  for (int axis = 0; axis < 3; ++axis) {
    for (const auto& [a, b] : {std::pair(-0.5, -0.5), {-0.5, 0.5}, {0.5, -0.5}}) {
      Eigen::Vector3d begin = Eigen::Vector3d::Zero();
      begin[(axis + 1) % 3] = a;
      begin[(axis + 2) % 3] = b;
      begin[axis] = -0.5;
      Eigen::Vector3d end = begin;
      end[axis] = 0.5;
      stretches.push_back({seen(begin, end, prior.cam_from_target, random.uniform(-4, 4)),
                           seen(begin, end, truth, 0)});
    }
  }
  const auto pose = jointly_explained(stretches, prior);
  ASSERT_TRUE(pose.has_value());
  const Vector6d off = change_between(truth, pose->cam_from_target);
  EXPECT_LT(off.head<3>().norm(), 0.002);
  EXPECT_LT(off.tail<3>().head<2>().norm(), 0.002);
  EXPECT_LT(pose->covariance.diagonal().head<3>().maxCoeff(), 0.01 * kTurn * kTurn);
}

TEST(JointEdges, TooFewLinesSayNothing) {
  const Pose pose{Eigen::Matrix3d::Identity(), {0, 0, 10}};
  const PosePrior prior{pose, 1e-4 * Matrix6d::Identity()};
  const StretchCandidates one{seen({-0.5, 0, 0}, {0.5, 0, 0}, pose, 1)};
  EXPECT_FALSE(jointly_explained({}, prior));
  EXPECT_FALSE(jointly_explained(std::vector{one, one}, prior));
  EXPECT_TRUE(jointly_explained(std::vector{one, one, one}, prior));
}

}  // namespace
}  // namespace sightline
