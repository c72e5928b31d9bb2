// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/datasets/sightings.h"
#include "eval/study/label_limits.h"
#include "eval/study/planted.h"
#include "features/extractor.h"
#include "pose/absolute_orientation.h"
#include "pose/solver.h"
#include "scenes/scene/prior.h"
#include "scenes/scene/scene_law.h"
#include "scenes/target/target.h"

namespace sightline {

/// Where a study's trials begin.
enum class StudyKind {
  kImages,       ///< at a scene that is rendered, or at an image of a data set
  kNumeric,      ///< at observations: exact projections, noise and planted outliers
  kOrientation,  ///< at matched points in two frames, for the absolute orientation
};

/// A figure that a paper prints, to stand beside ours.
struct PaperFigure {
  double theta_error_deg = 0;
  double t_error_percent = 0;
};

/// Whether the last pass renders the target at the pose found and subtracts what the extractors err
/// on that. With the light known and the exact mesh it is an inverse crime: the same renderer made
/// the image of the same.
enum class BiasRemoval {
  kOff,
  kWrongLight,  ///< the light's direction is off by about 18 degrees
  kKnownLight,
};

/// What an image study's file says of its frames and of the extraction of features from them. What
/// is swept gives every value a set-up of its own.
struct ImageSetup {
  SceneLaw scene;
  PriorError prior;
  ExtractorChoice extractors;
  ExtractorOptions extractor_options;
  int passes = 1;  ///< of extraction; all but the first around the pose that came out before
  BiasRemoval bias_removal = BiasRemoval::kOff;
  /// What is rendered for it; null where it is off.
  std::shared_ptr<const Target> bias_target;
  LabelLimits limits;
};

/// One cell of a study: what all its trials share.
struct Condition {
  std::string label;                           ///< "pose 1", or "all" where a study has one cell
  std::map<std::string, double> values;        ///< as summary.json states it: {"pose": 1}
  std::map<std::string, PaperFigure> paper{};  ///< by solver
  std::map<std::string, std::string> words{};  ///< as `values`: swept keys that are no numbers
  // In an image study.
  int setup = 0;  ///< index into the study's
  int pose = 0;   ///< index into the given poses; means nothing where they are drawn
  // What numeric and orientation studies apply in this cell.
  double noise_sd = 0;  ///< of each coordinate, pixels or metres; noise.scale applied
  int outliers = 0;     ///< points of a trial that are displaced
  int points = 0;       ///< of an orientation study's trial
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

/// What an orientation study draws: points uniform in a cube about the origin, three uniform Euler
/// angles, a translation uniform in a cube; and of every draw so many noisy copies.
struct PointPairs {
  double half_side_m = 10;
  double translation_m = 100;  ///< each coordinate in +-
  int copies = 50;
  int timed_repeats = 0;  ///< of every solve, for its mean time; 0: nothing is timed
};

/// What the claim of a numeric study says in numbers: the means of one solver stay below these.
struct ClaimLimits {
  std::string solver = "orpe";
  double theta_error_deg = 0;
  double t_error_percent = 0;
};

/// A study as its file states it, checked: a thing that can be run.
struct Study {
  StudyKind kind = StudyKind::kImages;
  std::string name;
  std::string title;
  std::string question;
  std::string reference;  ///< the figure or table of a paper that it repeats; may be empty
  std::string claim;      ///< what the paper says of it, in words; may be empty
  std::optional<ClaimLimits> limits;
  uint64_t seed = 1;
  int draws = 100;  ///< trials a condition
  std::vector<Condition> conditions;
  PoseLaw poses;

  std::shared_ptr<const Target> target;
  std::vector<int> features;       ///< indices into the target's features
  std::vector<ImageSetup> setups;  ///< of an image study: one, or one for every swept value
  /// Of an image study that renders nothing: the images of a data set, one a draw. Else null.
  std::shared_ptr<const std::vector<Sighting>> sightings;
  bool has_given_priors = false;  ///< the sightings have them, as far as there are any
  Camera camera;                  ///< of a numeric study; of the first set-up
  PriorError prior;               ///< alike
  Start start = Start::kPrior;
  std::vector<const PoseSolver*> solvers;
  std::vector<PoseInput> inputs;  ///< that the solvers get besides what was extracted
  SolverOptions solver_options;

  PlantedOutliers planted;      ///< of a numeric study
  bool is_sigma_known = false;  ///< a numeric study's solvers are told the noise applied

  PointPairs pairs;  ///< of an orientation study, which has methods and no solvers
  std::vector<const OrientationMethod*> methods;

  std::string toml;  ///< the file as run, overrides applied

  const ImageSetup& setup_of(int condition) const { return setups[conditions[condition].setup]; }
  /// The camera of a cell's trials; where their images are a data set's, of its first.
  const Camera& camera_of(int condition) const {
    return setups.empty() ? camera : setup_of(condition).scene.camera;
  }
  /// The camera of one trial of the cell.
  const Camera& camera_of(int condition, int64_t trial) const {
    return sightings ? sighting_of(trial).camera : camera_of(condition);
  }
  /// What a trial shows whose image is a data set's.
  const Sighting& sighting_of(int64_t trial) const {
    return (*sightings)[static_cast<size_t>(draw_of(trial))];
  }

  /// Whether its solves are timed, for timings.csv.
  bool takes_times() const { return pairs.timed_repeats > 0; }

  /// The names of the solvers or, in an orientation study, of the methods.
  std::vector<std::string> solver_names() const;

  int64_t trial_count() const { return static_cast<int64_t>(draws) * conditions.size(); }
  /// Trials are numbered draw by draw, so that a smaller study is the beginning of a larger one.
  int condition_of(int64_t trial) const { return static_cast<int>(trial % conditions.size()); }
  /// The number that keys the random draws of an image study's trial: set-ups share their draws, so
  /// that what is swept is all that differs between them.
  int64_t draw_of(int64_t trial) const {
    const auto cells = static_cast<int64_t>(conditions.size());
    const auto poses_each = cells / static_cast<int64_t>(setups.size());
    return trial / cells * poses_each + conditions[condition_of(trial)].pose;
  }
};

/// What the command line may say over a study's file.
struct StudyOverrides {
  std::optional<int> trials;  ///< a condition
  std::optional<int64_t> seed;
  std::vector<std::string> set;  ///< "key=value"
};

/// Reads a study by name or file. Throws InputError for whatever is missing, misspelt, out of range
/// or cannot be imaged.
Study read_study(const std::string& name_or_path, const StudyOverrides& overrides = {});

/// A study from its text; `source` stands for the file in errors.
Study read_study_text(const std::string& toml, const std::filesystem::path& source,
                      const StudyOverrides& overrides = {});

/// What a scene file says, to be rendered only: as a study of images, but it needs no solvers, and
/// its target no features. A study's name or file is one too.
Study read_scene(const std::string& name_or_path, const StudyOverrides& overrides = {});
Study read_scene_text(const std::string& toml, const std::filesystem::path& source,
                      const StudyOverrides& overrides = {});

}  // namespace sightline
