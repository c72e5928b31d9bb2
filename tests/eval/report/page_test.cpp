// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Reports of real studies in a real browser, without a window: a script put into a copy of the page
// uses it as a reader would, and leaves what it saw in an attribute.
#include <cstdlib>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

bool has_browser() {
  return std::system("chromium --version > /dev/null 2>&1") == 0;
}

int run(const std::string& command) {
  return std::system(command.c_str());
}

struct Opened {
  std::string dom;      // after the scripts
  std::string console;  // what they complained of
  nlohmann::json saw;   // what the test's script says
};

std::string console_lines(const std::string& log) {
  std::string lines;
  for (size_t at = log.find("CONSOLE"); at != std::string::npos; at = log.find("CONSOLE", at + 1)) {
    lines += log.substr(at, log.find('\n', at) - at) + "\n";
  }
  return lines;
}

// Opens a page with a script at its end, whose expression is what it saw.
Opened open_page(const fs::path& folder, const fs::path& page, const std::string& script) {
  std::string html = read_whole(page);
  const size_t end = html.rfind("</body>");
  html.insert(
      end == std::string::npos ? html.size() : end,
      "<script>document.documentElement.dataset.saw = encodeURIComponent(JSON.stringify((() "
      "=> {" +
          script + "})()));</script>\n");
  const fs::path copy = folder / "page.html";
  std::ofstream(copy, std::ios::binary) << html;
  const std::string command = fmt::format(
      "timeout 100 chromium --headless --no-sandbox --disable-gpu --disable-quic --no-first-run "
      "--disable-background-networking --disable-component-update --disable-sync "
      "--user-data-dir='{0}/profile' --window-size=1280,900 --virtual-time-budget=5000 "
      "--enable-logging=stderr --v=0 --dump-dom 'file://{1}' > '{0}/dom.html' 2> '{0}/log.txt'",
      folder.string(), copy.string());
  EXPECT_EQ(run(command), 0);
  Opened opened{read_whole(folder / "dom.html"), console_lines(read_whole(folder / "log.txt")), {}};
  const std::string mark = "data-saw=\"";
  const size_t begin = opened.dom.find(mark);
  if (begin == std::string::npos) return opened;
  const size_t from = begin + mark.size();
  std::string text;
  const std::string escaped = opened.dom.substr(from, opened.dom.find('"', from) - from);
  for (size_t i = 0; i < escaped.size(); ++i) {
    if (escaped[i] == '%') {
      text += static_cast<char>(std::stoi(escaped.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      text += escaped[i];
    }
  }
  opened.saw = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  return opened;
}

fs::path report_of(const fs::path& folder, const std::string& study) {
  EXPECT_EQ(run(fmt::format("{} study {} --quiet --out '{}/run' > /dev/null 2>&1",
                            SIGHTLINE_PROGRAM, study, folder.string())),
            0);
  return folder / "run" / "report.html";
}

// How many of a chart's pixels are painted, and in how many colours.
constexpr const char* kPainted = R"js(
const painted = [...document.querySelectorAll('figure.chart canvas')].map((canvas) => {
  const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
  const colours = new Set();
  for (let i = 0; i < data.length; i += 4) {
    if (data[i + 3] > 200) colours.add(data[i] << 16 | data[i + 1] << 8 | data[i + 2]);
  }
  return {ready: Number(canvas.dataset.ready), colours: colours.size};
});
)js";

TEST(Page, DrawsEveryChartOfASweepInABrowser) {
  if (!has_browser()) GTEST_SKIP() << "no chromium here";
  const TemporaryFolder folder;
  const fs::path page = report_of(folder.path(), "cube-noise --trials 12");
  const Opened opened = open_page(folder.path(), page, std::string(kPainted) + R"js(
    const figure = document.querySelector('figure.chart');
    const series = figure.querySelectorAll('.series button');
    const canvas = figure.querySelector('canvas');
    const before = canvas.toDataURL();
    series[0].click();
    const hidden = series[0].getAttribute('aria-pressed');
    const after = canvas.toDataURL();
    const select = document.querySelector('[data-group="cumulative-theta"] select');
    select.value = 2;
    select.dispatchEvent(new Event('change'));
    const table = figure.querySelector('details.data');
    table.open = true;
    const light = getComputedStyle(document.body).backgroundColor;
    document.getElementById('theme').click();
    return {painted, places: document.querySelectorAll('figure.chart').length,
      hidden, changed: before !== after, chosen: document.querySelector(
        '[data-group="cumulative-theta"] canvas').dataset.chart,
      turned: light !== getComputedStyle(document.body).backgroundColor,
      wide: document.documentElement.scrollWidth <= innerWidth,
      named: [...document.querySelectorAll('canvas')].every((c) =>
        c.getAttribute('role') === 'img' && c.getAttribute('aria-label').length > 20)};
  )js");
  EXPECT_EQ(opened.console, "");
  ASSERT_TRUE(opened.saw.is_object()) << "the page's script did not run to its end";
  EXPECT_EQ(opened.saw["painted"].size(), opened.saw["places"]);
  EXPECT_GE(opened.saw["places"], 11);  // five quantities; two errors, three ways; the angles
  for (const auto& chart : opened.saw["painted"]) {
    EXPECT_GE(chart["ready"], 1);
    EXPECT_GE(chart["colours"], 4);
  }
  EXPECT_EQ(opened.saw["hidden"], "false");
  EXPECT_EQ(opened.saw["changed"], true);
  EXPECT_EQ(opened.saw["chosen"], "cumulative-theta-3");
  EXPECT_EQ(opened.saw["turned"], true);
  EXPECT_EQ(opened.saw["wide"], true) << "the page scrolls sideways";
  EXPECT_EQ(opened.saw["named"], true);
}

TEST(Page, ExploresFramesInABrowser) {
  if (!has_browser()) GTEST_SKIP() << "no chromium here";
  const TemporaryFolder folder;
  // So many trials that some are not in the page, and small images.
  const fs::path page = report_of(folder.path(),
                                  "boeing-random --trials 66 --set 'solvers=[\"orpe\"]'"
                                  " --set image.samples_per_pixel=1 --set camera.width_px=256"
                                  " --set camera.height_px=256 --set camera.f_px=5000");
  const Opened opened = open_page(folder.path(), page, std::string(kPainted) + R"js(
    const place = document.querySelector('.explorer');
    const [solver, order, condition, kind, extent] = place.querySelectorAll('.choices select');
    const list = place.querySelector('select[size]');
    const shown = () => [...document.querySelectorAll('article.frame')].filter((a) => a.offsetHeight > 0);
    const choose = (select, value) => {
      select.value = value;
      select.dispatchEvent(new Event('change'));
    };
    const errors = [...list.options].map((option) => parseFloat(option.text) || Infinity);
    const sorted = errors.every((error, i) => i === 0 || error <= errors[i - 1]);
    const first = shown().map((a) => a.id);
    place.querySelectorAll('.steps button')[1].click();
    const second = shown().map((a) => a.id);
    const svg = shown()[0].querySelector('svg.whole');
    const whole = svg.viewBox.baseVal.width;
    const box = svg.getBoundingClientRect();
    svg.dispatchEvent(new WheelEvent('wheel', {deltaY: -60, cancelable: true,
      clientX: box.left + 10, clientY: box.top + 10}));
    const zoomed = svg.viewBox.baseVal.width;
    const left = svg.viewBox.baseVal.x;
    svg.dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowRight', cancelable: true}));
    const panned = svg.viewBox.baseVal.x > left;
    shown()[0].querySelector('.zoom button:last-child').click();
    const reset = svg.viewBox.baseVal.width;
    const embedded = list.options.length;
    choose(extent, 'all');
    const all = list.options.length;
    list.value = [...list.options].find((option) => option.text.includes('not in this page')).value;
    list.dispatchEvent(new Event('change'));
    const command = place.querySelector('.absent code')?.textContent;
    const none = shown().length;
    choose(kind, kind.options.length - 2);  // the first is for all
    return {painted, sorted, first, second, whole, zoomed, panned, reset, embedded, all, command,
      none, filtered: list.options.length,
      marks: ['windows', 'lines', 'edges', 'truth', 'found', 'removed', 'outline-0'].filter(
        (layer) => document.querySelector(`svg.whole .layer-${layer}`))};
  )js");
  EXPECT_EQ(opened.console, "");
  ASSERT_TRUE(opened.saw.is_object()) << "the page's script did not run to its end";
  const auto& saw = opened.saw;
  EXPECT_EQ(saw["sorted"], true);
  ASSERT_EQ(saw["first"].size(), 1u);
  ASSERT_EQ(saw["second"].size(), 1u);
  EXPECT_NE(saw["first"], saw["second"]);
  EXPECT_LT(saw["zoomed"], saw["whole"]);
  EXPECT_EQ(saw["panned"], true);
  EXPECT_EQ(saw["reset"], saw["whole"]);
  EXPECT_EQ(saw["embedded"], 60);
  EXPECT_EQ(saw["all"], 66);
  EXPECT_THAT(
      saw["command"].get<std::string>(),
      ::testing::MatchesRegex("sightline study study.toml --shard ([0-9]+)/66 --out trial-[0-9]+"));
  EXPECT_EQ(saw["none"], 0);
  EXPECT_GE(saw["filtered"], 1);
  EXPECT_LT(saw["filtered"], 66);
  EXPECT_EQ(saw["marks"].size(), 7u) << saw["marks"];

  // What the page says of a trial that it does not show: alone it is the same trial.
  const std::string command = saw["command"];
  const std::string arguments = command.substr(std::string("sightline ").size());
  ASSERT_EQ(run(fmt::format("cd '{}/run' && {} {} --quiet", folder.path().string(),
                            SIGHTLINE_PROGRAM, arguments)),
            0);
  const std::string name = arguments.substr(arguments.rfind(' ') + 1);
  EXPECT_THAT(read_whole(folder.path() / "run" / name / "report.html"), HasSubstr("<h3"));
}

TEST(Page, DrawsTheScoresOfOthersInABrowser) {
  if (!has_browser()) GTEST_SKIP() << "no chromium here";
  const TemporaryFolder folder;
  const std::string set = (folder.path() / "set").string();
  ASSERT_EQ(
      run(fmt::format("{} render cube --count 2 --truth minimal --quiet --out '{}' > /dev/null",
                      SIGHTLINE_PROGRAM, set)),
      0);
  folder.write("results.csv",
               "scene_id,im_id,obj_id,score,R,t,time\n0,0,1,1,1 0 0 0 1 0 0 0 1,0 0 9000,-1\n");
  ASSERT_EQ(
      run(fmt::format("{0} score '{1}/results.csv' --dataset '{1}/set' --quiet --out '{1}/out'",
                      SIGHTLINE_PROGRAM, folder.path().string())),
      0);
  const Opened opened = open_page(folder.path(), folder.path() / "out" / "report.html",
                                  std::string(kPainted) +
                                      "return {painted, outlines: "
                                      "document.querySelectorAll('#worst .outline').length, "
                                      "zooms: document.querySelectorAll('#worst .zoom').length, "
                                      "sections: "
                                      "[...document.querySelectorAll('section')].map((s) => "
                                      "s.id)};");
  EXPECT_EQ(opened.console, "");
  ASSERT_EQ(opened.saw["painted"].size(), 4u);  // two recalls, curves, boxes
  for (const auto& canvas : opened.saw["painted"]) EXPECT_GE(canvas["colours"], 2) << canvas;
  EXPECT_EQ(opened.saw["sections"].size(), 7u);
  EXPECT_EQ(opened.saw["outlines"], 2);  // of the one estimate: true, estimated
  EXPECT_EQ(opened.saw["zooms"], 1);
  EXPECT_THAT(opened.dom, HasSubstr("1 of 2 instances are missed"));
}

TEST(Page, TheBrowserTestSeesAnErrorOfAScript) {
  if (!has_browser()) GTEST_SKIP() << "no chromium here";
  const TemporaryFolder folder;
  const fs::path page = folder.write("broken.html", "<!DOCTYPE html><body></body>");
  const Opened opened = open_page(folder.path(), page, "return nobody.home;");
  EXPECT_THAT(opened.console, HasSubstr("nobody"));
  EXPECT_TRUE(opened.saw.is_null());
}

TEST(Page, ReachesNothingOutside) {
  if (!has_browser()) GTEST_SKIP() << "no chromium here";
  const TemporaryFolder folder;
  const fs::path page = report_of(folder.path(), "orientation-points --trials 5");
  const Opened opened = open_page(folder.path(), page, R"js(
    document.body.append(Object.assign(new Image(), {src: 'https://example.org/x.png'}));
    return {loaded: performance.getEntriesByType('resource').map((entry) => entry.name)};
  )js");
  ASSERT_TRUE(opened.saw.is_object());
  EXPECT_EQ(opened.saw["loaded"].size(), 0u) << opened.saw["loaded"];
  EXPECT_THAT(opened.console, HasSubstr("Content Security Policy"))
      << "the page's policy forbids it";
}

}  // namespace
}  // namespace sightline
