// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The keys of a study of images: scene, extraction, and what of them is swept.
#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "eval/doors/image_bound_solver.h"
#include "eval/doors/registration_solver.h"
#include "eval/study/key_tables.h"
#include "eval/study/study_keys.h"
#include "eval/study/sweep_keys.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

// Tables of an image study whose keys can be swept, and of one whose images are a data set's.
const std::vector<std::string> kSweptOfDataset = {"prior", "extraction"};
const std::vector<std::string> kSweptTables = {
    "camera", "poses",    "image",  "background", "noise", "light", "lamp",      "environment",
    "livery", "material", "motion", "optics",     "other", "prior", "extraction"};

// What sets cells apart whose extractors differ.
constexpr const char* kSweptExtractor = "extractor";

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
  JointEdges& joint_edges = setup.extractor_options.joint_edges;
  // What the scene draws on a target looks like edges as its own print does.
  if (joint_edges == JointEdges::kTextured && !setup.scene.materials.textures.empty()) {
    joint_edges = JointEdges::kOn;
  }
  const bool is_drawn_grey = is_noise_known && setup.scene.colouring.mode == ColourMode::kGrey;
  if (is_drawn_grey && setup.channel == ExtractedChannel::kContrast) {
    file.table("extraction")
        .fail("channel", "is \"contrast\", which needs image.colour = \"rgb\" or \"bayer\"");
  }
  const bool is_noise_given = file.table("extraction").has("noise_sd_grey");
  if (is_noise_known || is_noise_given) {
    setup.registration.noise_sd_grey = setup.extractor_options.search.noise_sd_grey;
  }
  if (setup.registration.use != RegistrationUse::kOff) {
    setup.registration.mesh = registration_mesh(setup.scene.target, setup.registration);
  }
  if (setup.bias_removal != BiasRemoval::kOff) {
    setup.bias_target = decimated(setup.scene.target, mesh_fraction);
  }
}

// The pictures that the study's trials show, or as many as guests need to know.
ShownPictures pictures_of(const ImageStudy& study, const SceneLaw& law, const Study& common) {
  std::vector<ShownTarget> shown;
  if (study.sighted) {
    const auto& sightings = study.sighted->set->sightings;
    for (const Sighting& s : sightings) {
      shown.push_back({{s.scene_id, s.im_id}, s.gt_id, s.image, s.camera, s.cam_from_target});
    }
    return {*study.target, std::move(shown), [&sightings](PictureName picture) {
              return has_picture(sightings, picture.scene_id, picture.im_id);
            }};
  }
  // Of more pictures than these the noise of observations need not be known.
  constexpr int64_t kMostPictures = 1000;
  const int64_t poses = std::max<int64_t>(1, static_cast<int64_t>(law.poses.t_m.size()));
  for (int64_t draw = 0; draw < std::min(common.draws * poses, kMostPictures); ++draw) {
    const DrawnScene drawn = draw_scene(law, static_cast<int>(draw % poses), common.seed, draw);
    shown.push_back({{0, draw}, 0, "", drawn.scene.camera, drawn.scene.cam_from_target});
  }
  return {*study.target, std::move(shown),
          [](PictureName picture) { return picture.scene_id == 0; }};
}

// Who finds the features: guests by their name, one of the program's own for all kinds of features
// that it can find, or for each kind the one that [extraction] names.
void choose_extractor(const std::string& name, const ImageStudy& study, const Study& common,
                      GuestExtractors& guests, ImageSetup& setup) {
  if (const FeatureExtractor* const own = find_feature_extractor(name)) {
    setup.extractors.choose(*own);
  } else if (name != kExtractorsByKind) {
    try {
      setup.guest = guests.find(name, [&] { return pictures_of(study, setup.scene, common); });
    } catch (const InputError& error) {
      throw InputError(fmt::format("observations {}: {}", name, error.what()));
    }
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
    if (name == "other" || name == "lamp") {
      for (const TomlTable& one : table.tables(name)) one.reject_unknown_keys();
    } else if (name != "poses") {
      table.table(name).reject_unknown_keys();
    }
  }
}

// The set-up of a cell.
ImageSetup read_swept_setup(const TomlTable& table, const SweptCell& cell,
                            const ImageStudy& study) {
  ImageSetup setup;
  with_swept_values(table, cell, [&](const TomlTable& set) {
    setup = read_setup(set, study);
    if (!cell.empty()) reject_unknown_scene_keys(set);
  });
  return setup;
}

// Each cell of the sweeps once for every extractor; where there is but one it sets nothing apart.
std::vector<SweptCell> with_extractors(const std::vector<SweptCell>& swept,
                                       const std::vector<std::string>& names) {
  if (names.size() == 1) return swept;
  std::vector<SweptCell> cells;
  for (const SweptCell& cell : swept) {
    for (const std::string& name : names) {
      cells.push_back(cell);
      cells.back().push_back({kSweptExtractor, fmt::format("'{}'", name)});
    }
  }
  return cells;
}

// Files of observations are about one set of pictures.
void require_one_set_of_pictures(const TomlTable& table, const ImageStudy& study,
                                 const std::vector<SweptCell>& swept) {
  if (study.sighted) return;
  for (const SweptValue& value : swept.front()) {
    const std::string changed = value.key.substr(0, value.key.find('.'));
    if (changed == "prior" || changed == "extraction") continue;
    table.fail("observations", fmt::format("cannot stand beside a sweep of {}: each of its values "
                                           "makes other pictures",
                                           value.key));
  }
}

// Set-ups that name one panorama hold it once: each has a hundred megabytes.
void share_panorama(const std::vector<ImageSetup>& before, ImageSetup& setup) {
  EnvironmentLaw& own = setup.scene.environment;
  for (const ImageSetup& other : before) {
    const EnvironmentLaw& law = other.scene.environment;
    if (own.light != nullptr && law.file == own.file) own.light = law.light;
  }
}

// A set-up for every cell of the sweeps, once for every extractor.
void read_setups(const TomlTable& table, ImageStudy& study, Study& common,
                 GuestExtractors& guests) {
  const std::vector<SweptCell> swept =
      read_sweeps(table, study.sighted ? kSweptOfDataset : kSweptTables);
  if (guests.are_files_among()) require_one_set_of_pictures(table, study, swept);
  const std::vector<std::string> names = read_extractor_names(table, guests);
  const std::vector<SweptCell> cells = with_extractors(swept, names);
  const std::vector<Condition> conditions = conditions_of(cells);
  for (size_t i = 0; i < cells.size(); ++i) {
    SweptCell keys = cells[i];
    std::erase_if(keys, [](const SweptValue& value) { return value.key == kSweptExtractor; });
    ImageSetup read = read_swept_setup(table, keys, study);
    share_panorama(study.setups, read);
    study.setups.push_back(std::move(read));
    ImageSetup& setup = study.setups.back();
    choose_extractor(names[i % names.size()], study, common, guests, setup);
    if (!setup.guest) require_useful_extractors(table, study, setup.extractors);
    add_cells(table, conditions[i], study, common.conditions);
  }
}

// The guests, the registrations that [extraction] asks for, and the image's own bounds.
std::vector<TrialSolver> solvers_beside(const TomlTable& table, uint64_t seed,
                                        std::vector<TrialSolver> guests) {
  RegistrationUse use = RegistrationUse::kOff;
  read_key(table.table("extraction"), registration_key(use));
  for (TrialSolver& solver : registration_solvers(use)) guests.push_back(std::move(solver));
  bool has_image_bound = false;
  read_keys(table, bound_keys(has_image_bound));
  if (has_image_bound && table.has("dataset")) {
    table.table("bound").fail("image", "needs rendered images: nobody knows a data set's light");
  }
  if (has_image_bound) {
    for (TrialSolver& bound : image_bound_solvers(seed)) guests.push_back(std::move(bound));
  }
  return guests;
}

// Every cell has the same solvers.
void require_one_registration(const TomlTable& table, const ImageStudy& study) {
  for (const ImageSetup& setup : study.setups) {
    if (setup.registration.use == study.setups.front().registration.use) continue;
    table.table("sweep").fail("extraction.registration",
                              "cannot be swept: \"both\" has both in every cell");
  }
}

}  // namespace

ImageStudy read_image_study(const TomlTable& table, Use use, Study& common, const Guests& guests) {
  ImageStudy study;
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
  if (use == Use::kTrials || table.has("solvers") || table.table("external").has("solver")) {
    const SightedSet* const set = study.sighted ? study.sighted->set.get() : nullptr;
    study.solving = read_solving(
        table, "prior",
        solvers_beside(table, common.seed, read_guest_solvers(table, set, guests.solvers)));
  }
  GuestExtractors extractors(table, guests.extractors);
  read_setups(table, study, common, extractors);
  require_one_registration(table, study);
  read_setup(table, study);  // the keys as they stand are checked, though all be swept
  for (size_t i = 0; i < study.pose_law().t_m.size(); ++i) {
    read_paper_figures(table.table("poses").tables("fixed")[i].table("paper"));
  }
  return study;
}

}  // namespace sightline
