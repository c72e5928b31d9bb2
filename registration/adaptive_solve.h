// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "pose/pose.h"
#include "registration/block_rows.h"

namespace sightline {

/// What the image has taught of a block so far.
struct BlockLearning {
  double inside = 1;   ///< its deviations' variance over that of all blocks
  double outside = 1;  ///< alike, of the background
  double noise = 1;    ///< of its pixels' variance over the image's
};

/// What the image has taught of itself: how far blocks deviate from the model, which of them more
/// than others, how noisy they are, and which pixels nothing explains.
struct Learning {
  double inside_sd = 3;   ///< of the blocks' own lights, grey levels
  double outside_sd = 3;  ///< of their own backgrounds
  double pixel_variance = 9;
  std::vector<BlockLearning> blocks;  ///< by id
  std::vector<float> weights;         ///< by pixel, y * width + x, from Student's distribution
};

/// Nothing learnt yet of an image of that size.
Learning new_learning(const cv::Size& image, double pixel_variance);

/// A block without its local deviations.
struct ReducedBlock {
  using System = Eigen::Matrix<double, kUnknowns + 1, kUnknowns + 1>;

  /// Of the unknowns and the residual: Z' W Z - Z' W B (B' W B + T^-1)^-1 B' W Z.
  System system;
  Eigen::Matrix<double, kLocals, kUnknowns + 1> response;  ///< of the deviations to Z
  Eigen::Matrix<double, kLocals, kLocals> covariance;      ///< of the deviations
};

/// Marginalises a block's deviations: its light's by `inside_variance`, each of (albedo,
/// albedo_normal) / 0.7, its background's by `outside_variance`. `gram` is weighted_gram's.
ReducedBlock reduced(const double* gram, double inside_variance, double outside_variance);

/// What a solution leaves of a block: its residuals, and its deviations.
struct BlockRest {
  std::vector<double> residuals;  ///< of its pixels
  Eigen::Matrix<double, kLocals, 1> deviations;
};

/// What is known of the unknowns besides the image: `information` about zero change, and `pull`,
/// the information times what the change should be.
struct PriorTerm {
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(kUnknowns, kUnknowns);
  Unknowns pull = Unknowns::Zero();
};

/// One solution for the change of the unknowns, and what it leaves.
struct Solution {
  Unknowns change = Unknowns::Zero();
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(kUnknowns, kUnknowns);
  std::vector<ReducedBlock> blocks;              ///< one a block of the rows
  std::vector<BlockRest> rests;                  ///< alike
  double inside_excess = 1, outside_excess = 1;  ///< of the deviations' variance over the assumed
};

/// How an image fits a solution.
struct FitQuality {
  double chi2 = 0;  ///< mean of the squared residuals over their variance, each at most 25
  double lost = 0;  ///< share of the pixels with a weight under 0.3
  double cost = 0;  ///< -2 log of the posterior, but for a constant of the image
};

/// Solves for the change, weights as learnt so far.
Solution solve_rows(const BlockRows& rows, const Learning& learning, const PriorTerm& prior);

/// Of a solution that was found with these weights.
FitQuality fit_quality(const BlockRows& rows, const Learning& learning, const Solution& solution);

/// The standard deviation of a solution's residuals, from their median size.
double robust_sd(const Solution& solution);

/// What the solution's residuals and deviations teach: Learning for the next solution. The sds grow
/// by at most the factor 10, over-relaxed.
void learn(const BlockRows& rows, const Solution& solution, Learning& learning);

}  // namespace sightline
