// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/trial/numeric_trial.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include <Eigen/Cholesky>

#include "eval/records/line_records.h"
#include "eval/trial/estimates.h"
#include "eval/trial/labels.h"

namespace sightline {
namespace {

// Brings `count` items, drawn without replacement, to the front.
template <typename Item>
void draw_to_front(std::vector<Item>& items, int count, RandomStream& stream) {
  for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
    const uint64_t left = items.size() - i;
    std::swap(items[i], items[i + ((uint64_t{stream.bits()} * left) >> 32)]);
  }
}

// The exact projections; none when a feature is behind the camera.
std::vector<ObservationRecord> project_features(const NumericStudy& study, const Camera& camera,
                                                const Pose& cam_from_target) {
  std::vector<ObservationRecord> records;
  for (const int feature : study.features) {
    const TargetFeature& of_target = study.target->features[feature];
    const auto pixel = project(camera, cam_from_target * of_target.position_m);
    if (!pixel) return {};
    ObservationRecord& record = records.emplace_back();
    record.feature = of_target.name;
    record.is_visible = true;
    record.true_pixel = *pixel;
    record.pixel = *pixel;
  }
  return records;
}

// Student's t of standard deviation 1, drawn as Bailey's polar form has it (Mathematics of
// Computation 62, 1994).
double drawn_student(double freedom, RandomStream& stream) {
  const double radius = std::sqrt(freedom * (std::pow(stream.uniform(), -2 / freedom) - 1));
  const double t = radius * std::cos(2 * std::numbers::pi * stream.uniform());
  return t * std::sqrt((freedom - 2) / freedom);
}

double drawn_error(const NoiseLaw& law, RandomStream& stream) {
  return law.tails == NoiseLaw::Tails::kStudent ? drawn_student(law.freedom, stream)
                                                : stream.normal();
}

void add_noise(const NoiseLaw& law, double sd_px, RandomStream& stream,
               std::vector<ObservationRecord>& records) {
  for (ObservationRecord& record : records) {
    const double du = sd_px * drawn_error(law, stream);
    record.pixel += Eigen::Vector2d(du, sd_px * drawn_error(law, stream));
  }
}

// By the law, of what is uniform in the range.
double size_by_law(const PlantedOutliers& law, double uniform_px) {
  const auto [min, max] = law.size_px;
  if (law.law == OutlierLaw::kFixed) return max;
  if (law.law != OutlierLaw::kTailed) return uniform_px;
  return min * max / (max + min - uniform_px);  // the share above a size falls with its inverse
}

double drawn_size_px(const PlantedOutliers& law, RandomStream& stream) {
  return size_by_law(law, stream.uniform(law.size_px.min, law.size_px.max));
}

// Features as points where the lines along their edges meet, with the noise that this leaves them.
// Those whose edges do not meet are missing; where there are lines alone, all are.
void add_corner_noise(const NumericStudy& study, const NumericSetup& setup, double sd_px,
                      RandomStream& stream, TrialRecord& trial) {
  std::vector<ObservationRecord>& records = trial.pose_trial().observations;
  for (size_t i = 0; i < records.size(); ++i) {
    const auto covariance = corner_covariance_px2(setup.edges, study.feature(static_cast<int>(i)),
                                                  setup.camera, trial.true_cam_from_target, sd_px);
    const double du = stream.normal();
    const Eigen::Vector2d drawn(du, stream.normal());
    if (!covariance || !setup.edges.has_points()) {
      records[i].status = ObservationOutcome::kMissing;
      continue;
    }
    const Eigen::LLT<Eigen::Matrix2d> root(*covariance);
    records[i].pixel += root.matrixL() * drawn;
    records[i].error_sigmas = drawn.norm();
  }
}

// What is wrong with a line, beside its noise.
struct LineError {
  double offset_px = 0;  // in the middle of the line, along its normal
  double slope = 0;
  bool is_planted = false;
};

// One a line. Those that are wrong pass as far from the ends of what is seen of their edges as the
// law says.
std::vector<LineError> planted_line_errors(const PlantedOutliers& law,
                                           std::span<const SeenEdge> seen, RandomStream& stream) {
  std::vector<LineError> errors(seen.size());
  std::vector<size_t> lines(seen.size());
  std::iota(lines.begin(), lines.end(), size_t{0});
  const int possible = std::min(law.lines, static_cast<int>(seen.size()));
  draw_to_front(lines, possible, stream);
  const auto drawn_at_end = [&] {
    const double size_px = drawn_size_px(law, stream);
    return stream.uniform() < 0.5 ? -size_px : size_px;
  };
  for (const size_t line : std::span(lines).first(static_cast<size_t>(possible))) {
    const double begin_px = drawn_at_end(), end_px = drawn_at_end();
    errors[line] = {(begin_px + end_px) / 2, (end_px - begin_px) / seen[line].length_px, true};
  }
  return errors;
}

// A line along an edge, whose noise is drawn.
LineRecord drawn_line(const Target& target, const SeenEdge& seen, const LineError& error,
                      const Camera& camera, const Pose& truth, double sd_px, RandomStream& stream) {
  const Edge& edge = edge_of(target, seen.of);
  const Eigen::Vector2d begin = project(camera, truth * edge.begin_m).value();
  const Eigen::Vector2d end = project(camera, truth * edge.end_m).value();
  const Eigen::Vector2d direction = (end - begin).normalized();
  const Eigen::Vector2d normal(-direction.y(), direction.x());
  const Eigen::Matrix2d covariance = covariance_of_edge_pixels(seen.length_px, 1, sd_px);
  const Eigen::Vector2d sd = covariance.diagonal().cwiseSqrt();
  const double offset_sigmas = stream.normal() + (error.is_planted ? error.offset_px / sd.x() : 0);
  const double slope_sigmas = stream.normal() + (error.is_planted ? error.slope / sd.y() : 0);
  LineRecord line;
  line.feature = target.features[seen.of.feature].name;
  line.edge = seen.of.edge;
  line.label = error.is_planted ? LineLabel::kWrong : LineLabel::kRight;
  line.offset_px = -sd.x() * offset_sigmas;
  line.pixel = (begin + end) / 2 - line.offset_px * normal;
  line.direction = (direction + sd.y() * slope_sigmas * normal).normalized();
  line.offset_variance_px2 = covariance(0, 0);
  line.slope_variance = covariance(1, 1);
  line.error_sigmas = std::hypot(offset_sigmas, slope_sigmas);
  return line;
}

// The edges that are seen as lines, with the noise of their edge pixels.
std::vector<LineRecord> drawn_lines(const NumericStudy& study, const NumericSetup& setup,
                                    const Pose& truth, double sd_px, uint64_t seed, int64_t trial) {
  RandomStream noise(seed, "lines", trial), outliers(seed, "line_outliers", trial);
  const std::vector<SeenEdge> seen =
      seen_lines(setup.edges, *study.target, study.features, setup.camera, truth);
  const std::vector<LineError> errors = planted_line_errors(setup.planted, seen, outliers);
  std::vector<LineRecord> lines;
  for (size_t i = 0; i < seen.size(); ++i) {
    lines.push_back(
        drawn_line(*study.target, seen[i], errors[i], setup.camera, truth, sd_px, noise));
  }
  return lines;
}

Eigen::Vector2d drawn_displacement(const PlantedOutliers& law, RandomStream& stream) {
  const double angle = 2 * std::numbers::pi * stream.uniform();
  return drawn_size_px(law, stream) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

// How many outliers a trial has: the stated number, and each other point by chance.
int drawn_count(const NumericStudy& study, const NumericCell& cell, uint64_t seed, int64_t trial) {
  const double rate = study.setups[cell.setup].planted.rate;
  if (rate == 0) return cell.outliers;
  RandomStream stream(seed, "outlier_rate", trial);
  int count = cell.outliers;
  for (int i = cell.outliers; i < static_cast<int>(study.features.size()); ++i) {
    count += stream.uniform() < rate;
  }
  return count;
}

void swap_pairs(const NumericStudy& study, int count, RandomStream& stream,
                std::vector<ObservationRecord>& records) {
  std::vector<std::pair<int, int>> pairs = mirrored_pairs(*study.target, study.features);
  draw_to_front(pairs, count, stream);
  for (const auto& [a, b] : std::span(pairs).first(static_cast<size_t>(count))) {
    std::swap(records[a].pixel, records[b].pixel);
    records[a].is_outlier = true;
    records[b].is_outlier = true;
  }
}

// What failed together in one of the model's trials.
void replay_failures(const OutlierModel& model, RandomStream& stream,
                     std::vector<ObservationRecord>& records) {
  const auto& failures = model.trials[(uint64_t{stream.bits()} * model.trials.size()) >> 32];
  for (const OutlierModel::Failure& failure : failures) {
    const auto record = std::find_if(
        records.begin(), records.end(),
        [&](const ObservationRecord& candidate) { return candidate.feature == failure.feature; });
    if (record == records.end()) continue;
    if (failure.is_missing) {
      record->status = ObservationOutcome::kMissing;
    } else {
      record->pixel = record->true_pixel + failure.displacement_px;
      record->is_outlier = true;
    }
  }
}

void plant_outliers(const NumericStudy& study, const PlantedOutliers& law, int count,
                    RandomStream& stream, std::vector<ObservationRecord>& records) {
  if (law.law == OutlierLaw::kModel) {
    replay_failures(*law.model, stream, records);
    return;
  }
  if (law.law == OutlierLaw::kSwapped) {
    swap_pairs(study, count / 2, stream, records);
    return;
  }
  std::vector<ObservationRecord*> chosen;
  for (ObservationRecord& record : records) {
    if (record.is_found()) chosen.push_back(&record);
  }
  const int possible = std::min(count, static_cast<int>(chosen.size()));
  draw_to_front(chosen, possible, stream);
  chosen.resize(static_cast<size_t>(possible));
  Eigen::Vector2d shift = drawn_displacement(law, stream);
  for (ObservationRecord* record : chosen) {
    record->pixel += shift;
    record->is_outlier = true;
    if (law.law != OutlierLaw::kClustered) shift = drawn_displacement(law, stream);
  }
}

FoundPoints all_points(const NumericStudy& study, const TrialRecord& record) {
  const NumericSetup& setup = study.setup_of(record.condition);
  const PoseTrial& trial = record.pose_trial();
  FoundPoints found;
  found.options = &setup.options;
  found.trial = study.name_of(record.trial);
  PoseProblem& problem = found.problem;
  problem.camera = setup.camera;
  if (setup.start == Start::kPrior) {
    problem.initial_cam_from_target = trial.prior_cam_from_target;
  }
  const bool has_covariances = setup.edges.observed != SeenEdges::Observed::kNothing;
  if (setup.is_sigma_known && !has_covariances)
    problem.sigma_px = study.cells[record.condition].noise_px;
  for (size_t i = 0; i < trial.observations.size(); ++i) {
    if (!trial.observations[i].is_found()) continue;
    problem.points_in_target.push_back(study.feature(static_cast<int>(i)).position_m);
    problem.pixels.push_back(trial.observations[i].pixel);
    found.slots.push_back(static_cast<int>(i));
  }
  if (!has_covariances) return found;
  for (const int slot : found.slots) {
    const auto covariance =
        corner_covariance_px2(setup.edges, study.feature(slot), setup.camera,
                              record.true_cam_from_target, study.cells[record.condition].noise_px);
    problem.covariances_px2.push_back(covariance.value());
  }
  for (const LineRecord& line : trial.lines) {
    problem.lines.push_back(line_of(line, *study.target).value());
  }
  return found;
}

}  // namespace

TrialRecord run_numeric_trial(const NumericStudy& study, uint64_t seed, int64_t index) {
  TrialRecord record;
  record.trial = index;
  record.condition = static_cast<int>(index % study.cells.size());
  const NumericCell& cell = study.cells[record.condition];
  const NumericSetup& setup = study.setup_of(record.condition);

  RandomStream pose_stream(seed, "pose", index);
  record.true_cam_from_target = drawn_pose(setup.poses, pose_stream);
  PoseTrial& trial = record.pose_trial();
  trial.observations = project_features(study, setup.camera, record.true_cam_from_target);
  if (trial.observations.empty()) {
    trial.estimates = failed_estimates(study.solving, EstimateOutcome::kNotImaged);
    return record;
  }
  if (setup.start == Start::kPrior) {
    RandomStream prior_stream(seed, "prior", index);
    trial.prior_cam_from_target =
        draw_prior(record.true_cam_from_target, setup.camera, setup.prior, prior_stream);
  }
  RandomStream noise_stream(seed, "pixel", index);
  if (setup.edges.observed == SeenEdges::Observed::kNothing) {
    add_noise(setup.noise, cell.noise_px, noise_stream, trial.observations);
  } else {
    add_corner_noise(study, setup, cell.noise_px, noise_stream, record);
    trial.lines =
        drawn_lines(study, setup, record.true_cam_from_target, cell.noise_px, seed, index);
  }
  RandomStream outlier_stream(seed, "outliers", index);
  const int outliers = drawn_count(study, cell, seed, index);
  plant_outliers(study, setup.planted, outliers, outlier_stream, trial.observations);
  for (ObservationRecord& observation : trial.observations) {
    if (observation.is_found()) {
      observation.error_px = (observation.pixel - observation.true_pixel).norm();
      observation.label =
          observation.is_outlier ? ObservationLabel::kPlanted : ObservationLabel::kInlier;
    } else {
      observation.label = ObservationLabel::kMissing;
    }
  }
  trial.estimates = estimates_of(study, seed, all_points(study, record), record);
  return record;
}
}  // namespace sightline
