// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/target/target_report.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "eval/output/json.h"
#include "eval/output/numbers.h"
#include "eval/output/output_folder.h"
#include "eval/target/silhouette.h"
#include "eval/target/target_proposal.h"
#include "pose/angles.h"
#include "pose/attitude.h"
#include "renderer/renderer.h"
#include "scenes/files/input_error.h"
#include "scenes/mesh/decimation.h"
#include "scenes/mesh/mesh_inspection.h"
#include "scenes/picture/picture_file.h"
#include "scenes/target/target.h"

namespace sightline {
namespace {

constexpr size_t kMaxListedParts = 40;
constexpr int kPictureWidth = 960;
constexpr int kPictureHeight = 640;

std::string closedness(const MeshInspection& mesh) {
  if (mesh.closed_components == mesh.components) return "closed";
  return fmt::format("open: {} of {} closed, {}", mesh.closed_components,
                     counted(mesh.components, "piece"), counted(mesh.open_edges, "open edge"));
}

std::string orientation(const MeshInspection& mesh) {
  if (mesh.flipped_edges > 0 || mesh.inward_components > 0) {
    return fmt::format("{} edges whose faces disagree, {} closed pieces inside out",
                       mesh.flipped_edges, mesh.inward_components);
  }
  return mesh.closed_components == mesh.components ? "outward" : "agree with their neighbours";
}

// What a picture of the target would not show, and how its mesh was taken.
std::vector<std::string> target_notes(const Target& target) {
  std::vector<std::string> notes = target.mesh.notes;
  const size_t lost = target.mesh.lost_textures.size();
  if (lost > 0) {
    notes.push_back(fmt::format("{}{}: drawn without", target.mesh.lost_textures.front(),
                                lost == 1 ? "" : fmt::format(", and {} more are lost", lost - 1)));
  }
  return notes;
}

std::string mesh_text(const Target& target, const MeshInspection& mesh) {
  const Eigen::Vector3d size = mesh.bounds.max_m - mesh.bounds.min_m;
  std::string out;
  out += fmt::format("size       {:.3f} x {:.3f} x {:.3f} m (x, y, z), radius {:.3f} m\n", size.x(),
                     size.y(), size.z(), mesh.radius_m);
  out += fmt::format("mesh       {}, {} vertices, {}, {}\n", counted(mesh.triangles, "triangle"),
                     mesh.vertices, counted(mesh.components, "piece"),
                     counted(static_cast<int64_t>(mesh.parts.size()), "part"));
  out += fmt::format("surface    {}; {} shared by three faces or more\n", closedness(mesh),
                     counted(mesh.non_manifold_edges, "edge"));
  out += fmt::format("normals    {}\n", orientation(mesh));
  out += fmt::format("sharp      {} edges turn by {} deg or more, {:.1f} m in all\n",
                     mesh.sharp_edges, kSharpAngleDeg, mesh.sharp_length_m);
  out += fmt::format(
      "cleaned    {} vertices welded, {} degenerate and {} duplicate triangles dropped\n",
      target.cleaning.welded_vertices, target.cleaning.degenerate_triangles,
      target.cleaning.duplicate_triangles);
  for (const std::string& note : target_notes(target)) out += fmt::format("note       {}\n", note);
  return out;
}

std::string parts_text(const MeshInspection& mesh) {
  std::string out = "\n  id  part                          triangles   area m2  albedo\n";
  for (size_t i = 0; i < std::min(mesh.parts.size(), kMaxListedParts); ++i) {
    const MeshInspection::PartSummary& part = mesh.parts[i];
    out += fmt::format("{:>4}  {:<28} {:>10} {:>9.2f} {:>7.2f}\n", i + 1, part.name, part.triangles,
                       part.area_m2, part.albedo);
  }
  if (mesh.parts.size() > kMaxListedParts) {
    out += fmt::format("      and {} more\n", mesh.parts.size() - kMaxListedParts);
  }
  return out;
}

std::string features_text(const Target& target) {
  if (target.features.empty()) return "";
  std::string out = "\nfeature                         kind                 position m\n";
  for (const TargetFeature& feature : target.features) {
    const Eigen::Vector3d& p = feature.position_m;
    out += fmt::format("{:<30}  {:<18} {:>8.3f} {:>8.3f} {:>8.3f}\n", feature.name,
                       to_string(feature.kind), p.x(), p.y(), p.z());
  }
  return out;
}

std::vector<SilhouetteOffset> silhouettes(const Target& target) {
  std::vector<int> features(target.features.size());
  std::iota(features.begin(), features.end(), 0);
  return silhouette_offsets(target, features, views_all_round(target));
}

// How far a rounded edge shows beside the crease that a feature is.
std::string silhouettes_text(const Target& target) {
  if (target.features.empty()) return "";
  std::string out = fmt::format(
      "\nThe outline beside each feature, over those of {} views from all sides that show it, "
      "{:.0f} px"
      "\nto the diagonal of the target's box:\n\n"
      "feature                         views  median px  max px  median m   max m\n",
      kSilhouetteViews, kSilhouetteSizePx);
  const std::vector<SilhouetteOffset> offsets = silhouettes(target);
  for (size_t i = 0; i < offsets.size(); ++i) {
    const SilhouetteOffset& offset = offsets[i];
    out += fmt::format("{:<30}  {:>5}", target.features[i].name, offset.views);
    if (offset.views > 0) {
      out += fmt::format("  {:>9.3f} {:>7.3f} {:>9.4f} {:>7.4f}", offset.median_px,
                         offset.greatest_px, offset.median_m, offset.greatest_m);
    }
    out += '\n';
  }
  return out;
}

}  // namespace

Scene picture_scene(const std::shared_ptr<const Target>& target,
                    const std::vector<double>& theta_deg) {
  Scene scene;
  scene.target = target;
  scene.cam_from_target.rotation = rotation_from_attitude(
      {theta_deg[0] * kDegree, theta_deg[1] * kDegree, theta_deg[2] * kDegree});
  const Bounds box = bounds(target->mesh);
  const Eigen::Vector3d centre = (box.min_m + box.max_m) / 2;
  const double distance_m = 20 * (box.max_m - box.min_m).norm();
  scene.cam_from_target.translation =
      Eigen::Vector3d(0, 0, distance_m) - scene.cam_from_target.rotation * centre;
  scene.camera = centred_camera(kPictureWidth, kPictureHeight, 1.0);
  Eigen::AlignedBox2d spread;  // of the pixels for a focal length of one pixel
  for (const Eigen::Vector3d& vertex : target->mesh.vertices) {
    const Eigen::Vector3d x = scene.cam_from_target * vertex;
    spread.extend(Eigen::Vector2d(std::abs(x.x() / x.z()), std::abs(x.y() / x.z())));
  }
  const double focal_px =
      0.46 * std::min(kPictureWidth / spread.max().x(), kPictureHeight / spread.max().y());
  scene.camera = centred_camera(kPictureWidth, kPictureHeight, focal_px);
  scene.light = {.to_light_in_cam = Eigen::Vector3d(-0.4, -0.5, -0.75).normalized(),
                 .ambient = 0.25,
                 .directional = 0.7};  // together below 1: a white target keeps its shades
  scene.sensor = {.psf_sigma_px = 0.5, .read_noise_grey = 0, .full_well_electrons = 0, .bits = 8};
  return scene;
}

void write_picture(const cv::Mat& image, const std::string& file) {
  if (std::filesystem::path(file).extension() != ".png") {
    throw InputError(fmt::format("--picture {}: must end in .png", file));
  }
  try {
    write_file(file, png_bytes(image));
  } catch (const InputError& error) {
    throw InputError(fmt::format("--picture {}", error.what()));
  }
}

namespace {

// Writes a mesh of fewer triangles; returns what to tell of it.
std::string write_coarser(const Target& target, const TargetArguments& arguments) {
  const std::filesystem::path file = arguments.coarser;
  if (file.extension() != ".glb") {
    throw InputError(fmt::format("--out {}: must end in .glb", arguments.coarser));
  }
  if (std::filesystem::exists(file)) {
    throw InputError(fmt::format("--out {}: exists already; it is kept", arguments.coarser));
  }
  const Mesh coarser = decimated(target.mesh, arguments.kept_percent / 100);
  write_glb(coarser, file);
  return fmt::format("\ncoarser    {}: {} of {} triangles, grey; read it with --forward z --up y\n",
                     arguments.coarser, coarser.triangles.size(), target.mesh.triangles.size());
}

std::shared_ptr<const Target> target_with_mesh(const std::string& name, const MeshUse& use) {
  std::shared_ptr<const Target> target = load_target(name, use);
  if (const std::string reason = why_not_renderable(*target); !reason.empty()) {
    throw InputError(fmt::format("target {}: {}", name, reason));
  }
  return target;
}

Json point_json(const Eigen::Vector3d& point) {
  return {point.x(), point.y(), point.z()};
}

Json features_json(const Target& target) {
  Json features = Json::array();
  if (target.features.empty()) return features;
  const std::vector<SilhouetteOffset> offsets = silhouettes(target);
  for (size_t i = 0; i < offsets.size(); ++i) {
    const TargetFeature& feature = target.features[i];
    const SilhouetteOffset& offset = offsets[i];
    Json outline = {{"views", offset.views}};
    if (offset.views > 0) {
      outline["median_px"] = offset.median_px;
      outline["greatest_px"] = offset.greatest_px;
      outline["median_m"] = offset.median_m;
      outline["greatest_m"] = offset.greatest_m;
    }
    features.push_back({{"name", feature.name},
                        {"kind", to_string(feature.kind)},
                        {"position_m", point_json(feature.position_m)},
                        {"outline", std::move(outline)}});
  }
  return features;
}

// Whether a picture in grey would lack something: textures, colours of vertices, or a part's own.
bool is_coloured(const Mesh& mesh) {
  return !mesh.coats.empty() ||
         std::any_of(mesh.parts.begin(), mesh.parts.end(), [](const Part& p) {
           if (!p.material) return false;
           const auto& base = p.material->base;
           return base[0] != base[1] || base[1] != base[2];
         });
}

// In colour where the mesh has textures or colours.
cv::Mat draw_picture(const std::shared_ptr<const Target>& target,
                     const std::vector<double>& theta_deg) {
  Scene scene = picture_scene(target, theta_deg);
  if (!is_coloured(target->mesh)) {
    return Renderer().render(scene, RandomStream(0, "picture", 0)).image;
  }
  scene.colouring.mode = ColourMode::kRgb;
  scene.sensor.is_srgb = true;
  return Renderer().render(scene, RandomStream(0, "picture", 0)).colour;
}

}  // namespace

std::string target_json(const std::string& name, const MeshUse& use) {
  const std::shared_ptr<const Target> target = target_with_mesh(name, use);
  const MeshInspection mesh = inspect(target->mesh);
  Json json = {{"name", target->name},
               {"description", target->description},
               {"size_m", point_json(mesh.bounds.max_m - mesh.bounds.min_m)},
               {"radius_m", mesh.radius_m},
               {"triangles", mesh.triangles},
               {"vertices", mesh.vertices},
               {"pieces", mesh.components},
               {"closed_pieces", mesh.closed_components},
               {"open_edges", mesh.open_edges},
               {"edges_of_three_faces", mesh.non_manifold_edges},
               {"flipped_edges", mesh.flipped_edges},
               {"pieces_inside_out", mesh.inward_components},
               {"sharp_edges", mesh.sharp_edges},
               {"sharp_length_m", mesh.sharp_length_m},
               {"welded_vertices", target->cleaning.welded_vertices},
               {"degenerate_triangles", target->cleaning.degenerate_triangles},
               {"duplicate_triangles", target->cleaning.duplicate_triangles},
               {"notes", target_notes(*target)},
               {"parts", Json::array()},
               {"features", features_json(*target)}};
  for (const MeshInspection::PartSummary& part : mesh.parts) {
    json["parts"].push_back({{"name", part.name},
                             {"triangles", part.triangles},
                             {"area_m2", part.area_m2},
                             {"albedo", part.albedo}});
  }
  return json_text(json);
}

TargetReport report_target(const TargetArguments& arguments) {
  for (const double angle : arguments.theta_deg) {
    if (!std::isfinite(angle)) throw InputError(fmt::format("--theta: {} is not finite", angle));
  }
  const std::shared_ptr<const Target> target = target_with_mesh(arguments.target, arguments.mesh);
  const MeshInspection mesh = inspect(target->mesh);
  std::string out = target->name;
  if (!target->description.empty()) out += ": " + target->description;
  out += "\n\n" + mesh_text(*target, mesh) + parts_text(mesh) + features_text(*target) +
         silhouettes_text(*target);
  if (!arguments.coarser.empty()) out += write_coarser(*target, arguments);
  if (arguments.propose) {
    const TargetReport proposal = propose_target(target, arguments);
    return {out + proposal.text, proposal.proposed};
  }
  if (!arguments.picture.empty()) {
    write_picture(draw_picture(target, arguments.theta_deg), arguments.picture);
    out += fmt::format("\npicture    {}\n", arguments.picture);
  }
  return {out, {}};
}

}  // namespace sightline
