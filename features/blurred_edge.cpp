// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The model: grey(p) = low + (high - low) Phi(x / s), x = n . (p - point) - offset - slope t, with
// t along the line. A pixel's square adds 1/12 to s^2, so that s stands for blur and pixel at once.
#include "features/blurred_edge.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "features/normal_law.h"

namespace sightline {
namespace {

constexpr double kBandPx = 3;
constexpr double kMaxMovePx = 1.5;
constexpr double kMinBlurPx = 0.25;
constexpr double kMaxBlurPx = 2.5;
constexpr int kMaxIterations = 12;
constexpr int kParameters = 5;  // offset, slope, low, high, s

using Vector5d = Eigen::Matrix<double, kParameters, 1>;
using Matrix5d = Eigen::Matrix<double, kParameters, kParameters>;

struct Band {
  struct Pixel {
    double along_px, across_px, grey;
  };
  std::vector<Pixel> pixels;
};

Band band_of(const cv::Mat& image, const ImageLine& line, const Stretch& stretch) {
  const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
  const Eigen::Vector2d from = line.point + stretch.from_px * line.direction;
  const Eigen::Vector2d to = line.point + stretch.to_px * line.direction;
  const Eigen::Vector2d least = from.cwiseMin(to).array() - kBandPx;
  const Eigen::Vector2d most = from.cwiseMax(to).array() + kBandPx;
  const int first_u = std::max(0, static_cast<int>(std::ceil(least.x())));
  const int last_u = std::min(image.cols - 1, static_cast<int>(std::floor(most.x())));
  const int first_v = std::max(0, static_cast<int>(std::ceil(least.y())));
  const int last_v = std::min(image.rows - 1, static_cast<int>(std::floor(most.y())));
  Band band;
  for (int v = first_v; v <= last_v; ++v) {
    const uint8_t* row = image.ptr<uint8_t>(v);
    for (int u = first_u; u <= last_u; ++u) {
      const Eigen::Vector2d p = Eigen::Vector2d(u, v) - line.point;
      const double across = normal.dot(p);
      const double along = line.direction.dot(p);
      if (std::abs(across) > kBandPx || along < stretch.from_px || along > stretch.to_px) continue;
      band.pixels.push_back({along, across, static_cast<double>(row[u])});
    }
  }
  return band;
}

struct Normal {
  Matrix5d information = Matrix5d::Zero();
  Vector5d gradient = Vector5d::Zero();
  double squares = 0;
};

// J^T J, J^T r and r^T r of grey minus model.
Normal normal_equations(const Band& band, const Vector5d& x) {
  const NormalLaw& law = normal_law();
  const double s = x[4];
  const double contrast = x[3] - x[2];
  Normal sums;
  for (const Band::Pixel& pixel : band.pixels) {
    const double z = (pixel.across_px - x[0] - x[1] * pixel.along_px) / s;
    const auto [cumulative, density] = law.at(z);
    const double residual = pixel.grey - x[2] - contrast * cumulative;
    const double by_offset = -contrast * density / s;
    Vector5d row;
    row << by_offset, by_offset * pixel.along_px, 1 - cumulative, cumulative, by_offset * z;
    sums.information.noalias() += row * row.transpose();
    sums.gradient.noalias() += row * residual;
    sums.squares += residual * residual;
  }
  return sums;
}

Vector5d start_of(const Band& band) {
  double low = 0, high = 0, low_count = 0, high_count = 0;
  for (const Band::Pixel& pixel : band.pixels) {
    (pixel.across_px < 0 ? low : high) += pixel.grey;
    (pixel.across_px < 0 ? low_count : high_count) += 1;
  }
  Vector5d start;
  start << 0, 0, low / std::max(low_count, 1.0), high / std::max(high_count, 1.0), 0.8;
  return start;
}

}  // namespace

std::optional<ImageLine> fit_blurred_edge(const cv::Mat& image, const ImageLine& line,
                                          const Stretch& stretch, double noise_sd_grey) {
  constexpr size_t kFewestPixels = 20;
  constexpr double kConvergedPx = 1e-2;  // by the last step: the next would be its square
  const Band band = band_of(image, line, stretch);
  if (band.pixels.size() < kFewestPixels) return std::nullopt;
  Vector5d x = start_of(band);
  Normal sums = normal_equations(band, x);
  double damping = 1e-3;
  for (int i = 0; i < kMaxIterations; ++i) {
    Matrix5d damped = sums.information;
    damped.diagonal() *= 1 + damping;
    damped.diagonal().array() += 1e-9;
    const Vector5d step = damped.ldlt().solve(sums.gradient);
    Vector5d next = x + step;
    next[4] = std::clamp(next[4], kMinBlurPx, kMaxBlurPx);
    const Normal there = normal_equations(band, next);
    if (!(there.squares < sums.squares)) {
      damping *= 10;
      if (damping > 1e3) break;
      continue;
    }
    x = next;
    sums = there;
    damping = std::max(damping / 10, 1e-6);
    if (std::abs(step[0]) + std::abs(step[1]) * (stretch.to_px - stretch.from_px) < kConvergedPx) {
      break;
    }
  }
  const double degrees = static_cast<double>(band.pixels.size() - kParameters);
  const double sd = std::max(noise_sd_grey, std::sqrt(sums.squares / degrees));
  const double middle_px = (stretch.from_px + stretch.to_px) / 2;
  const double half_px = (stretch.to_px - stretch.from_px) / 2;
  const double moved_px = std::abs(x[0] + x[1] * middle_px) + std::abs(x[1]) * half_px;
  const Matrix5d covariance = sd * sd * sums.information.ldlt().solve(Matrix5d::Identity());
  if (!(moved_px <= kMaxMovePx) || !covariance.allFinite() || !(covariance(0, 0) > 0)) {
    return std::nullopt;
  }

  // About the middle of the stretch, where offset and slope are nearly uncorrelated.
  const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
  ImageLine refined;
  refined.point = line.point + middle_px * line.direction + (x[0] + x[1] * middle_px) * normal;
  refined.direction = (line.direction + x[1] * normal).normalized();
  refined.edge_pixels = line.edge_pixels;
  refined.contrast_grey = std::abs(x[3] - x[2]);
  Eigen::Matrix2d to_middle;
  to_middle << 1, middle_px, 0, 1;
  refined.covariance = to_middle * covariance.topLeftCorner<2, 2>() * to_middle.transpose();
  refined.rms_px = std::sqrt(refined.covariance(0, 0));
  return refined;
}

}  // namespace sightline
