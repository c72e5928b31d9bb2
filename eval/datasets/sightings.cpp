// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/sightings.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "eval/datasets/bop/numbered.h"
#include "eval/datasets/bop/results_csv.h"
#include "eval/datasets/conventions.h"
#include "eval/datasets/pictures.h"
#include "eval/datasets/set_readers.h"
#include "scenes/files/input_error.h"
#include "scenes/picture/picture_file.h"
#include "scenes/scene/scene.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// Turns the frame that the set's poses are of into the target's.
Eigen::Matrix3d target_from_model(bool is_of_file_axes, const Target& target) {
  return is_of_file_axes ? target.target_from_file : Eigen::Matrix3d::Identity();
}

Pose cam_from_target(const Pose& cam_from_model, const Eigen::Matrix3d& target_from_model) {
  return {cam_from_model.rotation * target_from_model.transpose(), cam_from_model.translation};
}

// ---- is it the target?

Eigen::AlignedBox3d box_of(const Target& target) {
  const Bounds box = bounds(target.mesh);
  return {box.min_m, box.max_m};
}

Eigen::AlignedBox3d turned(const Eigen::Matrix3d& rotation, const Eigen::AlignedBox3d& box) {
  const Eigen::Vector3d a = rotation * box.min();
  const Eigen::Vector3d b = rotation * box.max();
  return {a.cwiseMin(b), a.cwiseMax(b)};  // axes turn into axes
}

bool fits(const Eigen::AlignedBox3d& model_box, const SightingSource& source, bool is_of_file_axes,
          const Target& target) {
  const Eigen::AlignedBox3d stated = turned(target_from_model(is_of_file_axes, target), model_box);
  const Eigen::AlignedBox3d box = box_of(target);
  if (!target.has_mesh()) {  // keypoints lie on the model or in it
    const double beyond_m = source.box_tolerance * stated.diagonal().norm();
    return (stated.min() - box.min()).maxCoeff() <= beyond_m &&
           (box.max() - stated.max()).maxCoeff() <= beyond_m;
  }
  const double allowed_m = source.box_tolerance * box.diagonal().norm();
  return (stated.min() - box.min()).cwiseAbs().maxCoeff() <= allowed_m &&
         (stated.max() - box.max()).cwiseAbs().maxCoeff() <= allowed_m;
}

std::string text_of(const Eigen::AlignedBox3d& box) {
  const Eigen::Vector3d a = box.min();
  const Eigen::Vector3d b = box.max();
  return fmt::format("({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g}) m", a.x(), a.y(), a.z(),
                     b.x(), b.y(), b.z());
}

void require_same_model(const SightingSource& source, const SetReading& reading,
                        const Target& target) {
  if (!reading.model_box_m) return;
  if (fits(*reading.model_box_m, source, source.is_of_file_axes, target)) return;
  if (!target.has_mesh()) {
    throw InputError(fmt::format(
        "{}: object {} fills {}, the keypoints of '{}' {}; they must lie within it, up to {:g} % "
        "of its size (dataset.box_tolerance)",
        reading.model_file.string(), reading.obj_id, text_of(*reading.model_box_m), target.name,
        text_of(box_of(target)), 100 * source.box_tolerance));
  }
  const bool would_otherwise = fits(*reading.model_box_m, source, !source.is_of_file_axes, target);
  throw InputError(fmt::format(
      "{}: object {} fills {}, the target '{}' {}{}; they must agree within {:g} % of the target's "
      "size (dataset.box_tolerance){}",
      reading.model_file.string(), reading.obj_id, text_of(*reading.model_box_m), target.name,
      text_of(
          turned(target_from_model(source.is_of_file_axes, target).transpose(), box_of(target))),
      source.is_of_file_axes ? " in the axes of its mesh file" : "", 100 * source.box_tolerance,
      would_otherwise
          ? fmt::format("; with --axes {} they do", source.is_of_file_axes ? "target" : "file")
          : ""));
}

// Why a picture cannot show the target at its pose; empty where it can. Lengths in another unit put
// the camera into the target, or so far away that nothing is left of it: both can be drawn.
std::string why_not_shown(const Sighting& sighting, const std::shared_ptr<const Target>& target) {
  constexpr double kNear = 0.01;  // of the target's size
  constexpr double kLeastPx = 2;
  const Eigen::AlignedBox3d box = box_of(*target);
  const double size_m = box.diagonal().norm();
  const Eigen::Vector3d camera_in_target = inverse(sighting.cam_from_target).translation;
  if (box.exteriorDistance(camera_in_target) <= kNear * size_m) {
    return "the camera stands within its box, or at it";
  }
  Scene scene;
  scene.target = target;
  scene.camera = sighting.camera;
  scene.cam_from_target = sighting.cam_from_target;
  std::string reason = why_not_imageable(scene);
  if (!reason.empty()) return reason;
  const double size_px = std::max(sighting.camera.fx_px, sighting.camera.fy_px) * size_m /
                         sighting.cam_from_target.translation.norm();
  return size_px >= kLeastPx ? "" : "it is smaller than 2 px";
}

// Throws where no pose puts the target into its image, and notes it where most do not: then a
// quaternion, a matrix or a unit is likely to be read otherwise than it was written.
void require_any_in_image(const SightingSource& source, SightedSet& set,
                          const std::shared_ptr<const Target>& target) {
  const std::vector<Sighting>& sightings = set.sightings;
  std::string first_reason;
  constexpr size_t kEnough = 100;  // of which some are inside: to look at all takes long
  size_t outside = 0;
  size_t looked_at = 0;
  for (const Sighting& sighting : sightings) {
    if (sighting.problem == EstimateOutcome::kNoTruth) continue;
    if (looked_at >= kEnough && outside < looked_at) break;
    ++looked_at;
    const std::string reason = why_not_shown(sighting, target);
    if (reason.empty()) continue;
    ++outside;
    if (first_reason.empty()) first_reason = reason;
  }
  if (looked_at == 0) {
    throw InputError(fmt::format(
        "{}: none of its {} true poses is one: rotations must be such (quaternions of length 1), "
        "and all numbers finite",
        source.folder.string(), sightings.size()));
  }
  if (2 * outside <= looked_at) return;
  if (outside < looked_at) {
    set.notes.push_back(fmt::format(
        "{}: {} of {} poses do not put '{}' into its image; by the first, {} (quaternions are read "
        "scalar first, matrices row by row, both as camera from target)",
        source.folder.string(), outside, looked_at, target->name, first_reason));
    return;
  }
  throw InputError(fmt::format(
      "{}: none of its {} poses puts '{}' into its image; by the first, {} (translations must be "
      "in mm in BOP, in m in SPEED+)",
      source.folder.string(), sightings.size(), target->name, first_reason));
}

// ---- priors

void give_priors(const SightingSource& source, SightedSet& set) {
  std::vector<BopEstimate> estimates = read_bop_results(source.priors);
  std::erase_if(estimates, [&set](const BopEstimate& e) { return e.obj_id != set.obj_id; });
  std::vector<Pose> priors;
  std::vector<PlaceInImage> places;
  std::vector<double> scores;
  for (const BopEstimate& estimate : estimates) {
    priors.push_back(pose_in_metres(estimate, set.target_from_model));
    places.push_back({estimate.scene_id, estimate.im_id, priors.back().translation});
    scores.push_back(estimate.score);
  }
  bool has_any = false;
  const std::vector<int> chosen = sightings_of(places, scores, set.sightings);
  for (size_t i = 0; i < chosen.size(); ++i) {
    if (chosen[i] < 0 || !estimates[i].problem.empty()) continue;
    set.sightings[static_cast<size_t>(chosen[i])].prior_cam_from_target = priors[i];
    has_any = true;
  }
  if (has_any) return;
  throw InputError(fmt::format("{}: has no pose of object {} in an image of the set",
                               source.priors.string(), set.obj_id));
}

// The size of the first picture that is there, which stands for all until they are read.
void set_camera_sizes(std::vector<Sighting>& sightings) {
  std::optional<cv::Size> size;
  for (size_t i = 0; i < sightings.size() && !size; ++i) size = picture_size(sightings[i].picture);
  if (!size) {
    throw InputError(fmt::format("{}: cannot be read, nor any other picture of the set",
                                 sightings.front().picture.string()));
  }
  for (Sighting& sighting : sightings) {
    sighting.camera.width_px = size->width;
    sighting.camera.height_px = size->height;
  }
}

// The symmetries of the model, in mm, as those of the target.
Symmetries symmetries_of_target(const Symmetries& of_model_mm,
                                const Eigen::Matrix3d& target_from_model) {
  const auto in_metres = [&](const Eigen::Vector3d& in_model_mm) {
    return Eigen::Vector3d(kMetresPerMillimetre * target_from_model * in_model_mm);
  };
  Symmetries symmetries{.poses = {}, .axes = {}};
  for (const Pose& mm : of_model_mm.poses) {
    symmetries.poses.push_back({target_from_model * mm.rotation * target_from_model.transpose(),
                                in_metres(mm.translation)});
  }
  for (const SymmetryAxis& axis : of_model_mm.axes) {
    symmetries.axes.push_back({target_from_model * axis.direction, in_metres(axis.point)});
  }
  return symmetries;
}

}  // namespace

bool has_picture(std::span<const Sighting> sightings, int scene_id, int64_t im_id) {
  const auto of_scene = std::find_if(sightings.begin(), sightings.end(),
                                     [=](const Sighting& s) { return s.scene_id == scene_id; });
  if (of_scene == sightings.end()) return false;
  const fs::path folder = of_scene->picture.parent_path();
  if (!numbered_picture(folder, {im_id}).empty()) return true;
  // Of the imagewise format, whose keys may have fewer digits, and no scene where that is 0.
  std::vector<std::string> keys = {fmt::format("{:06}_{:06}", scene_id, im_id),
                                   fmt::format("{}_{}", scene_id, im_id)};
  if (scene_id == 0) {
    keys.push_back(fmt::format("{:06}", im_id));
    keys.push_back(std::to_string(im_id));
  }
  return std::ranges::any_of(keys, [&folder](const std::string& key) {
    return !picture_named(folder, key + ".rgb").empty() ||
           !picture_named(folder, key + ".gray").empty();
  });
}

Pose pose_in_metres(const BopEstimate& estimate, const Eigen::Matrix3d& target_from_model) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (!estimate.problem.empty()) {
    return {Eigen::Matrix3d::Identity(), Eigen::Vector3d::Constant(kNone)};
  }
  const Pose mm = cam_from_target(estimate.cam_from_model, target_from_model);
  return {nearest_rotation(mm.rotation), kMetresPerMillimetre * mm.translation};
}

std::vector<int> sightings_of(std::span<const PlaceInImage> estimates,
                              std::span<const double> scores, std::span<const Sighting> sightings) {
  std::map<std::pair<int, int64_t>, std::vector<size_t>> in_image;
  for (size_t i = 0; i < sightings.size(); ++i) {
    in_image[{sightings[i].scene_id, sightings[i].im_id}].push_back(i);
  }
  std::vector<size_t> order(estimates.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return scores[a] > scores[b]; });
  std::vector<int> chosen(estimates.size(), -1);
  std::map<std::pair<int, int64_t>, std::vector<size_t>> without_position;
  for (const size_t estimate : order) {
    const std::pair image{estimates[estimate].scene_id, estimates[estimate].im_id};
    std::vector<size_t>& free = in_image[image];
    if (free.size() <= without_position[image].size()) continue;
    if (!estimates[estimate].position_m.allFinite()) {
      without_position[image].push_back(estimate);
      continue;
    }
    const auto distance_m = [&](size_t sighting) {
      return (sightings[sighting].cam_from_target.translation - estimates[estimate].position_m)
          .norm();
    };
    const auto nearest = std::min_element(free.begin(), free.end(), [&](size_t a, size_t b) {
      return distance_m(a) < distance_m(b);
    });
    chosen[estimate] = static_cast<int>(*nearest);
    free.erase(nearest);
  }
  for (const auto& [image, waiting] : without_position) {
    for (size_t i = 0; i < waiting.size(); ++i) {
      chosen[waiting[i]] = static_cast<int>(in_image[image][i]);
    }
  }
  return chosen;
}

SightedSet read_sightings(const SightingSource& source,
                          const std::shared_ptr<const Target>& target) {
  if (!fs::is_directory(source.folder)) {
    throw InputError(fmt::format("{}: is no folder", source.folder.string()));
  }
  if (source.is_of_file_axes && !target->has_mesh()) {
    throw InputError(fmt::format("axes is \"file\", but '{}' has keypoints alone and no mesh file",
                                 target->name));
  }
  SetReading reading = set_reader_of(source).read(source);
  require_same_model(source, reading, *target);
  const Eigen::Matrix3d turn = target_from_model(source.is_of_file_axes, *target);
  SightedSet set{std::move(reading.sightings), reading.obj_id, turn,
                 symmetries_of_target(reading.symmetries, turn), std::move(reading.notes)};
  set_camera_sizes(set.sightings);
  for (Sighting& sighting : set.sightings) {
    sighting.image = fs::relative(sighting.picture, source.folder).string();
    sighting.cam_from_target = cam_from_target(sighting.cam_from_target, set.target_from_model);
  }
  std::vector<fs::path> pictures;
  for (const Sighting& sighting : set.sightings) pictures.push_back(sighting.picture);
  const std::string note = note_on_links(source.folder, pictures);
  if (!note.empty()) set.notes.push_back(note);
  if (!source.priors.empty()) give_priors(source, set);
  require_any_in_image(source, set, target);
  return set;
}

}  // namespace sightline
