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

#include "features/extractor.h"
#include "pose/absolute_orientation.h"
#include "pose/solver.h"
#include "scenes/scene.h"
#include "scenes/target.h"

namespace sightline {

/// Where a study's trials begin.
enum class StudyKind {
  kImages,       ///< at a scene that is rendered
  kNumeric,      ///< at observations: exact projections, noise and planted outliers
  kOrientation,  ///< at matched points in two frames, for the absolute orientation
};

/// A figure that a paper prints, to stand beside ours.
struct PaperFigure {
  double theta_error_deg = 0;
  double t_error_percent = 0;
};

/// One cell of a study: what all its trials share. Poses are drawn about `theta_deg` and `t_m`.
struct Condition {
  std::string label;                         ///< "pose 1", or "all" where a study has one cell
  std::map<std::string, double> values;      ///< as summary.json states it: {"pose": 1}
  std::map<std::string, PaperFigure> paper;  ///< by solver
  // What numeric and orientation studies apply in this cell.
  double noise_sd = 0;  ///< of each coordinate, pixels or metres; noise.scale applied
  int outliers = 0;     ///< points of a trial that are displaced
  int points = 0;       ///< of an orientation study's trial
};

/// A pose that is given, or the ranges that poses are drawn from (uniform, in the study's units).
struct PoseLaw {
  struct Range {
    double min = 0;
    double max = 0;
  };
  /// By condition; empty where poses are drawn. Pitch, yaw, roll in degrees; metres.
  std::vector<Eigen::Vector3d> theta_deg;
  std::vector<Eigen::Vector3d> t_m;
  /// Added to both lateral coordinates of a given pose, uniform in +-.
  double lateral_jitter_m = 0;
  bool is_attitude_uniform = false;  ///< uniform on SO(3), and drawn_angle_deg means nothing
  Range drawn_angle_deg;             ///< each of the three angles
  Range drawn_lateral_m;             ///< x and y of the target's origin
  Range drawn_range_m;               ///< z of the target's origin
  int max_redraws = 100;             ///< of a drawn pose with a feature outside the image
};

/// Where the solvers start.
enum class Start {
  kPrior,  ///< from the prior pose, as a tracker would
  kFree,   ///< from orthogonal iteration, which needs neither truth nor prior
};

/// How a numeric study displaces the points that it makes outliers, on top of their noise.
enum class OutlierLaw {
  kUniform,    ///< in a uniform direction, by a size uniform in the range
  kFixed,      ///< in a uniform direction, by the upper end of the range
  kClustered,  ///< all of a trial by one displacement, drawn as kUniform
  kSwapped,    ///< pairs of points that mirror each other in y = 0 exchange their pixels
};

struct PlantedOutliers {
  OutlierLaw law = OutlierLaw::kUniform;
  PoseLaw::Range size_px{15, 30};
};

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
  std::string solver;
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
  std::vector<int> features;  ///< indices into the target's features
  Camera camera;
  Light light;                 ///< its direction is drawn
  double light_cone_deg = 45;  ///< about the direction from the target to the camera
  double background = 0.15;
  Sensor sensor;  ///< noise.scale applied
  int samples_per_pixel = 16;
  PriorError prior;
  ExtractorChoice extractors;
  ExtractorOptions extractor_options;
  Start start = Start::kPrior;
  double outlier_px = 5;  ///< an observation farther from the truth is an outlier
  std::vector<const PoseSolver*> solvers;
  SolverOptions solver_options;

  PlantedOutliers planted;      ///< of a numeric study
  bool is_sigma_known = false;  ///< a numeric study's solvers are told the noise applied

  PointPairs pairs;  ///< of an orientation study, which has methods and no solvers
  std::vector<const OrientationMethod*> methods;

  std::string toml;  ///< the file as run, overrides applied

  /// The names of the solvers or, in an orientation study, of the methods.
  std::vector<std::string> solver_names() const;

  int64_t trial_count() const { return static_cast<int64_t>(draws) * conditions.size(); }
  /// Trials are numbered draw by draw, so that a smaller study is the beginning of a larger one.
  int condition_of(int64_t trial) const { return static_cast<int>(trial % conditions.size()); }
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

/// A study from its text as run; `source` stands for the file in errors.
Study read_study_text(const std::string& toml, const std::filesystem::path& source);

}  // namespace sightline
