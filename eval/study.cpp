// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/study.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/study_keys.h"
#include "scenes/assets.h"
#include "scenes/input_error.h"

namespace sightline {
namespace {

constexpr double kMaxTrials = 10'000'000;

// What a file is read for.
enum class Use { kTrials, kRendering };

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

void read_extraction(const TomlTable& table, ImageSetup& setup) {
  setup.extractors.line_intersection = read_extractor(
      table, "line_intersection", FeatureKind::kLineIntersection, "hough_intersection");
  setup.extractors.corner =
      read_extractor(table, "corner", FeatureKind::kCorner, "shi_tomasi_nearest");
  ExtractorOptions& options = setup.extractor_options;
  options.window_half_px =
      static_cast<int>(table.integer("window_half_px", {4, 512}, options.window_half_px));
  setup.outlier_px = table.number("outlier_px", {0.01, 1000}, 5.0);

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

void read_features(const TomlTable& table, Use use, Study& study) {
  const std::vector<std::string> known = names_of(study.target->features);
  if (known.empty() && use == Use::kRendering && !table.has("features")) return;
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

ImageSetup read_setup(const TomlTable& table, const Study& study) {
  ImageSetup setup;
  setup.scene = read_scene_law(table, study.target, study.features);
  setup.prior = read_prior(table.table("prior"));
  read_extraction(table.table("extraction"), setup);
  return setup;
}

// A key that is swept, and the values it takes, as TOML writes them.
struct SweptKey {
  std::string key;
  std::vector<std::string> values;
};

std::vector<SweptKey> read_sweep(const TomlTable& sweep) {
  constexpr size_t kMostCells = 10'000;
  std::vector<SweptKey> swept;
  size_t cells = 1;
  for (const std::string& key : sweep.keys()) {
    const std::string table = key.substr(0, key.find('.'));
    const std::vector<std::string> tables = {"camera", "image",     "background", "noise",
                                             "light",  "livery",    "motion",     "other",
                                             "prior",  "extraction"};
    if (table == key || std::find(tables.begin(), tables.end(), table) == tables.end()) {
      sweep.fail(key, fmt::format("cannot be swept, must be a quoted key of [{}], such as "
                                  "\"background.level\"",
                                  fmt::join(tables, "], [")));
    }
    swept.push_back({key, sweep.literals(key)});
    cells *= swept.back().values.size();
    if (cells > kMostCells) sweep.fail(key, fmt::format("makes over {} cells", kMostCells));
  }
  return swept;
}

// Notes a swept value in a cell's condition.
void add_value(Condition& condition, const std::string& key, const std::string& literal) {
  const TomlTable value = TomlTable::read_text("value = " + literal, key);
  const bool is_number = literal.find_first_not_of("+-.0123456789e_") == std::string::npos;
  if (is_number) {
    condition.values[key] = value.number("value");
  } else {
    condition.words[key] =
        literal.front() == '\'' || literal.front() == '"' ? value.text("value") : literal;
  }
  const std::string shown = is_number ? literal : condition.words[key];
  condition.label += fmt::format("{}{} {}", condition.label.empty() ? "" : ", ", key, shown);
}

// The cells of one set-up: one for every given pose, or one for all drawn ones.
void add_conditions(const TomlTable& table, const Condition& swept, Study& study) {
  const auto fixed = table.table("poses").tables("fixed");
  Condition cell = swept;
  cell.setup = static_cast<int>(study.setups.size()) - 1;
  if (fixed.empty()) {
    if (cell.label.empty()) cell.label = "all";
    study.conditions.push_back(cell);
  }
  for (size_t i = 0; i < fixed.size(); ++i) {
    Condition& given = study.conditions.emplace_back(cell);
    given.pose = static_cast<int>(i);
    given.label = fmt::format("pose {}{}{}", i + 1, cell.label.empty() ? "" : ", ", cell.label);
    given.values["pose"] = static_cast<double>(i + 1);
    if (cell.label.empty()) given.paper = read_paper_figures(fixed[i].table("paper"));
  }
}

// One set-up for every combination of swept values; the last key's values run fastest.
void read_setups(const TomlTable& table, Study& study) {
  const std::vector<SweptKey> swept = read_sweep(table.table("sweep"));
  std::vector<size_t> at(swept.size(), 0);
  for (bool has_more = true; has_more;) {
    Condition condition;
    std::vector<std::string> settings;
    for (size_t k = 0; k < swept.size(); ++k) {
      const std::string& value = swept[k].values[at[k]];
      settings.push_back(fmt::format("{}={}", swept[k].key, value));
      add_value(condition, swept[k].key, value);
    }
    const TomlTable set =
        swept.empty() ? table : TomlTable::read_text(table.to_toml(), table.file(), settings);
    study.setups.push_back(read_setup(set, study));
    // Swept keys are checked as others are; those that nobody reads are unknown.
    for (const char* part : {"camera", "image", "background", "noise", "light", "livery", "motion",
                             "prior", "extraction"}) {
      set.table(part).reject_unknown_keys();
    }
    for (const TomlTable& other : set.tables("other")) other.reject_unknown_keys();
    add_conditions(table, condition, study);
    has_more = false;
    for (size_t k = swept.size(); k-- > 0 && !has_more;) {
      has_more = ++at[k] < swept[k].values.size();
      if (!has_more) at[k] = 0;
    }
  }
}

void read_image_study(const TomlTable& table, Use use, Study& study) {
  if (use == Use::kTrials || table.has("solvers")) read_solvers(table, "prior", study);
  study.target = read_target(table);
  read_features(table, use, study);
  read_setups(table, study);
  if (study.setups.size() > 1) read_setup(table, study);  // the keys as they stand are read too
  study.camera = study.setups.front().scene.camera;
  study.prior = study.setups.front().prior;
  study.poses = study.setups.front().scene.poses;
  for (size_t i = 0; i < study.poses.t_m.size(); ++i) {
    read_paper_figures(table.table("poses").tables("fixed")[i].table("paper"));
  }
}

StudyKind read_kind(const TomlTable& table) {
  const std::vector<std::string> kinds = {"images", "numeric", "orientation"};
  const std::string kind = table.choice("kind", kinds, "images");
  if (kind == "numeric") return StudyKind::kNumeric;
  return kind == "orientation" ? StudyKind::kOrientation : StudyKind::kImages;
}

Study read_table(const TomlTable& table, const std::string& fallback_name, Use use) {
  Study study;
  study.kind = read_kind(table);
  if (use == Use::kRendering && study.kind != StudyKind::kImages) {
    table.fail("kind", "is of a study that renders nothing");
  }
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
      read_image_study(table, use, study);
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

Study read_file(const std::string& name_or_path, const StudyOverrides& overrides, Use use) {
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
  return read_table(TomlTable::read_file(file, settings), file.stem(), use);
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

PriorError read_prior(const TomlTable& table) {
  return {.attitude_deg = table.number("attitude_deg", {0, 90}, 2.0),
          .range_fraction = table.number("range_percent", {0, 20}, 1.0) / 100,
          .lateral_px = table.number("lateral_px", {0, 1000}, 3.0)};
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
  read_features(table, Use::kTrials, study);
}

std::vector<std::string> Study::solver_names() const {
  std::vector<std::string> names;
  for (const PoseSolver* solver : solvers) names.emplace_back(solver->name);
  for (const OrientationMethod* method : methods) names.emplace_back(method->name);
  return names;
}

Study read_study(const std::string& name_or_path, const StudyOverrides& overrides) {
  return read_file(name_or_path, overrides, Use::kTrials);
}

Study read_scene(const std::string& name_or_path, const StudyOverrides& overrides) {
  return read_file(name_or_path, overrides, Use::kRendering);
}

Study read_study_text(const std::string& toml, const std::filesystem::path& source) {
  return read_table(TomlTable::read_text(toml, source), source.stem(), Use::kTrials);
}

Study read_scene_text(const std::string& toml, const std::filesystem::path& source,
                      const StudyOverrides& overrides) {
  return read_table(TomlTable::read_text(toml, source, settings_of(overrides)), source.stem(),
                    Use::kRendering);
}

}  // namespace sightline
