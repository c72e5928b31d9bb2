// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <iostream>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "eval/image_sets/estimate.h"
#include "eval/image_sets/extras.h"
#include "eval/image_sets/render_set.h"
#include "eval/image_sets/set_format.h"
#include "eval/image_sets/verify.h"
#include "eval/output/json.h"
#include "eval/output/plain_text.h"
#include "eval/program/commands/commands.h"
#include "eval/program/mesh_options.h"
#include "eval/work/interrupt.h"
#include "eval/work/processors.h"
#include "eval/work/progress.h"
#include "eval/work/shard.h"
#include "renderer/gl_context.h"

namespace sightline {
namespace {

constexpr int kProblemsExit = 1;
constexpr int kNotImagedExit = 4;

struct RenderArguments {
  SetRequest request;
  SetOptions options;
  std::string out;
  std::string shard;
  std::string truth = "full";
  std::string verified;
  bool is_dry_run = false;
  bool is_quiet = false;
  bool is_json = false;
};

int run_verify(const RenderArguments& arguments) {
  constexpr int64_t kMostLines = 50;
  int64_t lines = 0;
  Json told = Json::array();
  const auto tell = [&](const std::string& problem) {
    if (arguments.is_json) {
      told.push_back(problem);
      return;
    }
    if (++lines <= kMostLines) std::cout << problem << "\n";
    if (lines == kMostLines + 1) std::cout << "...\n";
  };
  SetVerdict verdict;
  {
    Progress progress("verify", planned_images(arguments.verified), !arguments.is_quiet);
    verdict = verify_set(arguments.verified, tell, [&](int64_t n) { progress.advance(n); });
  }
  const int64_t whole = verdict.images - verdict.missing;
  if (arguments.is_json) {
    const Json json = {{"set", arguments.verified},
                       {"images", verdict.images},
                       {"missing", verdict.missing},
                       {"problems", std::move(told)}};
    std::cout << json_text(json);
    return verdict.problems == 0 ? 0 : kProblemsExit;
  }
  std::cout << fmt::format("{} of {} images are there; {}\n", whole, verdict.images,
                           verdict.problems == 0 ? "all is as it should be"
                                                 : fmt::format("{} problem{}", verdict.problems,
                                                               verdict.problems == 1 ? "" : "s"));
  return verdict.problems == 0 ? 0 : kProblemsExit;
}

void print_result(const SetPlan& plan, const SetResult& result, const SetOptions& options,
                  bool is_json) {
  if (is_json) {
    const Json json = {{"set", options.out.string()},     {"images", result.images},
                       {"images_of_the_set", plan.count}, {"resumed", result.resumed},
                       {"failed", result.failed},         {"is_complete", result.is_complete}};
    std::cout << json_text(json);
    return;
  }
  if (result.resumed > 0) {
    std::cerr << fmt::format("resumed: {} of {} images were there\n", result.resumed,
                             result.images);
  }
  std::cout << fmt::format(
      "{}: {}\n", plain_line(options.out.string()),
      result.is_complete ? fmt::format("{} images, complete", plan.count)
                         : fmt::format("{} of {} images; the last shard will complete the set",
                                       result.images, plan.count));
}

int run_render(RenderArguments& arguments) {
  if (!arguments.verified.empty()) return run_verify(arguments);
  remember_interrupts();
  arguments.request.has_full_truth = arguments.truth == "full";
  if (arguments.options.jobs == 0) {
    arguments.options.jobs = arguments.shard.empty() ? usable_processors() : 1;
  }
  for (std::string& setting : mesh_settings(arguments.request.mesh)) {
    arguments.request.overrides.set.push_back(std::move(setting));
  }
  const SetPlan plan = plan_set(arguments.request);
  std::cerr << warnings_of(plan);
  if (arguments.is_dry_run) {
    const SetEstimate estimate = estimate_set(plan, arguments.options.jobs, arguments.out);
    std::cout << (arguments.is_json ? json_text(json_of(estimate, plan)) : text_of(estimate, plan));
    return 0;
  }
  SetOptions& options = arguments.options;
  options.out = arguments.out;
  options.show_progress = !arguments.is_quiet;
  options.shard = chosen_shard(arguments.shard, !arguments.is_quiet);
  const SetResult result = render_set(plan, options);
  if (!arguments.is_quiet || arguments.is_json) {
    print_result(plan, result, options, arguments.is_json);
  }
  if (result.failed == 0) return 0;
  std::cerr << fmt::format("sightline: {} of {} scenes could not be imaged (see sightline/)\n",
                           result.failed, plan.count);
  return kNotImagedExit;
}

std::string format_list() {
  std::string text;
  for (const SetFormat& format : set_formats()) {
    text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", format.name, format.summary);
  }
  return text;
}

}  // namespace

void add_render(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<RenderArguments>();
  SetRequest& request = arguments->request;
  CLI::App* sub = app.add_subcommand(
      "render", "Write an image set with its truth, or verify one that was written");
  auto* source = sub->add_option("source", request.source,
                                 "Name of a target or study, a scene or study .toml, or a mesh");
  auto* count = sub->add_option("--count", request.count, "Images of the set")
                    ->check(CLI::Range(int64_t{1}, int64_t{1'000'000'000}));
  auto* out = sub->add_option("--out", arguments->out, "Folder of the set");
  sub->add_option("--seed", request.overrides.seed, "Seed of all random draws")
      ->check(CLI::NonNegativeNumber);
  arguments->options.jobs = 0;  // see run_render
  sub->add_option("--jobs", arguments->options.jobs,
                  "Processes to run at once [as many as there are processors; one with --shard]")
      ->check(CLI::Range(1, 1024));
  sub->add_option("--shard", arguments->shard,
                  "Only images with number mod N = I, into the same folder as the other shards: "
                  "I/N, auto or auto/N (from the engine)");
  sub->add_flag("--resume", arguments->options.is_resumed,
                "Continue the set in --out, up to a larger --count too; begin where there is none");
  sub->add_option("--format", request.format, format_list())->capture_default_str();
  sub->add_option("--truth", arguments->truth, "full, or minimal: no exact depth and no part ids")
      ->check(CLI::IsMember({"full", "minimal"}))
      ->capture_default_str();
  sub->add_option(
         "--also", request.also,
         "More pictures, by commas: itodd (bop: gray/ and depth/ as .tif, which sets in grey have "
         "anyway), tiff (bop: gray/ as .tiff; bop_imagewise: .gray.tiff, which sets in grey have "
         "anyway), rgb (of either in grey), normals, nocs (object coordinates)")
      ->delimiter(',')
      ->check(CLI::IsMember(extra_names()));
  sub->add_option("--depth-scale", request.depth_scale,
                  "Millimetres a step of the 16-bit depth [the finest that reaches all]")
      ->check(CLI::Range(1e-6, 1e6));
  sub->add_option("--scene-size", request.chunk, "Images a numbered scene")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub->add_option("--set", request.overrides.set,
                  "key=value over the scene's file, for example image.bits=12; may be repeated")
      ->allow_extra_args(false);
  sub->add_option_function<std::string>(
         "--missing-textures",
         [arguments](const std::string& policy) {
           arguments->request.overrides.set.push_back(
               fmt::format("image.missing_textures=\"{}\"", policy));
         },
         "refuse or grey: draw a mesh without the textures that are lost, and say so [refuse]")
      ->check(CLI::IsMember({"refuse", "grey"}));
  add_mesh_options(*sub, request.mesh);
  const auto names = gl_choice_names();
  sub->add_option("--gl", request.gl, "Draw with OpenGL, to compare: auto, osmesa or egl")
      ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())))
      ->capture_default_str();
  sub->add_flag("--dry-run", arguments->is_dry_run,
                "Make a few images in memory and say what the set will take");
  sub->add_flag("--quiet", arguments->is_quiet, "No progress and no summary");
  sub->add_flag("--json", arguments->is_json,
                "Print the summary, or what --dry-run or --verify finds, as JSON");
  auto* verify = sub->add_option("--verify", arguments->verified,
                                 "Re-read the set in this folder and say what is missing, torn or "
                                 "inconsistent (exit code 1 if anything)");
  for (CLI::Option* option : {source, count, out}) verify->excludes(option);
  sub->callback([arguments, source, count, out, verify, &exit_code] {
    if (verify->count() == 0) {
      for (const CLI::Option* needed : {source, count, out}) {
        if (needed->count() == 0) throw CLI::RequiredError(needed->get_name());
      }
    }
    exit_code = run_render(*arguments);
  });
}

}  // namespace sightline
