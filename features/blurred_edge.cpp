// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The model: grey(p) = low + (high - low) Phi(x / s), x = n . (p - point) - offset - slope t, with
// t along the line. A pixel's square adds 1/12 to s^2, so that s stands for blur and pixel at once.
// An edge beside it adds (beyond - high) Phi(x' / s), with x' its own distance, of like form.
#include "features/blurred_edge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

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
constexpr int kOfLine = 5;               // parameters: offset, slope, low, high, s
constexpr int kOfBeside = 3;             // of an edge beside it: offset, slope, contrast
constexpr double kContrastSdGrey = 100;  // of an edge beside it, before it is seen

template <int kBeside>
constexpr int kParameters = kOfLine + kOfBeside* kBeside;
template <int kBeside>
using Vector = Eigen::Matrix<double, kParameters<kBeside>, 1>;
template <int kBeside>
using Matrix = Eigen::Matrix<double, kParameters<kBeside>, kParameters<kBeside>>;

struct Band {
  struct Pixel {
    double along_px, across_px, grey;
  };
  std::vector<Pixel> pixels;
};

// The pixels of a row, of those between two, that may lie in the band.
std::pair<int, int> in_band(const Eigen::Vector2d& point, const Eigen::Vector2d& normal, int v,
                            int first_u, int last_u) {
  if (std::abs(normal.x()) < 1e-3) return {first_u, last_u};
  const double middle_u = point.x() - normal.y() * (v - point.y()) / normal.x();
  const double half_u = kBandPx / std::abs(normal.x()) + 1;
  return {std::max(first_u, static_cast<int>(std::max(middle_u - half_u, first_u - 1.0))),
          std::min(last_u, static_cast<int>(std::min(middle_u + half_u, last_u + 1.0)))};
}

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
    const auto [row_first_u, row_last_u] = in_band(line.point, normal, v, first_u, last_u);
    for (int u = row_first_u; u <= row_last_u; ++u) {
      const Eigen::Vector2d p = Eigen::Vector2d(u, v) - line.point;
      const double across = normal.dot(p);
      const double along = line.direction.dot(p);
      if (std::abs(across) > kBandPx || along < stretch.from_px || along > stretch.to_px) continue;
      band.pixels.push_back({along, across, static_cast<double>(row[u])});
    }
  }
  return band;
}

// What is fitted, and what is known of the edges beside it.
struct Task {
  const Band& band;
  const Stretch& stretch;
  std::span<const EdgeBeside> beside;
  double noise_sd_grey;
};

template <int kBeside>
struct Normal {
  Matrix<kBeside> information = Matrix<kBeside>::Zero();
  Vector<kBeside> gradient = Vector<kBeside>::Zero();
  double squares = 0;
};

// How far an edge beside the line is expected from it, and the cosine of the angle between them.
std::pair<double, double> expected_beside(const EdgeBeside& edge, double from_begin_px) {
  const size_t last = edge.offset_px.size() - 2;
  const size_t i = std::min(static_cast<size_t>(std::max(0.0, from_begin_px)), last);
  const double slope = edge.offset_px[i + 1] - edge.offset_px[i];
  const double part = from_begin_px - static_cast<double>(i);
  return {edge.offset_px[i] + part * slope, 1 / std::sqrt(1 + slope * slope)};
}

// Adds what is known of a parameter beforehand: zero to a standard deviation.
template <int kBeside>
void add_known(double sd, double noise_sd_grey, int parameter, const Vector<kBeside>& x,
               Normal<kBeside>& sums) {
  const double weight = std::pow(std::max(1.0, noise_sd_grey) / sd, 2);
  sums.information(parameter, parameter) += weight;
  sums.gradient[parameter] -= weight * x[parameter];
  sums.squares += weight * x[parameter] * x[parameter];
}

// J^T J, J^T r and r^T r of grey minus model.
template <int kBeside>
Normal<kBeside> normal_equations(const Task& task, const Vector<kBeside>& x) {
  const NormalLaw& law = normal_law();
  const double s = x[4];
  const double contrast = x[3] - x[2];
  const double middle_px = (task.stretch.from_px + task.stretch.to_px) / 2;
  const double half_px = (task.stretch.to_px - task.stretch.from_px) / 2;
  // Of each pixel's row of J and, after it, its r; of even size, which is summed fastest.
  constexpr int kColumns = (kParameters<kBeside> + 2) / 2 * 2;
  using Row = Eigen::Matrix<double, kColumns, 1>;
  Eigen::Matrix<double, kColumns, kColumns> products;
  products.setZero();
  Row row = Row::Zero();
  for (const Band::Pixel& pixel : task.band.pixels) {
    const double z = (pixel.across_px - x[0] - x[1] * pixel.along_px) / s;
    const auto [cumulative, density] = law.at(z);
    double residual = pixel.grey - x[2] - contrast * cumulative;
    const double by_offset = -contrast * density / s;
    row.template head<kOfLine>() << by_offset, by_offset * pixel.along_px, 1 - cumulative,
        cumulative, by_offset * z;
    for (int i = 0; i < kBeside; ++i) {
      const EdgeBeside& edge = task.beside[i];
      const auto own = x.template segment<kOfBeside>(kOfLine + kOfBeside * i);
      const double along_px = pixel.along_px - middle_px;
      const auto [offset_px, cosine] = expected_beside(edge, pixel.along_px - task.stretch.from_px);
      const double z2 = cosine * (pixel.across_px - offset_px - own[0] - own[1] * along_px) / s;
      const auto [cumulative2, density2] = law.at(z2);
      const double step = offset_px > 0 ? cumulative2 : cumulative2 - 1;
      residual -= own[2] * step;
      const double by_offset2 = -own[2] * density2 * cosine / s;
      row[4] += -own[2] * density2 * z2 / s;
      row.template segment<kOfBeside>(kOfLine + kOfBeside * i) << by_offset2, by_offset2 * along_px,
          step;
    }
    row[kParameters<kBeside>] = residual;
    products.noalias() += row * row.transpose();
  }
  Normal<kBeside> sums;
  sums.information = products.template topLeftCorner<kParameters<kBeside>, kParameters<kBeside>>();
  sums.gradient = products.col(kParameters<kBeside>).template head<kParameters<kBeside>>();
  sums.squares = products(kParameters<kBeside>, kParameters<kBeside>);
  for (int i = 0; i < kBeside; ++i) {
    const int first = kOfLine + kOfBeside * i;
    const double sd_px = task.beside[i].sd_px;
    add_known<kBeside>(sd_px, task.noise_sd_grey, first, x, sums);
    add_known<kBeside>(sd_px / half_px, task.noise_sd_grey, first + 1, x, sums);
    add_known<kBeside>(kContrastSdGrey, task.noise_sd_grey, first + 2, x, sums);
  }
  return sums;
}

template <int kBeside>
Vector<kBeside> start_of(const Band& band) {
  double low = 0, high = 0, low_count = 0, high_count = 0;
  for (const Band::Pixel& pixel : band.pixels) {
    (pixel.across_px < 0 ? low : high) += pixel.grey;
    (pixel.across_px < 0 ? low_count : high_count) += 1;
  }
  Vector<kBeside> start = Vector<kBeside>::Zero();
  start.template head<kOfLine>() << 0, 0, low / std::max(low_count, 1.0),
      high / std::max(high_count, 1.0), 0.8;
  return start;
}

// The line of a band's pixels; see fit_blurred_edge.
template <int kBeside>
std::optional<ImageLine> fitted(const Task& task, const ImageLine& line) {
  constexpr double kConvergedPx = 1e-2;       // by the last step: the next would be its square
  constexpr double kConvergedSquares = 1e-2;  // of the sum, by the last step: 0.5 % of sigma
  const Stretch& stretch = task.stretch;
  Vector<kBeside> x = start_of<kBeside>(task.band);
  Normal<kBeside> sums = normal_equations<kBeside>(task, x);
  double damping = 1e-3;
  for (int i = 0; i < kMaxIterations; ++i) {
    Matrix<kBeside> damped = sums.information;
    damped.diagonal() *= 1 + damping;
    damped.diagonal().array() += 1e-9;
    const Vector<kBeside> step = damped.ldlt().solve(sums.gradient);
    Vector<kBeside> next = x + step;
    next[4] = std::clamp(next[4], kMinBlurPx, kMaxBlurPx);
    const double moves_px =
        std::abs(step[0]) + std::abs(step[1]) * (stretch.to_px - stretch.from_px);
    if (moves_px < kConvergedPx && step.dot(sums.gradient) < kConvergedSquares * sums.squares) {
      x = next;
      break;
    }
    const Normal<kBeside> there = normal_equations<kBeside>(task, next);
    if (!(there.squares < sums.squares)) {
      damping *= 10;
      if (damping > 1e3) break;
      continue;
    }
    x = next;
    sums = there;
    damping = std::max(damping / 10, 1e-6);
    if (moves_px < kConvergedPx) break;
  }
  const double degrees = static_cast<double>(task.band.pixels.size() - kOfLine);
  const double sd = std::max(task.noise_sd_grey, std::sqrt(sums.squares / degrees));
  const double middle_px = (stretch.from_px + stretch.to_px) / 2;
  const double half_px = (stretch.to_px - stretch.from_px) / 2;
  const double moved_px = std::abs(x[0] + x[1] * middle_px) + std::abs(x[1]) * half_px;
  const Matrix<kBeside> covariance =
      sd * sd * sums.information.ldlt().solve(Matrix<kBeside>::Identity());
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
  refined.covariance =
      to_middle * covariance.template topLeftCorner<2, 2>() * to_middle.transpose();
  refined.rms_px = std::sqrt(refined.covariance(0, 0));
  return refined;
}

}  // namespace

std::optional<ImageLine> fit_blurred_edge(const cv::Mat& image, const ImageLine& line,
                                          const Stretch& stretch, double noise_sd_grey,
                                          std::span<const EdgeBeside> beside) {
  constexpr size_t kFewestPixels = 20;
  const Band band = band_of(image, line, stretch);
  if (band.pixels.size() < kFewestPixels) return std::nullopt;
  const Task task{band, stretch, beside, noise_sd_grey};
  switch (beside.size()) {
    case 0:
      return fitted<0>(task, line);
    case 1:
      return fitted<1>(task, line);
    default:
      return fitted<2>(task, line);
  }
}

}  // namespace sightline
