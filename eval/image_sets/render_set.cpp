// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/image_sets/render_set.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "eval/image_sets/join.h"
#include "eval/image_sets/set_format.h"
#include "eval/image_sets/set_lock.h"
#include "eval/image_sets/truth.h"
#include "eval/output/output_folder.h"
#include "eval/work/interrupt.h"
#include "eval/work/memory.h"
#include "eval/work/shares.h"
#include "renderer/gl_context.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// Empty where there is none that could be ours.
std::string text_of(const fs::path& file) {
  return bytes_of_file(file, kMostTextBytes).value_or("");
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_directory(folder, error)) {
    throw InputError(fmt::format("--out {}: exists and is not a folder", folder.string()));
  }
  fs::create_directories(folder, error);
  if (error) {
    throw InputError(
        fmt::format("--out {}: cannot be written ({})", folder.string(), error.message()));
  }
}

// What somebody's manifest says; null where it is no JSON.
Json manifest_in(const std::string& text) {
  try {
    return parse_json(text, "sightline.json");
  } catch (const InputError&) {
    return {};
  }
}

// The first key in which two manifests differ.
std::string difference(const std::string& there, const std::string& asked) {
  const Json a = manifest_in(there);
  const Json b = Json::parse(asked);
  if (!a.is_object()) return "holds no manifest that can be read";
  const auto told = [&](const std::string& key) {
    const Json before = a.contains(key) ? a[key] : Json("nothing");
    if (before == b.at(key)) return std::string();
    return fmt::format("was begun with {} {}, not {}", key, before.dump(), b.at(key).dump());
  };
  const std::string kCount = "count";  // a larger one alone would be no difference
  for (const auto& [key, value] : b.items()) {
    if (const std::string text = told(key); key != kCount && !text.empty()) return text;
  }
  for (const auto& [key, value] : a.items()) {
    if (!b.contains(key)) return fmt::format("was begun with {} {}", key, value.dump());
  }
  const std::string text = told(kCount);
  return text.empty() ? "was begun with another manifest" : text;
}

// A folder that holds something, and no set, is somebody else's.
void refuse_foreign(const fs::path& folder) {
  const std::set<fs::path> ours = {".lock", "scene.toml", "scene.toml.partial",
                                   "sightline.json.partial"};
  if (fs::exists(folder / "sightline.json")) return;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (ours.contains(entry.path().filename())) continue;
    throw InputError(fmt::format(
        "--out {}: exists and is not empty; remove it or name another folder", folder.string()));
  }
}

// Whether the set that is there is this one but for images at its end.
bool is_beginning(const std::string& there, const SetPlan& plan) {
  const Json manifest = manifest_in(there);
  if (!manifest.is_object() || !manifest.contains("count")) return false;
  const Json& count = manifest["count"];
  if (!count.is_number_integer() || !(count < plan.count)) return false;
  SetPlan shorter = plan;
  shorter.count = count.get<int64_t>();
  return manifest_of(shorter) == there;
}

// A set that lacks something has no list of its images, which would say that it is whole.
void remove_list(const SetPlan& plan, const fs::path& folder) {
  std::error_code none;
  fs::remove(folder / plan.format->list_path, none);
}

// The folder is this set's from here on, or was. A set that ended earlier is continued: until all
// images are there it has no list of them, as if it had just been begun.
void claim(const SetPlan& plan, const fs::path& folder, bool is_resumed) {
  const fs::path manifest = folder / "sightline.json";
  const fs::path scene = folder / "scene.toml";
  if (!fs::exists(manifest)) {
    write_file(scene, plan.study.toml);
    write_file(manifest, manifest_of(plan));
    return;
  }
  const std::string there = text_of(manifest);
  const bool is_longer = is_resumed && is_beginning(there, plan);
  if (!is_longer && there != manifest_of(plan)) {
    const char* const hint = is_beginning(there, plan) ? "; --resume makes it longer" : "";
    throw InputError(
        fmt::format("--out {}: {}{}", folder.string(), difference(there, manifest_of(plan)), hint));
  }
  if (text_of(scene) != plan.study.toml) {
    throw InputError(fmt::format("--out {}: was begun with other keys of the scene {}",
                                 folder.string(), plan.study.name));
  }
  if (!is_longer) return;
  remove_list(plan, folder);
  write_file(manifest, manifest_of(plan));
}

// Another process may have begun to make the set longer while this one did its images.
void require_unchanged(const SetPlan& plan, const fs::path& folder) {
  const std::string there = text_of(folder / "sightline.json");
  const std::string asked = manifest_of(plan);
  if (there == asked) return;
  throw InputError(fmt::format(
      "--out {}: was made another set while this run made its images ({}); they are kept: run it "
      "again for that set, with --resume",
      folder.string(), difference(there, asked)));
}

bool is_done(const SetPlan& plan, const fs::path& folder, int64_t index) {
  std::error_code none;
  return fs::exists(folder / truth_path(plan, index), none);
}

// Which images of a shard are there, by their place in it.
std::vector<bool> done_in(const SetPlan& plan, const fs::path& folder, const Shard& shard) {
  std::vector<bool> done;
  for (int64_t index = shard.index; index < plan.count; index += shard.count) {
    done.push_back(is_done(plan, folder, index));
  }
  return done;
}

// The images of a shard that are there, but for a file that is gone.
std::set<int64_t> broken_in(const SetPlan& plan, const fs::path& folder, const Shard& shard) {
  std::set<int64_t> broken;
  for (int64_t index = shard.index; index < plan.count; index += shard.count) {
    stop_if_interrupted();
    if (is_done(plan, folder, index) && !has_all_files(folder, plan, index)) broken.insert(index);
  }
  return broken;
}

// Broken images lose their truth: without it they are made again.
void forget(const std::set<int64_t>& broken, const SetPlan& plan, const fs::path& folder) {
  if (broken.empty()) return;
  remove_list(plan, folder);
  std::error_code none;
  for (const int64_t index : broken) fs::remove(folder / truth_path(plan, index), none);
}

// What the images of a shard that are to be made draw of folders is read before any is begun.
void check_drawn_files(const SetPlan& plan, const fs::path& folder, const Shard& shard,
                       const std::set<int64_t>& broken) {
  CheckedFiles checked;
  for (int64_t index = shard.index; index < plan.count; index += shard.count) {
    if (is_done(plan, folder, index) && !broken.contains(index)) continue;
    stop_if_interrupted();
    const ImageStudy& images = plan.images();
    check_drawn_files(images.setup_of(plan.study.condition_of(index)).scene, plan.study.seed,
                      images.draw_of(index), checked);
  }
}

// A shard that is resumed has looked for its own images' files, and asks for those of the others.
bool is_all_done(const SetPlan& plan, const fs::path& folder, bool asks_for_files) {
  for (int64_t index = 0; index < plan.count; ++index) {
    stop_if_interrupted();
    if (!is_done(plan, folder, index)) return false;
    if (asks_for_files && !has_all_files(folder, plan, index)) return false;
  }
  return true;
}

// Writes the files of images, each into folders that it makes when first seen.
class SetWriter {
 public:
  SetWriter(const SetPlan& plan, const fs::path& folder) : plan_(plan), folder_(folder) {}

  void write(const SetImage& image) {
    for (const SetFile& file : files_of(plan_, image)) write(file);
  }

 private:
  void write(const SetFile& file) {
    const fs::path path = folder_ / file.path;
    if (made_.insert(path.parent_path()).second) {
      std::error_code error;  // that of the file will say it
      fs::create_directories(path.parent_path(), error);
    }
    write_file(path, file.bytes);
  }

  const SetPlan& plan_;
  const fs::path& folder_;
  std::set<fs::path> made_;
};

void render_share(const SetPlan& plan, const fs::path& folder, const Shard& shard,
                  const Tick& tick) {
  SetWriter writer(plan, folder);
  Renderer renderer({.gl = gl_choice(plan.gl).value()});
  for (int64_t index = shard.index; index < plan.count; index += shard.count) {
    if (is_done(plan, folder, index)) continue;
    stop_if_interrupted();
    writer.write(render_image(plan, index, renderer));
    tick();
  }
}

}  // namespace

SetResult render_set(const SetPlan& plan, const SetOptions& options) {
  const Camera& camera = plan.images().setups.front().scene.camera;
  const std::string why_not =
      why_no_memory(camera.width_px, camera.height_px, options.jobs, free_memory_bytes());
  if (!why_not.empty()) throw InputError(fmt::format("camera.width_px: {}", why_not));
  const fs::path& folder = options.out;
  std::set<int64_t> broken;
  if (options.is_resumed) broken = broken_in(plan, folder, options.shard);
  check_drawn_files(plan, folder, options.shard, broken);
  make_folder(folder);
  refuse_foreign(folder);
  const SetLock lock(folder, options.shard);
  {
    const SetLock::Alone alone(lock);
    claim(plan, folder, options.is_resumed);
    forget(broken, plan, folder);
  }
  const std::vector<bool> done = done_in(plan, folder, options.shard);
  SetResult result;
  result.images = static_cast<int64_t>(done.size());
  result.resumed = std::count(done.begin(), done.end(), true);
  if (result.resumed > 0 && !options.is_resumed) {
    throw InputError(fmt::format("--out {}: holds {} of this run's images; continue with --resume",
                                 folder.string(), result.resumed));
  }
  const ShardWork work{.label = plan.study.name,
                       .shard = options.shard,
                       .to_do = result.images - result.resumed,
                       .jobs = options.jobs,
                       .show_progress = options.show_progress};
  try {
    if (work.to_do > 0) {
      run_shares(work, [&](int, const Shard& share, const Tick& tick) {
        render_share(plan, folder, share, tick);
      });
    }
    const SetLock::Alone alone(lock);
    require_unchanged(plan, folder);
    result.is_complete = is_all_done(plan, folder, options.is_resumed && options.shard.count > 1);
    if (!result.is_complete) remove_list(plan, folder);
    if (result.is_complete) result.failed = join_set(plan, folder, options.jobs);
  } catch (const Interrupted&) {
    throw Interrupted("interrupted; finished images are kept for --resume");
  }
  return result;
}

}  // namespace sightline
