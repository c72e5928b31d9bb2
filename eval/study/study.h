// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// A study as its file states it. What every study has stands in `Study`; what only one kind has
// stands in the kind's own struct, of which a study holds exactly one. eval/study/study_file.h
// reads them.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "eval/datasets/sightings.h"
#include "eval/doors/registration_setup.h"
#include "eval/doors/trial_extractor.h"
#include "eval/doors/trial_solver.h"
#include "eval/study/label_limits.h"
#include "eval/study/planted.h"
#include "eval/study/seen_edges.h"
#include "features/extractor.h"
#include "pose/absolute_orientation.h"
#include "pose/robust_alignment.h"
#include "pose/solver.h"
#include "scenes/scene/prior.h"
#include "scenes/scene/scene_law.h"
#include "scenes/target/target.h"

namespace sightline {

/// A figure that a paper prints, to stand beside ours.
struct PaperFigure {
  double theta_error_deg = 0;
  double t_error_percent = 0;
};

/// What all trials of one row of the study's result share, in words and numbers for readers: which
/// given pose they show, or which values the swept keys have. What a condition makes of the trials
/// stands in the cell of the same index of the study's kind.
struct Condition {
  std::string label;                           ///< "pose 1", or "all" where a study has one
  std::map<std::string, double> values;        ///< as summary.json states it: {"pose": 1}
  std::map<std::string, PaperFigure> paper{};  ///< by solver
  std::map<std::string, std::string> words{};  ///< as `values`: swept keys that are no numbers
};

/// Where the solvers start.
enum class Start {
  kPrior,  ///< from the prior pose, as a tracker would
  kFree,   ///< from orthogonal iteration, which needs neither truth nor prior
};

/// What the solvers are given of a trial, besides what was extracted: the steps between an error
/// that nothing causes and the one that is measured.
enum class PoseInput {
  kExact,    ///< the true projections of the features found: what the geometry leaves
  kNoise,    ///< outliers at the truth plus the error of an inlier of the trial: noise alone
  kInliers,  ///< without the outliers: what a perfect removal leaves
};

std::string_view to_string(PoseInput input);

/// The name under which a solver's estimates from such an input are kept: "lspe/exact".
std::string name_with(std::string_view solver, PoseInput input);

/// Whether a solver can be asked what it makes of other points than those that were extracted.
bool can_be_given_inputs(const TrialSolver& solver);

/// Which solvers estimate the pose of every trial, from where, and with which options.
struct Solving {
  std::vector<TrialSolver> solvers;
  /// That the solvers get besides what was extracted: those that can_be_given_inputs.
  std::vector<PoseInput> inputs;
  Start start = Start::kPrior;
  SolverOptions options;

  /// The names under which a trial's estimates are kept, in their order.
  std::vector<std::string> names() const;
};

/// What studies of images and numeric studies share: the pose of a target is estimated from
/// features of it.
struct PoseStudy {
  std::shared_ptr<const Target> target;
  std::vector<int> features;  ///< indices into the target's features
  Solving solving;

  const TargetFeature& feature(int slot) const { return target->features[features[slot]]; }
};

/// Whether the last pass renders the target at the pose found and subtracts what the extractors err
/// on that. With the light known and the exact mesh it is an inverse crime: the same renderer made
/// the image of the same.
enum class BiasRemoval {
  kOff,
  kWrongLight,  ///< the light's direction is off by about 18 degrees
  kKnownLight,
};

/// What of a picture in colour extractors look at.
enum class ExtractedChannel {
  kGrey,      ///< its grey
  kContrast,  ///< in each window its grey, or the colour that has more contrast there
};

/// What an image study's file says of its frames and of the extraction of features from them. A
/// study has one set-up or, where keys are swept, one for every combination of their values.
struct ImageSetup {
  SceneLaw scene;
  PriorError prior;
  ExtractorChoice extractors;
  /// Who finds the features in their place; null: they do.
  std::shared_ptr<const TrialExtractor> guest;
  ExtractorOptions extractor_options;
  /// Whether solvers that use lines are given those that were found along edges.
  bool uses_lines = false;
  ExtractedChannel channel = ExtractedChannel::kGrey;
  int passes = 1;  ///< of extraction; all but the first around the pose that came out before
  BiasRemoval bias_removal = BiasRemoval::kOff;
  /// What is rendered for it; null where it is off.
  std::shared_ptr<const Target> bias_target;
  RegistrationSetup registration;
  LabelLimits limits;
};

/// Which images a condition of an image study has.
struct ImageCell {
  int setup = 0;  ///< index into the study's set-ups
  int pose = 0;   ///< index into the set-up's given poses; 0 where poses are drawn
};

/// The images of a data set, which stand where a study else renders its own: one a draw.
struct SightedImages {
  std::shared_ptr<const SightedSet> set;
  bool has_given_priors = false;  ///< the sightings have them, as far as there are any
};

/// A study whose trials begin at a scene that is rendered, or at an image of a data set.
struct ImageStudy : PoseStudy {
  std::vector<ImageSetup> setups;        ///< at least one
  std::vector<ImageCell> cells;          ///< one a condition of the study
  std::optional<SightedImages> sighted;  ///< none: the images are rendered

  const ImageSetup& setup_of(int condition) const { return setups[cells[condition].setup]; }
  /// The given poses, which set-ups share, or what they are drawn from in the first set-up.
  const PoseLaw& pose_law() const { return setups.front().scene.poses; }
  /// The number that keys the random draws of a trial: set-ups share their draws, so that what is
  /// swept is all that differs between them.
  int64_t draw_of(int64_t trial) const;
  /// The picture that a trial shows, as files of others name it.
  TrialName name_of(int64_t trial) const;
  /// Whether trials ask processes, which only a run does.
  bool asks_processes() const;
  /// What a trial shows whose image is a data set's.
  const Sighting& sighting_of(int64_t trial) const;
  /// The camera of a cell's trials; where their images are a data set's, of its first.
  const Camera& camera_of(int condition) const { return setup_of(condition).scene.camera; }
};

/// How the noise of a numeric study is distributed, in each coordinate by itself.
struct NoiseLaw {
  enum class Tails {
    kNormal,
    kStudent,  ///< Student's t, scaled to the standard deviation: rare errors are large
  };
  Tails tails = Tails::kNormal;
  double freedom =
      3;  ///< of kStudent: degrees of freedom, above 2; the fewer, the heavier the tails
};

/// What one condition of a numeric study applies to the exact projections.
struct NumericCell {
  double noise_px = 0;  ///< standard deviation of each coordinate; noise.scale applied
  int outliers = 0;     ///< points of a trial that are displaced
  int setup = 0;        ///< index into the study's set-ups
};

/// What a numeric study's file says of its trials. A study has one set-up or, where its keys are
/// swept, one for every combination of their values.
struct NumericSetup {
  Camera camera;
  PoseLaw poses;
  PriorError prior;
  NoiseLaw noise;
  PlantedOutliers planted;
  SeenEdges edges;
  bool is_sigma_known = false;  ///< the solvers are told the noise applied
  Start start = Start::kFree;
  SolverOptions options;
};

/// What the claim of a numeric study says in numbers: the means of one solver stay below these.
struct ClaimLimits {
  std::string solver = "orpe";
  double theta_error_deg = 0;
  double t_error_percent = 0;
};

/// A study whose trials begin at observations: exact projections, noise and planted outliers.
struct NumericStudy : PoseStudy {
  std::vector<NumericSetup> setups = std::vector<NumericSetup>(1);  ///< at least one
  std::optional<ClaimLimits> limits;
  std::vector<NumericCell> cells;  ///< one a condition of the study

  const NumericSetup& setup_of(int condition) const { return setups[cells[condition].setup]; }

  /// A trial as files of others name it: the image is the trial's number.
  static TrialName name_of(int64_t trial) { return {.trial = trial, .im_id = trial}; }
};

/// What an orientation study draws: points uniform in a cube about the origin, three uniform Euler
/// angles, a translation uniform in a cube; and of every draw so many noisy copies, each with its
/// own wrong pairs.
struct PointPairs {
  double half_side_m = 10;
  double translation_m = 100;  ///< each coordinate in +-
  int copies = 50;
  int timed_repeats = 0;         ///< of every solve, for its mean time; 0: nothing is timed
  bool is_sigma_known = false;   ///< methods for pairs with outliers are told the noise applied
  bool estimates_scale = false;  ///< and seek a scale
};

/// What one condition of an orientation study draws.
struct OrientationCell {
  double noise_m = 0;  ///< standard deviation of each coordinate; noise.scale applied
  int points = 0;      ///< of a trial
  int outliers = 0;    ///< of them, in the second frame anywhere in the volume of the others
  double scale = 1;    ///< of the second frame
};

/// A method of an orientation study: one that takes every pair to be right, or one for pairs with
/// outliers.
using StudyMethod = std::variant<const OrientationMethod*, const RobustAlignmentMethod*>;

std::string_view name_of(const StudyMethod& method);

/// A study whose trials begin at matched points in two frames, for the absolute orientation.
struct OrientationStudy {
  std::vector<StudyMethod> methods;
  PointPairs pairs;
  std::vector<OrientationCell> cells;  ///< one a condition of the study

  /// Whether its solves are timed, for timings.csv.
  bool takes_times() const { return pairs.timed_repeats > 0; }
  /// Whether any of its pairs are wrong.
  bool has_outliers() const;
};

/// A study as its file states it, checked: a thing that can be run.
struct Study {
  std::string name;
  std::string title;
  std::string question;
  std::string reference;  ///< the figure or table of a paper that it repeats; may be empty
  std::string claim;      ///< what the paper says of it, in words; may be empty
  uint64_t seed = 1;
  int draws = 100;  ///< trials a condition
  std::vector<Condition> conditions;
  std::string toml;  ///< the file as run, overrides applied
  std::variant<ImageStudy, NumericStudy, OrientationStudy> kind;

  // The study as one of its kinds; null where it is of another.
  const ImageStudy* images() const { return std::get_if<ImageStudy>(&kind); }
  const NumericStudy* numeric() const { return std::get_if<NumericStudy>(&kind); }
  const OrientationStudy* orientation() const { return std::get_if<OrientationStudy>(&kind); }
  /// The study as one that estimates the pose of a target; null for an orientation study.
  const PoseStudy* pose_study() const;

  /// The solvers that every trial has an estimate of; none in an orientation study.
  std::span<const TrialSolver> solvers() const;
  /// The solver of that name; null where the study has none.
  const TrialSolver* find_solver(std::string_view solver_name) const;
  /// The names of the solvers or, in an orientation study, of the methods.
  std::vector<std::string> solver_names() const;
  /// The poses that the file gives or the law they are drawn from; null for an orientation study.
  const PoseLaw* pose_law() const;
  /// Whether its images were rendered here, and not taken from a data set or never made.
  bool renders() const { return images() != nullptr && !images()->sighted; }
  /// Whether its solves are timed, for timings.csv.
  bool takes_times() const { return orientation() != nullptr && orientation()->takes_times(); }
  /// The camera of one trial of a study that has any.
  const Camera& camera_of(int64_t trial) const;

  int64_t trial_count() const { return static_cast<int64_t>(draws) * conditions.size(); }
  /// Trials are numbered draw by draw, so that a smaller study is the beginning of a larger one.
  int condition_of(int64_t trial) const { return static_cast<int>(trial % conditions.size()); }
};

}  // namespace sightline
