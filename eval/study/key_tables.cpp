// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/study/key_tables.h"

#include <limits>

#include <fmt/format.h>

#include "eval/doors/estimate_file.h"
#include "eval/doors/external_extractor.h"
#include "eval/doors/external_process.h"
#include "eval/doors/observation_file.h"

namespace sightline {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Choice solver_choice(std::string& chosen) {
  std::vector<std::pair<std::string, std::string>> worded;
  for (const PoseSolver& solver : pose_solvers()) worded.emplace_back(solver.name, solver.name);
  return choice(chosen, std::move(worded));
}

// Keys above all tables, and tables that are read in code of their own.
std::vector<Key> described_keys() {
  const Study study;
  const std::string text = "a text";
  return {
      {"",
       "kind",
       Described{"\"images\"", R"("images", "numeric", "orientation")"},
       {},
       "",
       "where trials begin: at images, at made observations, or at matched points in two frames"},
      {"", "name", Described{"the file's", text}, {}, "", "of the study, and of its folder"},
      {"", "title", Described{"the name", text}, {}, "", "heading of the report"},
      {"", "question", Described{"\"\"", text}, {}, "", "what the study asks, for the report"},
      {"",
       "reference",
       Described{"\"\"", text},
       {},
       "",
       "figure or table of a paper that it repeats"},
      {"", "claim", Described{"\"\"", text}, {}, "", "what the paper says of it"},
      {"",
       "seed",
       Described{fmt::to_string(study.seed), "whole, 0 to 9e15"},
       {},
       "",
       "of all random draws"},
      {"",
       "trials",
       Described{fmt::format("{}; with [dataset] all", study.draws), "whole, 1 to 10000000"},
       {},
       "",
       "trials a condition"},
      {"",
       "target",
       Described{"required", text},
       {},
       "",
       "name of a target, a target.toml or a mesh file"},
      {"mesh",
       "unit",
       Described{"\"m\"", text},
       {},
       "",
       "of a mesh file: its unit, m, cm, mm, km, in, ft or metres as a number"},
      {"mesh",
       "forward",
       Described{"\"+x\"", "an axis, \"x\" to \"-z\""},
       {},
       "",
       "of a mesh file: its axis that points forward"},
      {"mesh",
       "up",
       Described{"\"-z\"", "an axis, \"x\" to \"-z\""},
       {},
       "",
       "of a mesh file: its axis that points up"},
      {"mesh",
       "hide",
       Described{"none", "names"},
       {},
       "",
       "parts of the target's mesh that are left out; * stands for any letters"},
      {"mesh",
       "backfaces",
       Described{"\"material\"", "\"material\", \"seen\""},
       {},
       "",
       "whether surfaces of one side, as glTF's without doubleSided are, are seen from behind too, "
       "those of all bodies"},
      {"",
       "features",
       Described{"\"all\"", "\"all\", or names"},
       {},
       "",
       "features of the target that are looked for"},
      {"",
       "solvers",
       Described{"required", "names"},
       {},
       "",
       "pose solvers, see `sightline list solvers`"},
      {"",
       "extractors",
       Described{"guests, or \"by_kind\"", "names"},
       {},
       "",
       "who finds the features, a cell each: \"by_kind\" (those of [extraction]), one of "
       "`sightline "
       "list extractors` for all that it can find, or a name of [[observations]] or "
       "[[external.extractor]]"},
      {"",
       "methods",
       Described{"all but those for outliers", "names"},
       {},
       "",
       "of an orientation study: its methods, see `sightline list methods`"},
      {"functions",
       "solvers",
       Described{"none", "names"},
       {},
       "",
       "solvers that are functions of a program that runs the study, as the Python module may be "
       "given; it writes this key"},
      {"functions", "extractors", Described{"none", "names"}, {}, "", "the same of extractors"},
      {"solver",
       "inputs",
       Described{"none", R"(of "exact", "noise", "inliers")"},
       {},
       "",
       "what solvers get besides what was extracted: true projections, outliers replaced by noise, "
       "inliers alone"},
      {"sweep",
       "\"TABLE.KEY\"",
       Described{"none", "values"},
       {},
       "",
       "of an image study: values of a key of a scene's tables, [prior] or [extraction]; of a "
       "numeric study: of [camera], [edges], [noise], [outliers], [poses], [prior] or [solver]"},
      {"sweep",
       "noise_px",
       Described{"none", "numbers"},
       {},
       "px",
       "of a numeric study: values of noise.pixel_px"},
      {"sweep",
       "outliers",
       Described{"none", "whole numbers"},
       {},
       "",
       "of a numeric study: values of outliers.count"},
      {"sweep",
       "sigma",
       Described{"none", "numbers"},
       {},
       "m",
       "of an orientation study: values of noise.sigma_m"},
      {"sweep",
       "points",
       Described{"none", "whole numbers"},
       {},
       "",
       "of an orientation study: values of points.count"},
      {"sweep",
       "share",
       Described{"none", "numbers"},
       {},
       "",
       "of an orientation study: values of outliers.share"},
      {"sweep",
       "scale",
       Described{"none", "numbers"},
       {},
       "",
       "of an orientation study: values of points.scale"},
      {"poses.fixed.paper",
       "SOLVER",
       Described{"none", "[degrees, percent], 0 to 180"},
       {},
       "",
       "errors that a paper prints for a given pose, beside ours in the report"},
  };
}

}  // namespace

std::vector<Key> solver_keys(Start& start, SolverOptions& options) {
  OutlierOptions& outliers = options.outliers;
  return {
      {.table = "solver",
       .name = "start",
       .value = choice(start, {{"prior", Start::kPrior}, {"free", Start::kFree}}),
       .allowed = {},
       .unit = "",
       .meaning = "where solvers start: at the prior, or at what orthogonal iteration finds alone",
       .if_absent = R"("prior", of a numeric study "free")"},
      {"solver",
       "rho",
       &options.orpe.rho,
       {1, 1e9},
       "",
       "orpe: an outlier lowers the minimax residual (squared px) at least by this factor"},
      {"solver",
       "final",
       choice(options.orpe.final, {{"minimax", OrpeOptions::Final::kMinimax},
                                   {"least_squares", OrpeOptions::Final::kLeastSquares}}),
       {},
       "",
       "orpe: what its pose minimises on the points that are left"},
      {"solver",
       "outlier_probability",
       &outliers.probability,
       {1e-9, 0.5},
       "",
       "probability of a point being an outlier, before any pixel is seen"},
      {"solver",
       "outlier_scale_px",
       &outliers.scale_px,
       {1e-3, 1e6},
       "px",
       "standard deviation of an outlier's error, each coordinate"},
      {"solver",
       "false_alarm_rate",
       &outliers.false_alarm_rate,
       {1e-9, 0.5},
       "",
       "how often anything is removed from points that have no outlier"},
      {.table = "solver",
       .name = "max_removed",
       .value = &outliers.max_removed,
       .allowed = {0, 10000},
       .unit = "",
       .meaning = "most points that a solver removes",
       .if_absent = "the solver's own limit"},
  };
}

std::vector<Key> noise_keys(NoiseLaw& noise) {
  return {
      {"noise",
       "law",
       choice(noise.tails,
              {{"normal", NoiseLaw::Tails::kNormal}, {"student", NoiseLaw::Tails::kStudent}}),
       {},
       "",
       "of a numeric study: normal errors, or Student's t of the same standard deviation, whose "
       "rare errors are large"},
      {"noise",
       "freedom",
       &noise.freedom,
       {2.1, 1000},
       "",
       "of a numeric study: degrees of freedom of Student's t; the fewer, the heavier the "
       "tails"}};
}

std::vector<Key> sigma_keys(bool& is_sigma_known) {
  return {{"solver",
           "sigma",
           choice(is_sigma_known, {{"unknown", false}, {"known", true}}),
           {},
           "",
           "of a numeric study, and for the methods of an orientation study that know outliers: "
           "whether solvers are told the noise applied"}};
}

std::vector<Key> scale_keys(bool& estimates_scale) {
  return {{"solver",
           "scale",
           choice(estimates_scale, {{"one", false}, {"free", true}}),
           {},
           "",
           "of an orientation study: whether methods that know outliers seek a scale"}};
}

std::vector<Key> dataset_keys(SightingSource& source, int& bits) {
  return {
      {.table = "dataset",
       .name = "path",
       .value = &source.folder,
       .allowed = {},
       .unit = "",
       .meaning = "folder of a data set in the format of BOP or SPEED+",
       .is_required = true},
      {.table = "dataset",
       .name = "split",
       .value = &source.split,
       .allowed = {},
       .unit = "",
       .meaning = "part of the data set: a folder of BOP, a list of SPEED+",
       .if_absent = "\"test\", or the only one"},
      {.table = "dataset",
       .name = "sensor",
       .value = &source.sensor,
       .allowed = {},
       .unit = "",
       .meaning = "sensor of a data set of BOP that has several (scene_gt_SENSOR.json)",
       .if_absent =
           "that of scene_gt.json, else the one that BOP evaluates, else the first by name"},
      {.table = "dataset",
       .name = "object",
       .value = &source.obj_id,
       .allowed = {0, 1e9},
       .unit = "",
       .meaning = "id of the target in a data set of BOP",
       .if_absent = "the only one"},
      {"dataset",
       "axes",
       choice(source.is_of_file_axes, {{"target", false}, {"file", true}}),
       {},
       "",
       "whose axes the data set's poses are of: the target's, or its mesh file's"},
      {"dataset",
       "box_tolerance",
       &source.box_tolerance,
       {0, 1e6},
       "",
       "how far the target's box may be from the data set's, of its size"},
      {.table = "dataset",
       .name = "priors",
       .value = &source.priors,
       .allowed = {},
       .unit = "",
       .meaning = "file of prior poses, a BOP results CSV",
       .if_absent = "drawn by [prior]"},
      {"dataset", "bits", &bits, {1, kMostBits}, "bit", "depth of the images' grey levels"},
  };
}

std::vector<Key> point_keys(PointPairs& pairs) {
  return {
      {"points",
       "half_side_m",
       &pairs.half_side_m,
       {1e-6, 1e9},
       "m",
       "points are uniform in a cube about the origin, this its half side"},
      {"points",
       "translation_m",
       &pairs.translation_m,
       {0, 1e9},
       "m",
       "each coordinate of the translation is uniform within +- this"},
      {"",
       "copies",
       &pairs.copies,
       {1, 1'000'000},
       "",
       "of an orientation study: noisy copies of every draw"},
      {"",
       "timed_repeats",
       &pairs.timed_repeats,
       {0, 1'000'000'000},
       "",
       "of an orientation study: solves whose mean time is taken; 0: nothing is timed"},
  };
}

std::vector<Key> limit_keys(ClaimLimits& limits) {
  const std::string meaning = "the claim: the solver's mean stays below this in every condition";
  return {
      {"limits",
       "solver",
       solver_choice(limits.solver),
       {},
       "",
       "solver that a numeric study's claim is of"},
      {"limits",
       "theta_error_deg",
       &limits.theta_error_deg,
       {0, 180},
       "deg",
       meaning,
       {},
       "",
       true},
      {"limits", "t_error_percent", &limits.t_error_percent, {0, 1e6}, "%", meaning, {}, "", true},
  };
}

std::vector<Key> axis_keys() {
  const Described unless_swept = {"required unless swept"};
  const Described whole = {"required unless swept", "whole, 0 to the number of features"};
  return {
      {"noise",
       "pixel_px",
       unless_swept,
       {0, 1e4},
       "px",
       "of a numeric study: standard deviation of each coordinate"},
      {"noise",
       "sigma_m",
       unless_swept,
       {0, 1e9},
       "m",
       "of an orientation study: standard deviation of each coordinate"},
      {"outliers", "count", whole, {0, kInfinity}, "", "displaced points of a trial"},
      {"points", "count", unless_swept, {3, 1e6}, "", "points of a trial"},
      {"points",
       "scale",
       Described{"1"},
       {1e-6, 1e6},
       "",
       "of an orientation study: of lengths in the second frame"},
      {"outliers",
       "share",
       Described{"0"},
       {0, 0.9999},
       "",
       "of an orientation study: part of the pairs that are wrong, in the second frame anywhere in "
       "the volume of the others"},
  };
}

std::vector<KeyText> study_keys() {
  ImageSetup setup;
  setup.extractors = default_extractors();
  bool has_image_bound = false;
  double bias_mesh_fraction = kBiasMeshFraction;
  Start start = Start::kPrior;
  SolverOptions options;
  NoiseLaw noise;
  SeenEdges seen_edges;
  bool is_sigma_known = false;
  bool estimates_scale = false;
  SightingSource source;
  int bits = kMostBits;
  PlantedOutliers planted;
  PointPairs pairs;
  ClaimLimits limits;
  ObservationSource observations;
  EstimateSource estimates;
  ProcessSource solver_process;
  ExtractorProcessSource extractor_process;
  std::vector<KeyText> all;
  for (const std::vector<Key>& keys :
       {described_keys(), point_keys(pairs), dataset_keys(source, bits), keys_of(setup.prior),
        extraction_keys(setup, bias_mesh_fraction), bound_keys(has_image_bound),
        solver_keys(start, options), sigma_keys(is_sigma_known), scale_keys(estimates_scale),
        noise_keys(noise), keys_of(planted), keys_of(seen_edges), axis_keys(), limit_keys(limits),
        keys_of(observations), keys_of(estimates), keys_of(solver_process),
        keys_of(extractor_process)}) {
    for (KeyText& text : texts_of(keys, "")) all.push_back(std::move(text));
  }
  return all;
}

}  // namespace sightline
