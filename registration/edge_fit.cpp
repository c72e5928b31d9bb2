// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/edge_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "pose/camera.h"
#include "registration/edges.h"
#include "registration/symmetric.h"
#include "renderer/basis.h"
#include "scenes/random/random.h"

namespace sightline {
namespace {

// L with L L' the covariance, of which some axes may be known exactly.
Matrix6d root_of(Matrix6d covariance) {
  covariance.diagonal().array() += 1e-24;
  return covariance.llt().matrixL();
}

constexpr double kSharpBlurPx = 0.8;  // of the image, to find its slopes

struct Candidate {
  double support = 0;
  Pose pose;
};

// Narrows a search: the best of each round are drawn about anew, closer and on a sharper image.
struct Round {
  double blur_px;
  int draws;      // about each that the last round kept
  double spread;  // of the prior's
  size_t kept;
  double apart;  // sds of the prior between any two that are kept: else all are soon of one place
  size_t every;  // which of the edge points are asked: on blurred images neighbours say the same
};
constexpr std::array<Round, 3> kRounds = {
    {{2.5, 4000, 1.2, 10, 1, 2}, {1.5, 25, 0.35, 6, 0.7, 2}, {kSharpBlurPx, 40, 0.12, 5, 0.5, 1}}};

class Search {
 public:
  Search(const GreyImage& image, const PosePrior& prior, std::vector<MeshEdgePoint> points)
      : image_(image),
        points_(std::move(points)),
        spread_(root_of(prior.covariance)),
        draws_(0, "poses by edges", 0),
        best_{{0, prior.cam_from_target}} {}

  std::vector<Pose> run() {
    for (const Round& round : kRounds) narrow(round);
    std::vector<Pose> poses;
    for (const Candidate& candidate : best_) poses.push_back(candidate.pose);
    return poses;
  }

 private:
  void narrow(const Round& round) {
    const EdgeImage edges(image_, round.blur_px);
    std::vector<MeshEdgePoint> points;
    for (size_t i = 0; i < points_.size(); i += round.every) points.push_back(points_[i]);
    std::vector<Candidate> found;
    for (const Candidate& about : best_) {
      found.push_back(about);
      for (int i = 0; i < round.draws; ++i) found.push_back({0, drawn(about.pose, round.spread)});
    }
    for (Candidate& c : found) c.support = edge_support(edges, image_.camera, points, c.pose);
    std::stable_sort(found.begin(), found.end(),
                     [](const Candidate& a, const Candidate& b) { return a.support > b.support; });
    best_ = apart(found, round);
  }

  // The best, none nearer to a better one than the round says.
  std::vector<Candidate> apart(const std::vector<Candidate>& found, const Round& round) const {
    std::vector<Candidate> kept;
    for (const Candidate& candidate : found) {
      const bool is_apart = std::ranges::all_of(kept, [&](const Candidate& better) {
        const Vector6d change = change_between(better.pose, candidate.pose);
        return spread_.triangularView<Eigen::Lower>().solve(change).norm() > round.apart;
      });
      if (is_apart) kept.push_back(candidate);
      if (kept.size() == round.kept) break;
    }
    return kept;
  }

  Pose drawn(const Pose& about, double spread) {
    Vector6d normal;
    for (double& value : normal) value = draws_.normal();
    return retract(about, spread * (spread_ * normal));
  }

  const GreyImage& image_;
  std::vector<MeshEdgePoint> points_;
  Matrix6d spread_;
  RandomStream draws_;
  std::vector<Candidate> best_;
};

std::vector<MeshEdgePoint> edge_points_at(const Pose& pose, const Camera& camera,
                                          BasisDrawer& drawer) {
  BasisOptions options;
  options.margin_px = 2;
  const auto images = drawer.draw(pose, options);
  return images ? edge_points(*images, camera, pose) : std::vector<MeshEdgePoint>{};
}

// Follows the nearest edges along the normals.
class EdgeFitter {
 public:
  EdgeFitter(const GreyImage& image, const Mesh& mesh, const PosePrior& prior)
      : edges_(image, kSharpBlurPx),
        camera_(image.camera),
        drawer_(mesh, image.camera),
        prior_(prior),
        prior_information_(inverse_of(Matrix6d(prior.covariance + 1e-24 * Matrix6d::Identity()))
                               .value_or(Matrix6d::Zero())) {}

  // The mesh's edges as seen at a pose; empty where it cannot be drawn.
  std::vector<MeshEdgePoint> points_at(const Pose& pose) {
    ++drawings_;
    return edge_points_at(pose, camera_, drawer_);
  }

  int drawings() const { return drawings_; }

  EdgeFit fit(const Pose& start) {
    constexpr int kDrawings = 3, kSteps = 5;
    constexpr double kFirstReachPx = 5, kLeastReachPx = 1.5, kShrink = 0.8;
    EdgeFit fit;
    fit.cam_from_target = start;
    double reach_px = kFirstReachPx;
    for (int i = 0; i < kDrawings; ++i) {
      const std::vector<MeshEdgePoint> points = points_at(fit.cam_from_target);
      for (int k = 0; k < kSteps; ++k) {
        step(points, reach_px, fit);
        reach_px = std::max(kLeastReachPx, kShrink * reach_px);
      }
    }
    const std::vector<MeshEdgePoint> points = points_at(fit.cam_from_target);
    fit.support = edge_support(edges_, camera_, points, fit.cam_from_target);
    fit.contrast = outline_contrast(edges_, camera_, points, fit.cam_from_target);
    return fit;
  }

 private:
  static constexpr double kSpacingPx = 0.5;  // of the places where the image is asked

  // The image's edge beside a point of the mesh's.
  struct Found {
    double offset_px = 0;  // along the normal
    double slope = 0;
    double weight = 0;
    bool is_at_end = false;           // of the reach: the edge may lie beyond
    Eigen::Matrix<double, 1, 6> row;  // the derivative of the point's place along the normal
  };

  // The slopes along the normal within reach, half a pixel apart, the point's own in the middle.
  // Empty where the image ends before.
  std::vector<double> slopes_beside(const MeshEdgePoint& point, const Eigen::Vector2d& pixel,
                                    int side) const {
    std::vector<double> slopes;
    for (int i = -side; i <= side; ++i) {
      const auto slope = slope_along(edges_, point.normal, pixel + i * kSpacingPx * point.normal);
      if (!slope) return {};
      slopes.push_back(*slope);
    }
    return slopes;
  }

  // The steepest place within reach, one farther away having to be steeper.
  std::optional<Found> edge_near(const MeshEdgePoint& point, const Pose& pose,
                                 double reach_px) const {
    const Eigen::Vector3d at = pose * point.in_target_m;
    const auto pixel = project(camera_, at);
    if (!pixel) return std::nullopt;
    const int side = static_cast<int>(reach_px / kSpacingPx);
    const std::vector<double> slopes = slopes_beside(point, *pixel, side);
    if (slopes.empty()) return std::nullopt;
    const auto worth = [&](int i) {
      const double nearness = (i - side) * kSpacingPx / (0.5 * reach_px);
      return slopes[static_cast<size_t>(i)] * std::exp(-0.5 * nearness * nearness);
    };
    int best = 0;
    for (int i = 1; i <= 2 * side; ++i) best = worth(i) > worth(best) ? i : best;
    Found found;
    found.is_at_end = best == 0 || best == 2 * side;
    const auto b = static_cast<size_t>(best);
    const double within =
        found.is_at_end
            ? 0
            : std::clamp(top_of_parabola(slopes[b - 1], slopes[b], slopes[b + 1]), -1.0, 1.0);
    found.offset_px = (best - side + within) * kSpacingPx;
    found.slope = slopes[b];
    found.row = row_of(point, pose);
    return found;
  }

  // The derivative of a point's place along its normal by the change of the pose.
  Eigen::Matrix<double, 1, 6> row_of(const MeshEdgePoint& point, const Pose& pose) const {
    const Eigen::Vector3d arm = pose.rotation * point.in_target_m;
    const Eigen::Vector3d at = arm + pose.translation;
    const Eigen::Vector2d n = lens_jacobian(camera_, at.hnormalized()).transpose() * point.normal;
    const double nx = n.x() * camera_.fx_px / at.z(), ny = n.y() * camera_.fy_px / at.z();
    const Eigen::Vector3d by_point(nx, ny, -(nx * at.x() + ny * at.y()) / at.z());
    Eigen::Matrix<double, 1, 6> row;
    row << arm.cross(by_point).transpose(), by_point.transpose();
    return row;
  }

  std::vector<Found> edges_near(const std::vector<MeshEdgePoint>& points, const Pose& pose,
                                double reach_px) const {
    constexpr double kEndWeight = 0.1;  // of an edge at the end of the reach
    constexpr double kCrease = 0.5;     // of a crease's: print lies beside it more often
    std::vector<Found> found;
    for (const MeshEdgePoint& point : points) {
      auto edge = edge_near(point, pose, reach_px);
      if (!edge) continue;
      edge->weight = worth_of_slope(edge->slope) * (edge->is_at_end ? kEndWeight : 1) *
                     (point.is_outline ? 1 : kCrease);
      found.push_back(*edge);
    }
    return found;
  }

  // One step of Gauss and Newton with Tukey's weights. The prior counts beside all points as if
  // they were independent, else it would draw every fit to itself; the covariance knows better.
  void step(const std::vector<MeshEdgePoint>& points, double reach_px, EdgeFit& fit) const {
    constexpr double kTukey = 2.5;    // sds, beyond which an edge counts for nothing
    constexpr double kTogether = 30;  // points that err together
    const std::vector<Found> found = edges_near(points, fit.cam_from_target, reach_px);
    if (found.empty()) return;
    const double sd_px = spread_px(found);
    Matrix6d of_points = Matrix6d::Zero();
    Vector6d pull =
        prior_information_ * change_between(fit.cam_from_target, prior_.cam_from_target);
    for (const Found& edge : found) {
      const double u = edge.offset_px / (kTukey * sd_px);
      if (std::abs(u) >= 1) continue;
      const double weight = edge.weight * (1 - u * u) * (1 - u * u) / (sd_px * sd_px);
      of_points += weight * edge.row.transpose() * edge.row;
      pull += weight * edge.offset_px * edge.row.transpose();
    }
    const auto inverse = inverse_of(Matrix6d(prior_information_ + of_points));
    const auto covariance = inverse_of(Matrix6d(prior_information_ + of_points / kTogether));
    if (!inverse || !covariance) return;
    fit.covariance = *covariance;
    fit.cam_from_target = retract(fit.cam_from_target, *inverse * pull);
  }

  // The offsets' standard deviation from their median size; at least half a pixel.
  static double spread_px(const std::vector<Found>& found) {
    constexpr double kLeastSdPx = 0.5, kSdOverMedian = 1.4826;
    std::vector<double> sizes;
    for (const Found& edge : found) sizes.push_back(std::abs(edge.offset_px));
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    return std::max(kLeastSdPx, kSdOverMedian * *middle);
  }

  EdgeImage edges_;
  Camera camera_;
  BasisDrawer drawer_;
  const PosePrior& prior_;
  Matrix6d prior_information_;
  int drawings_ = 0;
};

}  // namespace

std::optional<EdgeFit> fit_edges(const GreyImage& image, const Mesh& mesh, const PosePrior& prior) {
  constexpr size_t kFewest = 30;
  EdgeFitter fitter(image, mesh, prior);
  std::vector<MeshEdgePoint> points = fitter.points_at(prior.cam_from_target);
  if (points.size() < kFewest) return std::nullopt;
  std::optional<EdgeFit> best;
  for (const Pose& start : Search(image, prior, std::move(points)).run()) {
    const EdgeFit fit = fitter.fit(start);
    if (!best || fit.support > best->support) best = fit;
  }
  if (best) best->drawings = fitter.drawings();
  return best;
}

double edge_support_at(const GreyImage& image, const Mesh& mesh, const Pose& cam_from_target) {
  BasisDrawer drawer(mesh, image.camera);
  return edge_support(EdgeImage(image, kSharpBlurPx), image.camera,
                      edge_points_at(cam_from_target, image.camera, drawer), cam_from_target);
}

}  // namespace sightline
