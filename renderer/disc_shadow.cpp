// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/disc_shadow.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

#include "pose/angles.h"

namespace sightline {
namespace {

constexpr int kCellTexels = 2;
// A sheet is torn where it rises by more than this part of how steeply rays to the disc's rim do.
constexpr double kTorn = 0.1;
constexpr double kWidest = 1.0 / 16;  // penumbra of a narrow disc, of the receiver's size
// Triangles that a ray may be held against, some microseconds: of more, maps are made after all.
constexpr double kMostTests = 1000;

// The least and the greatest of each cell's texels, those of the border to the next among them.
struct CellExtremes {
  cv::Mat least, greatest;  // CV_32F
};

CellExtremes extremes_of(const ShadowMap& map) {
  const int side = map.side();
  const int cells = (side + kCellTexels - 1) / kCellTexels;
  CellExtremes out{cv::Mat(cells, cells, CV_32F), cv::Mat(cells, cells, CV_32F)};
  std::vector<float> least(static_cast<size_t>(side)), greatest(least.size());
  for (int i = 0; i < cells; ++i) {
    const int begin = i * kCellTexels;
    const int end = std::min(begin + kCellTexels, side - 1);
    std::copy_n(map.row(begin), side, least.begin());
    greatest = least;
    for (int row = begin + 1; row <= end; ++row) {
      const float* values = map.row(row);
      for (size_t k = 0; k < least.size(); ++k) {
        least[k] = std::min(least[k], values[k]);
        greatest[k] = std::max(greatest[k], values[k]);
      }
    }
    for (int j = 0; j < cells; ++j) {
      const int first = j * kCellTexels;
      const int last = std::min(first + kCellTexels, side - 1) + 1;
      out.least.at<float>(i, j) = *std::min_element(least.begin() + first, least.begin() + last);
      out.greatest.at<float>(i, j) =
          *std::max_element(greatest.begin() + first, greatest.begin() + last);
    }
  }
  return out;
}

// Visits where an edge lies over the map, at least twice in each cell that it crosses: x and y in
// cells, z in metres, as `begin` and `along`, which leads to its end, have them.
template <typename Visit>
void for_each_step(const Eigen::Array3d& begin, const Eigen::Array3d& along, double cells,
                   const Visit& visit) {
  constexpr double kStepsACell = 2;
  double first = 0, last = 1;  // of the edge, what lies over the map
  for (int axis = 0; axis < 2; ++axis) {
    if (along[axis] == 0) continue;  // it may lie beside the map, as is asked below
    const double a = -begin[axis] / along[axis], b = (cells - begin[axis]) / along[axis];
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  if (first > last) return;
  const double steps = std::ceil(kStepsACell * (last - first) * along.head<2>().abs().maxCoeff());
  for (double step = 0; step <= steps; ++step) {
    const double part = first + (steps > 0 ? step / steps : 0) * (last - first);
    const Eigen::Array3d at = begin + part * along;
    if ((at.head<2>() >= 0).all() && (at.head<2>() < cells).all()) visit(at);
  }
}

}  // namespace

std::vector<Eigen::Vector3d> points_of_disc(const Eigen::Vector3d& to_light_in_cam,
                                            double radius_deg, int count) {
  constexpr double kGoldenAngle = 2.39996322972865332;
  const Eigen::Matrix3d axes = light_axes(to_light_in_cam);
  const double rim = std::tan(radius_deg * kDegree);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double radius = rim * std::sqrt((i + 0.5) / count);
    const Eigen::Vector3d across(radius * std::cos(i * kGoldenAngle),
                                 radius * std::sin(i * kGoldenAngle), 1);
    points.push_back((axes.transpose() * across).normalized());
  }
  return points;
}

bool DiscShadow::is_narrow(const std::vector<PlacedBody>& bodies, size_t receiver,
                           const Eigen::Vector3d& to_light_in_cam, double radius_deg) {
  const Eigen::Matrix3d light_from_cam = light_axes(to_light_in_cam);
  Eigen::AlignedBox3d extent;
  double top = -std::numeric_limits<double>::infinity();
  double triangles = 0;
  for (size_t b = 0; b < bodies.size(); ++b) {
    triangles += static_cast<double>(bodies[b].mesh->triangles.size());
    const Eigen::Matrix3d turn = light_from_cam * bodies[b].cam_from_body.rotation;
    const Eigen::Vector3d shift = light_from_cam * bodies[b].cam_from_body.translation;
    for (const Eigen::Vector3d& vertex : bodies[b].mesh->vertices) {
      const Eigen::Vector3d x = turn * vertex + shift;
      if (b == receiver) extent.extend(x);
      top = std::max(top, x.z());
    }
  }
  // As the light sees it: a body that is long along the rays is no larger for that.
  const Eigen::Array2d size_m = extent.sizes().head<2>();
  const double reach_m = (top - extent.min().z()) * std::tan(radius_deg * kDegree);
  if (reach_m > kWidest * size_m.maxCoeff()) return false;
  // A tile is as wide as rays reach, and so far beyond it stand triangles that belong to it.
  const Eigen::Array2d tile_and_reach = (3 * reach_m / size_m).min(1.0);
  return triangles * tile_and_reach.prod() <= kMostTests;
}

DiscShadow::DiscShadow(const std::vector<PlacedBody>& bodies, size_t receiver,
                       const Eigen::Vector3d& to_light_in_cam, double radius_deg,
                       const ShadowMap& middle, const std::vector<Eigen::Vector3d>& points)
    : light_from_body_(middle.light_from_body()),
      origin_(middle.origin()),
      tangent_(std::tan(radius_deg * kDegree)),
      tolerance_m_(middle.tolerance_m()),
      cell_m_(kCellTexels * middle.texel_m()) {
  const Eigen::Matrix3d axes = light_axes(to_light_in_cam);
  for (const Eigen::Vector3d& point : points) slopes_.push_back((axes * point).hnormalized());
  place_blockers(bodies, receiver);
  mark_outlines(middle);
  sort_blockers();
}

// A texel of the map is seen at its centre alone: a strut between two rows of centres is not on it.
// But of every triangle all that is nearer to no centre on it is near to its edges, so that cells
// over which an edge stands are torn, and as high as the edge.
void DiscShadow::mark_missed(cv::Mat& greatest, cv::Mat& is_whole) const {
  // Ridges, too, rise a little over the centres beside them.
  const double least_rise = std::min(cell_m_ / kCellTexels, kTorn * cell_m_ / tangent_);
  const Eigen::Array3d scale(cell_m_, cell_m_, 1);
  for (const Blocker& blocker : blockers_) {
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      const Eigen::Array3d from(blocker.x[k], blocker.y[k], blocker.z[k]);
      const Eigen::Array3d to(blocker.x[next], blocker.y[next], blocker.z[next]);
      for_each_step(from / scale, (to - from) / scale, greatest.cols, [&](const auto& at) {
        const cv::Point cell(static_cast<int>(at.x()), static_cast<int>(at.y()));
        float& value = greatest.at<float>(cell);
        if (!(at.z() > value + least_rise)) return;
        value = static_cast<float>(at.z());
        is_whole.at<uint8_t>(cell) = 0;
      });
    }
  }
}

// Border cells count as torn: beyond them nobody looked.
void DiscShadow::mark_outlines(const ShadowMap& middle) {
  CellExtremes extremes = extremes_of(middle);
  const cv::Mat rise = extremes.greatest - extremes.least;
  cv::Mat is_whole = rise <= kTorn * cell_m_ / tangent_;
  mark_missed(extremes.greatest, is_whole);
  cv::rectangle(is_whole, {0, 0, is_whole.cols, is_whole.rows}, 0);
  cv::distanceTransform(is_whole, to_outline_, cv::DIST_C, cv::DIST_MASK_3);
  double top = 0;
  cv::minMaxLoc(extremes.greatest, nullptr, &top);
  const int reach = static_cast<int>(std::ceil(std::max(0.0, top) * tangent_ / cell_m_)) + 1;
  const cv::Mat window = cv::Mat::ones(2 * reach + 1, 2 * reach + 1, CV_8U);
  cv::dilate(extremes.greatest, highest_, window);
}

void DiscShadow::place_blockers(const std::vector<PlacedBody>& bodies, size_t receiver) {
  const PlacedBody& body = bodies[receiver];
  const Eigen::Matrix3d light_from_cam = light_from_body_ * body.cam_from_body.rotation.transpose();
  for (size_t b = 0; b < bodies.size(); ++b) {
    const PlacedBody& caster = bodies[b];
    const Eigen::Matrix3d turn = light_from_cam * caster.cam_from_body.rotation;
    const Eigen::Vector3d shift =
        light_from_cam * (caster.cam_from_body.translation - body.cam_from_body.translation) -
        origin_;
    std::vector<Eigen::Vector3d> corners;
    for (const Eigen::Vector3d& vertex : caster.mesh->vertices) {
      corners.emplace_back(turn * vertex + shift);
    }
    for (size_t i = 0; i < caster.mesh->triangles.size(); ++i) {
      Eigen::Matrix3d at;
      for (int k = 0; k < 3; ++k) at.col(k) = corners[caster.mesh->triangles[i].vertex[k]];
      blockers_.push_back({at.row(0), at.row(1), at.row(2), at.row(2).maxCoeff(),
                           b == receiver ? static_cast<int>(i) : -1});
    }
  }
}

int DiscShadow::tile_of(double along) const {
  // Clamped first: far away there are more tiles than an integer counts.
  return static_cast<int>(std::clamp(along / tile_m_, 0.0, tiles_ - 1.0));
}

// No ray from the receiver that a triangle stops begins farther from it than it stands high.
void DiscShadow::sort_blockers() {
  const double side_m = cell_m_ * to_outline_.cols;
  double top = 0;
  for (const Blocker& blocker : blockers_) top = std::max(top, blocker.top);
  const double finest = side_m / std::max(1.0, std::sqrt(static_cast<double>(blockers_.size())));
  tile_m_ = std::max(finest, top * tangent_);
  tiles_ = std::max(1, static_cast<int>(std::ceil(side_m / tile_m_)));
  const auto for_each_tile = [&](const Blocker& blocker, const auto& visit) {
    const double reach = std::max(0.0, blocker.top) * tangent_;
    const double left = blocker.x.minCoeff() - reach, right = blocker.x.maxCoeff() + reach;
    const double near = blocker.y.minCoeff() - reach, far = blocker.y.maxCoeff() + reach;
    if (right < 0 || far < 0 || left > side_m || near > side_m) return;
    for (int row = tile_of(near); row <= tile_of(far); ++row) {
      for (int column = tile_of(left); column <= tile_of(right); ++column) {
        visit(static_cast<size_t>(row * tiles_ + column));
      }
    }
  };
  starts_.assign(static_cast<size_t>(tiles_) * tiles_ + 1, 0);
  for (const Blocker& blocker : blockers_) {
    for_each_tile(blocker, [&](size_t tile) { ++starts_[tile + 1]; });
  }
  for (size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
  sorted_.resize(starts_.back());
  std::vector<uint32_t> next(starts_.begin(), starts_.end() - 1);
  for (uint32_t i = 0; i < blockers_.size(); ++i) {
    for_each_tile(blockers_[i], [&](size_t tile) { sorted_[next[tile]++] = i; });
  }
}

bool DiscShadow::may_be_soft(const Eigen::Vector3d& x) const {
  constexpr double kRounding = 1.5;  // cells: of the point to its own, of outlines to theirs
  const Eigen::Vector3d at = light_from_body_ * x - origin_;
  const int column = static_cast<int>(std::floor(at.x() / cell_m_));
  const int row = static_cast<int>(std::floor(at.y() / cell_m_));
  if (column < 0 || row < 0 || column >= to_outline_.cols || row >= to_outline_.rows) return true;
  const double height_m = std::max(0.0, highest_.at<float>(row, column) - at.z());
  return to_outline_.at<float>(row, column) <= height_m * tangent_ / cell_m_ + kRounding;
}

bool DiscShadow::is_lit(const Eigen::Vector3d& x, int triangle, int point) const {
  const Eigen::Vector3d at = light_from_body_ * x - origin_;
  const Eigen::Vector2d& slope = slopes_[static_cast<size_t>(point)];
  const auto tile = static_cast<size_t>(tile_of(at.y()) * tiles_ + tile_of(at.x()));
  const double over = at.z() + tolerance_m_;
  for (uint32_t k = starts_[tile]; k < starts_[tile + 1]; ++k) {
    const Blocker& blocker = blockers_[sorted_[k]];
    if (blocker.top <= over || blocker.triangle == triangle) continue;
    // Where the corners lie as the ray sees them.
    const Eigen::Array3d rise = blocker.z.array() - at.z();
    const Eigen::Array3d u = blocker.x.array() - at.x() - slope.x() * rise;
    const Eigen::Array3d v = blocker.y.array() - at.y() - slope.y() * rise;
    const double a = u[1] * v[2] - u[2] * v[1];
    const double b = u[2] * v[0] - u[0] * v[2];
    const double c = u[0] * v[1] - u[1] * v[0];
    const bool is_inside = (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
    const double sum = a + b + c;
    if (!is_inside || sum == 0) continue;
    if ((a * rise[0] + b * rise[1] + c * rise[2]) / sum > tolerance_m_) return false;
  }
  return true;
}

}  // namespace sightline
