// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/fit.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/core.hpp>

#include "registration/covariance.h"
#include "registration/symmetric.h"

namespace sightline {
namespace {

constexpr double kLeastBlurVariance = 0.05, kMostBlurVariance = 9;  // px^2
constexpr double kLeastDrawnBlurVariance = 0.04;
constexpr double kSmallStepPx = 0.01;  // of the sharp image
constexpr int kSharpRounds = 2;        // solutions of one linearisation

GreyImage blurred_image(GreyImage image, double sigma_px) {
  image.grey = blurred(image.grey, sigma_px);
  return image;
}

// The prior's information; of what is known exactly almost so.
Matrix6d information_of(const PosePrior& prior) {
  constexpr double kExactRad = 1e-9;
  const double exact_m = kExactRad * prior.cam_from_target.translation.norm();
  Matrix6d covariance = prior.covariance;
  covariance.diagonal().head<3>().array() += kExactRad * kExactRad;
  covariance.diagonal().tail<3>().array() += exact_m * exact_m;
  const auto information = inverse_of(covariance);
  return information ? Matrix6d(*information) : Matrix6d(Matrix6d::Zero());
}

}  // namespace

double noise_variance(const GreyImage& image, const RegistrationOptions& options) {
  const double noise_sd =
      options.noise_sd_grey ? *options.noise_sd_grey : estimated_noise_sd(image.grey);
  const double step_grey = 255 / (std::exp2(options.bits) - 1);
  return noise_sd * noise_sd + step_grey * step_grey / 12;
}

std::vector<FitLevel> fit_levels(const GreyImage& image, bool is_near) {
  std::vector<FitLevel> levels;
  if (!is_near) {
    levels.push_back({blurred_image(shrunk(image, 4), 1.25), 4, 1.25, 4, 16});
    levels.push_back({blurred_image(shrunk(image, 2), 1.25), 2, 1.25, 3, 8});
    levels.push_back({blurred_image(image, 1.2), 1, 1.2, 3, 4});
  }
  levels.push_back({image, 1, 0, 6, 16});
  return levels;
}

Fitter::Fitter(const Mesh& mesh, const PosePrior& prior, double noise_variance,
               const RegistrationOptions& options)
    : mesh_(mesh),
      prior_(prior),
      prior_information_(information_of(prior)),
      noise_variance_(noise_variance),
      options_(options),
      radius_m_(radius_m(mesh)) {}

// Draws the model at the state's pose and makes rows_ of it; false where nothing can be compared.
bool Fitter::linearise(const FitLevel& level, int samples, BasisDrawer& drawer) {
  const double own =
      std::max(kLeastDrawnBlurVariance, state_.blur_variance_px2) / (level.factor * level.factor);
  const double blur_px = std::sqrt(own + level.blur_px * level.blur_px);
  BasisOptions basis;
  basis.samples_per_pixel = samples;
  basis.margin_px = margin_px(blur_px);
  if (state_.light) basis.to_light_in_cam = state_.light->segment<3>(1);
  const auto images = drawer.draw(state_.cam_from_target, basis);
  if (!images) return false;
  ++drawings_;
  const auto region = level.is_sharp() ? options_.region : RegistrationRegion::kImage;
  const ModelView view = model_view(*images, blur_px, region);
  if (!state_.light) fit_first_light(level.image, view);
  linearise_rows(level.image, view, state_.cam_from_target, *state_.light, level.is_sharp(), rows_);
  return !rows_.blocks.empty();
}

// Least squares, with a weak belief in a light from the camera.
void Fitter::fit_first_light(const GreyImage& image, const ModelView& view) {
  const LightVector usual(76, 0, 0, -120, 38);
  constexpr double kWeight = 0.05;  // of the belief, over the image's word on the glow
  constexpr double kWeightOfBackground = 0.001;
  Eigen::Matrix<double, 5, 5> gram = Eigen::Matrix<double, 5, 5>::Zero();
  LightVector right = LightVector::Zero();
  for (int y = 0; y < view.box.height; ++y) {
    const float* const grey = image.grey.ptr<float>(y + view.box.y) + view.box.x;
    std::array<const float*, 5> basis{};
    for (size_t k = 0; k < 5; ++k) basis[k] = view.basis[k].ptr<float>(y);
    for (int x = 0; x < view.box.width; ++x) {
      const LightVector row(basis[0][x], basis[1][x], basis[2][x], basis[3][x], basis[4][x]);
      gram.noalias() += row.lazyProduct(row.transpose());
      right += row * grey[x];
    }
  }
  LightVector belief = LightVector::Constant(kWeight * gram(0, 0));
  belief[4] *= kWeightOfBackground;
  gram.diagonal() += belief;
  state_.light = LightVector(solved(gram, right + belief.cwiseProduct(usual)));
}

PriorTerm Fitter::prior_term(bool is_sharp) const {
  constexpr double kLightSd = 100, kBackgroundSd = 100, kBlurSd = 0.5;
  const Vector6d error = change_between(prior_.cam_from_target, state_.cam_from_target);
  PriorTerm term;
  term.information.topLeftCorner(6, 6) = prior_information_;
  term.pull.head<6>() = -prior_information_ * error;
  for (int i = 0; i < 4; ++i) {
    term.information(kLightAt + i, kLightAt + i) = 1 / (kLightSd * kLightSd);
  }
  term.information(kLightAt + 4, kLightAt + 4) = 1 / (kBackgroundSd * kBackgroundSd);
  term.information(kBlurAt, kBlurAt) = is_sharp ? 1 / (kBlurSd * kBlurSd) : 1;
  return term;
}

// Returns by how many pixels of the whole image the target's rim moves.
double Fitter::apply(const Unknowns& change, bool is_sharp) {
  Vector6d delta = change.head<6>();
  state_.cam_from_target = retract(state_.cam_from_target, delta);
  *state_.light += change.segment<5>(kLightAt);
  if (is_sharp) {
    state_.blur_variance_px2 = std::clamp(state_.blur_variance_px2 + change[kBlurAt],
                                          kLeastBlurVariance, kMostBlurVariance);
  }
  return (delta.head<3>().norm() * radius_m_ + delta.segment<2>(3).norm()) /
         state_.cam_from_target.translation.z();
}

bool Fitter::fit_blurred(const FitLevel& level, double deviation_sd) {
  constexpr double kFirstVariance = 100;
  constexpr double kLeastVariance = 4;
  constexpr double kVarianceOverSeen = 4;
  constexpr double kSmallStep = 0.1;  // of the blur
  BasisDrawer drawer(mesh_, level.image.camera);
  Learning learning = new_learning(level.image.grey.size(), kFirstVariance);
  learning.inside_sd = deviation_sd;
  learning.outside_sd = deviation_sd;
  for (int i = 0; i < level.most_steps; ++i) {
    if (!linearise(level, level.samples, drawer)) return false;
    const Solution solution = solve_rows(rows_, learning, prior_term(false));
    const double moved_px = apply(solution.change, false) * level.image.camera.fx_px;
    const double seen_sd = robust_sd(solution);
    learning.pixel_variance = std::max(kLeastVariance, kVarianceOverSeen * seen_sd * seen_sd);
    if (i > 0 && moved_px < kSmallStep * level.blur_px) break;
  }
  return true;
}

// Solves the linearisation at hand again and again, each time with better weights.
Solution Fitter::solve_sharp() {
  const PriorTerm prior = prior_term(true);
  Solution solution = solve_rows(rows_, learning_, prior);
  for (int round = 1; round < kSharpRounds; ++round) {
    learn(rows_, solution, learning_);
    solution = solve_rows(rows_, learning_, prior);
  }
  return solution;
}

// Samples of a pixel of the model at a step of the sharp level. What they miss of the coverage,
// blur spreads over several pixels; where it hardly does, as much is missed as noise makes, and
// alike all along an edge, so that the covariance would not know.
int Fitter::sharp_samples(const FitLevel& level, int step) const {
  constexpr int kFirstSamples = 4;  // the first step is never the last
  constexpr int kSamplesUnblurred = 64;
  constexpr double kSmallBlurVariance = 0.3;  // px^2
  if (step == 0) return kFirstSamples;
  return state_.blur_variance_px2 < kSmallBlurVariance ? kSamplesUnblurred : level.samples;
}

bool Fitter::fit_sharp(const FitLevel& level, Registration& out) {
  BasisDrawer drawer(mesh_, level.image.camera);
  learning_ = new_learning(level.image.grey.size(), noise_variance_);
  for (int i = 0; i < level.most_steps; ++i) {
    if (!linearise(level, sharp_samples(level, i), drawer)) return false;
    const Solution solution = solve_sharp();
    const double moved_px = apply(solution.change, true) * level.image.camera.fx_px;
    const bool is_last = i + 1 == level.most_steps || (i > 0 && moved_px < kSmallStepPx);
    if (is_last) {
      const FitQuality quality = fit_quality(rows_, learning_, solution);
      const PoseSpread spread = pose_spread(rows_, solution, quality);
      out.covariance = spread.covariance;
      out.cluster_factor = spread.cluster_factor;
      out.chi2 = quality.chi2;
      out.lost = quality.lost;
      out.cost = quality.cost;
      out.inside_sd = learning_.inside_sd;
      out.outside_sd = learning_.outside_sd;
      return true;
    }
    learn(rows_, solution, learning_);
  }
  return false;
}

// What the camera's calibration may be off moves the pose: by how much, the same image says before
// a camera that is off by one sd.
Matrix6d Fitter::camera_term(const FitLevel& level) {
  const CameraErrors& errors = options_.camera_errors;
  Matrix6d sum = Matrix6d::Zero();
  const auto change_before = [&](const Camera& camera) -> std::optional<Vector6d> {
    FitLevel seen = level;
    seen.image.camera = camera;
    BasisDrawer drawer(mesh_, camera);
    if (!linearise(seen, sharp_samples(seen, 1), drawer)) return std::nullopt;
    return Vector6d(solve_rows(rows_, learning_, prior_term(true)).change.head<6>());
  };
  const auto own = change_before(level.image.camera);
  const auto add = [&](double sd, auto move) {
    if (sd == 0 || !own) return;
    Camera camera = level.image.camera;
    move(camera, sd);
    const auto change = change_before(camera);
    if (change) sum += (*change - *own) * (*change - *own).transpose();
  };
  add(errors.focal_fraction, [](Camera& camera, double sd) {
    camera.fx_px *= 1 + sd;
    camera.fy_px *= 1 + sd;
  });
  add(errors.principal_point_px, [](Camera& camera, double sd) { camera.cx_px += sd; });
  add(errors.principal_point_px, [](Camera& camera, double sd) { camera.cy_px += sd; });
  add(errors.k1, [](Camera& camera, double sd) {
    std::visit([sd](auto& lens) { lens.k1 += sd; }, camera.lens);
  });
  return sum;
}

Registration Fitter::fit(const std::vector<FitLevel>& levels, const Pose& start,
                         double blurred_sd) {
  state_ = {start, std::nullopt, options_.blur_px * options_.blur_px};
  drawings_ = 0;
  Registration out;
  out.starts = 1;
  for (const FitLevel& level : levels) {
    const bool is_fitted =
        level.is_sharp() ? fit_sharp(level, out) : fit_blurred(level, blurred_sd);
    if (!is_fitted) return out;
  }
  if (!options_.camera_errors.is_none()) out.covariance += camera_term(levels.back());
  out.status = RegistrationStatus::kOk;
  out.cam_from_target = state_.cam_from_target;
  out.light = *state_.light;
  out.blur_px = std::sqrt(state_.blur_variance_px2);
  out.noise_sd_grey = std::sqrt(noise_variance_);
  out.drawings = drawings_;
  return out;
}

}  // namespace sightline
