// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/study/study.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "eval/study/key_tables.h"
#include "eval/study/study_keys.h"
#include "scenes/files/assets.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

constexpr double kMaxTrials = 10'000'000;
constexpr const char* kAllFeatures = "all";

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

std::vector<PoseInput> read_inputs(const TomlTable& table) {
  std::vector<std::string> known;
  for (const PoseInput input : {PoseInput::kExact, PoseInput::kNoise, PoseInput::kInliers}) {
    known.emplace_back(to_string(input));
  }
  std::set<size_t> chosen;  // in the order of their steps
  for (const std::string& name : table.texts("inputs", std::vector<std::string>{})) {
    if (!chosen.insert(index_of(name, known, table, "inputs")).second) {
      table.fail("inputs", fmt::format("holds \"{}\" twice", name));
    }
  }
  std::vector<PoseInput> inputs;
  for (const size_t i : chosen) inputs.push_back(static_cast<PoseInput>(i));
  return inputs;
}

// What a user would know of the sensor: its noise in the middle of the range, grey levels of 255.
double typical_noise_sd_grey(const SensorLaw& law) {
  const auto middle = [](const Range& range) { return (range.min + range.max) / 2; };
  const double read = middle(law.read_noise_grey);
  const double electrons = middle(law.full_well_electrons);
  const double photon = electrons > 0 ? 255 * std::sqrt(0.5 / electrons) : 0;
  return middle(law.gain) * law.noise_scale * std::hypot(read, photon);
}

// A data set's frames are not drawn by a law that would say their noise.
void read_extraction(const TomlTable& file, bool is_noise_known, ImageSetup& setup) {
  setup.extractors = default_extractors();
  if (is_noise_known) {
    setup.extractor_options.search.noise_sd_grey = typical_noise_sd_grey(setup.scene.sensor);
  }
  double mesh_fraction = kBiasMeshFraction;
  // The lower threshold bounds the upper one, so that it is read before the table is made anew.
  read_key(file.table("extraction").table("lines"),
           find_key(extraction_keys(setup, mesh_fraction), "canny_low"));
  read_keys(file, extraction_keys(setup, mesh_fraction));
  if (setup.bias_removal != BiasRemoval::kOff) {
    setup.bias_target = decimated(setup.scene.target, mesh_fraction);
  }
}

std::shared_ptr<const Target> read_target(const TomlTable& table) {
  const std::string name = table.text("target");
  try {
    return load_target(name);
  } catch (const InputError& error) {
    table.fail("target", fmt::format("cannot be used: {}", error.what()));
  }
}

// An array of names, or the word for all, which is meant without the key too.
std::vector<std::string> read_feature_names(const TomlTable& table,
                                            const std::vector<std::string>& known) {
  if (!table.is_text("features")) return table.texts("features", known);
  const std::string word = table.text("features");
  if (word == kAllFeatures) return known;
  table.fail("features", fmt::format("is \"{}\", must be \"{}\" or an array of names (known: {})",
                                     word, kAllFeatures, fmt::join(known, ", ")));
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
  for (const std::string& name : read_feature_names(table, known)) {
    const size_t index = index_of(name, known, table, "features");
    if (!seen.insert(index).second) {
      table.fail("features", fmt::format("holds \"{}\" twice", name));
    }
    study.features.push_back(static_cast<int>(index));
  }
  if (study.features.empty()) table.fail("features", "is empty, must name at least one");
}

// The file as run. The word for all features is written out as their names: a run says what it
// looked for, whatever its target is given later.
std::string text_as_run(const TomlTable& table, const Study& study) {
  if (study.target == nullptr || !table.is_text("features")) return table.to_toml();
  const std::vector<std::string> names = names_of(study.target->features);
  const std::vector<std::string> settings = {"features=" + nlohmann::json(names).dump()};
  return TomlTable::read_text(table.to_toml(), table.file(), settings).to_toml();
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
  const bool is_drawn = study.sightings == nullptr;
  setup.scene =
      is_drawn ? read_scene_law(table, study.target, study.features) : dataset_scene(table, study);
  setup.prior = read_prior(table.table("prior"));
  read_extraction(table, is_drawn, setup);
  if (!is_drawn && setup.bias_removal != BiasRemoval::kOff) {
    table.table("extraction")
        .fail("bias_removal", "needs a rendered image: of a data set's nobody knows the light");
  }
  return setup;
}

// A key that is swept, and the values it takes, as TOML writes them.
struct SweptKey {
  std::string key;
  std::vector<std::string> values;
};

// Tables of an image study whose keys can be swept, and of one whose images are a data set's.
const std::vector<std::string> kSweptOfDataset = {"prior", "extraction"};
const std::vector<std::string> kSweptTables = {"camera", "poses", "image",     "background",
                                               "noise",  "light", "livery",    "motion",
                                               "other",  "prior", "extraction"};

std::vector<SweptKey> read_sweep(const TomlTable& sweep, const std::vector<std::string>& tables) {
  constexpr size_t kMostCells = 10'000;
  std::vector<SweptKey> swept;
  size_t cells = 1;
  for (const std::string& key : sweep.keys()) {
    const std::string table = key.substr(0, key.find('.'));
    const bool is_known =
        table != key && std::find(tables.begin(), tables.end(), table) != tables.end();
    if (!is_known || key == "poses.fixed") {
      sweep.fail(key, fmt::format("cannot be swept, must be a quoted key of [{}], such as "
                                  "\"prior.attitude_deg\"",
                                  fmt::join(tables, "], [")));
    }
    swept.push_back({key, sweep.literals(key)});
    cells *= swept.back().values.size();
    if (cells > kMostCells) sweep.fail(key, fmt::format("makes over {} cells", kMostCells));
  }
  return swept;
}

// One value of every key of a sweep.
struct SweptValue {
  std::string key;
  std::string literal;
};

// All combinations; the last key's values run fastest.
std::vector<std::vector<SweptValue>> combinations(const std::vector<SweptKey>& swept) {
  std::vector<std::vector<SweptValue>> all = {{}};
  for (const SweptKey& key : swept) {
    std::vector<std::vector<SweptValue>> longer;
    for (const std::vector<SweptValue>& begun : all) {
      for (const std::string& value : key.values) {
        longer.push_back(begun);
        longer.back().push_back({key.key, value});
      }
    }
    all = std::move(longer);
  }
  return all;
}

// [sweep] is one sweep, [[sweep]] several, whose cells follow each other.
std::vector<std::vector<SweptValue>> read_sweeps(const TomlTable& table,
                                                 const std::vector<std::string>& tables) {
  if (!table.is_array("sweep")) return combinations(read_sweep(table.table("sweep"), tables));
  std::vector<std::vector<SweptValue>> cells;
  for (const TomlTable& sweep : table.tables("sweep")) {
    for (auto& cell : combinations(read_sweep(sweep, tables))) cells.push_back(std::move(cell));
  }
  return cells;
}

bool is_text(const std::string& literal) {
  return literal.front() == '\'' || literal.front() == '"';
}

// The keys that a study sweeps.
struct SweptKeys {
  std::set<std::string> all;
  std::set<std::string> of_words;
};

// What stands for a swept value in a condition's label: its key and the value, or a word alone
// where words are of one key. Where several are swept at once the key lacks its table, unless
// another ends alike.
std::string label_of(const SweptValue& swept, const std::string& shown, bool is_alone,
                     const SweptKeys& keys) {
  if (is_text(swept.literal) && keys.of_words.size() == 1) return shown;
  const auto last_part = [](const std::string& key) { return key.substr(key.rfind('.') + 1); };
  const std::string last = last_part(swept.key);
  const bool is_unique = std::none_of(keys.all.begin(), keys.all.end(), [&](const auto& key) {
    return key != swept.key && last_part(key) == last;
  });
  return fmt::format("{} {}", !is_alone && is_unique ? last : swept.key, shown);
}

// Notes a swept value in a cell's condition.
void add_value(Condition& condition, const SweptValue& swept, bool is_alone,
               const SweptKeys& keys) {
  const TomlTable value = TomlTable::read_text("value = " + swept.literal, swept.key);
  const bool is_number = swept.literal.find_first_not_of("+-.0123456789e_") == std::string::npos;
  std::string shown = swept.literal;
  std::erase(shown, ' ');  // of a list
  if (is_number) {
    condition.values[swept.key] = value.number("value");
  } else {
    if (is_text(swept.literal)) shown = value.text("value");
    condition.words[swept.key] = shown;
  }
  const std::string label = label_of(swept, shown, is_alone, keys);
  if (condition.label.empty()) {
    condition.label = label;
  } else if (is_text(swept.literal)) {  // words lead
    condition.label = fmt::format("{}, {}", label, condition.label);
  } else {
    condition.label += ", " + label;
  }
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

// Swept keys are checked as all others are: those that nobody reads are unknown.
void reject_unknown_scene_keys(const TomlTable& table) {
  for (const std::string& name : kSweptTables) {
    if (name == "other") {
      for (const TomlTable& other : table.tables(name)) other.reject_unknown_keys();
    } else if (name != "poses") {
      table.table(name).reject_unknown_keys();
    }
  }
}

// A set-up for every cell of the sweeps.
void read_setups(const TomlTable& table, Study& study) {
  const std::vector<std::vector<SweptValue>> cells =
      read_sweeps(table, study.sightings ? kSweptOfDataset : kSweptTables);
  SweptKeys keys;
  for (const auto& cell : cells) {
    for (const SweptValue& swept : cell) {
      keys.all.insert(swept.key);
      if (is_text(swept.literal)) keys.of_words.insert(swept.key);
    }
  }
  for (const std::vector<SweptValue>& cell : cells) {
    Condition condition;
    std::vector<std::string> settings;
    for (const SweptValue& swept : cell) {
      settings.push_back(fmt::format("{}={}", swept.key, swept.literal));
      add_value(condition, swept, cell.size() == 1, keys);
    }
    if (cell.empty()) {
      study.setups.push_back(read_setup(table, study));
    } else {
      const TomlTable set = TomlTable::read_text(table.to_toml(), table.file(), settings);
      study.setups.push_back(read_setup(set, study));
      reject_unknown_scene_keys(set);
    }
    add_conditions(table, condition, study);
  }
}

void read_image_study(const TomlTable& table, Use use, Study& study) {
  if (use == Use::kTrials || table.has("solvers")) read_solvers(table, "prior", study);
  study.target = read_target(table);
  read_features(table, use, study);
  if (table.has("dataset")) {
    if (use == Use::kRendering) table.fail("dataset", "has its images already");
    read_dataset(table, study);
  }
  read_setups(table, study);
  read_setup(table, study);  // the keys as they stand are checked, though all be swept
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
  study.toml = text_as_run(table, study);
  return study;
}

Study read_file(const std::string& name_or_path, const StudyOverrides& overrides, Use use) {
  const std::filesystem::path file = find_study_file(name_or_path);
  std::vector<std::string> settings = settings_of(overrides);
  const TomlTable as_written = TomlTable::read_file(file, settings);
  // The study as run stands on its own: it says its name, and where what lies beside it is.
  if (!as_written.has("name")) settings.push_back(fmt::format("name='{}'", file.stem().string()));
  const auto place_beside = [&](const std::string& key, const std::filesystem::path& given) {
    const std::filesystem::path beside = std::filesystem::absolute(file).parent_path() / given;
    if (given.empty() || !given.is_relative() || !std::filesystem::exists(beside)) return;
    settings.push_back(fmt::format("{}='{}'", key, beside.lexically_normal().string()));
  };
  const std::filesystem::path target = as_written.text("target", "");
  if (target.has_extension()) place_beside("target", target);
  for (const char* key : {"path", "priors"}) {
    place_beside(fmt::format("dataset.{}", key), as_written.table("dataset").text(key, ""));
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

  study.start = default_start == "prior" ? Start::kPrior : Start::kFree;
  read_keys(table, solver_keys(study.start, study.solver_options));
  study.inputs = read_inputs(table.table("solver"));
}

void read_target_and_features(const TomlTable& table, Study& study) {
  study.target = read_target(table);
  read_features(table, Use::kTrials, study);
}

std::string_view to_string(PoseInput input) {
  constexpr std::string_view kNames[] = {"exact", "noise", "inliers"};
  return kNames[static_cast<int>(input)];
}

std::string name_with(std::string_view solver, PoseInput input) {
  return fmt::format("{}/{}", solver, to_string(input));
}

std::vector<std::string> Study::solver_names() const {
  std::vector<std::string> names;
  for (const PoseSolver* solver : solvers) names.emplace_back(solver->name);
  for (const PoseInput input : inputs) {
    for (const PoseSolver* solver : solvers) {
      if (!solver->evaluation_only) names.push_back(name_with(solver->name, input));
    }
  }
  for (const OrientationMethod* method : methods) names.emplace_back(method->name);
  return names;
}

Study read_study(const std::string& name_or_path, const StudyOverrides& overrides) {
  return read_file(name_or_path, overrides, Use::kTrials);
}

Study read_scene(const std::string& name_or_path, const StudyOverrides& overrides) {
  return read_file(name_or_path, overrides, Use::kRendering);
}

Study read_study_text(const std::string& toml, const std::filesystem::path& source,
                      const StudyOverrides& overrides) {
  return read_table(TomlTable::read_text(toml, source, settings_of(overrides)), source.stem(),
                    Use::kTrials);
}

Study read_scene_text(const std::string& toml, const std::filesystem::path& source,
                      const StudyOverrides& overrides) {
  return read_table(TomlTable::read_text(toml, source, settings_of(overrides)), source.stem(),
                    Use::kRendering);
}

}  // namespace sightline
