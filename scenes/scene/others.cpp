// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/others.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "scenes/files/input_error.h"
#include "scenes/scene/oriented_box.h"
#include "scenes/scene/poses.h"

namespace sightline {
namespace {

constexpr int kMostBodies = 254;  // body ids have 8 bits
constexpr int kMostDraws = 1000;  // of a body that is to keep apart

std::shared_ptr<const Target> load_other(const TomlTable& table, const OtherLaw& law,
                                         const MeshUse& use) {
  try {
    const std::shared_ptr<const Target> target = load_target(law.name, use);
    if (const std::string reason = why_not_renderable(*target); !reason.empty()) {
      throw InputError(reason);
    }
    return scaled(target, law.scale);
  } catch (const InputError& error) {
    table.fail("target", fmt::format("cannot be used: {}", error.what()));
  }
}

OtherBody draw_other(const OtherLaw& law, const Camera& camera, const Eigen::Vector3d& origin,
                     RandomStream& stream) {
  const double du_px = law.offset_px.draw(stream);
  const double dv_px = law.offset_px.draw(stream);
  const double fraction = law.range_fraction.draw(stream);
  Eigen::Vector3d theta_deg;
  for (double& angle : theta_deg) angle = law.angle_deg ? law.angle_deg->draw(stream) : 0;
  OtherBody body{law.target, pose_from(theta_deg, origin), law.is_occluder};
  if (!law.angle_deg) body.cam_from_target.rotation = stream.rotation();
  body.cam_from_target.translation +=
      origin.z() * Eigen::Vector3d(du_px / camera.fx_px, dv_px / camera.fy_px, 0);
  body.cam_from_target.translation *= fraction;
  return body;
}

OrientedBox box_of(const OtherBody& body) {
  return oriented_box(body.target->mesh, body.cam_from_target);
}

bool is_free(const OtherBody& body, const std::vector<OrientedBox>& taken) {
  const OrientedBox box = box_of(body);
  return std::none_of(taken.begin(), taken.end(),
                      [&box](const OrientedBox& other) { return do_overlap(box, other); });
}

}  // namespace

std::vector<Key> keys_of(OtherLaw& law) {
  return {
      {"other",
       "target",
       &law.name,
       {},
       "",
       "name of a target, a target.toml or a mesh file",
       {},
       "target",
       true},
      {"other", "scale", &law.scale, {1e-9, 1e9}, "", "factor on its size", {}, "target"},
      {"other",
       "role",
       choice(law.is_occluder, {{"occluder", true}, {"target", false}}),
       {},
       "",
       "an occluder hides and shades, a target's pose is told too",
       {},
       "is_occluder"},
      {"other",
       "count",
       &law.count,
       {0, kMostBodies},
       "",
       "bodies of this kind",
       {},
       "cam_from_target"},
      {"other",
       "offset_px",
       LowHigh{&law.offset_px},
       {-1e6, 1e6},
       "px",
       "where its origin is from the main target's, in u and in v",
       {},
       "cam_from_target"},
      {"other",
       "range_fraction",
       LowHigh{&law.range_fraction},
       {1e-3, 1e3},
       "",
       "its z over the main target's",
       {},
       "cam_from_target"},
      {"other",
       "angle_deg",
       OptionalLowHigh{&law.angle_deg},
       {-180, 180},
       "deg",
       "each of its three angles",
       {},
       "cam_from_target",
       false,
       "uniform on SO(3)"},
      {"other",
       "apart",
       &law.keeps_apart,
       {},
       "",
       "whether it is drawn anew until its box (along its own axes) cuts that of no body before "
       "it, "
       "the main target first; a scene without such a place is not imaged",
       {},
       "cam_from_target"},
  };
}

std::vector<OtherLaw> read_others(const TomlTable& file) {
  std::vector<OtherLaw> laws;
  MeshUse use;
  use.backfaces = file.table("mesh").text("backfaces", "");
  int bodies = 0;
  for (const TomlTable& table : file.tables("other")) {
    OtherLaw law;
    const std::vector<Key> keys = keys_of(law);
    read_key(table, find_key(keys, "target"));
    read_key(table, find_key(keys, "scale"));
    law.target = load_other(table, law, use);
    for (const Key& key : keys) read_key(table, key);
    bodies += law.count;
    if (bodies > kMostBodies) {
      table.fail("count", fmt::format("makes {} bodies, at most {} can stand beside the target",
                                      bodies, kMostBodies));
    }
    laws.push_back(std::move(law));
  }
  return laws;
}

DrawnOthers draw_others(const std::vector<OtherLaw>& laws, const Camera& camera, const Mesh& target,
                        const Pose& cam_from_target, const Draws& draws) {
  DrawnOthers others;
  const bool are_boxes_asked =
      std::any_of(laws.begin(), laws.end(), [](const OtherLaw& law) { return law.keeps_apart; });
  std::vector<OrientedBox> taken;
  if (are_boxes_asked) taken.push_back(oriented_box(target, cam_from_target));
  RandomStream stream = draws.stream("other");
  for (const OtherLaw& law : laws) {
    for (int i = 0; i < law.count; ++i) {
      OtherBody body = draw_other(law, camera, cam_from_target.translation, stream);
      for (int draw = 1; law.keeps_apart && !is_free(body, taken); ++draw) {
        if (draw == kMostDraws) {
          others.problem = fmt::format("body {} beside the target found no place apart in {} draws",
                                       others.bodies.size(), kMostDraws);
          return others;
        }
        body = draw_other(law, camera, cam_from_target.translation, stream);
      }
      if (are_boxes_asked) taken.push_back(box_of(body));
      others.bodies.push_back(std::move(body));
    }
  }
  return others;
}

}  // namespace sightline
