// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The table of [extraction].
#include <fmt/format.h>

#include "eval/study/key_tables.h"
#include "features/extractor.h"

namespace sightline {
namespace {

// One of the extractors that find features of a kind, by name.
Choice extractor_choice(const FeatureExtractor*& chosen, FeatureKind kind) {
  std::vector<std::pair<std::string, const FeatureExtractor*>> worded;
  for (const FeatureExtractor& extractor : feature_extractors()) {
    if (extractor.finds(kind)) worded.emplace_back(extractor.name, &extractor);
  }
  return choice(chosen, std::move(worded));
}

std::vector<Key> line_keys(LineOptions& line) {
  const std::string table = "extraction.lines";
  return {
      {table,
       "direction_tolerance_deg",
       &line.direction_tolerance_deg,
       {0.1, 90},
       "deg",
       "how far a line may turn from the predicted edge"},
      {table,
       "min_votes",
       &line.min_votes,
       {2, 1000},
       "",
       "least votes of edge pixels for a line in the Hough transform"},
      {table,
       "min_edge_pixels",
       &line.min_edge_pixels,
       {3, 1000},
       "",
       "least edge pixels that agree with a line in the end"},
      {table,
       "min_angle_deg",
       &line.min_angle_deg,
       {1, 89},
       "deg",
       "least angle between the two lines that meet in a feature"},
      {table,
       "canny_low",
       &line.canny_low,
       {1, 2000},
       "",
       "lower threshold of the edge detector, Sobel units of an 8-bit image"},
      {table,
       "canny_high",
       &line.canny_high,
       {line.canny_low, 2000},
       "",
       "upper threshold of the edge detector, not below canny_low"},
  };
}

std::vector<Key> corner_keys(CornerOptions& corner) {
  const std::string table = "extraction.corners";
  return {
      {table, "max_corners", &corner.max_corners, {1, 1000}, "", "most corners of a window"},
      {table,
       "quality",
       &corner.quality,
       {0.001, 1},
       "",
       "least strength of a corner, over that of the window's best"},
      {table,
       "min_contrast_grey",
       &corner.min_contrast_grey,
       {0, 255},
       "grey level of 255",
       "least contrast of the weaker edge at a corner"},
      {table,
       "min_distance_px",
       &corner.min_distance_px,
       {0, 100},
       "px",
       "least distance between corners"},
      {table, "block_px", &corner.block_px, {3, 31}, "px", "side of the structure tensor's window"},
  };
}

}  // namespace

Key registration_key(RegistrationUse& use) {
  return {"extraction",
          "registration",
          choice(use, {{"off", RegistrationUse::kOff},
                       {"image", RegistrationUse::kImage},
                       {"outline", RegistrationUse::kOutline},
                       {"both", RegistrationUse::kBoth}}),
          {},
          "",
          "whether the mesh is laid on the image too, as the estimators registration_image and "
          "registration_outline beside the solvers"};
}

std::vector<Key> extraction_keys(ImageSetup& setup, double& bias_mesh_fraction) {
  ExtractorOptions& options = setup.extractor_options;
  ExtractorChoice& extractors = setup.extractors;
  std::vector<Key> keys = {
      {"extraction",
       "line_intersection",
       extractor_choice(extractors.line_intersection, FeatureKind::kLineIntersection),
       {},
       "",
       "extractor of features where lines meet"},
      {"extraction",
       "corner",
       extractor_choice(extractors.corner, FeatureKind::kCorner),
       {},
       "",
       "extractor of corners"},
      {"extraction",
       "contour",
       extractor_choice(extractors.contour, FeatureKind::kContour),
       {},
       "",
       "extractor of features on the outline"},
      {"extraction",
       "use_lines",
       &setup.uses_lines,
       {},
       "",
       "whether solvers that use lines (sightline list solvers) are given those that were found "
       "along edges"},
      {"extraction",
       "channel",
       choice(setup.channel,
              {{"grey", ExtractedChannel::kGrey}, {"contrast", ExtractedChannel::kContrast}}),
       {},
       "",
       "what extractors see of pictures in colour: their grey, or in each window the channel "
       "(grey, red, green or blue) with the most contrast over noise"},
      {"extraction",
       "joint_edges",
       choice(setup.extractor_options.joint_edges, {{"textured", JointEdges::kTextured},
                                                    {"on", JointEdges::kOn},
                                                    {"off", JointEdges::kOff}}),
       {},
       "",
       "whether model_edges and edges_else_contour first match the lines along all edges with one "
       "pose: of targets with textures (material.textures too) or vertex colours, whose print "
       "looks "
       "like edges, always, or never"},
      {"extraction",
       "passes",
       &setup.passes,
       {1, 10},
       "",
       "passes of extraction; all but the first around the pose that came out before"},
      {"extraction",
       "bias_removal",
       choice(setup.bias_removal, {{"off", BiasRemoval::kOff},
                                   {"wrong_light", BiasRemoval::kWrongLight},
                                   {"known_light", BiasRemoval::kKnownLight}}),
       {},
       "",
       "whether what extractors err on a rendering at the pose found is taken off, with a light "
       "18 degrees off or the true one"},
      {"extraction",
       "bias_mesh_percent",
       Percent{&bias_mesh_fraction},
       {1, 100},
       "%",
       "triangles that are left of the mesh for that rendering"},
      registration_key(setup.registration.use),
      {"extraction",
       "registration_start",
       choice(setup.registration.start, {{"features", RegistrationStart::kAtFeatures},
                                         {"prior", RegistrationStart::kAtPrior}}),
       {},
       "",
       "where the registration begins: at the pose of the features found, or at the prior"},
      {"extraction",
       "registration_mesh_percent",
       Percent{&setup.registration.mesh_fraction},
       {1, 100},
       "%",
       "triangles that are left of the mesh that is laid on the image"},
      {"extraction",
       "registration_albedos",
       choice(setup.registration.knows_albedos, {{"known", true}, {"unknown", false}}),
       {},
       "",
       "whether that mesh has the albedos of the target's parts, or is of one albedo"},
      {"extraction",
       "registration_focal_sd_percent",
       Percent{&setup.registration.focal_sd_fraction},
       {0, 100},
       "%",
       "how far the focal length may be off, which the registration's covariance then bears"},
      {"extraction",
       "registration_principal_point_sd_px",
       &setup.registration.principal_point_sd_px,
       {0, 1000},
       "px",
       "the same of the principal point, in u and in v"},
      {"extraction",
       "registration_k1_sd",
       &setup.registration.distortion_sd,
       {0, 1},
       "",
       "the same of the lens' coefficient k1"},
      {.table = "extraction",
       .name = "noise_sd_grey",
       .value = &options.search.noise_sd_grey,
       .allowed = {0, 255},
       .unit = "grey level of 255",
       .meaning = "standard deviation of the image's noise, as far as extractors know it",
       .if_absent = fmt::format("what [noise] and image.gain make; with [dataset] {}",
                                options.search.noise_sd_grey)},
      {"extraction",
       "window_half_px",
       &options.window_half_px,
       {4, 512},
       "px",
       "windows are squares of twice this plus one, around the prediction"},
  };
  for (auto& part : {keys_of(setup.limits), line_keys(options.line), corner_keys(options.corner)}) {
    keys.insert(keys.end(), part.begin(), part.end());
  }
  return keys;
}

ExtractorChoice default_extractors() {
  return {.line_intersection = find_feature_extractor("hough_intersection"),
          .corner = find_feature_extractor("shi_tomasi_nearest"),
          .contour = find_feature_extractor("contour")};
}

}  // namespace sightline
