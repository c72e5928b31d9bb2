// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/review/target_review.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "eval/output/html.h"
#include "eval/output/output_folder.h"
#include "eval/report/frame_svg.h"
#include "eval/report/page.h"
#include "eval/target/target_report.h"
#include "renderer/renderer.h"
#include "scenes/files/input_error.h"
#include "scenes/random/random.h"

namespace sightline {
namespace {

// Pitch, yaw and roll of a view, and its caption. Up is up in those from the sides.
struct Side {
  std::vector<double> theta_deg;
  const char* caption;
};
const std::array<Side, 6> kSides = {{{{0, 0, 0}, "from above"},
                                     {{180, 0, 0}, "from below"},
                                     {{-90, 180, 0}, "from port"},
                                     {{-90, 0, 0}, "from starboard"},
                                     {{-90, 90, 0}, "from ahead"},
                                     {{-90, -90, 0}, "from behind"}}};

constexpr double kGoodPx = 2;      // a median error beyond is no point to go by
constexpr double kFewFound = 0.5;  // of the views that show it

constexpr double kNamesBesideUpTo = 720;  // px: farther right, names stand to the left of marks

// Of the space that a name takes, the lower left corner.
struct Label {
  double x, y;
};

constexpr double kWidth = 190, kHeight = 24;  // of that space

// A name's place beside its mark, moved down until it keeps clear of those before.
Label label_place(const Eigen::Vector2d& mark, std::vector<Label>& taken) {
  const bool is_left = mark.x() > kNamesBesideUpTo;
  Label place{mark.x() + (is_left ? -14 - kWidth : 14), mark.y() + 6};
  const auto is_taken = [&](const Label& other) {
    return std::abs(other.x - place.x) < kWidth && std::abs(other.y - place.y) < kHeight;
  };
  while (std::ranges::any_of(taken, is_taken)) place.y += kHeight;
  taken.push_back(place);
  return place;
}

// A mark with its name: a dot where the feature is to be seen, a ring where the target hides it.
std::string mark_of(const TargetFeature& feature, size_t number, const Eigen::Vector2d& at,
                    bool is_hidden, std::vector<Label>& taken) {
  const std::string name = fmt::format("{} {}", number, escape_html(feature.name));
  std::string svg =
      fmt::format(R"(<g><title>{}{}</title><circle cx="{:.1f}" cy="{:.1f}" r="{}" style="fill:{};)"
                  R"(stroke:{};stroke-width:2px"/>)",
                  name, is_hidden ? ", hidden" : "", at.x(), at.y(), is_hidden ? 7 : 8,
                  is_hidden ? "none" : "#ff6a2b", is_hidden ? "#6cc7f5" : "#ffffff");
  if (!is_hidden) {
    const Label label = label_place(at, taken);
    const bool is_left = at.x() > kNamesBesideUpTo;
    const double x = is_left ? label.x + kWidth : label.x;
    svg += fmt::format(
        R"(<path d="M{:.1f} {:.1f}L{:.1f} {:.1f}" style="stroke:#ffffff"/>)"
        R"(<text x="{:.1f}" y="{:.1f}" text-anchor="{}" style="font:600 20px system-ui,)"
        R"(sans-serif;fill:#ffffff;stroke:#000000;stroke-width:4px;paint-order:stroke">{}</text>)",
        at.x(), at.y(), x, label.y - 6, x, label.y, is_left ? "end" : "start", name);
  }
  return svg + "</g>\n";
}

std::string side_html(const std::shared_ptr<const Target>& target, const Side& side,
                      Renderer& renderer) {
  const Scene scene = picture_scene(target, side.theta_deg);
  const cv::Mat image = renderer.render(scene, RandomStream(0, "picture", 0)).image;
  const cv::Rect whole({0, 0}, image.size());
  const FramePicture picture = picture_of(image, 8, whole);
  std::string marks;
  std::vector<Label> taken;
  for (const bool is_hidden : {true, false}) {  // what is seen is drawn over the rest
    for (size_t i = 0; i < target->features.size(); ++i) {
      const TargetFeature& feature = target->features[i];
      if (is_self_hidden(*target, feature, scene.cam_from_target) != is_hidden) continue;
      const auto pixel = project(scene.camera, scene.cam_from_target * feature.position_m);
      if (pixel) marks += mark_of(feature, i + 1, *pixel, is_hidden, taken);
    }
  }
  return fmt::format(
      R"(<div class="frame"><h3>{0}</h3><div class="picture">
<svg class="whole" viewBox="{1}" role="img" aria-label="The target {0}, its features marked">
<image x="-0.5" y="-0.5" width="{2}" height="{3}" href="{4}"/>
{5}</svg></div></div>
)",
      side.caption, view_box(whole), image.cols, image.rows, picture.png_url, marks);
}

std::string pictures_html(const std::shared_ptr<const Target>& target) {
  Renderer renderer;
  std::string html =
      "<p>A dot: to be seen from there; a ring: the target itself hides it.</p>\n"
      R"(<div style="display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,30rem),1fr));gap:1rem">)";
  for (const Side& side : kSides) html += side_html(target, side, renderer);
  return html + "</div>\n";
}

// What a user should think of, or nothing.
std::string remark_on(const FeatureError& error) {
  if (error.shown == 0) return "never to be seen";
  if (error.found < kFewFound * error.shown) return "seldom found";
  return error.median_px > kGoodPx ? "errs" : "";
}

std::string table_html(const Target& target, const std::vector<FeatureError>& errors) {
  std::string rows;
  for (size_t i = 0; i < errors.size(); ++i) {
    const TargetFeature& feature = target.features[i];
    const FeatureError& error = errors[i];
    const Eigen::Vector3d& p = feature.position_m;
    const bool is_known = error.found > 0;
    rows += fmt::format(
        "<tr><th scope=\"row\">{} {}</th><td class=\"text\">{}</td><td>{:.3f}</td><td>{:.3f}</td>"
        "<td>{:.3f}</td><td>{:.0f}</td><td>{}</td><td>{}</td><td>{}</td>"
        "<td class=\"text\">{}</td></tr>\n",
        i + 1, escape_html(feature.name), to_string(feature.kind), p.x(), p.y(), p.z(),
        100 * error.visible_fraction,
        error.shown > 0 ? fmt::format("{:.0f}", 100.0 * error.found / error.shown) : "",
        is_known ? fmt::format("{:.2f}", error.median_px) : "",
        is_known ? fmt::format("{:.2f}", error.p90_px) : "", remark_on(error));
  }
  return fmt::format(
      R"(<div class="scroll"><table>
<caption><span>Over {} views from all sides, 400 px to the diagonal of the target's box, 3 grey
levels of noise; looked for by edges_else_contour from a pose that errs by {} degrees, as a first
pass leaves it.</span></caption>
<thead><tr><th>feature</th><th class="text">kind</th><th>x m</th><th>y m</th><th>z m</th>
<th>to be seen %</th><th>found % of these</th><th>median error px</th><th>90 % within px</th>
<th class="text">remark</th></tr></thead>
<tbody>
{}</tbody></table></div>
)",
      kReviewViews, kReviewAttitudeDeg, rows);
}

std::string changes_html(const Target& target, const std::string& file) {
  const std::string command = fmt::format("sightline target {}", escape_html(file));
  return fmt::format(
      R"(<p>A study wants six features or more in sight. What errs, or is seldom found, is better
left out; what the pictures show and no feature marks can be added, where an outline is rounded:</p>
<pre>{0} --drop {1} --review review.html
{0} --add X,Y,Z,nose --review review.html</pre>
<p>Coordinates are metres: x forward, y starboard, z down. Corners of straight edges are added by
hand, as docs/targets.md says.</p>
)",
      command, escape_html(target.features.back().name));
}

}  // namespace

std::string review_page(const std::shared_ptr<const Target>& target,
                        const std::vector<FeatureError>& errors, const std::string& file) {
  Page page;
  page.title = fmt::format("Features of {}", escape_html(target->name));
  page.given_html = fmt::format("{} features on {} triangles · {}", target->features.size(),
                                target->mesh.triangles.size(), escape_html(file));
  if (target->features.size() < kWantedFeatures) {
    page.warning = fmt::format("{} features; a study wants {} or more", target->features.size(),
                               kWantedFeatures);
  }
  page.sections = {{"sides", "From six sides", pictures_html(target), {}},
                   {"features", "What to expect of each", table_html(*target, errors), {}},
                   {"changes", "Changing them", changes_html(*target, file), {}}};
  return render_page(page);
}

void write_review(const std::string& target, const std::filesystem::path& page) {
  if (page.extension() != ".html") {
    throw InputError(fmt::format("--review {}: must end in .html", page.string()));
  }
  const std::shared_ptr<const Target> loaded = load_target(target);
  if (const std::string reason = why_not_renderable(*loaded); !reason.empty()) {
    throw InputError(fmt::format("--review: target {}: {}", target, reason));
  }
  if (loaded->features.empty()) {
    throw InputError(fmt::format("--review: {} has no features to review (see --propose)", target));
  }
  write_file(page, review_page(loaded, feature_errors(loaded), target));
}

}  // namespace sightline
