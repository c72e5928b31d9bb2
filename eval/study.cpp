// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/study.h"

#include <algorithm>
#include <numbers>
#include <set>

#include <fmt/format.h>

#include "eval/study_keys.h"
#include "pose/attitude.h"
#include "scenes/assets.h"
#include "scenes/input_error.h"

namespace sightline {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kMaxTrials = 10'000'000;

std::map<std::string, PaperFigure> read_paper_figures(const TomlTable& table) {
  std::map<std::string, PaperFigure> figures;
  for (const std::string& solver : names_of(pose_solvers())) {
    if (!table.has(solver)) continue;
    const std::vector<double> pair = table.numbers(solver, 2);
    if (!(std::min(pair[0], pair[1]) >= 0) || std::max(pair[0], pair[1]) > 180) {
      table.fail(solver, fmt::format("is [{}, {}], must be [degrees, percent] from 0 to 180",
                                     pair[0], pair[1]));
    }
    figures[solver] = {pair[0], pair[1]};
  }
  return figures;
}

void read_fixed_poses(const std::vector<TomlTable>& fixed, Study& study) {
  for (size_t i = 0; i < fixed.size(); ++i) {
    study.poses.theta_deg.push_back(fixed[i].vector3("theta_deg"));
    study.poses.t_m.push_back(fixed[i].vector3("t_m"));
    study.conditions.push_back({.label = fmt::format("pose {}", i + 1),
                                .values = {{"pose", static_cast<double>(i + 1)}},
                                .paper = read_paper_figures(fixed[i].table("paper"))});
  }
}

void read_poses(const TomlTable& table, Study& study) {
  const auto fixed = table.tables("fixed");
  PoseLaw& law = study.poses;
  law.lateral_jitter_m = table.number("lateral_jitter_m", {0, 1e6}, 0.0);
  law.max_redraws = static_cast<int>(table.integer("max_redraws", {0, 100000}, law.max_redraws));
  if (!fixed.empty()) {
    for (const char* key : {"angle_deg", "lateral_m", "range_m", "max_redraws"}) {
      if (table.has(key))
        table.fail(key, "cannot stand beside [[poses.fixed]]: give one or the other");
    }
    read_fixed_poses(fixed, study);
    return;
  }
  if (!table.has("range_m")) {
    table.fail("fixed",
               "is missing: give [[poses.fixed]], or the ranges angle_deg, lateral_m and "
               "range_m to draw from");
  }
  if (table.has("lateral_jitter_m")) table.fail("lateral_jitter_m", "belongs to [[poses.fixed]]");
  law.drawn_angle_deg = read_range(table, "angle_deg", {-180, 180});
  read_position_ranges(table, study);
  study.conditions.push_back({.label = "all", .values = {}, .paper = {}});
}

void read_image(const TomlTable& image, const TomlTable& noise, Study& study) {
  study.samples_per_pixel = static_cast<int>(image.integer("samples_per_pixel", {1, 64}, 16));
  const std::set<int> allowed = {1, 4, 16, 64};
  if (!allowed.contains(study.samples_per_pixel)) {
    image.fail("samples_per_pixel",
               fmt::format("is {}, must be 1, 4, 16 or 64", study.samples_per_pixel));
  }
  study.background = image.number("background", {0, 1}, 0.15);
  study.sensor.psf_sigma_px = image.number("psf_sigma_px", {0, 50}, 0.7);
  study.sensor.bits = static_cast<int>(image.integer("bits", {1, 16}, 8));
  const double scale = noise.number("scale", {0, 1000}, 1.0);
  study.sensor.read_noise_grey = scale * noise.number("read_noise_grey", {0, 255}, 3.0);
  const double electrons = noise.number("full_well_electrons", {0, 1e9}, 0.0);
  study.sensor.full_well_electrons = scale > 0 ? electrons / (scale * scale) : 0;
}

void read_light(const TomlTable& table, Study& study) {
  study.light.ambient = table.number("ambient", {0, 1}, 0.30);
  study.light.directional = table.number("directional", {0, 1}, 0.75);
  study.light_cone_deg = table.number("cone_deg", {0, 180}, 45.0);
}

void read_outlier_options(const TomlTable& table, OutlierOptions& options) {
  options.probability = table.number("outlier_probability", {1e-9, 0.5}, options.probability);
  options.scale_px = table.number("outlier_scale_px", {1e-3, 1e6}, options.scale_px);
  options.false_alarm_rate =
      table.number("false_alarm_rate", {1e-9, 0.5}, options.false_alarm_rate);
  if (table.has("max_removed")) {
    options.max_removed = static_cast<int>(table.integer("max_removed", {0, 10000}));
  }
}

const FeatureExtractor* read_extractor(const TomlTable& table, const char* key, FeatureKind kind,
                                       const std::string& fallback) {
  std::vector<std::string> names;
  for (const FeatureExtractor& extractor : feature_extractors()) {
    if (extractor.kind == kind) names.emplace_back(extractor.name);
  }
  return find_feature_extractor(table.choice(key, names, fallback));
}

void read_extraction(const TomlTable& table, Study& study) {
  study.extractors.line_intersection = read_extractor(
      table, "line_intersection", FeatureKind::kLineIntersection, "hough_intersection");
  study.extractors.corner =
      read_extractor(table, "corner", FeatureKind::kCorner, "shi_tomasi_nearest");
  ExtractorOptions& options = study.extractor_options;
  options.window_half_px =
      static_cast<int>(table.integer("window_half_px", {4, 512}, options.window_half_px));
  study.outlier_px = table.number("outlier_px", {0.01, 1000}, 5.0);

  const TomlTable lines = table.table("lines");
  LineOptions& line = options.line;
  line.direction_tolerance_deg =
      lines.number("direction_tolerance_deg", {0.1, 90}, line.direction_tolerance_deg);
  line.min_votes = static_cast<int>(lines.integer("min_votes", {2, 1000}, line.min_votes));
  line.min_edge_pixels =
      static_cast<int>(lines.integer("min_edge_pixels", {3, 1000}, line.min_edge_pixels));
  line.min_angle_deg = lines.number("min_angle_deg", {1, 89}, line.min_angle_deg);
  line.canny_low = lines.number("canny_low", {1, 2000}, line.canny_low);
  line.canny_high = lines.number("canny_high", {line.canny_low, 2000}, line.canny_high);

  const TomlTable corners = table.table("corners");
  CornerOptions& corner = options.corner;
  corner.max_corners =
      static_cast<int>(corners.integer("max_corners", {1, 1000}, corner.max_corners));
  corner.quality = corners.number("quality", {0.001, 1}, corner.quality);
  corner.min_contrast_grey =
      corners.number("min_contrast_grey", {0, 255}, corner.min_contrast_grey);
  corner.min_distance_px = corners.number("min_distance_px", {0, 100}, corner.min_distance_px);
  corner.block_px = static_cast<int>(corners.integer("block_px", {3, 31}, corner.block_px));
}

std::shared_ptr<const Target> read_target(const TomlTable& table) {
  const std::string name = table.text("target");
  try {
    return load_target(name);
  } catch (const InputError& error) {
    table.fail("target", fmt::format("cannot be used: {}", error.what()));
  }
}

void read_features(const TomlTable& table, Study& study) {
  const std::vector<std::string> known = names_of(study.target->features);
  if (known.empty()) {
    table.fail("target", fmt::format("'{}' has no features; a target.toml beside its mesh gives "
                                     "it some",
                                     study.target->name));
  }
  std::set<size_t> seen;
  for (const std::string& name : table.texts("features", known)) {
    const size_t index = index_of(name, known, table, "features");
    if (!seen.insert(index).second) {
      table.fail("features", fmt::format("holds \"{}\" twice", name));
    }
    study.features.push_back(static_cast<int>(index));
  }
  if (study.features.empty()) table.fail("features", "is empty, must name at least one");
}

// A given pose that cannot be imaged is the user's error, not a failed trial.
void require_imageable(const TomlTable& table, const Study& study) {
  for (size_t i = 0; i < study.poses.t_m.size(); ++i) {
    const Eigen::Vector3d theta = study.poses.theta_deg[i] * kDegree;
    Scene scene;
    scene.target = study.target;
    scene.camera = study.camera;
    scene.cam_from_target = {rotation_from_attitude({theta.x(), theta.y(), theta.z()}),
                             study.poses.t_m[i]};
    const std::string reason = why_not_imageable(scene);
    if (!reason.empty()) table.fail(fmt::format("fixed[{}]", i), "cannot be imaged: " + reason);
  }
}

std::vector<std::string> settings_of(const StudyOverrides& overrides) {
  std::vector<std::string> settings = overrides.set;
  if (overrides.trials) settings.push_back(fmt::format("trials={}", *overrides.trials));
  if (overrides.seed) settings.push_back(fmt::format("seed={}", *overrides.seed));
  return settings;
}

// The name becomes that of a folder.
void require_file_name(const TomlTable& table, const std::string& name) {
  const std::string allowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_.";
  if (name.empty() || name[0] == '.' || name.find_first_not_of(allowed) != std::string::npos) {
    table.fail("name", fmt::format("is \"{}\", must be letters, digits, '-', '_' and '.'", name));
  }
}

void read_image_study(const TomlTable& table, Study& study) {
  study.camera = read_camera(table.table("camera"));
  const TomlTable poses = table.table("poses");
  read_poses(poses, study);
  read_image(table.table("image"), table.table("noise"), study);
  read_light(table.table("light"), study);
  read_prior(table.table("prior"), study);
  read_extraction(table.table("extraction"), study);
  read_solvers(table, "prior", study);
  read_target_and_features(table, study);
  table.reject_unknown_keys();
  require_imageable(poses, study);
}

StudyKind read_kind(const TomlTable& table) {
  const std::vector<std::string> kinds = {"images", "numeric", "orientation"};
  const std::string kind = table.choice("kind", kinds, "images");
  if (kind == "numeric") return StudyKind::kNumeric;
  return kind == "orientation" ? StudyKind::kOrientation : StudyKind::kImages;
}

Study read_table(const TomlTable& table, const std::string& fallback_name) {
  Study study;
  study.kind = read_kind(table);
  study.name = table.text("name", fallback_name);
  require_file_name(table, study.name);
  study.title = table.text("title", study.name);
  study.question = table.text("question", "");
  study.reference = table.text("reference", "");
  study.claim = table.text("claim", "");
  study.seed = static_cast<uint64_t>(table.integer("seed", {0, 9e15}, 1));
  study.draws = static_cast<int>(table.integer("trials", {1, kMaxTrials}, 100));
  switch (study.kind) {
    case StudyKind::kImages:
      read_image_study(table, study);
      break;
    case StudyKind::kNumeric:
      read_numeric_study(table, study);
      break;
    case StudyKind::kOrientation:
      read_orientation_study(table, study);
      break;
  }
  table.reject_unknown_keys();
  study.toml = table.to_toml();
  return study;
}

}  // namespace

size_t index_of(const std::string& name, const std::vector<std::string>& names,
                const TomlTable& table, const char* key) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    table.fail(key, fmt::format("holds \"{}\"{}", name, suggestion(name, names)));
  }
  return static_cast<size_t>(found - names.begin());
}

Camera read_camera(const TomlTable& table) {
  const int width = static_cast<int>(table.integer("width_px", {16, 16384}, 512));
  const int height = static_cast<int>(table.integer("height_px", {16, 16384}, 512));
  return centred_camera(width, height, table.number("f_px", {1, 1e7}));
}

PoseLaw::Range read_range(const TomlTable& table, const char* key, PoseLaw::Range allowed) {
  const std::vector<double> ends = table.numbers(key, 2);
  if (!(ends[0] <= ends[1]) || ends[0] < allowed.min || ends[1] > allowed.max) {
    table.fail(key, fmt::format("is [{}, {}], must be [low, high] between {} and {}", ends[0],
                                ends[1], allowed.min, allowed.max));
  }
  return {ends[0], ends[1]};
}

void read_position_ranges(const TomlTable& poses, Study& study) {
  study.poses.drawn_lateral_m = read_range(poses, "lateral_m", {-1e6, 1e6});
  study.poses.drawn_range_m = read_range(poses, "range_m", {1e-3, 1e9});
}

void read_prior(const TomlTable& table, Study& study) {
  study.prior.attitude_deg = table.number("attitude_deg", {0, 90}, 2.0);
  study.prior.range_fraction = table.number("range_percent", {0, 20}, 1.0) / 100;
  study.prior.lateral_px = table.number("lateral_px", {0, 1000}, 3.0);
}

void read_solvers(const TomlTable& table, const std::string& default_start, Study& study) {
  const std::vector<std::string> known = names_of(pose_solvers());
  std::set<std::string> seen;
  for (const std::string& name : table.texts("solvers")) {
    study.solvers.push_back(&pose_solvers()[index_of(name, known, table, "solvers")]);
    if (!seen.insert(name).second) {
      table.fail("solvers", fmt::format("holds \"{}\" twice", name));
    }
  }
  if (study.solvers.empty()) table.fail("solvers", "is empty, must name at least one solver");

  const TomlTable options = table.table("solver");
  const std::vector<std::string> starts = {"prior", "free"};
  study.start =
      options.choice("start", starts, default_start) == "prior" ? Start::kPrior : Start::kFree;
  OrpeOptions& orpe = study.solver_options.orpe;
  orpe.rho = options.number("rho", {1, 1e9}, orpe.rho);
  const std::vector<std::string> finals = {"minimax", "least_squares"};
  orpe.final = options.choice("final", finals, finals[0]) == finals[0]
                   ? OrpeOptions::Final::kMinimax
                   : OrpeOptions::Final::kLeastSquares;
  read_outlier_options(options, study.solver_options.outliers);
}

void read_target_and_features(const TomlTable& table, Study& study) {
  study.target = read_target(table);
  read_features(table, study);
}

std::vector<std::string> Study::solver_names() const {
  std::vector<std::string> names;
  for (const PoseSolver* solver : solvers) names.emplace_back(solver->name);
  for (const OrientationMethod* method : methods) names.emplace_back(method->name);
  return names;
}

Study read_study(const std::string& name_or_path, const StudyOverrides& overrides) {
  const std::filesystem::path file = find_study_file(name_or_path);
  std::vector<std::string> settings = settings_of(overrides);
  const TomlTable as_written = TomlTable::read_file(file, settings);
  // The study as run stands on its own: it says its name, and where a target beside it lies.
  if (!as_written.has("name")) settings.push_back(fmt::format("name='{}'", file.stem().string()));
  const std::filesystem::path target = as_written.text("target", "");
  const std::filesystem::path beside = std::filesystem::absolute(file).parent_path() / target;
  if (target.is_relative() && target.has_extension() && std::filesystem::exists(beside)) {
    settings.push_back(fmt::format("target='{}'", beside.lexically_normal().string()));
  }
  return read_table(TomlTable::read_file(file, settings), file.stem());
}

Study read_study_text(const std::string& toml, const std::filesystem::path& source) {
  return read_table(TomlTable::read_text(toml, source), source.stem());
}

}  // namespace sightline
