// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The keys of a study of images: scene, extraction, and what of them is swept.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "eval/study/key_tables.h"
#include "eval/study/study_keys.h"
#include "eval/study/sweep_keys.h"

namespace sightline {
namespace {

// Tables of an image study whose keys can be swept, and of one whose images are a data set's.
const std::vector<std::string> kSweptOfDataset = {"prior", "extraction"};
const std::vector<std::string> kSweptTables = {"camera", "poses", "image",     "background",
                                               "noise",  "light", "livery",    "motion",
                                               "other",  "prior", "extraction"};

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

// Of keypoints alone some extractors find nothing: a study of nothing else would only fail.
void require_useful_extractors(const TomlTable& table, const ImageStudy& study,
                               const ExtractorChoice& extractors) {
  if (study.target->has_mesh()) return;
  for (const int feature : study.features) {
    if (!extractors.of(study.target->features[feature].kind).needs_mesh) return;
  }
  const FeatureKind kind = study.target->features[study.features.front()].kind;
  table.table("extraction")
      .fail(
          to_string(kind),
          fmt::format("is \"{}\", which looks for what a mesh shows, but '{}' has keypoints alone",
                      extractors.of(kind).name, study.target->name));
}

ImageSetup read_setup(const TomlTable& table, const ImageStudy& study) {
  ImageSetup setup;
  const bool is_drawn = !study.sighted;
  setup.scene =
      is_drawn ? read_scene_law(table, study.target, study.features) : dataset_scene(table, study);
  setup.prior = read_prior(table.table("prior"));
  read_extraction(table, is_drawn, setup);
  require_useful_extractors(table, study, setup.extractors);
  if (!is_drawn && setup.bias_removal != BiasRemoval::kOff) {
    table.table("extraction")
        .fail("bias_removal", "needs a rendered image: of a data set's nobody knows the light");
  }
  return setup;
}

// The cells of the last set-up, one for every given pose or one for all drawn ones, and their
// conditions.
void add_cells(const TomlTable& table, const Condition& swept, ImageStudy& study,
               std::vector<Condition>& conditions) {
  const auto fixed = table.table("poses").tables("fixed");
  const int setup = static_cast<int>(study.setups.size()) - 1;
  if (fixed.empty()) {
    study.cells.push_back({setup, 0});
    Condition& condition = conditions.emplace_back(swept);
    if (condition.label.empty()) condition.label = "all";
  }
  for (size_t i = 0; i < fixed.size(); ++i) {
    study.cells.push_back({setup, static_cast<int>(i)});
    Condition& given = conditions.emplace_back(swept);
    given.label = fmt::format("pose {}{}{}", i + 1, swept.label.empty() ? "" : ", ", swept.label);
    given.values["pose"] = static_cast<double>(i + 1);
    if (swept.label.empty()) given.paper = read_paper_figures(fixed[i].table("paper"));
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
void read_setups(const TomlTable& table, ImageStudy& study, std::vector<Condition>& conditions) {
  const std::vector<SweptCell> cells =
      read_sweeps(table, study.sighted ? kSweptOfDataset : kSweptTables);
  const std::vector<Condition> swept = conditions_of(cells);
  for (size_t i = 0; i < cells.size(); ++i) {
    std::vector<std::string> settings;
    for (const SweptValue& value : cells[i]) {
      settings.push_back(fmt::format("{}={}", value.key, value.literal));
    }
    if (cells[i].empty()) {
      study.setups.push_back(read_setup(table, study));
    } else {
      const TomlTable set = TomlTable::read_text(table.to_toml(), table.file(), settings);
      study.setups.push_back(read_setup(set, study));
      reject_unknown_scene_keys(set);
    }
    add_cells(table, swept[i], study, conditions);
  }
}

}  // namespace

ImageStudy read_image_study(const TomlTable& table, Use use, Study& common) {
  ImageStudy study;
  if (use == Use::kTrials || table.has("solvers")) study.solving = read_solving(table, "prior");
  study.target = read_target(table);
  if (const std::string reason = why_not_renderable(*study.target);
      !reason.empty() && !table.has("dataset")) {
    table.fail("target", reason);
  }
  study.features = read_features(table, use, *study.target);
  if (table.has("dataset")) {
    if (use == Use::kRendering) table.fail("dataset", "has its images already");
    study.sighted = read_dataset(table, study.target, common.draws);
  }
  read_setups(table, study, common.conditions);
  read_setup(table, study);  // the keys as they stand are checked, though all be swept
  for (size_t i = 0; i < study.pose_law().t_m.size(); ++i) {
    read_paper_figures(table.table("poses").tables("fixed")[i].table("paper"));
  }
  return study;
}

}  // namespace sightline
