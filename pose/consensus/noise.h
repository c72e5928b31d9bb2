// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The size of the noise where it is not known.
#pragma once

namespace sightline::consensus {

/// Parts of the image's root area; of 640 x 480 pixels, 1.1 px.
inline constexpr double kTypicalNoise = 2e-3;
inline constexpr double kSmallerNoiseDoubt = 1;
inline constexpr double kLargerNoiseDoubt = 0.7;

/// What a sum of squares says of the noise.
struct NoisePosterior {
  double log_evidence = 0;   ///< of the sum, the noise integrated out
  double most_probable = 0;  ///< variance
};

/// The posterior of the noise s from `squares`, a sum of squared residuals of k = `pairs` pairs of
/// degrees of freedom: exp(-squares / (2 s^2)) / s^(2 k), under a prior of ln s that is normal
/// about `typical`, with a deviation for each side. Laplace in ln s, in which the posterior is
/// log-concave.
///
/// The prior is so wide that noise of a hundredth or of ten pixels is found from a few dozen
/// points. It keeps four points, of one pair, from being exact by chance, and clutter from being
/// explained by large noise.
NoisePosterior noise_posterior(double squares, double pairs, double typical = kTypicalNoise);

/// The mean variance under the same posterior: what the covariance of a pose is to be multiplied by
/// for its second moment, the noise integrated out. Of few pairs it is up to three times the most
/// probable one (of Student's law of nu degrees, without the prior, nu / (nu - 2) times).
double mean_variance(double squares, double pairs, double typical = kTypicalNoise);

/// What the sum of squares of so many standard normal numbers exceeds at this rate (Wilson and
/// Hilferty 1931; Abramowitz and Stegun 26.2.23).
double chi_square_limit(double degrees, double rate);

}  // namespace sightline::consensus
