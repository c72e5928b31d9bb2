// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/registration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Eigenvalues>

#include "registration/edge_fit.h"
#include "registration/fit.h"
#include "registration/one_face.h"
#include "registration/symmetric.h"
#include "registration/usable.h"

namespace sightline {
namespace {

// Fits that look like the model at the wrong pose exceeded these; good ones of plain frames do not.
constexpr double kMostClusterFactor = 1.5;
constexpr double kMostLost = 0.002;
// How far squares of blurred images may deviate from the model, grey levels: where the faces are
// printed, the little that suits plain ones leads astray.
constexpr double kTightSd = 3, kLooseSd = 40;
// Beyond either the faces show what no light explains, print above all. Starts that agree may then
// agree on a wrong pose, and grey levels do not tell which is better: edges are asked.
constexpr double kAlienClusterFactor = 5;
constexpr double kAlienLost = 0.02;
// By how much less the cost of a fit must be for it to be the better one.
constexpr double kClearlyBetter = 10;

bool looks_like_model(const Registration& fit) {
  return fit.is_ok() && fit.cluster_factor <= kMostClusterFactor && fit.lost <= kMostLost;
}

bool is_alien(const Registration& fit) {
  return fit.cluster_factor > kAlienClusterFactor || fit.lost > kAlienLost;
}

// How much of a prior's variance is left, on average over its six axes.
double share_left(const Matrix6d& covariance, const Matrix6d& prior) {
  const auto information = inverse_of(prior);
  return information ? (*information * covariance).trace() / 6 : 0;
}

// The prior's covariance, of which some axes may be known exactly.
Matrix6d invertible(const PosePrior& prior) {
  Matrix6d covariance = prior.covariance;
  covariance.diagonal() += 1e-12 * covariance.diagonal() + Vector6d::Constant(1e-24);
  return covariance;
}

bool is_allowed_by(const PosePrior& prior, const Pose& cam_from_target) {
  // Six normal numbers have such a sum of squares once in a million times.
  constexpr double kFarthest = 39;
  const Vector6d moved = change_between(prior.cam_from_target, cam_from_target);
  return mahalanobis2(moved, invertible(prior)) <= kFarthest;
}

// Why a fit is not to be believed whatever it looks like; empty where it may be.
std::string contradiction(const Registration& fit, const RegistrationTask& task) {
  const PosePrior& prior = task.prior;
  // Of the prior's variances, on average: the image must say more than that.
  constexpr double kMostLeft = 0.5;
  if (!is_allowed_by(prior, fit.cam_from_target)) {
    return "the fit lies beyond what the prior allows";
  }
  // A prior as sharp as the image leaves it nothing to say.
  constexpr double kSharpPx = 0.5;
  const double px_per_m = task.camera.fx_px / prior.cam_from_target.translation.z();
  const bool is_sharp = std::sqrt(prior.covariance(3, 3)) * px_per_m < kSharpPx;
  if (!is_sharp && share_left(fit.covariance, invertible(prior)) > kMostLeft) {
    return "the image says little more than the prior";
  }
  return {};
}

// Poses to start from where the prior led astray: turned by 1.5 sds about each axis of its doubt,
// and back.
std::vector<Pose> other_starts(const PosePrior& prior) {
  constexpr double kSds = 1.5;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(prior.covariance.topLeftCorner<3, 3>());
  std::vector<Pose> starts;
  for (const double side : {kSds, -kSds}) {
    for (int i = 0; i < 3; ++i) {
      const double sd = std::sqrt(std::max(0.0, axes.eigenvalues()[i]));
      Pose start = prior.cam_from_target;
      start.rotation =
          rotation_from_vector(side * sd * axes.eigenvectors().col(i)) * start.rotation;
      starts.push_back(start);
    }
  }
  return starts;
}

// Whether two fits are of one pose, as far as the surer of the two says: a fit that is far from the
// model is sure of nothing, and would agree with any.
bool agree(const Registration& a, const Registration& b) {
  constexpr double kFarthest = 25;  // squared sds
  if (!a.is_ok() || !b.is_ok()) return false;
  const Vector6d difference = change_between(b.cam_from_target, a.cam_from_target);
  return mahalanobis2(difference, a.covariance) < kFarthest &&
         mahalanobis2(difference, b.covariance) < kFarthest;
}

void distrust(const std::string& reason, Registration& out) {
  out.status = RegistrationStatus::kNotTrusted;
  out.reason = reason;
}

// Fits from start to start until one looks like the model, or the best two agree.
class Trials {
 public:
  // Takes a fit; true when no more are needed.
  bool take(const Registration& fit) {
    ++starts_;
    drawings_ += fit.drawings;
    if (agree(fit, best_)) {
      is_agreed_ = true;
      if (fit.cost < best_.cost) best_ = fit;
    } else if (fit.is_ok() && (!best_.is_ok() || fit.cost < best_.cost - kClearlyBetter)) {
      best_ = fit;
      is_agreed_ = false;
    }
    return looks_like_model(best_) || (is_agreed_ && !is_alien(best_));
  }

  // Only print leaves so much that nothing explains, and other starts change nothing there.
  bool is_best_printed() const { return best_.is_ok() && best_.lost > kAlienLost; }

  bool may_improve() const { return !is_agreed_ && !is_best_printed(); }

  bool is_best_alien() const { return !best_.is_ok() || is_alien(best_); }

  // What edges say of an image that does not look like the model: they confirm a fit of grey
  // levels, which is the finer one, or their own pose is the answer. `near` was fitted from there;
  // `support` asks the edges about a pose.
  template <typename Support>
  Registration result(const RegistrationTask& task, const EdgeFit& edges, const Registration& near,
                      const Support& support) const {
    Registration out = best_;
    int supports = 0;
    const auto counted_support = [&](const Pose& pose) {
      ++supports;
      return support(pose);
    };
    const auto is_confirmed = [&](const Registration& fit) {
      return fit.is_ok() && is_surer(fit, edges) &&
             is_confirmed_by(edges, fit.cam_from_target, counted_support, task.prior);
    };
    // Where both are confirmed the one that began there depends less on the prior.
    if (is_confirmed(near)) {
      out = near;
    } else if (!is_confirmed(best_)) {
      out.cam_from_target = edges.cam_from_target;
      out.covariance = edges.covariance;
      out.status = RegistrationStatus::kOk;
    }
    if (!edges.is_believable()) {
      distrust("the image does not look like the model, nor has it an outline there", out);
    }
    out.starts = starts_ + 1;
    out.drawings = drawings_ + near.drawings + edges.drawings + supports;
    return judged(out, task);
  }

  Registration result(const RegistrationTask& task) const {
    Registration out = counted();
    if (out.is_ok() && !looks_like_model(out) && !is_agreed_ && starts_ > 1) {
      distrust("the image does not look like the model, and no two starts agree", out);
    }
    return judged(out, task);
  }

 private:
  // Whether grey levels know the attitude better than edges do. Where print spoils them, they know
  // themselves that they do not.
  static bool is_surer(const Registration& fit, const EdgeFit& edges) {
    return fit.covariance.topLeftCorner<3, 3>().trace() <
           edges.covariance.topLeftCorner<3, 3>().trace();
  }

  // Whether edges have nothing against a fit of grey levels: they lie where it does, or support it
  // nearly as much as their own. Right fits have at least 0.97 of that, fits of print at most 0.75,
  // but where the outline is the same again, which is for the prior to tell.
  template <typename Support>
  static bool is_confirmed_by(const EdgeFit& edges, const Pose& pose, const Support& support,
                              const PosePrior& prior) {
    constexpr double kFarthest = 25;  // squared sds
    constexpr double kNearlyAsMuch = 0.9;
    if (!is_allowed_by(prior, pose)) return false;
    return support(pose) >= kNearlyAsMuch * edges.support ||
           mahalanobis2(change_between(edges.cam_from_target, pose), edges.covariance) < kFarthest;
  }

  Registration counted() const {
    Registration out = best_;
    out.starts = starts_;
    out.drawings = drawings_;
    return out;
  }

  static Registration judged(Registration out, const RegistrationTask& task) {
    const std::string reason = contradiction(out, task);
    if (out.is_ok() && !reason.empty()) distrust(reason, out);
    return out;
  }

  Registration best_;
  bool is_agreed_ = false;
  int starts_ = 0;
  int drawings_ = 0;
};

// From start to start until a fit is found that may be believed, or none is.
Registration searched(const RegistrationTask& task, const GreyImage& image, Fitter& fitter) {
  Trials trials;
  if (task.start) {
    if (trials.take(fitter.fit(fit_levels(image, true), *task.start, kTightSd)))
      return trials.result(task);
  }
  const std::vector<FitLevel> levels = fit_levels(image, false);
  if (trials.take(fitter.fit(levels, task.prior.cam_from_target, kTightSd))) {
    return trials.result(task);
  }
  if (trials.take(fitter.fit(levels, task.prior.cam_from_target, kLooseSd))) {
    return trials.result(task);
  }
  if (trials.may_improve()) {
    bool is_loose = false;
    for (const Pose& start : other_starts(task.prior)) {
      if (trials.take(fitter.fit(levels, start, is_loose ? kLooseSd : kTightSd))) {
        return trials.result(task);
      }
      is_loose = !is_loose;
    }
  }
  if (trials.is_best_alien()) {
    if (const auto edges = fit_edges(image, task.mesh, task.prior)) {
      const Trials before = trials;
      const Registration near =
          fitter.fit(fit_levels(image, true), edges->cam_from_target, kTightSd);
      if (trials.take(near) && !before.is_best_printed()) return trials.result(task);
      return before.result(task, *edges, near, [&](const Pose& pose) {
        return edge_support_at(image, task.mesh, pose);
      });
    }
  }
  return trials.result(task);
}

// Squares' own lights explain nearly all that a wrong pose makes of a flat face, and leave little
// along its slivers. Of frames of one face nearly all wrong poses left more than this, and a tenth
// of the right ones (docs/registration.md).
bool suits_one_face(const Registration& fit) {
  constexpr double kMostFactor = 1.3;
  constexpr double kMostLostOfFace = 0.0004;
  return fit.cluster_factor <= kMostFactor && fit.lost <= kMostLostOfFace;
}

// Where one flat face is seen and its neighbours as slivers, poses that are turned a little look
// alike, and a search ends in the next of them: all about are tried, and where another is as good
// none is trusted.
Registration tried_around(const Registration& found, const RegistrationTask& task,
                          const GreyImage& image, Fitter& fitter) {
  constexpr int kStarts = 8;
  constexpr double kSds = 1.5;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(
      task.prior.covariance.topLeftCorner<3, 3>(), Eigen::EigenvaluesOnly);
  const double turn_rad = kSds * std::sqrt(std::max(0.0, axes.eigenvalues()[2]));
  const std::vector<FitLevel> levels = fit_levels(image, false);
  Trials trials;
  trials.take(found);
  std::vector<Registration> fits = {found};
  for (int i = 0; i < kStarts; ++i) {
    const double way = 2 * std::numbers::pi * i / kStarts;
    Pose start = found.cam_from_target;
    start.rotation =
        rotation_from_vector(turn_rad * Eigen::Vector3d(std::cos(way), std::sin(way), 0)) *
        start.rotation;
    fits.push_back(fitter.fit(levels, start, kTightSd));
    if (is_allowed_by(task.prior, fits.back().cam_from_target)) trials.take(fits.back());
  }
  Registration best = trials.result(task);
  best.starts = found.starts + kStarts;
  best.drawings = 0;
  for (const Registration& fit : fits) best.drawings += fit.drawings;
  const bool has_rival = std::ranges::any_of(fits, [&](const Registration& fit) {
    return fit.is_ok() && is_allowed_by(task.prior, fit.cam_from_target) && !agree(fit, best) &&
           fit.cost < best.cost + kClearlyBetter;
  });
  if (best.is_ok() && has_rival) {
    distrust("one flat face alone is seen, and other poses are as good", best);
  } else if (best.is_ok() && !suits_one_face(best)) {
    distrust("one flat face alone is seen, and what the pose leaves of the image is no noise",
             best);
  }
  return best;
}

}  // namespace

std::string_view to_string(RegistrationStatus status) {
  constexpr std::array<std::string_view, 6> kNames = {
      "ok",         "behind_camera", "target outside", "target too small", "target saturated",
      "not trusted"};
  return kNames[static_cast<size_t>(status)];
}

Registration register_mesh(const RegistrationTask& task, const RegistrationOptions& options) {
  constexpr double kOneFace = 0.8;  // of what is seen
  const GreyImage image = grey_image(task.image, task.white, options.is_srgb, task.camera);
  if (const Usability found = usability(task, image); found.status != RegistrationStatus::kOk) {
    Registration out;
    out.status = found.status;
    out.reason = found.reason;
    return out;
  }
  Fitter fitter(task.mesh, task.prior, noise_variance(image, options), options);
  const Registration found = searched(task, image, fitter);
  // Where faces are printed the least cost is no sign of the right pose.
  const bool is_plain = found.is_ok() && found.lost <= kAlienLost;
  const bool is_one_face = is_plain && facing_share(task.mesh, found.cam_from_target) > kOneFace;
  return is_one_face ? tried_around(found, task, image, fitter) : found;
}

}  // namespace sightline
