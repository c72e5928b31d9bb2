// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The keys of a study of images: scene, extraction, and what of them is swept.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "eval/study/study_keys.h"
#include "eval/study/sweep_keys.h"

namespace sightline {
namespace {

// Of the mesh's triangles: a model of the target that somebody made for another purpose.
constexpr double kBiasMeshPercent = 50;

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

const FeatureExtractor* read_extractor(const TomlTable& table, const char* key, FeatureKind kind,
                                       const std::string& fallback) {
  std::vector<std::string> names;
  for (const FeatureExtractor& extractor : feature_extractors()) {
    if (extractor.finds(kind)) names.emplace_back(extractor.name);
  }
  return find_feature_extractor(table.choice(key, names, fallback));
}

// What a user would know of the sensor: its noise in the middle of the range, grey levels of 255.
double typical_noise_sd_grey(const SceneLaw& law) {
  const auto middle = [](const Range& range) { return (range.min + range.max) / 2; };
  const double read = middle(law.read_noise_grey);
  const double electrons = middle(law.full_well_electrons);
  const double photon = electrons > 0 ? 255 * std::sqrt(0.5 / electrons) : 0;
  return middle(law.gain) * law.noise_scale * std::hypot(read, photon);
}

// A data set's frames are not drawn by a law that would say their noise.
void read_extraction(const TomlTable& table, bool is_noise_known, ImageSetup& setup) {
  setup.extractors.line_intersection = read_extractor(
      table, "line_intersection", FeatureKind::kLineIntersection, "hough_intersection");
  setup.extractors.corner =
      read_extractor(table, "corner", FeatureKind::kCorner, "shi_tomasi_nearest");
  setup.extractors.contour = read_extractor(table, "contour", FeatureKind::kContour, "contour");
  setup.passes = static_cast<int>(table.integer("passes", {1, 10}, 1));
  const std::vector<std::string> removals = {"off", "wrong_light", "known_light"};
  const std::string removal = table.choice("bias_removal", removals, removals[0]);
  if (removal != "off") {
    setup.bias_removal =
        removal == "known_light" ? BiasRemoval::kKnownLight : BiasRemoval::kWrongLight;
  }
  const double kept_percent = table.number("bias_mesh_percent", {1, 100}, kBiasMeshPercent);
  if (setup.bias_removal != BiasRemoval::kOff) {
    setup.bias_target = decimated(setup.scene.target, kept_percent / 100);
  }
  ExtractorOptions& options = setup.extractor_options;
  double& noise = options.search.noise_sd_grey;
  if (is_noise_known) noise = typical_noise_sd_grey(setup.scene);
  noise = table.number("noise_sd_grey", {0, 255}, noise);
  options.window_half_px =
      static_cast<int>(table.integer("window_half_px", {4, 512}, options.window_half_px));
  LabelLimits& limits = setup.limits;
  limits.outlier_px = table.number("outlier_px", {0.01, 1000}, limits.outlier_px);
  if (table.has("outlier_sigmas")) {
    limits.outlier_sigmas = table.number("outlier_sigmas", {0.1, 1e6});
  }
  limits.line_px = table.number("line_px", {0.01, 1000}, limits.line_px);
  limits.least_contrast_grey =
      table.number("least_contrast_grey", {0, 255}, limits.least_contrast_grey);

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

ImageSetup read_setup(const TomlTable& table, const ImageStudy& study) {
  ImageSetup setup;
  const bool is_drawn = !study.sighted;
  setup.scene =
      is_drawn ? read_scene_law(table, study.target, study.features) : dataset_scene(table, study);
  setup.prior = read_prior(table.table("prior"));
  const TomlTable extraction = table.table("extraction");
  read_extraction(extraction, is_drawn, setup);
  if (!is_drawn && setup.bias_removal != BiasRemoval::kOff) {
    extraction.fail("bias_removal",
                    "needs a rendered image: of a data set's nobody knows the light");
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
