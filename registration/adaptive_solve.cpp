// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/adaptive_solve.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/core.hpp>

#include "registration/symmetric.h"

namespace sightline {
namespace {

constexpr double kNu = 6;            // degrees of freedom of the pixels' noise
constexpr double kBlockNu = 4;       // of the blocks' deviations
constexpr double kAlbedoUnit = 0.7;  // a usual albedo: deviations are of its grey
constexpr double kLostWeight = 0.3;

using LocalsByLocals = Eigen::Matrix<double, kLocals, kLocals>;
using LocalsByUnknowns = Eigen::Matrix<double, kLocals, kUnknowns + 1>;
using GramMatrix = Eigen::Matrix<double, kColumns, kColumns, Eigen::RowMajor>;

// Which column a local deviation is of, and its unit.
constexpr std::array<int, kLocals> kLocalColumns = {6, 7, 8, 9, 10, 13, 14};
constexpr std::array<double, kLocals> kLocalUnits = {
    kAlbedoUnit, kAlbedoUnit, kAlbedoUnit, kAlbedoUnit, 1, 1, 1};

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The sd of normal numbers whose absolute values have this median.
double sd_of_median(double absolute_median) {
  return 1.4826 * absolute_median;
}

// The inverse of a positive definite matrix, in units that suit each other, by sweeps of its
// diagonal: of so small a matrix that takes less time than a decomposition.
LocalsByLocals swept_inverse(LocalsByLocals matrix) {
  for (int k = 0; k < kLocals; ++k) {
    const double pivot = 1 / matrix(k, k);
    const Eigen::Matrix<double, kLocals, 1> column = matrix.col(k);
    const Eigen::Matrix<double, kLocals, 1> scaled = column * pivot;
    matrix.noalias() -= column.lazyProduct(scaled.transpose());
    matrix.col(k) = scaled;
    matrix.row(k) = scaled.transpose();
    matrix(k, k) = -pivot;
  }
  return -matrix;
}

// The pixels' weights over their variance, and zeros up to the block's stride.
std::array<double, kBlockPixels> weights_of(const BlockRows& rows, const Block& block,
                                            const Learning& learning) {
  std::array<double, kBlockPixels> weights;
  const double information =
      1 / (learning.pixel_variance * learning.blocks[static_cast<size_t>(block.id)].noise);
  const auto pixels = rows.pixels_of(block);
  for (size_t i = 0; i < pixels.size(); ++i) {
    weights[i] = learning.weights[static_cast<size_t>(pixels[i])] * information;
  }
  std::fill(weights.begin() + block.count, weights.begin() + block.stride, 0.0);
  return weights;
}

double inside_variance(const Learning& learning, int id) {
  return learning.inside_sd * learning.inside_sd * learning.blocks[static_cast<size_t>(id)].inside;
}

double outside_variance(const Learning& learning, int id) {
  return learning.outside_sd * learning.outside_sd *
         learning.blocks[static_cast<size_t>(id)].outside;
}

BlockRest rest_of(const BlockRows& rows, const Block& block, const ReducedBlock& reduced_block,
                  const Unknowns& change) {
  Eigen::Matrix<double, kUnknowns + 1, 1> of_columns;
  of_columns << -change, 1;
  BlockRest rest;
  rest.deviations = reduced_block.response.lazyProduct(of_columns);
  std::array<double, kColumns> coefficients{};
  for (int i = 0; i <= kUnknowns; ++i) coefficients[static_cast<size_t>(i)] = of_columns[i];
  for (size_t k = 0; k < kLocalColumns.size(); ++k) {
    coefficients[static_cast<size_t>(kLocalColumns[k])] -=
        rest.deviations[static_cast<int>(k)] / kLocalUnits[k];
  }
  rest.residuals.resize(static_cast<size_t>(block.stride));
  combine_columns(rows.columns_of(block), block.stride, coefficients.data(), rest.residuals.data());
  rest.residuals.resize(static_cast<size_t>(block.count));
  return rest;
}

// The square sizes of a block's deviations, their own doubt included.
double inside_square(const BlockRest& rest, const ReducedBlock& block) {
  return rest.deviations.head(kInsideLocals).squaredNorm() +
         block.covariance.diagonal().head(kInsideLocals).sum();
}

double outside_square(const BlockRest& rest, const ReducedBlock& block) {
  return rest.deviations.tail(kOutsideLocals).squaredNorm() +
         block.covariance.diagonal().tail(kOutsideLocals).sum();
}

// -2 log of a block's part of the posterior, deviations integrated out.
double deviation_cost(const BlockRest& rest, const ReducedBlock& block, double inside,
                      double outside) {
  return rest.deviations.head(kInsideLocals).squaredNorm() / inside +
         rest.deviations.tail(kOutsideLocals).squaredNorm() / outside +
         kInsideLocals * std::log(inside) + kOutsideLocals * std::log(outside) -
         std::log(block.covariance.determinant());
}

// Sums up how large the deviations are.
void find_excess(const BlockRows& rows, const Learning& learning, Solution& solution) {
  double inside = 0, outside = 0;
  for (size_t b = 0; b < rows.blocks.size(); ++b) {
    const int id = rows.blocks[b].id;
    inside += inside_square(solution.rests[b], solution.blocks[b]) / inside_variance(learning, id);
    outside +=
        outside_square(solution.rests[b], solution.blocks[b]) / outside_variance(learning, id);
  }
  const auto blocks = static_cast<double>(rows.blocks.size());
  solution.inside_excess = inside / (kInsideLocals * blocks);
  solution.outside_excess = outside / (kOutsideLocals * blocks);
}

// The excess of a block's noise over the image's. What pixels of noise alone show by chance is
// none.
double noise_excess(const std::vector<double>& residuals, double variance) {
  constexpr double kSlack = 3.3;  // sds of the square of a median of n normal numbers, root n
  const double by_chance = 1 + kSlack / std::sqrt(static_cast<double>(residuals.size()));
  // Of nearly all blocks the median is that small, and counting tells it sooner than sorting.
  const double size = std::sqrt(by_chance * variance) / sd_of_median(1);
  const auto count = static_cast<int>(residuals.size());
  if (count_below(residuals.data(), count, size) > count / 2) return 1;
  std::vector<double> sizes;
  sizes.reserve(residuals.size());
  for (const double residual : residuals) sizes.push_back(std::abs(residual));
  const double sd = sd_of_median(median(sizes));
  return std::max(1.0, sd * sd / variance);
}

double adapted(double sd, double excess) {
  constexpr double kLeast = 0.15, kMost = 60;
  return std::clamp(sd * std::clamp(excess, 0.3, 10.0), kLeast, kMost);
}

}  // namespace

Learning new_learning(const cv::Size& image, double pixel_variance) {
  Learning learning;
  learning.pixel_variance = pixel_variance;
  learning.blocks.resize(static_cast<size_t>(block_count(image)));
  learning.weights.assign(static_cast<size_t>(image.area()), 1.0F);
  return learning;
}

ReducedBlock reduced(const double* gram, double inside_variance, double outside_variance) {
  const Eigen::Map<const GramMatrix> all(gram);
  LocalsByUnknowns cross;
  LocalsByLocals own;
  for (int i = 0; i < kLocals; ++i) {
    const int column = kLocalColumns[static_cast<size_t>(i)];
    const double unit = kLocalUnits[static_cast<size_t>(i)];
    cross.row(i) = all.row(column).head(kUnknowns + 1) / unit;
    for (int j = 0; j < kLocals; ++j) {
      own(i, j) = all(column, kLocalColumns[static_cast<size_t>(j)]) /
                  (unit * kLocalUnits[static_cast<size_t>(j)]);
    }
    own(i, i) += 1 / (i < kInsideLocals ? inside_variance : outside_variance);
  }
  ReducedBlock block;
  block.covariance = swept_inverse(own);
  block.response = block.covariance.lazyProduct(cross);
  block.system = all.topLeftCorner(kUnknowns + 1, kUnknowns + 1);
  block.system -= cross.transpose().lazyProduct(block.response);
  return block;
}

Solution solve_rows(const BlockRows& rows, const Learning& learning, const PriorTerm& prior) {
  Solution solution;
  if (rows.blocks.empty()) return solution;
  ReducedBlock::System sum = ReducedBlock::System::Zero();
  std::array<double, kColumns * kColumns> gram{};
  for (const Block& block : rows.blocks) {
    const auto weights = weights_of(rows, block, learning);
    weighted_gram(rows.columns_of(block), block.stride, weights.data(), gram.data());
    solution.blocks.push_back(reduced(gram.data(), inside_variance(learning, block.id),
                                      outside_variance(learning, block.id)));
    sum += solution.blocks.back().system;
  }
  solution.information = sum.topLeftCorner(kUnknowns, kUnknowns) + prior.information;
  solution.change = solved(solution.information, sum.topRightCorner(kUnknowns, 1) + prior.pull);
  for (size_t b = 0; b < rows.blocks.size(); ++b) {
    solution.rests.push_back(rest_of(rows, rows.blocks[b], solution.blocks[b], solution.change));
  }
  find_excess(rows, learning, solution);
  return solution;
}

FitQuality fit_quality(const BlockRows& rows, const Learning& learning, const Solution& solution) {
  // A pixel of Student's noise costs this much on average: so that more pixels are no worse.
  constexpr double kMeanCost = 0.93;
  constexpr double kMostSquare = 25;
  FitQuality quality;
  double squares = 0;
  int lost = 0, pixels = 0;
  for (size_t b = 0; b < rows.blocks.size(); ++b) {
    const int id = rows.blocks[b].id;
    const double noise = learning.blocks[static_cast<size_t>(id)].noise;
    quality.cost += deviation_cost(solution.rests[b], solution.blocks[b],
                                   inside_variance(learning, id), outside_variance(learning, id));
    for (const double residual : solution.rests[b].residuals) {
      const double square = residual * residual / learning.pixel_variance;
      const double own = square / noise;
      quality.cost += (kNu + 1) * std::log1p(square / kNu) - kMeanCost;
      squares += std::min(own, kMostSquare);
      if ((kNu + 1) / (kNu + own) < kLostWeight) ++lost;
    }
    pixels += rows.blocks[b].count;
  }
  quality.chi2 = squares / pixels;
  quality.lost = static_cast<double>(lost) / pixels;
  return quality;
}

double robust_sd(const Solution& solution) {
  std::vector<double> sizes;
  for (const BlockRest& rest : solution.rests) {
    for (const double residual : rest.residuals) sizes.push_back(std::abs(residual));
  }
  return sd_of_median(median(sizes));
}

void learn(const BlockRows& rows, const Solution& solution, Learning& learning) {
  for (size_t b = 0; b < rows.blocks.size(); ++b) {
    const Block& block = rows.blocks[b];
    BlockLearning& learnt = learning.blocks[static_cast<size_t>(block.id)];
    const BlockRest& rest = solution.rests[b];
    const double inside = learning.inside_sd * learning.inside_sd;
    const double outside = learning.outside_sd * learning.outside_sd;
    learnt.inside =
        (kBlockNu + inside_square(rest, solution.blocks[b]) / inside) / (kBlockNu + kInsideLocals);
    learnt.outside = (kBlockNu + outside_square(rest, solution.blocks[b]) / outside) /
                     (kBlockNu + kOutsideLocals);
    learnt.noise = noise_excess(rest.residuals, learning.pixel_variance);
    const double variance = learning.pixel_variance * learnt.noise;
    const auto pixels = rows.pixels_of(block);
    std::array<float, kBlockPixels> weights;
    student_weights(rest.residuals.data(), block.count, variance, kNu, weights.data());
    for (size_t i = 0; i < pixels.size(); ++i) {
      learning.weights[static_cast<size_t>(pixels[i])] = weights[i];
    }
  }
  learning.inside_sd = adapted(learning.inside_sd, solution.inside_excess);
  learning.outside_sd = adapted(learning.outside_sd, solution.outside_excess);
}

}  // namespace sightline
