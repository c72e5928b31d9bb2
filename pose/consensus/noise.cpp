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

/// The posterior of x = ln s.
class NoiseLaw {
 public:
  NoiseLaw(double squares, double pairs, double typical)
      : sum_(std::max(squares, kRounding)), k_(std::max(pairs, 0.0)), centre_(std::log(typical)) {}

  double log_density(double x) const {
    const double off = x - centre_;
    return -2 * k_ * x - 0.5 * pull(x) - 0.5 * prior_precision(x, centre_) * off * off;
  }
  double curvature(double x) const { return 2 * pull(x) + prior_precision(x, centre_); }

  /// By Newton's method, which begins at the mean of what the sum and the prior say.
  double mode() const {
    double x = centre_;
    if (k_ > 0) {
      const double own = 0.5 * std::log(sum_ / (2 * k_));
      const double prior = prior_precision(own, centre_);
      x = (4 * k_ * own + prior * centre_) / (4 * k_ + prior);
    }
    constexpr int kSteps = 5;
    for (int step = 0; step < kSteps; ++step) {
      const double slope = -2 * k_ + pull(x) - prior_precision(x, centre_) * (x - centre_);
      x += std::clamp(slope / curvature(x), -2.0, 2.0);
    }
    return x;
  }

 private:
  static constexpr double kRounding = 1e-28;

  double pull(double x) const { return sum_ * std::exp(-2 * x); }

  const double sum_, k_, centre_;
};

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

NoisePosterior noise_posterior(double squares, double pairs, double typical) {
  const NoiseLaw law(squares, pairs, typical);
  const double x = law.mode();
  NoisePosterior posterior;
  posterior.log_evidence =
      law.log_density(x) + 0.5 * std::log(2 * std::numbers::pi / law.curvature(x));
  posterior.most_probable = std::exp(2 * x);
  return posterior;
}

double mean_variance(double squares, double pairs, double typical) {
  const NoiseLaw law(squares, pairs, typical);
  const double mode = law.mode(), highest = law.log_density(mode);
  // The trapezoidal rule; the variance doubles the upper tail's reach.
  constexpr int kBelow = 8, kAbove = 20;
  const double step = 0.5 / std::sqrt(law.curvature(mode));
  double moment = 0, total = 0;
  for (int i = -kBelow; i <= kAbove; ++i) {
    const double x = mode + i * step;
    const double weight = std::exp(law.log_density(x) - highest);
    total += weight;
    moment += weight * std::exp(2 * x);
  }
  return moment / total;
}

}  // namespace sightline::consensus
