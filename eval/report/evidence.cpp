// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/evidence.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string_view>

#include <fmt/format.h>

#include "eval/report/means.h"
#include "eval/report/outline.h"
#include "eval/report/text.h"

namespace sightline {
namespace {

constexpr size_t kMaxFrames = 8;
constexpr size_t kMaxFirstDraws = 4;
constexpr std::string_view kRanks[] = {"", "second ", "third "};
constexpr size_t kWorstFrames = std::size(kRanks);

double theta_error_deg(const TrialRecord& trial, const std::string& solver) {
  const EstimateRecord* estimate = find_estimate(trial, solver);
  const bool is_ok =
      estimate != nullptr && estimate->is_ok() && std::isfinite(estimate->theta_error_deg);
  return is_ok ? estimate->theta_error_deg : std::numeric_limits<double>::infinity();
}

// Adds a reason to a trial that is shown already.
void choose(std::vector<FrameChoice>& choices, const TrialRecord& trial,
            const std::string& reason) {
  for (FrameChoice& choice : choices) {
    if (choice.trial != trial.trial) continue;
    choice.caption += "; " + reason;
    return;
  }
  if (choices.size() < kMaxFrames) choices.push_back({trial.trial, reason});
}

std::string draw_name(const Study& study, const TrialRecord& trial) {
  const auto conditions = static_cast<int64_t>(study.conditions.size());
  return fmt::format("{}, draw {}", study.conditions[trial.condition].label,
                     trial.trial / conditions + 1);
}

// From the best to the worst of the poses that were found.
std::vector<const TrialRecord*> by_error(std::span<const TrialRecord> trials,
                                         const std::string& solver) {
  std::vector<const TrialRecord*> sorted;
  for (const TrialRecord& trial : trials) {
    if (std::isfinite(theta_error_deg(trial, solver))) sorted.push_back(&trial);
  }
  std::stable_sort(sorted.begin(), sorted.end(), [&](const auto* a, const auto* b) {
    return theta_error_deg(*a, solver) < theta_error_deg(*b, solver);
  });
  return sorted;
}

void choose_worst(std::vector<FrameChoice>& choices, const std::vector<const TrialRecord*>& sorted,
                  size_t count, const std::string& solver) {
  const std::string label = solver_label(solver);
  for (size_t k = 0; k < std::min(count, sorted.size()); ++k) {
    choose(choices, *sorted[sorted.size() - 1 - k],
           std::string(kRanks[k]) + "worst pose of " + label);
  }
}

void choose_first_draws(std::vector<FrameChoice>& choices, const Study& study,
                        std::span<const TrialRecord> trials) {
  const size_t limit = std::min(study.conditions.size(), kMaxFirstDraws);
  for (size_t condition = 0; condition < limit; ++condition) {
    const auto first = std::find_if(trials.begin(), trials.end(), [&](const TrialRecord& trial) {
      return trial.condition == static_cast<int>(condition);
    });
    if (first != trials.end()) choose(choices, *first, draw_name(study, *first));
  }
}

// The first trial in which a solver's estimate is of some kind.
template <typename IsOfThatKind>
void choose_first(std::vector<FrameChoice>& choices, std::span<const TrialRecord> trials,
                  const std::string& solver, const IsOfThatKind& is_of_that_kind,
                  const std::string& reason) {
  for (const TrialRecord& trial : trials) {
    const EstimateRecord* estimate = find_estimate(trial, solver);
    if (estimate == nullptr || !is_of_that_kind(*estimate)) continue;
    choose(choices, trial, reason);
    return;
  }
}

// What a solver does rightly, wrongly and not at all.
void choose_kinds(std::vector<FrameChoice>& choices, std::span<const TrialRecord> trials,
                  const std::string& solver) {
  const std::string label = solver_label(solver);
  const auto is_right = [](const EstimateRecord& estimate) {
    return estimate.is_ok() && !estimate.removed.empty() && estimate.false_removals == 0;
  };
  const auto is_wrong = [](const EstimateRecord& estimate) {
    return estimate.is_ok() && estimate.false_removals > 0;
  };
  const auto has_failed = [](const EstimateRecord& estimate) { return !estimate.is_ok(); };
  choose_first(choices, trials, solver, is_right, label + " removes an outlier");
  choose_first(choices, trials, solver, is_wrong, label + " removes an inlier");
  choose_first(choices, trials, solver, has_failed, label + " finds no pose");
}

Outline traced(Renderer& renderer, const Scene& scene, const EstimateRecord& estimate) {
  if (!estimate.is_ok()) return {};
  return target_outline(renderer, scene, estimate.cam_from_target);
}

bool is_same(const Pose& a, const Pose& b) {
  return a.rotation == b.rotation && a.translation == b.translation;
}

bool is_same(double a, double b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}

bool is_same(const ObservationRecord& a, const ObservationRecord& b) {
  return a.feature == b.feature && a.status == b.status && a.is_visible == b.is_visible &&
         a.is_outlier == b.is_outlier && (!a.is_found() || a.pixel == b.pixel);
}

// A failed trial's numbers mean nothing.
bool is_same(const EstimateRecord& a, const EstimateRecord& b) {
  if (a.solver != b.solver || a.status != b.status) return false;
  if (!a.is_ok()) return true;
  return is_same(a.cam_from_target, b.cam_from_target) && a.removed == b.removed &&
         is_same(a.theta_error_deg, b.theta_error_deg) &&
         is_same(a.t_error_percent, b.t_error_percent) &&
         is_same(a.reprojection_rms_px, b.reprojection_rms_px);
}

template <typename Record>
bool is_same(const std::vector<Record>& a, const std::vector<Record>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Record& x, const Record& y) { return is_same(x, y); });
}

// In all that the report shows of a trial, bit by bit.
bool is_same(const TrialRecord& a, const TrialRecord& b) {
  return is_same(a.true_cam_from_target, b.true_cam_from_target) &&
         is_same(a.observations, b.observations) && is_same(a.estimates, b.estimates);
}

FrameEvidence evidence_of(const Study& study, const FrameChoice& choice, const TrialRecord& stored,
                          Renderer& renderer) {
  FrameEvidence evidence{choice.caption, stored, run_trial(study, choice.trial, renderer), {}};
  if (!is_same(stored, evidence.trial.record)) {
    evidence.caption += "; this re-run differs from the stored trial";
  }
  for (const EstimateRecord& estimate : evidence.trial.record.estimates) {
    Outline outline = traced(renderer, evidence.trial.scene, estimate);
    if (!outline.empty()) evidence.outlines.emplace(estimate.solver, std::move(outline));
  }
  return evidence;
}

}  // namespace

std::vector<FrameChoice> choose_frames(const Study& study, std::span<const TrialRecord> trials) {
  std::vector<FrameChoice> choices;
  if (trials.empty()) return choices;
  const std::string solver = lead_solver(study);
  const auto sorted = by_error(trials, solver);
  if (study.conditions.size() > 1) {
    choose_first_draws(choices, study, trials);
    choose_worst(choices, sorted, 1, solver);
    choose_kinds(choices, trials, solver);
    return choices;
  }
  choose(choices, trials.front(), "first draw");
  if (!sorted.empty()) {
    choose(choices, *sorted[sorted.size() / 2], "median of " + solver_label(solver));
  }
  choose_worst(choices, sorted, kWorstFrames, solver);
  choose_kinds(choices, trials, solver);
  return choices;
}

std::vector<FrameEvidence> gather_evidence(const Study& study, std::span<const TrialRecord> trials,
                                           Renderer& renderer) {
  std::vector<FrameEvidence> frames;
  for (const FrameChoice& choice : choose_frames(study, trials)) {
    const auto stored = std::find_if(trials.begin(), trials.end(), [&](const TrialRecord& trial) {
      return trial.trial == choice.trial;
    });
    frames.push_back(evidence_of(study, choice, *stored, renderer));
  }
  return frames;
}

}  // namespace sightline
