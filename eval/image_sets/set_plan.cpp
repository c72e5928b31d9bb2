// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/image_sets/set_plan.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <opencv2/imgproc.hpp>

#include "eval/image_sets/set_format.h"
#include "eval/study/study_file.h"
#include "renderer/gl_context.h"
#include "scenes/files/assets.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"
#include "scenes/files/toml_text.h"
#include "scenes/target/target_memory.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr int kLargestDepth = 65535;

bool is_same(const Target& a, const Target& b) {
  return &a == &b || (a.name == b.name && a.mesh.vertices == b.mesh.vertices);
}

std::vector<std::shared_ptr<const Target>> objects_of(const ImageStudy& study) {
  std::vector<std::shared_ptr<const Target>> objects = {study.target};
  for (const ImageSetup& setup : study.setups) {
    for (const OtherLaw& other : setup.scene.others) {
      const bool is_known = std::any_of(objects.begin(), objects.end(), [&](const auto& object) {
        return is_same(*object, *other.target);
      });
      if (!other.is_occluder && !is_known) objects.push_back(other.target);
    }
  }
  return objects;
}

double farthest_of(const SceneLaw& law) {
  double origin_m = law.poses.drawn_range_m.max;
  for (const Eigen::Vector3d& t : law.poses.t_m) origin_m = std::max(origin_m, t.z());
  double far_m = origin_m + radius_m(law.target->mesh, law.poses.aim_m);
  for (const OtherLaw& other : law.others) {
    far_m = std::max(far_m, origin_m * other.range_fraction.max + radius_m(other.target->mesh));
  }
  return far_m;
}

bool is_one_of(const std::string& name, const std::vector<std::string>& names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string three_digits(double value) {
  return fmt::format("{:.3g}", value);
}

// A scene looks at the middle of its target, wherever that has its origin.
std::string aim_line(const Eigen::Vector3d& middle, double radius) {
  if (middle.norm() <= 1e-9 * radius) return "";
  return fmt::format("aim_m = [{}, {}, {}]\n", middle.x() + 0.0, middle.y() + 0.0,
                     middle.z() + 0.0);
}

Json manifest_json(const SetPlan& plan) {
  Json objects = Json::array();
  for (size_t i = 0; i < plan.objects.size(); ++i) {
    objects.push_back({{"obj_id", i + 1}, {"target", plan.objects[i]->name}});
  }
  Json json = {{"version", SIGHTLINE_VERSION},
               {"name", plan.study.name},
               {"seed", plan.study.seed},
               {"count", plan.count},
               {"images_a_scene", plan.chunk},
               {"format", plan.format->name},
               {"truth", plan.has_full_truth ? "full" : "minimal"},
               {"gl", plan.gl},
               {"depth_scale", plan.depth_scale},
               {"objects", objects}};
  const std::vector<std::string> also = names_of(plan.extras);
  if (!also.empty()) json["also"] = also;
  return json;
}

}  // namespace

std::string default_scene(const std::string& target, const MeshUse& use) {
  constexpr int kSide = 512;
  constexpr double kFocal = 2000;
  constexpr double kLargest = 0.7;  // of the image's width
  constexpr double kSmallest = 0.3;
  const std::shared_ptr<const Target> loaded = load_target(target, use);
  if (const std::string reason = why_not_renderable(*loaded); !reason.empty()) {
    throw InputError(fmt::format("{}: {}", target, reason));
  }
  const Eigen::Vector3d middle = middle_m(loaded->mesh);
  const double radius = radius_m(loaded->mesh, middle);
  const double near_m = kFocal * 2 * radius / (kLargest * kSide);
  const double far_m = kFocal * 2 * radius / (kSmallest * kSide);
  // The smallest margin beside the target, halved.
  const double lateral_m = near_m * (1 - kLargest) / 4 * kSide / kFocal;
  const bool is_file = fs::path(target).has_extension() || target.find('/') != std::string::npos;
  const std::string named = is_file ? fs::absolute(target).lexically_normal().string() : target;
  return fmt::format(R"(# The default scene of its target: made from its size.
name = {0}
target = {1}

[camera]
width_px = {2}
height_px = {2}
f_px = {3}.0

[poses]
attitude = "uniform"
lateral_m = [-{4}, {4}]
range_m = [{5}, {6}]
{7}
[background]
level = [0.02, 0.3]
)",
                     toml_text(is_file ? plain_name(fs::path(target).stem().string()) : target),
                     toml_text(named), kSide, kFocal, three_digits(lateral_m), three_digits(near_m),
                     three_digits(far_m), aim_line(middle, radius));
}

Study read_set_study(const std::string& source, const StudyOverrides& overrides,
                     const MeshUse& use) {
  const fs::path path(source);
  const bool is_file = path.has_extension() || source.find('/') != std::string::npos;
  if (is_file && path.extension() == ".toml" && path.filename() != "target.toml") {
    return read_scene(source, overrides);
  }
  if (!is_file && is_one_of(source, study_names())) return read_scene(source, overrides);
  if (!is_file && !is_one_of(source, target_names())) {
    std::vector<std::string> names = target_names();
    for (const std::string& study : study_names()) names.push_back(study);
    throw InputError(
        fmt::format("'{}' is neither a target nor a study{}", source, suggestion(source, names)));
  }
  const TargetMemory memory;  // the scene is made for the mesh, and then reads it
  return read_scene_text(default_scene(source, use), path.stem().string() + " (default scene)",
                         overrides);
}

double farthest_m(const ImageStudy& study) {
  double far_m = 0;
  for (const ImageSetup& setup : study.setups) far_m = std::max(far_m, farthest_of(setup.scene));
  return far_m;
}

double finest_depth_scale(double far_m) {
  const double scale = 1000 * far_m / kLargestDepth;
  const double unit = std::pow(10, std::floor(std::log10(scale)) - 3);
  return std::stod(fmt::format("{:.3e}", std::ceil(scale / unit) * unit));
}

int object_id(const SetPlan& plan, const Target& target) {
  for (size_t i = 0; i < plan.objects.size(); ++i) {
    if (is_same(*plan.objects[i], target)) return static_cast<int>(i) + 1;
  }
  return 0;
}

bool shows_colours(const SetPlan& plan) {
  return std::ranges::any_of(plan.images().setups, [](const ImageSetup& setup) {
    return setup.scene.colouring.mode != ColourMode::kGrey;
  });
}

bool shows_grey(const SetPlan& plan) {
  return std::ranges::any_of(plan.images().setups, [](const ImageSetup& setup) {
    return setup.scene.colouring.mode == ColourMode::kGrey;
  });
}

SetPlan plan_set(const SetRequest& request) {
  SetPlan plan;
  plan.format = &find_set_format(request.format);
  plan.study = read_set_study(request.source, request.overrides, request.mesh);
  plan.count = request.count;
  plan.chunk = request.chunk;
  plan.has_full_truth = request.has_full_truth;
  plan.extras = extras_named(request.also);
  const std::vector<std::string> possible = names_of(plan.format->extras);
  for (const std::string& name : request.also) {
    if (is_one_of(name, possible)) continue;
    throw InputError(fmt::format("--also {}: the format {} has no place for it, but for {}", name,
                                 plan.format->name, fmt::join(possible, ", ")));
  }
  if (plan.extras.has_rgb_of_grey && !shows_grey(plan)) {
    throw InputError("--also rgb: is of sets in grey; this one is in colour, and has rgb/ anyway");
  }
  if (!shows_colours(plan)) plan.extras = joined(plan.extras, plan.format->grey_extras);
  plan.gl = request.gl;
  plan.depth_scale = request.depth_scale.value_or(finest_depth_scale(farthest_m(plan.images())));
  plan.objects = objects_of(plan.images());
  return plan;
}

std::string manifest_of(const SetPlan& plan) {
  return manifest_json(plan).dump(2) + "\n";
}

SetPlan read_plan(const fs::path& folder) {
  const fs::path file = folder / "sightline.json";
  const std::string text = read_input_file(file, kMostTextBytes);
  try {
    const Json json = parse_json(text, file.string());
    SetPlan plan;
    plan.format = &find_set_format(json.at("format").get<std::string>());
    plan.study = read_scene_text(read_input_file(folder / "scene.toml", kMostTextBytes),
                                 folder / "scene.toml");
    plan.count = json.at("count").get<int64_t>();
    plan.chunk = json.at("images_a_scene").get<int>();
    plan.has_full_truth = json.at("truth") == "full";
    plan.extras = extras_named(json.value("also", std::vector<std::string>()));
    plan.gl = json.at("gl").get<std::string>();
    plan.depth_scale = json.at("depth_scale").get<double>();
    plan.objects = objects_of(plan.images());
    const bool is_sound =
        plan.count > 0 && plan.chunk > 0 && plan.depth_scale > 0 && gl_choice(plan.gl).has_value();
    if (!is_sound || manifest_of(plan) != text) {
      throw InputError(fmt::format("{}: does not fit scene.toml and this version ({})",
                                   file.string(), SIGHTLINE_VERSION));
    }
    return plan;
  } catch (const Json::exception&) {
    throw InputError(fmt::format("{}: is not what a set's sightline.json holds", file.string()));
  }
}

DrawnScene draw_scene(const SetPlan& plan, int64_t index) {
  const ImageStudy& images = plan.images();
  const int condition = plan.study.condition_of(index);
  return draw_scene(images.setup_of(condition).scene, images.cells[condition].pose, plan.study.seed,
                    images.draw_of(index));
}

SetImage render_image(const SetPlan& plan, int64_t index, Renderer& renderer) {
  SetImage image;
  image.index = index;
  image.drawn = draw_scene(plan, index);
  if (!image.drawn.is_imageable) return image;
  const auto draw = static_cast<uint64_t>(plan.images().draw_of(index));
  image.frame = renderer.render(image.drawn.scene, RandomStream(plan.study.seed, "sensor", draw));
  return image;
}

}  // namespace sightline
