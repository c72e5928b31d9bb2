// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/benchmarks/pose_accuracy.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "pose/consensus/answer.h"
#include "pose/consensus/cloud.h"
#include "pose/consensus/mixture.h"
#include "pose/consensus/search.h"
#include "pose/fit_points.h"
#include "pose/reprojection.h"
#include "pose/solver.h"

namespace sightline {
namespace {

/// e^T H e of a right answer, H what the true inliers say: least squares on them has six on average
/// and exceeds this in one of 1e10 draws.
constexpr double kRight = 60;
constexpr double kCapDeg = 20;
/// Outliers lie so far from where they belong, at least.
constexpr double kLeastOutlierPx = 15;
constexpr double kNearOutlierPx = 20;

struct Cell {
  int points = 8;
  int outliers_percent = 0;
};

struct Request {
  std::vector<const PoseSolver*> solvers = {find_pose_solver("consensus")};
  std::vector<Cell> cells = {{8, 30},  {8, 50},   {12, 50},  {12, 70},   {20, 50},
                             {50, 70}, {200, 90}, {200, 95}, {1000, 90}, {1000, 95}};
  int draws = 1000;
  unsigned seed = 1;
  bool are_outliers_near = false;
  double noise_px = 1;
  bool has_prior = false;
};

class AccuracyDraw {
 public:
  explicit AccuracyDraw(unsigned seed) : engine_(seed) {}

  double normal() { return normal_(engine_); }
  double uniform(double low, double high) { return low + (high - low) * uniform_(engine_); }
  Eigen::Vector2d pair() {
    const double first = normal();
    return {first, normal()};
  }
  Eigen::Vector3d vector() {
    const Eigen::Vector2d first = pair();
    return {first.x(), first.y(), normal()};
  }
  Eigen::Matrix3d rotation() {
    const Eigen::Vector2d first = pair();
    const Eigen::Vector2d last = pair();
    return rotation_from_quaternion_wxyz({first.x(), first.y(), last.x(), last.y()});
  }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_{0, 1};
};

/// Points in view of a camera of 640 x 480 pixels, 4 to 8 m away and all over the image, or in a
/// square of 4 m tilted at random.
std::vector<Eigen::Vector3d> points_in_view(const Camera& camera, int count, bool is_planar,
                                            AccuracyDraw& draw) {
  std::vector<Eigen::Vector3d> points;
  Eigen::Matrix3d tilt = draw.rotation();
  Eigen::Vector3d middle(draw.uniform(-1, 1), draw.uniform(-1, 1), draw.uniform(5, 7));
  for (int misses = 0; static_cast<int>(points.size()) < count;) {
    Eigen::Vector3d x(draw.uniform(-2, 2), draw.uniform(-2, 2), 0);
    if (is_planar) x = middle + tilt * x;
    if (!is_planar) {
      const double depth = draw.uniform(4, 8);
      x = depth * Eigen::Vector3d(draw.uniform(-0.4, 0.4), draw.uniform(-0.3, 0.3), 1);
    }
    const std::optional<Eigen::Vector2d> pixel = x.z() < 1 ? std::nullopt : project(camera, x);
    if (pixel && is_inside(camera, *pixel)) {
      points.push_back(x);
      continue;
    }
    constexpr int kMostMisses = 100;
    if (++misses < kMostMisses) continue;  // a plane that is seen from the edge fills no image
    tilt = draw.rotation();
    points.clear();
    misses = 0;
  }
  return points;
}

struct AccuracyCase {
  PoseProblem problem;
  Pose truth;
};

Eigen::Vector2d outlier_at(const Request& request, const Eigen::Vector2d& noisy,
                           AccuracyDraw& draw) {
  if (request.are_outliers_near) return noisy + kNearOutlierPx * draw.pair();
  for (;;) {
    const double u = draw.uniform(0, 639);
    const Eigen::Vector2d pixel(u, draw.uniform(0, 479));
    if ((pixel - noisy).norm() >= kLeastOutlierPx) return pixel;
  }
}

AccuracyCase draw_accuracy_case(const Request& request, const Cell& cell, bool is_planar,
                                AccuracyDraw& draw) {
  AccuracyCase c;
  PoseProblem& problem = c.problem;
  problem.camera = centred_camera(640, 480, 800);
  const auto in_cam = points_in_view(problem.camera, cell.points, is_planar, draw);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& x : in_cam) mean += x / cell.points;
  c.truth = {draw.rotation(), mean};
  const int outliers = (cell.points * cell.outliers_percent + 50) / 100;
  for (int i = 0; i < cell.points; ++i) {
    problem.points_in_target.push_back(inverse(c.truth) * in_cam[i]);
    const Eigen::Vector2d seen = *project(problem.camera, in_cam[i]);
    const Eigen::Vector2d noisy = seen + request.noise_px * draw.pair();
    problem.pixels.push_back(i < outliers ? outlier_at(request, noisy, draw) : noisy);
    problem.true_inliers.push_back(i >= outliers);
  }
  if (request.has_prior) {
    constexpr double kTurnRad = 3 * std::numbers::pi / 180;
    problem.initial_cam_from_target = {
        rotation_from_vector(kTurnRad * draw.vector().normalized()) * c.truth.rotation,
        c.truth.translation + 0.02 * mean.z() * draw.vector().normalized()};
  }
  return c;
}

Vector6d pose_error(const Pose& pose, const Pose& truth) {
  Vector6d error;
  error << vector_from_rotation(pose.rotation * truth.rotation.transpose()),
      pose.translation - truth.translation;
  return error;
}

/// e^T H e in units of the noise; infinite without a pose.
double squared_error(const AccuracyCase& c, const PoseEstimate& estimate, double noise_px) {
  if (estimate.status != PoseStatus::kOk) return std::numeric_limits<double>::infinity();
  const Correspondences points = prepare(c.problem).correspondences;
  std::vector<int> kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (c.problem.true_inliers[i]) kept.push_back(static_cast<int>(i));
  }
  const std::optional<Matrix6d> covariance =
      unit_covariance({points, kept, {}}, to_centred(c.truth, points));
  if (!covariance) return std::numeric_limits<double>::infinity();
  const Vector6d error =
      pose_error(to_centred(estimate.cam_from_target, points), to_centred(c.truth, points));
  return error.dot(covariance->ldlt().solve(error)) / (noise_px * noise_px);
}

double capped_angle_deg(const AccuracyCase& c, const PoseEstimate& estimate) {
  if (estimate.status != PoseStatus::kOk) return kCapDeg;
  const double angle = geodesic_angle_rad(estimate.cam_from_target.rotation, c.truth.rotation) *
                       180 / std::numbers::pi;
  return std::min(angle, kCapDeg);
}

bool is_flagged(const PoseEstimate& estimate) {
  if (estimate.status != PoseStatus::kOk) return true;
  const Diagnosis said = estimate.diagnosis.value_or(Diagnosis{});
  return said.is_ambiguous.value_or(false) || said.is_test_failed.value_or(false) ||
         !said.is_significant.value_or(true);
}

/// The largest evidence of the modes that consensus finds.
double largest_evidence(const consensus::Cloud& cloud) {
  double largest = -std::numeric_limits<double>::infinity();
  const consensus::Found found = consensus::search(cloud);
  for (const consensus::Mode& mode : found.modes.all()) {
    consensus::Answer answer;
    if (consensus::answer_of(cloud, mode, answer)) {
      largest = std::max(largest, answer.log_evidence);
    }
  }
  return largest;
}

/// Whether the mode about the best pose of the true inliers has less evidence than another one that
/// consensus finds, or leads away from the truth: then the data do not say which is true.
bool is_truth_beaten(const AccuracyCase& c, const PoseEstimate& oracle, double noise_px) {
  const consensus::Cloud cloud = consensus::prepare_cloud(c.problem).cloud;
  consensus::Mode mode;
  mode.cam_from_centred = consensus::to_cloud(oracle.cam_from_target, cloud);
  mode.law = consensus::outlier_law(cloud);
  constexpr double kTolerance = 1e-7;
  const double scale = noise_px / cloud.image_unit_px;
  consensus::Answer answer;
  if (!consensus::fit_mixture(cloud, scale, {30, kTolerance}, mode) ||
      !consensus::answer_of(cloud, mode, answer)) {
    return true;
  }
  PoseEstimate estimate = oracle;
  estimate.cam_from_target = consensus::from_cloud(answer.cam_from_centred, cloud);
  return !(squared_error(c, estimate, noise_px) < kRight) ||
         answer.log_evidence <= largest_evidence(cloud);
}

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Least squares on the true inliers, from the truth, so that no other minimum is met.
PoseEstimate oracle_answer(const AccuracyCase& c) {
  PoseProblem problem = c.problem;
  problem.initial_cam_from_target = c.truth;
  return find_pose_solver("oracle")->core(problem, {});
}

struct AccuracyTally {
  int draws = 0, right = 0, unflagged = 0, second = 0, flagged_right = 0, beaten = 0;
  double squares = 0, oracle_squares = 0;  ///< of right answers
  double angles2 = 0, oracle_angles2 = 0;  ///< of all, capped
  double nees = 0;
  double seconds = 0;

  void add(const AccuracyCase& c, const PoseEstimate& estimate, const PoseEstimate& oracle,
           double noise_px) {
    ++draws;
    angles2 += std::pow(capped_angle_deg(c, estimate), 2);
    oracle_angles2 += std::pow(capped_angle_deg(c, oracle), 2);
    const double square = squared_error(c, estimate, noise_px);
    if (!(square < kRight)) {
      unflagged += !is_flagged(estimate);
      PoseEstimate other = estimate;
      other.cam_from_target = estimate.second_cam_from_target.value_or(estimate.cam_from_target);
      second += squared_error(c, other, noise_px) < kRight;
      beaten += is_truth_beaten(c, oracle, noise_px);
      return;
    }
    ++right;
    flagged_right += is_flagged(estimate);
    squares += square;
    oracle_squares += squared_error(c, oracle, noise_px);
    const Matrix6d covariance =
        estimate.covariance.value_or(noise_px * noise_px * estimate.unit_covariance);
    const Vector6d error = pose_error(estimate.cam_from_target, c.truth);
    nees += error.dot(covariance.ldlt().solve(error));
  }
};

AccuracyTally tally_of(const Request& request, const Cell& cell, bool is_planar, bool is_told,
                       const PoseSolver& solver) {
  AccuracyDraw draw(request.seed);
  AccuracyTally tally;
  const int draws = cell.points >= 1000 ? std::max(request.draws / 5, 1) : request.draws;
  while (tally.draws < draws) {
    AccuracyCase c = draw_accuracy_case(request, cell, is_planar, draw);
    // Four inliers that are nearly in a line, a plane seen from its edge: where the truth's own
    // neighbourhood does not hold the minimum, nothing can be said of right and wrong.
    const PoseEstimate oracle = oracle_answer(c);
    if (!(squared_error(c, oracle, request.noise_px) < kRight)) continue;
    c.problem.sigma_px = is_told ? request.noise_px : 0;
    const double before = cpu_seconds();
    const PoseEstimate estimate = solver.solve(c.problem, {});
    tally.seconds += cpu_seconds() - before;
    tally.add(c, estimate, oracle, request.noise_px);
  }
  return tally;
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

Cell cell_of(const std::string& text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) throw std::invalid_argument(text);
  Cell cell = {std::stoi(text.substr(0, slash)), std::stoi(text.substr(slash + 1))};
  if (cell.points < 4 || cell.outliers_percent < 0 || cell.outliers_percent > 99) {
    throw std::invalid_argument(text);
  }
  return cell;
}

const PoseSolver* solver_of(const std::string& name) {
  const PoseSolver* const solver = find_pose_solver(name);
  if (solver == nullptr) throw std::invalid_argument(name);
  return solver;
}

bool is_second(const std::string& value, std::string_view first, std::string_view second) {
  if (value != first && value != second) throw std::invalid_argument(value);
  return value == second;
}

void set(Request& request, const std::string& key, const std::string& value) {
  if (key == "draws")
    request.draws = std::stoi(value);
  else if (key == "seed")
    request.seed = static_cast<unsigned>(std::stoul(value));
  else if (key == "noise_px")
    request.noise_px = std::stod(value);
  else if (key == "outliers")
    request.are_outliers_near = is_second(value, "anywhere", "near");
  else if (key == "start")
    request.has_prior = is_second(value, "free", "prior");
  else if (key == "cells") {
    request.cells.clear();
    for (const std::string& cell : split(value)) request.cells.push_back(cell_of(cell));
  } else if (key == "solver") {
    request.solvers.clear();
    for (const std::string& name : split(value)) request.solvers.push_back(solver_of(name));
  } else {
    throw std::invalid_argument(key);
  }
}

std::string line_of(const AccuracyTally& t) {
  const double draws = t.draws, right = std::max(t.right, 1);
  return fmt::format("{:7.2f} {:7.3f} {:7.3f} {:7.2f} {:9.2f} {:8.2f} {:8.2f} {:8.2f} {:9.4f}",
                     100 * t.right / draws, std::sqrt(t.squares / t.oracle_squares),
                     std::sqrt(t.angles2 / t.oracle_angles2), t.nees / right,
                     1000 * t.unflagged / draws, 100 * t.second / draws, 100 * t.beaten / draws,
                     100 * t.flagged_right / draws, 1e3 * t.seconds / draws);
}

void print_table(const Request& request) {
  fmt::print("{:>10} {:>6} {:>8} {:>16} {:>7} {:>7} {:>7} {:>7} {:>9} {:>8} {:>8} {:>8} {:>9}\n",
             "cell", "target", "noise", "solver", "right/%", "r", "r (all)", "NEES", "unflagged",
             "second/%", "beaten/%", "flagged", "CPU/ms");
  for (const Cell& cell : request.cells) {
    for (const bool is_planar : {false, true}) {
      for (const bool is_told : {true, false}) {
        for (const PoseSolver* solver : request.solvers) {
          fmt::print("{:>10} {:>6} {:>8} {:>16} {}\n",
                     fmt::format("{}/{}", cell.points, cell.outliers_percent),
                     is_planar ? "planar" : "solid", is_told ? "known" : "unknown", solver->name,
                     line_of(tally_of(request, cell, is_planar, is_told, *solver)));
          std::cout.flush();
          std::fflush(stdout);
        }
      }
    }
  }
}

}  // namespace

int run_pose_accuracy(int argc, char** argv) {
  Request request;
  for (int i = 0; i < argc; ++i) {
    const std::string given = argv[i];
    const std::size_t equals = given.find('=');
    try {
      if (equals == std::string::npos) throw std::invalid_argument(given);
      set(request, given.substr(0, equals), given.substr(equals + 1));
    } catch (const std::exception&) {
      std::cerr << "accuracy: " << given
                << ": expected solver=, cells=N/SHARE,..., draws=, seed=, noise_px=, "
                   "outliers=anywhere|near, start=free|prior\n";
      return 2;
    }
  }
  print_table(request);
  return 0;
}

}  // namespace sightline
