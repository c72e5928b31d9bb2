// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/consensus/noise.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sightline::consensus {
namespace {

/// The precision of the prior of x = ln s on the side of its centre where x lies.
double prior_precision(double x, double centre) {
  const double doubt = x > centre ? kLargerNoiseDoubt : kSmallerNoiseDoubt;
  return 1 / (doubt * doubt);
}

/// The upper quantile of the normal law.
double normal_quantile(double tail) {
  const double t = std::sqrt(-2 * std::log(std::clamp(tail, 1e-12, 0.5)));
  return t - (2.515517 + t * (0.802853 + t * 0.010328)) /
                 (1 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
}

}  // namespace

double chi_square_limit(double degrees, double rate) {
  const double spread = 2 / (9 * degrees);
  const double root = 1 - spread + normal_quantile(rate) * std::sqrt(spread);
  return degrees * root * root * root;
}

NoisePosterior noise_posterior(double squares, double pairs) {
  constexpr double kRounding = 1e-28;
  const double k = std::max(pairs, 0.0);
  const double sum = std::max(squares, kRounding);
  static const double centre = std::log(kTypicalNoise);
  // Newton's method begins at the mean of what the sum and the prior say.
  double x = centre;
  if (k > 0) {
    const double own = 0.5 * std::log(sum / (2 * k));
    const double prior = prior_precision(own, centre);
    x = (4 * k * own + prior * centre) / (4 * k + prior);
  }
  double pull = 0, prior = 0;  // of the sum, of the prior
  constexpr int kSteps = 5;
  for (int step = 0;; ++step) {
    pull = sum * std::exp(-2 * x);
    prior = prior_precision(x, centre);
    if (step == kSteps) break;
    const double slope = -2 * k + pull - prior * (x - centre);
    x += std::clamp(slope / (2 * pull + prior), -2.0, 2.0);
  }
  const double curvature = 2 * pull + prior;
  NoisePosterior posterior;
  posterior.log_evidence = -2 * k * x - 0.5 * pull - 0.5 * prior * (x - centre) * (x - centre) +
                           0.5 * std::log(2 * std::numbers::pi / curvature);
  posterior.most_probable = std::exp(2 * x);
  // ln s of nu degrees of freedom has the curvature 2 nu. Below three the tails have no end.
  const double degrees = std::max(0.5 * curvature, 3.0);
  posterior.with_tails = posterior.most_probable * degrees / (degrees - 2);
  return posterior;
}

}  // namespace sightline::consensus
