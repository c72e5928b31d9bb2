// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/image_sets/estimate.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/image_sets/set_format.h"
#include "eval/image_sets/truth.h"
#include "renderer/gl_context.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int kSamples = 20;
constexpr double kBlock = 4096;  // file systems give a file whole blocks

struct Cost {
  int images = 0;
  double render_ms = 0;
  double encode_ms = 0;
  double files = 0;
  double bytes = 0;
  double blocks = 0;
};

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

void add_files(Cost& cost, const std::vector<SetFile>& files) {
  for (const SetFile& file : files) {
    const auto size = static_cast<double>(file.bytes.size());
    ++cost.files;
    cost.bytes += size;
    cost.blocks += std::ceil(size / kBlock);
  }
}

void add_image(Cost& cost, const SetPlan& plan, int64_t index, Renderer& renderer) {
  auto start = Clock::now();
  const SetImage image = render_image(plan, index, renderer);
  if (!image.drawn.is_imageable) return;
  cost.render_ms += ms_since(start);
  start = Clock::now();
  add_files(cost, files_of(plan, image));
  cost.encode_ms += ms_since(start);
  ++cost.images;
}

// The free bytes where the set would lie; none where nobody says.
std::optional<double> free_bytes(fs::path at) {
  std::error_code error;
  at = fs::absolute(at, error);
  while (!fs::exists(at, error) && at.has_relative_path()) at = at.parent_path();
  const fs::space_info space = fs::space(at, error);
  if (error) return std::nullopt;
  return static_cast<double>(space.available);
}

std::string in_bytes(double bytes) {
  constexpr std::array kUnits = {"B", "kB", "MB", "GB", "TB"};
  size_t unit = 0;
  for (; bytes >= 999.5 && unit + 1 < kUnits.size(); ++unit) bytes /= 1000;
  return fmt::format("{:.3g} {}", bytes, kUnits[unit]);
}

std::string in_time(double seconds) {
  if (seconds < 90) return fmt::format("{:.0f} s", std::max(1.0, seconds));
  if (seconds < 90 * 60) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

std::string truth_name(const SetPlan& plan) {
  return plan.has_full_truth ? "full" : "minimal";
}

double depth_reach_m(const SetPlan& plan) {
  return 65535 * plan.depth_scale / 1000;
}

// Each once, however many cells there are.
std::string notes_on_surfaces(const SetPlan& plan) {
  std::vector<std::string> lines;
  const auto add = [&lines](const SceneLaw& law, const Target& target) {
    for (const std::string& note : surface_notes(law.colouring, target.mesh)) {
      const std::string line = fmt::format("note: {}: {}\n", target.name, note);
      if (std::find(lines.begin(), lines.end(), line) == lines.end()) lines.push_back(line);
    }
  };
  for (const ImageSetup& setup : plan.images().setups) {
    add(setup.scene, *setup.scene.target);
    for (const OtherLaw& other : setup.scene.others) add(setup.scene, *other.target);
  }
  return fmt::format("{}", fmt::join(lines, ""));
}

}  // namespace

std::string warnings_of(const SetPlan& plan) {
  std::string text;
  const double reach_m = depth_reach_m(plan);
  const double far_m = farthest_m(plan.images());
  if (reach_m < far_m) {
    text += fmt::format(
        "warning: depth_scale {} ends at {:.6g} m, the scenes reach {:.6g} m; what is beyond gets "
        "depth 0 (finest that reaches all: {})\n",
        plan.depth_scale, reach_m, far_m, finest_depth_scale(far_m));
  }
  text += notes_on_surfaces(plan);
  const Camera& camera = plan.images().setups.front().scene.camera;
  if (!is_pinhole(camera.lens) && !plan.format->lens_note.empty()) {
    text += fmt::format("warning: {}\n", plan.format->lens_note);
  }
  return text;
}

SetEstimate estimate_set(const SetPlan& plan, int jobs, const fs::path& out) {
  Renderer renderer({.gl = gl_choice(plan.gl).value()});
  Cost cost;
  Cost warm_up;
  const int64_t samples = std::min<int64_t>(kSamples, plan.count);
  add_image(warm_up, plan, 0, renderer);
  for (int64_t i = 0; i < samples; ++i) {
    add_image(cost, plan, i * plan.count / samples, renderer);
  }
  SetEstimate estimate;
  estimate.sampled = cost.images;
  estimate.jobs = jobs;
  if (cost.images == 0) return estimate;
  const double n = cost.images;
  const auto images = static_cast<double>(plan.count);
  estimate.render_ms = cost.render_ms / n;
  estimate.encode_ms = cost.encode_ms / n;
  estimate.image_files = cost.files / n;
  estimate.image_bytes = cost.bytes / n;
  estimate.seconds = (cost.render_ms + cost.encode_ms) / n * images / 1000 / jobs;
  estimate.files = cost.files / n * images;
  estimate.bytes = cost.bytes / n * images;
  estimate.disk_bytes = kBlock * cost.blocks / n * images;
  estimate.free_bytes = free_bytes(out);
  return estimate;
}

std::string text_of(const SetEstimate& estimate, const SetPlan& plan) {
  if (estimate.sampled == 0) return "none of the sampled scenes can be imaged\n";
  const Camera& camera = plan.images().setups.front().scene.camera;
  std::string text = fmt::format(
      "{} images of {} x {} px, {} a scene, format {}, truth {}\n"
      "an image    {:.1f} ms to render, {:.1f} ms to encode, {:.3g} files, {}\n"
      "time        {} with {} job{} ({:.0f} images/s, if there is a processor for each)\n"
      "disk        {} in {:.0f} files, {} in blocks of {} bytes\n",
      plan.count, camera.width_px, camera.height_px, plan.chunk, plan.format->name,
      truth_name(plan), estimate.render_ms, estimate.encode_ms, estimate.image_files,
      in_bytes(estimate.image_bytes), in_time(estimate.seconds), estimate.jobs,
      estimate.jobs == 1 ? "" : "s", static_cast<double>(plan.count) / estimate.seconds,
      in_bytes(estimate.bytes), estimate.files, in_bytes(estimate.disk_bytes), kBlock);
  text += fmt::format("depth_scale {} mm a step: reaches {:.6g} m, the scenes reach {:.6g} m\n",
                      plan.depth_scale, depth_reach_m(plan), farthest_m(plan.images()));
  if (estimate.free_bytes && *estimate.free_bytes < estimate.disk_bytes) {
    text += fmt::format("warning: only {} are free there\n", in_bytes(*estimate.free_bytes));
  }
  return text;
}

Json json_of(const SetEstimate& estimate, const SetPlan& plan) {
  const Camera& camera = plan.images().setups.front().scene.camera;
  Json json = {{"images", plan.count},
               {"width_px", camera.width_px},
               {"height_px", camera.height_px},
               {"scene_size", plan.chunk},
               {"format", plan.format->name},
               {"truth", truth_name(plan)},
               {"depth_scale_mm", plan.depth_scale},
               {"depth_reach_m", depth_reach_m(plan)},
               {"scenes_reach_m", farthest_m(plan.images())},
               {"sampled_images", estimate.sampled},
               {"jobs", estimate.jobs}};
  const bool is_known = estimate.sampled > 0;
  const auto number = [is_known](double value) { return is_known ? Json(value) : Json(nullptr); };
  const auto whole = [is_known](double value) {
    return is_known ? Json(std::llround(value)) : Json(nullptr);
  };
  json["image"] = {{"render_ms", number(estimate.render_ms)},
                   {"encode_ms", number(estimate.encode_ms)},
                   {"files", number(estimate.image_files)},
                   {"bytes", number(estimate.image_bytes)}};
  json["seconds"] = number(estimate.seconds);
  json["files"] = whole(estimate.files);
  json["bytes"] = whole(estimate.bytes);
  json["disk_bytes"] = whole(estimate.disk_bytes);
  json["free_bytes"] =
      estimate.free_bytes ? Json(std::llround(*estimate.free_bytes)) : Json(nullptr);
  return json;
}

}  // namespace sightline
