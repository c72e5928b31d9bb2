// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include <fmt/format.h>

#include "eval/output/words.h"
#include "eval/report/frame_svg.h"
#include "eval/report/means.h"
#include "eval/report/outline.h"
#include "scenes/random/random.h"

namespace sightline {
namespace {

constexpr size_t kMaxFirstDraws = 4;
constexpr size_t kWorstOfLead = 12;
constexpr size_t kWorstOfOthers = 3;
constexpr size_t kLeastFrames = 8;  // whatever their size
constexpr double kManyPixels = 4e6;
constexpr size_t kMostBytes = 13'000'000;  // leaves room for the rest of 15 MB

double theta_error_deg(const TrialRecord& trial, const std::string& solver) {
  const EstimateRecord* estimate = find_estimate(trial, solver);
  const bool is_ok =
      estimate != nullptr && estimate->is_ok() && std::isfinite(estimate->theta_error_deg);
  return is_ok ? estimate->theta_error_deg : std::numeric_limits<double>::infinity();
}

// The trials that are chosen so far.
struct Choices {
  size_t limit = 0;
  std::vector<FrameChoice> list = {};

  bool is_full() const { return list.size() >= limit; }

  // Adds a reason to a trial that is shown already.
  void add(const TrialRecord& trial, const std::string& reason) {
    for (FrameChoice& choice : list) {
      if (choice.trial != trial.trial) continue;
      choice.caption += "; " + reason;
      return;
    }
    if (!is_full()) list.push_back({trial.trial, reason});
  }
};

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

std::string rank(size_t k) {
  if (k == 0) return "worst pose";
  const char* ending = k == 1 ? "nd" : k == 2 ? "rd" : "th";
  return fmt::format("{}{} worst pose", k + 1, ending);
}

// The worst poses from rank `begin` on, 0 being the worst.
void choose_worst(Choices& choices, const std::vector<const TrialRecord*>& sorted, size_t begin,
                  size_t end, const std::string& solver) {
  for (size_t k = begin; k < std::min(end, sorted.size()); ++k) {
    choices.add(*sorted[sorted.size() - 1 - k], rank(k) + " of " + solver_label(solver));
  }
}

void choose_first_draws(Choices& choices, const Study& study, std::span<const TrialRecord> trials) {
  const size_t limit = std::min(study.conditions.size(), kMaxFirstDraws);
  for (size_t condition = 0; condition < limit; ++condition) {
    const auto first = std::find_if(trials.begin(), trials.end(), [&](const TrialRecord& trial) {
      return trial.condition == static_cast<int>(condition);
    });
    if (first == trials.end()) continue;
    choices.add(*first, limit > 1 ? draw_name(study, *first) : "first draw");
  }
}

// What a solver made of a trial, by kind: rightly, wrongly and not at all.
std::vector<std::string> kinds_of(const EstimateRecord& estimate) {
  if (!estimate.is_ok()) return {"finds no pose: " + words(to_string(estimate.status))};
  std::vector<std::string> kinds;
  if (estimate.false_removals > 0) kinds.push_back("removes an inlier");
  if (estimate.missed_outliers > 0) kinds.push_back("keeps an outlier");
  if (!estimate.removed.empty() && kinds.empty()) kinds.push_back("removes an outlier");
  return kinds;
}

// The first trial of each kind, of a solver.
void choose_kinds(Choices& choices, std::span<const TrialRecord> trials,
                  const std::string& solver) {
  std::set<std::string> seen;
  for (const TrialRecord& trial : trials) {
    const EstimateRecord* estimate = find_estimate(trial, solver);
    if (estimate == nullptr) continue;
    for (const std::string& kind : kinds_of(*estimate)) {
      if (seen.insert(kind).second) choices.add(trial, solver_label(solver) + " " + kind);
    }
  }
}

// The first trial of each reason for which a feature is missing.
void choose_missing(Choices& choices, std::span<const TrialRecord> trials) {
  std::set<ObservationOutcome> seen;
  for (const TrialRecord& trial : trials) {
    for (const ObservationRecord& observation : trial.observations()) {
      if (observation.is_found() || !seen.insert(observation.status).second) continue;
      choices.add(trial, "a feature is missing: " + words(to_string(observation.status)));
    }
  }
}

void fill_at_random(Choices& choices, const Study& study, std::span<const TrialRecord> trials) {
  RandomStream stream(study.seed, "report/frames", 0);
  std::vector<size_t> left(trials.size());
  std::iota(left.begin(), left.end(), size_t{0});
  std::set<int64_t> taken;
  for (const FrameChoice& choice : choices.list) taken.insert(choice.trial);
  std::erase_if(left, [&](size_t i) { return taken.contains(trials[i].trial); });
  while (!choices.is_full() && !left.empty()) {
    const auto at = static_cast<size_t>(stream.uniform() * static_cast<double>(left.size()));
    std::swap(left[at], left.back());
    choices.add(trials[left.back()], "chosen at random");
    left.pop_back();
  }
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
bool is_same(std::span<const Record> a, std::span<const Record> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Record& x, const Record& y) { return is_same(x, y); });
}

// In all that the report shows of a trial, bit by bit.
bool is_same(const TrialRecord& a, const TrialRecord& b) {
  return is_same(a.true_cam_from_target, b.true_cam_from_target) &&
         is_same(a.observations(), b.observations()) && is_same(a.estimates(), b.estimates());
}

// Where the target, the windows and the outlines are, of any solver.
cv::Rect region_of_interest(const Trial& trial, const std::map<std::string, Outline>& outlines) {
  if (trial.frame.image.empty()) return {};
  cv::Rect region = trial.frame.truth.target().visible_box;
  for (const Observation& observation : trial.observations) region |= observation.window;
  for (const auto& [solver, outline] : outlines) {
    for (const std::vector<Eigen::Vector2d>& polygon : outline) {
      for (const Eigen::Vector2d& vertex : polygon) {
        region |= cv::Rect(cv::Point(cvRound(vertex.x()), cvRound(vertex.y())), cv::Size(1, 1));
      }
    }
  }
  return region;
}

// A picture of a larger part takes more of the page than it is worth.
constexpr int kMostResidualPixels = 1 << 20;

// Of the first registration that has a pose.
std::optional<ResidualPicture> residual_of(const ImageStudy& images, const Trial& trial) {
  for (const EstimateRecord& estimate : trial.record.estimates()) {
    if (!estimate.is_ok() || !estimate.solver.starts_with("registration_")) continue;
    const auto model = model_beside(images, trial, estimate.cam_from_target);
    if (!model || model->box.area() > kMostResidualPixels) return std::nullopt;
    return residual_picture(estimate.solver, *model);
  }
  return std::nullopt;
}

FrameEvidence evidence_of(const Study& study, const FrameChoice& choice, const TrialRecord& stored,
                          Renderer& renderer, SetFiles& files) {
  const ImageStudy& images = *study.images();
  FrameEvidence evidence{choice.caption,
                         stored,
                         // A report starts nobody's programs, though the study name them.
                         images.asks_processes()
                             ? recall_image_trial(images, study.seed, stored, renderer)
                             : run_image_trial(images, study.seed, choice.trial, renderer, files),
                         {},
                         {}};
  Trial& trial = evidence.trial;
  if (!is_same(stored, trial.record)) {
    evidence.caption += "; this re-run differs from the stored trial";
  }
  for (const EstimateRecord& estimate : trial.record.estimates()) {
    Outline outline = traced(renderer, trial.scene, estimate);
    if (!outline.empty()) evidence.outlines.emplace(estimate.solver, std::move(outline));
  }
  evidence.picture = picture_of(trial.frame.image, trial.scene.sensor.bits,
                                region_of_interest(trial, evidence.outlines));
  evidence.residual = residual_of(images, trial);
  trial.frame = {};  // sixty of them would fill the memory
  return evidence;
}

// About what a frame takes in the page: its picture, and its marks, there and in the close-ups.
size_t bytes_of(const FrameEvidence& frame) {
  constexpr size_t kBytesAFrame = 8000;
  constexpr size_t kBytesAnEdgePixel = 2 * 17;
  constexpr size_t kBytesAnOutlineSample = 2 * 3;  // most lie on straight lines
  constexpr size_t kBytesAVertex = 14;
  size_t bytes = frame.picture.png_url.size() + kBytesAFrame;
  if (frame.residual) {
    bytes += frame.residual->model_url.size() + frame.residual->residual_url.size();
  }
  for (const Observation& observation : frame.trial.observations) {
    for (const ImageLine& line : observation.lines) {
      bytes += kBytesAnEdgePixel * line.edge_pixels.size();
    }
    bytes += kBytesAnEdgePixel * observation.contour.size();
    bytes += kBytesAnOutlineSample * observation.laid_outline.size();
  }
  for (const auto& [solver, outline] : frame.outlines) {
    for (const auto& polygon : outline) bytes += kBytesAVertex * polygon.size();
  }
  return bytes;
}

size_t frames_for(const Study& study) {
  double pixels = 0;
  for (size_t i = 0; i < study.conditions.size(); ++i) {
    const Camera& camera = study.images()->camera_of(static_cast<int>(i));
    pixels = std::max(pixels, static_cast<double>(camera.width_px) * camera.height_px);
  }
  const double many = static_cast<double>(kMostFrames) * std::min(1.0, kManyPixels / pixels);
  return std::max(static_cast<size_t>(many), kLeastFrames);
}

}  // namespace

std::vector<FrameChoice> choose_frames(const Study& study, std::span<const TrialRecord> trials,
                                       size_t limit) {
  Choices choices{limit};
  if (trials.empty()) return {};
  const std::string lead = lead_solver(study);
  const auto sorted = by_error(trials, lead);
  choose_first_draws(choices, study, trials);
  if (!sorted.empty()) choices.add(*sorted[sorted.size() / 2], "median of " + solver_label(lead));
  choose_worst(choices, sorted, 0, 1, lead);
  choose_kinds(choices, trials, lead);
  choose_worst(choices, sorted, 1, kWorstOfLead, lead);
  choose_missing(choices, trials);
  for (const TrialSolver& solver : study.solvers()) {
    if (solver.evaluation_only || solver.name == lead) continue;
    const std::string name(solver.name);
    choose_kinds(choices, trials, name);
    choose_worst(choices, by_error(trials, name), 0, kWorstOfOthers, name);
  }
  fill_at_random(choices, study, trials);
  return choices.list;
}

std::vector<FrameEvidence> gather_evidence(const Study& study, std::span<const TrialRecord> trials,
                                           Renderer& renderer) {
  std::vector<FrameEvidence> frames;
  SetFiles files;
  size_t bytes = 0;
  for (const FrameChoice& choice : choose_frames(study, trials, frames_for(study))) {
    const auto stored = std::find_if(trials.begin(), trials.end(), [&](const TrialRecord& trial) {
      return trial.trial == choice.trial;
    });
    FrameEvidence frame = evidence_of(study, choice, *stored, renderer, files);
    bytes += bytes_of(frame);
    if (bytes > kMostBytes && !frames.empty()) break;
    frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace sightline
