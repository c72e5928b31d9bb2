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

#include <Eigen/Core>

#include "features/normal_equations.h"
#include "features/normal_law.h"

namespace sightline {
namespace {

constexpr double kMaxMovePx = 1.5;
constexpr double kMinBlurPx = 0.25;
constexpr double kMaxBlurPx = 2.5;
constexpr int kMaxIterations = 12;
constexpr double kContrastSdGrey = 100;  // of an edge beside the line, before it is seen

// The parameters, in the order of a vector of them: of the line, then of each edge beside it. The
// slopes are those against the given line and the expected edge, offsets are along their normals.
constexpr int kOffset = 0;
constexpr int kSlope = 1;
constexpr int kLow = 2;
constexpr int kHigh = 3;
constexpr int kBlur = 4;
constexpr int kOfLine = 5;
constexpr int kOfBeside = 3;  // offset, slope, contrast

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
  const double half_u = kBlurredBandPx / std::abs(normal.x()) + 1;
  return {std::max(first_u, static_cast<int>(std::max(middle_u - half_u, first_u - 1.0))),
          std::min(last_u, static_cast<int>(std::min(middle_u + half_u, last_u + 1.0)))};
}

Band band_of(const cv::Mat& image, const ImageLine& line, const Stretch& stretch) {
  const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
  const Eigen::Vector2d from = line.point + stretch.from_px * line.direction;
  const Eigen::Vector2d to = line.point + stretch.to_px * line.direction;
  const Eigen::Vector2d least = from.cwiseMin(to).array() - kBlurredBandPx;
  const Eigen::Vector2d most = from.cwiseMax(to).array() + kBlurredBandPx;
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
      if (std::abs(across) > kBlurredBandPx || along < stretch.from_px || along > stretch.to_px)
        continue;
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

// How far an edge beside the line is expected from it, and the cosine of the angle between them.
std::pair<double, double> expected_beside(const EdgeBeside& edge, double from_begin_px) {
  const size_t last = edge.offset_px.size() - 2;
  const size_t i = std::min(static_cast<size_t>(std::max(0.0, from_begin_px)), last);
  const double slope = edge.offset_px[i + 1] - edge.offset_px[i];
  const double part = from_begin_px - static_cast<double>(i);
  return {edge.offset_px[i] + part * slope, 1 / std::sqrt(1 + slope * slope)};
}

// Adds what is known of a parameter beforehand: zero to a standard deviation.
void add_known(double sd, double noise_sd_grey, int parameter, const SmallVector& x,
               NormalEquations& sums) {
  const double weight = std::pow(std::max(1.0, noise_sd_grey) / sd, 2);
  sums.information(parameter, parameter) += weight;
  sums.gradient[parameter] -= weight * x[parameter];
  sums.squares += weight * x[parameter] * x[parameter];
}

// Writes the derivatives of a pixel's grey by the line's parameters, and gives grey minus model,
// both as they are without edges beside it.
double fill_for_line(const Band::Pixel& pixel, const double* x, double* row) {
  const double s = x[kBlur];
  const double contrast = x[kHigh] - x[kLow];
  const double z = (pixel.across_px - x[kOffset] - x[kSlope] * pixel.along_px) / s;
  const auto [cumulative, density] = normal_law().at(z);
  const double by_offset = -contrast * density / s;
  row[kOffset] = by_offset;
  row[kSlope] = by_offset * pixel.along_px;
  row[kLow] = 1 - cumulative;
  row[kHigh] = cumulative;
  row[kBlur] = by_offset * z;
  return pixel.grey - x[kLow] - contrast * cumulative;
}

// Writes the derivatives by the parameters of one edge beside the line, adds its share to that by
// the blur, and gives what it adds to the model.
double fill_for_beside(const Task& task, int which, const Band::Pixel& pixel, double middle_px,
                       const double* x, double* row) {
  const int first = kOfLine + kOfBeside * which;
  const double* const own = x + first;
  const double s = x[kBlur];
  const double along_px = pixel.along_px - middle_px;
  const auto [offset_px, cosine] =
      expected_beside(task.beside[which], pixel.along_px - task.stretch.from_px);
  const double z = cosine * (pixel.across_px - offset_px - own[0] - own[1] * along_px) / s;
  const auto [cumulative, density] = normal_law().at(z);
  const double step = offset_px > 0 ? cumulative : cumulative - 1;
  const double by_offset = -own[2] * density * cosine / s;
  row[kBlur] += -own[2] * density * z / s;
  row[first] = by_offset;
  row[first + 1] = by_offset * along_px;
  row[first + 2] = step;
  return own[2] * step;
}

// The sums over all pixels with so many edges beside the line, known to the compiler because this
// is where the time goes. Plain arrays compile in a fraction of the time that matrices of fixed
// size take, and are as fast.
template <int kBeside>
NormalEquations summed(const Task& task, const SmallVector& parameters) {
  constexpr int kSize = kOfLine + kOfBeside * kBeside;
  // A row is followed by its residual; of even size, which is summed fastest.
  constexpr int kColumns = (kSize + 2) / 2 * 2;
  double products[kColumns][kColumns] = {};  // from the diagonal on
  double row[kColumns] = {};
  double x[kSize];
  std::copy_n(parameters.data(), kSize, x);
  const double middle_px = (task.stretch.from_px + task.stretch.to_px) / 2;
  for (const Band::Pixel& pixel : task.band.pixels) {
    double residual = fill_for_line(pixel, x, row);
    for (int i = 0; i < kBeside; ++i) {
      residual -= fill_for_beside(task, i, pixel, middle_px, x, row);
    }
    row[kSize] = residual;
    for (int i = 0; i <= kSize; ++i) {
      for (int k = i & ~1; k < kColumns; ++k) products[i][k] += row[i] * row[k];
    }
  }
  NormalEquations sums{SmallMatrix(kSize, kSize), SmallVector(kSize), products[kSize][kSize]};
  for (int i = 0; i < kSize; ++i) {
    sums.gradient[i] = products[i][kSize];
    for (int k = 0; k < kSize; ++k)
      sums.information(i, k) = products[std::min(i, k)][std::max(i, k)];
  }
  return sums;
}

// J^T J, J^T r and r^T r of grey minus model, and of what is known beforehand.
NormalEquations normal_equations(const Task& task, const SmallVector& x) {
  const auto sum = task.beside.empty()       ? summed<0>
                   : task.beside.size() == 1 ? summed<1>
                                             : summed<2>;
  NormalEquations sums = sum(task, x);
  const double half_px = (task.stretch.to_px - task.stretch.from_px) / 2;
  for (int i = 0; i < static_cast<int>(task.beside.size()); ++i) {
    const int first = kOfLine + kOfBeside * i;
    const double sd_px = task.beside[i].sd_px;
    add_known(sd_px, task.noise_sd_grey, first, x, sums);
    add_known(sd_px / half_px, task.noise_sd_grey, first + 1, x, sums);
    add_known(kContrastSdGrey, task.noise_sd_grey, first + 2, x, sums);
  }
  return sums;
}

// The line as given between the mean greys of its two sides, and edges beside it without contrast.
SmallVector start_of(const Task& task) {
  constexpr double kUsualBlurPx = 0.8;
  double low = 0, high = 0, low_count = 0, high_count = 0;
  for (const Band::Pixel& pixel : task.band.pixels) {
    (pixel.across_px < 0 ? low : high) += pixel.grey;
    (pixel.across_px < 0 ? low_count : high_count) += 1;
  }
  SmallVector start = SmallVector::Zero(kOfLine + kOfBeside * static_cast<int>(task.beside.size()));
  start[kLow] = low / std::max(low_count, 1.0);
  start[kHigh] = high / std::max(high_count, 1.0);
  start[kBlur] = kUsualBlurPx;
  return start;
}

// Parameters of least squares, and the sums at the last place where these were taken.
struct Fit {
  SmallVector x;
  NormalEquations sums;
};

// Levenberg and Marquardt's method.
Fit least_squares(const Task& task) {
  constexpr double kConvergedPx = 1e-2;       // by the last step: the next would be its square
  constexpr double kConvergedSquares = 1e-2;  // of the sum, by the last step: 0.5 % of sigma
  constexpr double kMostDamping = 1e3;
  Fit fit{start_of(task), {}};
  fit.sums = normal_equations(task, fit.x);
  double damping = 1e-3;
  for (int i = 0; i < kMaxIterations; ++i) {
    const SmallVector step = damped_step(fit.sums, damping, Substitution::kUnrolled);
    SmallVector next = fit.x + step;
    next[kBlur] = std::clamp(next[kBlur], kMinBlurPx, kMaxBlurPx);
    const double moves_px = std::abs(step[kOffset]) +
                            std::abs(step[kSlope]) * (task.stretch.to_px - task.stretch.from_px);
    if (moves_px < kConvergedPx &&
        step.dot(fit.sums.gradient) < kConvergedSquares * fit.sums.squares) {
      fit.x = next;
      break;
    }
    NormalEquations there = normal_equations(task, next);
    if (!(there.squares < fit.sums.squares)) {
      damping *= 10;
      if (damping > kMostDamping) break;
      continue;
    }
    fit = {next, std::move(there)};
    damping = std::max(damping / 10, 1e-6);
    if (moves_px < kConvergedPx) break;
  }
  return fit;
}

// The line of a band's pixels; see fit_blurred_edge.
std::optional<ImageLine> fitted(const Task& task, const ImageLine& line) {
  const auto [x, sums] = least_squares(task);
  const Stretch& stretch = task.stretch;
  const double degrees = static_cast<double>(task.band.pixels.size() - kOfLine);
  const double sd = std::max(task.noise_sd_grey, std::sqrt(sums.squares / degrees));
  const double middle_px = (stretch.from_px + stretch.to_px) / 2;
  const double half_px = (stretch.to_px - stretch.from_px) / 2;
  const double moved_px =
      std::abs(x[kOffset] + x[kSlope] * middle_px) + std::abs(x[kSlope]) * half_px;
  const SmallMatrix covariance = sd * sd * inverse_of(sums.information);
  if (!(moved_px <= kMaxMovePx) || !covariance.allFinite() || !(covariance(0, 0) > 0)) {
    return std::nullopt;
  }

  // About the middle of the stretch, where offset and slope are nearly uncorrelated.
  const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
  ImageLine refined;
  refined.point =
      line.point + middle_px * line.direction + (x[kOffset] + x[kSlope] * middle_px) * normal;
  refined.direction = (line.direction + x[kSlope] * normal).normalized();
  refined.edge_pixels = line.edge_pixels;
  refined.contrast_grey = std::abs(x[kHigh] - x[kLow]);
  Eigen::Matrix2d to_middle;
  to_middle << 1, middle_px, 0, 1;
  const Eigen::Matrix2d of_line = covariance.topLeftCorner<2, 2>();
  refined.covariance = to_middle * of_line * to_middle.transpose();
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
  constexpr size_t kMostBeside = 2;
  const auto known_beside = beside.first(std::min(beside.size(), kMostBeside));
  return fitted({band, stretch, known_beside, noise_sd_grey}, line);
}

}  // namespace sightline
