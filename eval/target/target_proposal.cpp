// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/target/target_proposal.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <opencv2/imgproc.hpp>

#include "renderer/renderer.h"
#include "scenes/builders/target_file.h"
#include "scenes/files/input_error.h"
#include "scenes/files/toml_text.h"
#include "scenes/target/proposal.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr double kLeastSizeM = 1e-4;  // edges of a target must be longer than a nanometre

// Decimals with which a coordinate is known to some 1e-5 of the size; the micrometre or finer.
int decimals_for(double size_m) {
  return std::max(6, static_cast<int>(std::ceil(5 - std::log10(size_m))));
}

// Pitch, yaw and roll of the three views, and their captions.
struct View {
  std::vector<double> theta_deg;
  const char* caption;
};
const std::array<View, 3> kViews = {{
    {{0, 0, 0}, "from above"},
    {{-35, 25, 20}, "from above, aft and port"},
    {{150, 25, 20}, "from below"},
}};

const cv::Scalar kMark(40, 40, 255);  // BGR
const cv::Scalar kHidden(200, 170, 120);
const cv::Scalar kEdge(40, 200, 255);
const cv::Scalar kText(255, 255, 255);
const cv::Scalar kHalo(0, 0, 0);

void draw_text(cv::Mat& image, const std::string& text, cv::Point at, double scale) {
  cv::putText(image, text, at, cv::FONT_HERSHEY_SIMPLEX, scale, kHalo, 4, cv::LINE_AA);
  cv::putText(image, text, at, cv::FONT_HERSHEY_SIMPLEX, scale, kText, 1, cv::LINE_AA);
}

cv::Point2d pixel_of(const Scene& scene, const Eigen::Vector3d& x_in_target) {
  const auto pixel = project(scene.camera, scene.cam_from_target * x_in_target);
  return pixel ? cv::Point2d(pixel->x(), pixel->y()) : cv::Point2d(-1, -1);
}

// Where a label keeps clear of those drawn before: round the mark, then farther out.
cv::Point label_place(cv::Point mark, const std::vector<cv::Point>& taken) {
  for (int ring = 0; ring < 4; ++ring) {
    for (const cv::Point step : {cv::Point(9, -7), {9, 19}, {-29, -7}, {-29, 19}, {-8, -16}}) {
      const cv::Point place = mark + step * (1 + ring);
      const bool is_free = std::none_of(taken.begin(), taken.end(), [&](cv::Point other) {
        return std::abs(other.x - place.x) < 24 && std::abs(other.y - place.y) < 16;
      });
      if (is_free) return place;
    }
  }
  return mark + cv::Point(9, -7);
}

// The target from one side: what is visible as dots with their edges, what is hidden as rings.
cv::Mat draw_view(const std::shared_ptr<const Target>& target, const View& view,
                  Renderer& renderer) {
  const Scene scene = picture_scene(target, view.theta_deg);
  cv::Mat image;
  cv::cvtColor(renderer.render(scene, RandomStream(0, "picture", 0)).image, image,
               cv::COLOR_GRAY2BGR);
  std::vector<cv::Point> labels;
  for (const bool is_hidden : {true, false}) {  // what is visible is drawn over the rest
    for (size_t i = 0; i < target->features.size(); ++i) {
      const TargetFeature& feature = target->features[i];
      if (is_self_hidden(*target, feature, scene.cam_from_target) != is_hidden) continue;
      const cv::Point mark = pixel_of(scene, feature.position_m);
      for (const Edge& edge : feature.edges) {
        if (is_hidden) break;
        const cv::Point2d end = pixel_of(scene, edge.end_m);
        cv::line(image, mark, end, kEdge, 1, cv::LINE_AA);
      }
      cv::circle(image, mark, is_hidden ? 4 : 5, is_hidden ? kHidden : kMark,
                 is_hidden ? 1 : cv::FILLED, cv::LINE_AA);
      labels.push_back(label_place(mark, labels));
      if (!is_hidden) draw_text(image, std::to_string(i + 1), labels.back(), 0.55);
    }
  }
  draw_text(image, view.caption, {12, 24}, 0.6);
  return image;
}

// The names that the numbers stand for, in columns.
cv::Mat draw_legend(const Target& target, cv::Size size) {
  constexpr int kRows = 26;
  constexpr int kRowPx = 23;
  constexpr int kColumnPx = 310;
  cv::Mat image(size, CV_8UC3, cv::Scalar(38, 38, 38));
  for (size_t i = 0; i < target.features.size(); ++i) {
    const int row = static_cast<int>(i) % kRows;
    const int column = static_cast<int>(i) / kRows;
    draw_text(image, fmt::format("{:>2}  {}", i + 1, target.features[i].name),
              {20 + column * kColumnPx, 32 + row * kRowPx}, 0.55);
  }
  return image;
}

cv::Mat draw_features(const std::shared_ptr<const Target>& target) {
  Renderer renderer;
  std::array<cv::Mat, 3> views;
  for (size_t i = 0; i < views.size(); ++i) views[i] = draw_view(target, kViews[i], renderer);
  cv::Mat top, bottom, whole;
  cv::hconcat(views[0], views[1], top);
  cv::hconcat(views[2], draw_legend(*target, views[2].size()), bottom);
  cv::vconcat(top, bottom, whole);
  return whole;
}

fs::path folder_of(const std::string& given, const std::string& name) {
  fs::path folder = given.empty() ? fs::path(name) : fs::path(given);
  if (folder.extension() == ".toml") {
    if (folder.filename() != "target.toml") {
      throw InputError(
          fmt::format("--propose {}: must be a folder, or a target.toml in one", given));
    }
    folder = folder.parent_path();
  }
  if (fs::exists(folder / "target.toml")) {
    throw InputError(
        fmt::format("--propose: {} exists already; it is kept", (folder / "target.toml").string()));
  }
  return folder;
}

// The lengths of a corner's two edges.
std::string edges_text(const TargetFeature& feature) {
  if (feature.kind != FeatureKind::kLineIntersection) return "rounded";
  const auto length_m = [&](int i) { return (feature.edges[i].end_m - feature.position_m).norm(); };
  return fmt::format("{:.2f} {:>6.2f}", length_m(0), length_m(1));
}

std::string proposals_text(const std::vector<FeatureProposal>& proposals) {
  std::string out =
      "\n   #  proposed feature             position m                 edges m      visible "
      "outline\n";
  for (size_t i = 0; i < proposals.size(); ++i) {
    const TargetFeature& feature = proposals[i].feature;
    const Eigen::Vector3d& p = feature.position_m;
    out += fmt::format("{:>4}  {:<24} {:>8.3f} {:>8.3f} {:>8.3f}  {:>13}  {:>6.0f} % {:>5.0f} %\n",
                       i + 1, feature.name, p.x(), p.y(), p.z(), edges_text(feature),
                       100 * proposals[i].visible_fraction, 100 * proposals[i].outline_fraction);
  }
  out += "visible: share of 200 views over the sphere; outline: of its lesser edge\n";
  if (proposals.size() < kWantedFeatures) {
    out += fmt::format(
        "warning: {} feature{}; a study wants {} or more: add some to target.toml by hand\n",
        proposals.size(), proposals.size() == 1 ? " is all there is" : "s are all there are",
        kWantedFeatures);
  }
  return out;
}

// Takes back what it made, unless it is kept: files, and the folders that were not there before.
class Undo {
 public:
  explicit Undo(const fs::path& folder) {
    std::error_code error;
    for (fs::path at = fs::absolute(folder); !fs::exists(at, error); at = at.parent_path()) {
      made_.push_back(at);
    }
  }
  Undo(const Undo&) = delete;
  Undo& operator=(const Undo&) = delete;
  ~Undo() {
    std::error_code error;
    for (const fs::path& path : made_) fs::remove(path, error);
  }
  // Files are taken back before their folders.
  void add(const fs::path& file) {
    std::error_code error;
    if (!fs::exists(file, error)) made_.insert(made_.begin(), file);
  }
  void keep() { made_.clear(); }

 private:
  std::vector<fs::path> made_;
};

// Which parts have no features because they move.
std::string moving_text(const Mesh& mesh) {
  std::vector<std::string> names;
  for (const Part& part : mesh.parts) {
    const bool is_told = std::find(names.begin(), names.end(), part.name) != names.end();
    if (is_moving_part(part.name) && !is_told) names.push_back(part.name);
  }
  if (names.empty()) return "";
  return fmt::format("no features of what moves or blurs by its name (--hide leaves it out): {}\n",
                     fmt::join(names, ", "));
}

TargetReport write_proposal(const BuiltTarget& built, const fs::path& folder,
                            const std::string& picture_file,
                            const std::vector<FeatureProposal>& proposals) {
  const std::string picture =
      picture_file.empty() ? (folder / "features.png").string() : picture_file;
  Undo undo(folder);
  for (const char* file : {"target.toml", "mesh.glb"}) undo.add(folder / file);
  undo.add(picture);
  write_target(built, folder);
  // Read anew: what is drawn is what a study will see.
  const auto written = load_target((folder / "target.toml").string());
  write_picture(draw_features(written), picture);
  undo.keep();
  const fs::path file = folder / "target.toml";
  const std::string text =
      proposals_text(proposals) + moving_text(built.mesh) +
      fmt::format("\ntarget     {}\npicture    {}\n", file.string(), picture) +
      "next       sightline target TARGET --review review.html: judge them; --drop NAME, --add "
      "x,y,z\n";
  return {text, file};
}

}  // namespace

TargetReport propose_target(const std::shared_ptr<const Target>& target,
                            const TargetArguments& arguments) {
  const std::string name = plain_name(target->name);
  const fs::path folder = folder_of(*arguments.propose, name);
  const Bounds box = bounds(target->mesh);
  const double size_m = (box.max_m - box.min_m).norm();
  if (size_m < kLeastSizeM) {
    throw InputError(fmt::format("{}: is {:.3g} m in size, must be at least {} m (see --unit)",
                                 arguments.target, size_m, kLeastSizeM));
  }
  const std::vector<FeatureProposal> proposals =
      propose_features(target->mesh, target->occluder, {.max_features = arguments.max_features});
  if (proposals.empty()) {
    throw InputError(
        fmt::format("{}: has nothing to propose: no two straight sharp edges meet in sight, and "
                    "nothing sticks out",
                    arguments.target));
  }
  const std::string source = plain_name(fs::path(arguments.target).filename().string());
  BuiltTarget built{
      .name = name,
      .description = fmt::format("proposed from {}", source),
      .mesh = target->mesh,
      .features = {},
      .decimals = decimals_for(size_m),
      .header = fmt::format("# Proposed by `sightline target {} --propose`.\n", source)};
  for (const FeatureProposal& proposal : proposals) built.features.push_back(proposal.feature);
  return write_proposal(built, folder, arguments.picture, proposals);
}

}  // namespace sightline
