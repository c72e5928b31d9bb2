// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Edges of known targets, seen as lines under known noise.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "pose/camera.h"
#include "pose/line_observation.h"
#include "pose/pose.h"
#include "tests/pose/synthetic.h"

namespace sightline {

using Segment = std::pair<Eigen::Vector3d, Eigen::Vector3d>;

inline std::vector<Segment> cube_edges() {
  std::vector<Segment> edges;
  const std::vector<Eigen::Vector3d> vertices = cube_vertices();
  for (size_t i = 0; i < vertices.size(); ++i) {
    for (size_t j = i + 1; j < vertices.size(); ++j) {
      const bool is_edge = ((vertices[i] - vertices[j]).array() != 0).count() == 1;
      if (is_edge) edges.emplace_back(vertices[i], vertices[j]);
    }
  }
  return edges;
}

/// The exact image of an edge near its middle, as a camera without lens sees it.
inline LineObservation exact_line(const Camera& camera, const Pose& cam_from_target,
                                  const Segment& edge, double edge_pixel_sigma_px) {
  const Eigen::Vector2d begin = project(camera, cam_from_target * edge.first).value();
  const Eigen::Vector2d end = project(camera, cam_from_target * edge.second).value();
  const double length_px = (end - begin).norm();
  LineObservation line;
  line.begin_in_target = edge.first;
  line.end_in_target = edge.second;
  line.pixel = (begin + end) / 2;
  line.direction = (end - begin) / length_px;
  line.covariance = covariance_of_edge_pixels(length_px, 1, edge_pixel_sigma_px);
  return line;
}

inline void add_noise(LineObservation& line, Draw& draw) {
  const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
  line.pixel += std::sqrt(line.covariance(0, 0)) * draw.normal() * normal;
  const double slope = std::sqrt(line.covariance(1, 1)) * draw.normal();
  line.direction = (line.direction + slope * normal).normalized();
}

/// The cube's vertices and edges under noise of which solvers are told, from a pose near the truth.
inline Synthetic cube_with_lines(double point_sigma_px, double edge_pixel_sigma_px, Draw& draw) {
  Synthetic s = cube_problem(point_sigma_px, draw);
  s.problem.sigma_px = point_sigma_px;
  for (const Segment& edge : cube_edges()) {
    LineObservation line =
        exact_line(s.problem.camera, s.cam_from_target, edge, edge_pixel_sigma_px);
    add_noise(line, draw);
    s.problem.lines.push_back(line);
  }
  Vector6d error;
  error << 0.02 * draw.vector(), 0.02 * draw.vector();
  s.problem.initial_cam_from_target = retract(s.cam_from_target, error);
  return s;
}

/// Edges anywhere in the cube's box, so many, seen at a pose as lines under noise; no points.
inline PoseProblem random_lines(const Camera& camera, const Pose& cam_from_target, int count,
                                Draw& draw) {
  PoseProblem problem;
  problem.camera = camera;
  for (int i = 0; i < count; ++i) {
    problem.lines.push_back(
        exact_line(camera, cam_from_target, {draw.in_box(0.5), draw.in_box(0.5)}, 0.5));
    add_noise(problem.lines.back(), draw);
  }
  return problem;
}

/// A line that is shifted across itself.
inline void shift(LineObservation& line, double by_px) {
  line.pixel += by_px * Eigen::Vector2d(-line.direction.y(), line.direction.x());
}

}  // namespace sightline
