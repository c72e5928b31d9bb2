// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/facet_fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "features/normal_equations.h"

namespace sightline {
namespace {

using namespace facet_parameter;

constexpr double kMinBlurPx = 0.25;
constexpr double kTurnSdRad = 0.06;  // of the target against the given pose
constexpr double kLeastNoiseGrey = 0.5;
constexpr int kMaxIterations = 12;
// The longest step with which a fit ends: of some of the pixels, and of all.
constexpr double kNearPx = 0.2;
constexpr double kConvergedPx = 0.05;
constexpr double kNegligible = 0.01;  // a step that ends a fit, in standard deviations, squared
// After four iterations the residuals are down to four times the noise and four grey levels, or the
// fit leads nowhere: an upper estimate of what a fit that succeeds has by then.
constexpr int kHopeIterations = 4;
constexpr double kHopeNoises = 4;
constexpr double kHopeGrey = 4;
constexpr size_t kFewestPixels = 40;

// J^T J, J^T r and r^T r of grey minus model.
NormalEquations normal_equations(const FacetView& view, const std::vector<PatchPixel>& pixels,
                                 const FacetVector& x) {
  const int n = static_cast<int>(x.size());
  const int width = (n + 1) / 2 * 2;
  double information[kMost][kMost] = {};  // from the diagonal on
  double gradient[kMost] = {};
  double squares = 0;
  FacetRow row;
  for (const PatchPixel& pixel : pixels) {
    view.fill_row(pixel.u, pixel.v, x, row);
    double residual = pixel.grey;
    for (int i = kGreys; i < n; ++i) residual -= row[i] * x[i];
    for (int i = 0; i < n; ++i) {
      for (int k = i & ~1; k < width; ++k) information[i][k] += row[i] * row[k];
    }
    for (int i = 0; i < width; ++i) gradient[i] += residual * row[i];
    squares += residual * residual;
  }
  NormalEquations sums{SmallMatrix(n, n), FacetVector(n), squares};
  for (int i = 0; i < n; ++i) {
    sums.gradient[i] = gradient[i];
    for (int k = 0; k < n; ++k)
      sums.information(i, k) = information[std::min(i, k)][std::max(i, k)];
  }
  return sums;
}

// The pose with its point moved in the image, at its depth, and turned about it.
Pose moved(const FacetPatch& patch, const Pose& cam_from_target, const FacetVector& step) {
  const Eigen::Vector3d point = cam_from_target * patch.point_m;
  const Eigen::Vector3d there =
      point +
      point.z() * Eigen::Vector3d(step[0] / patch.camera.fx_px, step[1] / patch.camera.fy_px, 0);
  Pose out;
  out.rotation = rotation_from_vector(step.segment<3>(kTurn)) * cam_from_target.rotation;
  out.translation = there - out.rotation * patch.point_m;
  return out;
}

// A state of the fit. The pose takes up all motion; of x the turn counts it as well, from the pose
// that was given.
struct State {
  Pose cam_from_target;
  FacetView view;
  FacetVector x;
  NormalEquations sums;  // with what is known of the turn beforehand
};

NormalEquations sums_at(const FacetPatch& patch, const FacetView& view,
                        const std::vector<PatchPixel>& pixels, const FacetVector& x) {
  NormalEquations sums = normal_equations(view, pixels, x);
  const double noise_grey = std::max(patch.noise_sd_grey, kLeastNoiseGrey);
  const double known = noise_grey * noise_grey / (kTurnSdRad * kTurnSdRad);
  sums.information.diagonal().segment<3>(kTurn).array() += known;
  sums.gradient.segment<3>(kTurn) -= known * x.segment<3>(kTurn);
  sums.squares += known * x.segment<3>(kTurn).squaredNorm();
  return sums;
}

// How a fit begins: the greys are those of least squares at the given shape, from some pixels.
struct Beginning {
  Pose cam_from_target;
  FacetView view;
  std::vector<PatchPixel> pixels;
  std::vector<PatchPixel> some;  // of the pixels
  FacetVector x;
  double unexplained;  // share of the greys' variance: 1 where all is of one grey
};

std::optional<Beginning> begun(const FacetPatch& patch, const Pose& cam_from_target) {
  constexpr size_t kOneOf = 5;  // pixels
  const auto view = FacetView::of(patch, cam_from_target);
  if (!view) return std::nullopt;
  std::vector<PatchPixel> pixels = view->pixels(patch);
  if (pixels.size() < kFewestPixels) return std::nullopt;
  std::vector<PatchPixel> some;
  for (size_t i = 0; i < pixels.size(); i += kOneOf) some.push_back(pixels[i]);
  Beginning out{cam_from_target, *view, std::move(pixels), std::move(some), {}, 0};
  out.x = FacetVector::Zero(kGreys + view->greys());
  out.x[kBlur] = FacetView::kUsualBlurPx;
  const NormalEquations sums = normal_equations(*view, out.some, out.x);
  SmallMatrix information = sums.information.bottomRightCorner(view->greys(), view->greys());
  information.diagonal().array() += 1e-3;  // for a facet without pixels
  const FacetVector gradient = sums.gradient.tail(view->greys());
  const FacetVector greys = solved(information, gradient);
  out.x.tail(view->greys()) = greys;
  double sum = 0;
  for (const PatchPixel& pixel : out.some) sum += pixel.grey;
  const double squares = sums.squares - sum * sum / static_cast<double>(out.some.size());
  out.unexplained = squares > 0 ? (sums.squares - gradient.dot(greys)) / squares : 1;
  return out;
}

// The state a damped step away. None where other facets are seen from there.
std::optional<State> stepped(const FacetPatch& patch, const std::vector<PatchPixel>& pixels,
                             const State& state, const FacetVector& step) {
  if (!step.allFinite()) return std::nullopt;
  const Pose pose = moved(patch, state.cam_from_target, step);
  const auto view = FacetView::of(patch, pose);
  if (!view || !view->sees_same(state.view)) return std::nullopt;
  FacetVector x = state.x + step;
  x[kBlur] = std::clamp(x[kBlur], kMinBlurPx, FacetView::kMostBlurPx);
  return State{pose, *view, x, sums_at(patch, *view, pixels, x)};
}

double rms_grey(const State& state, size_t pixels) {
  return std::sqrt(state.sums.squares / static_cast<double>(pixels - state.x.size()));
}

// Levenberg and Marquardt's, until a step is shorter than `converged_px`, the next being its
// square, or changes nothing. False where it leads nowhere.
bool minimise(const FacetPatch& patch, const std::vector<PatchPixel>& pixels, double converged_px,
              State& state) {
  constexpr double kMostDamping = 1e2;
  const double noise_grey = std::max(patch.noise_sd_grey, kLeastNoiseGrey);
  double damping = 1e-3;
  for (int i = 0; i < kMaxIterations && damping <= kMostDamping; ++i) {
    if (i == kHopeIterations &&
        rms_grey(state, pixels.size()) > kHopeNoises * patch.noise_sd_grey + kHopeGrey) {
      return false;
    }
    const FacetVector step = damped_step(state.sums, damping);
    const double moved_px = step.head<2>().norm() + step.segment<3>(kTurn).norm() * patch.reach_px;
    // In standard deviations of what is changed, squared.
    const double squares = step.dot(state.sums.gradient) / (noise_grey * noise_grey);
    if (moved_px < converged_px / 4 || squares < kNegligible) break;
    auto next = stepped(patch, pixels, state, step);
    if (!next || !(next->sums.squares < state.sums.squares)) {
      damping *= 10;
      continue;
    }
    state = std::move(*next);
    if (moved_px < converged_px) break;
    damping = std::max(damping / 10, 1e-6);
  }
  return true;
}

std::optional<FacetFit> fit_from(const FacetPatch& patch, const Beginning& begin) {
  // First to where some of the pixels lead, which is near.
  State state{begin.cam_from_target, begin.view, begin.x,
              sums_at(patch, begin.view, begin.some, begin.x)};
  if (!minimise(patch, begin.some, kNearPx, state)) return std::nullopt;
  const std::vector<PatchPixel>& pixels = begin.pixels;
  state.sums = sums_at(patch, state.view, pixels, state.x);
  if (!minimise(patch, pixels, kConvergedPx, state)) return std::nullopt;
  FacetFit fit;
  fit.cam_from_target = state.cam_from_target;
  fit.pixel = state.view.pixel();
  fit.rms_grey = rms_grey(state, pixels.size());
  const double sd = std::max(patch.noise_sd_grey, fit.rms_grey);
  const SmallMatrix covariance = sd * sd * inverse_of(state.sums.information);
  const Eigen::Matrix2d& lens = state.view.lens();
  fit.covariance_px2 = lens * covariance.topLeftCorner<2, 2>() * lens.transpose();
  if (!fit.covariance_px2.allFinite() || !(fit.covariance_px2.diagonal().minCoeff() > 0)) {
    return std::nullopt;
  }
  return fit;
}

}  // namespace

std::optional<FacetFit> fit_facets(const FacetPatch& patch, const Pose& cam_from_target) {
  const auto begin = begun(patch, cam_from_target);
  return begin ? fit_from(patch, *begin) : std::nullopt;
}

std::vector<Pose> most_alike(const FacetPatch& patch, std::span<const Pose> poses, size_t most) {
  std::vector<std::pair<double, const Pose*>> ranked;
  for (const Pose& pose : poses) {
    const auto begin = begun(patch, pose);
    if (begin) ranked.emplace_back(begin->unexplained, &pose);
  }
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Pose> alike;
  for (size_t i = 0; i < std::min(most, ranked.size()); ++i) alike.push_back(*ranked[i].second);
  return alike;
}

}  // namespace sightline
