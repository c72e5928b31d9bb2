// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// solve(), align(), and what cameras see.
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "eval/solve/camera_file.h"
#include "eval/study/key_tables.h"
#include "pose/absolute_orientation.h"
#include "pose/consensus/cloud.h"
#include "pose/entry/all_poses.h"
#include "pose/lenses/catalogue.h"
#include "pose/solver.h"
#include "python/module/arrays.h"
#include "python/module/bindings.h"
#include "python/module/long_call.h"
#include "scenes/files/input_error.h"
#include "scenes/files/toml_table.h"
#include "scenes/scene/keys.h"

namespace sightline {
namespace {

namespace py = pybind11;

template <typename Catalogue>
std::vector<std::string> catalogue_names(const Catalogue& catalogue) {
  std::vector<std::string> names;
  for (const auto& entry : catalogue) names.emplace_back(entry.name);
  return names;
}

const PoseSolver& solver_named(const std::string& name) {
  if (const PoseSolver* const solver = find_pose_solver(name)) return *solver;
  throw InputError(fmt::format("solve: solver '{}' is not known{}", name,
                               suggestion(name, catalogue_names(pose_solvers()))));
}

const OrientationMethod& method_named(const std::string& name) {
  if (const OrientationMethod* const method = find_orientation_method(name)) return *method;
  throw InputError(fmt::format("align: method '{}' is not known{}", name,
                               suggestion(name, catalogue_names(orientation_methods()))));
}

// Settings "solver.key=value", as a study's file has them in [solver].
SolverOptions options_from(const std::vector<std::string>& settings) {
  SolverOptions options;
  Start start = Start::kFree;  // what `initial` says here
  std::vector<Key> keys = solver_keys(start, options);
  std::erase_if(keys, [](const Key& key) { return key.name == "start"; });
  const TomlTable table = TomlTable::read_text("", "solve", settings);
  read_keys(table, keys);
  table.reject_unknown_keys();
  return options;
}

std::optional<Pose> initial_from(const std::optional<Doubles>& matrix) {
  if (!matrix) return std::nullopt;
  // Rounded to four decimals it is one still.
  const std::optional<Pose> pose = consensus::rigid_pose(pose_from(*matrix));
  if (!pose) {
    throw InputError(
        "solve: initial is no rigid transform; its rotation must be orthonormal with "
        "determinant +1, and all numbers finite");
  }
  return is_valid(pose_from(*matrix)) ? pose_from(*matrix) : pose;
}

// Rows of two points of an edge, two pixels of its line and sigma.
std::vector<LineObservation> lines_from(const std::optional<Doubles>& rows) {
  std::vector<LineObservation> lines;
  if (!rows) return lines;
  const auto row = rows->unchecked<2>();
  for (py::ssize_t i = 0; i < row.shape(0); ++i) {
    LineObservation& line = lines.emplace_back(
        line_through({row(i, 6), row(i, 7)}, {row(i, 8), row(i, 9)}, row(i, 10)));
    line.begin_in_target = {row(i, 0), row(i, 1), row(i, 2)};
    line.end_in_target = {row(i, 3), row(i, 4), row(i, 5)};
  }
  return lines;
}

PoseProblem problem_from(const Doubles& points, const Doubles& pixels, const py::tuple& camera,
                         double sigma_px, const std::optional<Doubles>& covariances,
                         const std::optional<Doubles>& initial) {
  PoseProblem problem;
  problem.camera = camera_from(camera);
  problem.points_in_target = points_from(points);
  problem.pixels = pixels_from(pixels);
  if (covariances) problem.covariances_px2 = covariances_from(*covariances);
  problem.sigma_px = sigma_px;
  problem.initial_cam_from_target = initial_from(initial);
  return problem;
}

py::tuple solve_problem(const Doubles& points, const Doubles& pixels, const py::tuple& camera,
                        const std::string& solver, double sigma_px,
                        const std::optional<Doubles>& covariances,
                        const std::optional<Doubles>& initial,
                        const std::optional<std::vector<bool>>& true_inliers,
                        const std::vector<std::string>& settings,
                        const std::optional<Doubles>& lines) {
  const PoseSolver& chosen = solver_named(solver);
  if (lines && chosen.with_lines == nullptr) {
    throw InputError(
        fmt::format("solve: solver '{}' uses no lines; consensus and lspe do", solver));
  }
  if (chosen.evaluation_only && !true_inliers) {
    throw InputError(fmt::format("solve: solver '{}' needs true_inliers", solver));
  }
  const SolverOptions options = options_from(settings);
  PoseProblem problem = problem_from(points, pixels, camera, sigma_px, covariances, initial);
  if (true_inliers) problem.true_inliers = *true_inliers;
  problem.lines = lines_from(lines);
  PoseEstimate estimate;
  {
    const LongCall call;
    estimate = chosen.solve(problem, options);
  }
  return tuple_of(estimate);
}

py::tuple solve_all_poses(const Doubles& points, const Doubles& pixels, const py::tuple& camera,
                          double sigma_px, const std::optional<Doubles>& covariances,
                          const std::optional<Doubles>& initial, const std::vector<int>& left_out) {
  const PoseProblem problem = problem_from(points, pixels, camera, sigma_px, covariances, initial);
  PoseMinima minima;
  {
    const LongCall call;
    minima = solve_all(problem, left_out);
  }
  py::list poses;
  for (const PoseMinimum& minimum : minima.minima) {
    poses.append(py::make_tuple(matrix_of(minimum.cam_from_target), minimum.cost,
                                array_of(minimum.unit_covariance)));
  }
  return py::make_tuple(to_string(minima.status), poses, minima.ignored);
}

py::tuple align_points(const Doubles& a, const Doubles& b, const std::string& method,
                       const std::vector<double>& weights) {
  const OrientationMethod& chosen = method_named(method);
  const std::vector<Eigen::Vector3d> in_a = points_from(a);
  const std::vector<Eigen::Vector3d> in_b = points_from(b);
  OrientationEstimate estimate;
  {
    const LongCall call;
    estimate = chosen.estimate(in_a, in_b, weights);
  }
  return py::make_tuple(to_string(estimate.status), matrix_of(estimate.b_from_a), estimate.scale);
}

Doubles project_all(const py::tuple& camera, const Doubles& points_in_cam) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const Camera seen_by = camera_from(camera);
  std::vector<Eigen::Vector2d> pixels;
  for (const Eigen::Vector3d& point : points_from(points_in_cam)) {
    pixels.push_back(project(seen_by, point).value_or(Eigen::Vector2d::Constant(kNone)));
  }
  return rows_of(pixels);
}

py::dict lens_coefficient_counts() {
  py::dict counts;
  for (const LensModel& model : lens_models()) {
    counts[model.name.c_str()] = py::tuple(py::cast(model.counts));
  }
  return counts;
}

py::tuple read_camera_numbers(const std::string& file) {
  return numbers_of(read_camera_file(file));
}

py::tuple diagnosis_tuple(const Diagnosis& diagnosis) {
  py::object probable = py::none();
  if (diagnosis.most_probable_cam_from_target) {
    probable = matrix_of(*diagnosis.most_probable_cam_from_target);
  }
  return py::make_tuple(diagnosis.is_ambiguous, diagnosis.removed_probability,
                        diagnosis.is_removal_limit_reached, diagnosis.is_test_failed, probable,
                        diagnosis.is_significant);
}

}  // namespace

py::tuple tuple_of(const PoseEstimate& estimate) {
  py::object covariance = py::none();
  py::object diagnosis = py::none();
  py::object second = py::none();
  if (estimate.second_cam_from_target) second = matrix_of(*estimate.second_cam_from_target);
  if (estimate.covariance) covariance = array_of(*estimate.covariance);
  if (estimate.diagnosis) diagnosis = diagnosis_tuple(*estimate.diagnosis);
  return py::make_tuple(to_string(estimate.status), matrix_of(estimate.cam_from_target),
                        estimate.removed, covariance, array_of(estimate.unit_covariance), diagnosis,
                        estimate.iterations, estimate.ignored, estimate.residual_rms_px, second,
                        estimate.noise_px, estimate.inlier_probabilities, estimate.removed_lines,
                        estimate.ignored_lines);
}

void bind_pose(py::module_& module) {
  module.def("read_camera", &read_camera_numbers);
  module.def("lens_coefficient_counts", &lens_coefficient_counts);
  module.def("solve", &solve_problem);
  module.def("solve_all", &solve_all_poses);
  module.def("align", &align_points);
  module.def("project", &project_all);
}

}  // namespace sightline
