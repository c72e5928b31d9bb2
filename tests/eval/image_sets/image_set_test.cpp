// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Image sets as a user makes them: real processes, real files, read by what nobody here wrote
// (OpenCV, a JSON library).
#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <map>
#include <thread>

#include <Eigen/Geometry>
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <sys/stat.h>
#include <unistd.h>

#include "eval/image_sets/set_plan.h"
#include "scenes/random/random.h"
#include "tests/eval/image_sets/image_set_for_tests.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

Eigen::Vector3d vector_of(const json& numbers) {
  return {numbers[0].get<double>(), numbers[1].get<double>(), numbers[2].get<double>()};
}

Eigen::Matrix3d matrix_of(const json& row_wise) {
  Eigen::Matrix3d m;
  for (int i = 0; i < 9; ++i) m(i / 3, i % 3) = row_wise[static_cast<size_t>(i)];
  return m;
}

// Reads a scene by BOP's documentation alone.
TEST_F(ImageSet, BopIsWhatItsDocumentationSays) {
  const Outcome made = render("set", "--count 6 --scene-size 4");
  ASSERT_EQ(made.exit_code, 0) << made.output;
  const json info = read("set/models/models_info.json")["1"];
  EXPECT_NEAR(info["diameter"].get<double>(), 1000 * std::sqrt(3.0), 1e-4);
  EXPECT_NEAR(info["min_x"].get<double>(), -500, 1e-4);
  EXPECT_NEAR(info["size_z"].get<double>(), 1000, 1e-4);
  EXPECT_EQ(tree("set").at("models/obj_000001.ply"), tree("set").at("models_eval/obj_000001.ply"));
  EXPECT_EQ(read("set/camera.json")["width"], 64);
  for (const std::string scene : {"set/test/000000/", "set/test/000001/"}) {
    const json cameras = read(scene + "scene_camera.json");
    const json poses = read(scene + "scene_gt.json");
    const json infos = read(scene + "scene_gt_info.json");
    ASSERT_EQ(poses.size(),
              scene.back() == '/' && scene.find("000001") != std::string::npos ? 2 : 4);
    for (const auto& [id, gts] : poses.items()) {
      ASSERT_EQ(gts.size(), 1u);
      const std::string number = fmt::format("{:06}", std::stoi(id));
      const cv::Mat gray = picture(scene + "gray/" + number + ".png");
      const cv::Mat depth = picture(scene + "depth/" + number + ".png");
      const cv::Mat mask = picture(scene + "mask/" + number + "_000000.png");
      const cv::Mat seen = picture(scene + "mask_visib/" + number + "_000000.png");
      ASSERT_EQ(gray.type(), CV_8U);
      ASSERT_EQ(depth.type(), CV_16U);
      ASSERT_EQ(gray.size(), cv::Size(64, 64));
      const json& gt_info = infos[id][0];
      EXPECT_EQ(gt_info["px_count_visib"], cv::countNonZero(seen));
      EXPECT_EQ(gt_info["px_count_all"], cv::countNonZero(mask));  // all of it is in the image
      EXPECT_EQ(gt_info["px_count_valid"], cv::countNonZero(mask & (depth > 0)));
      const cv::Rect box = cv::boundingRect(seen);
      EXPECT_EQ(gt_info["bbox_visib"], json({box.x, box.y, box.width - 1, box.height - 1}));
      // The corners of the cube, put through the written pose and camera, span the mask.
      const Eigen::Matrix3d k = matrix_of(cameras[id]["cam_K"]);
      const Eigen::Matrix3d rotation = matrix_of(gts[0]["cam_R_m2c"]);
      const Eigen::Vector3d translation = vector_of(gts[0]["cam_t_m2c"]);
      Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
      for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3d x(corner & 1 ? 500 : -500, corner & 2 ? 500 : -500,
                                corner & 4 ? 500 : -500);
        const Eigen::Vector2d pixel = (k * (rotation * x + translation)).hnormalized();
        low = low.cwiseMin(pixel);
        high = high.cwiseMax(pixel);
      }
      EXPECT_NEAR(box.x, std::ceil(low.x()), 1);  // a sharp corner may miss a pixel's centre
      EXPECT_NEAR(box.y, std::ceil(low.y()), 1);
      EXPECT_NEAR(box.br().x - 1, std::floor(high.x()), 1);
      EXPECT_NEAR(box.br().y - 1, std::floor(high.y()), 1);
      // Depth is that of the cube: within half its diagonal of its middle.
      double least = 0, most = 0;
      cv::minMaxLoc(depth, &least, &most, nullptr, nullptr, seen);
      const double scale = cameras[id]["depth_scale"];
      EXPECT_NEAR(least * scale, translation.z(), 867);
      EXPECT_LT(least * scale, translation.z() - 400);
      EXPECT_LE(most, 65535);
    }
  }
  const json targets = read("set/test_targets_bop19.json");
  ASSERT_EQ(targets.size(), 6u);
  EXPECT_EQ(targets[5], json({{"im_id", 1}, {"inst_count", 1}, {"obj_id", 1}, {"scene_id", 1}}));
  EXPECT_EQ(verify("set").exit_code, 0) << verify("set").output;
}

TEST_F(ImageSet, TruthIsExact) {
  ASSERT_EQ(render("set", "--count 2").exit_code, 0);
  const json truth = read("set/sightline/000000/000001.json");
  const json pose = truth["bodies"][0]["cam_from_target"];
  const json gt = read("set/test/000000/scene_gt.json")["1"][0];
  EXPECT_EQ(gt["cam_R_m2c"], pose["rotation"]);
  const cv::Mat relative = picture("set/sightline/000000/000001_depth.tiff");
  const cv::Mat parts = picture("set/sightline/000000/000001_parts.png");
  const cv::Mat depth = picture("set/test/000000/depth/000001.png");
  ASSERT_EQ(relative.type(), CV_32F);
  ASSERT_EQ(parts.type(), CV_16U);
  EXPECT_EQ(cv::countNonZero((relative == relative) != (parts > 0)), 0);
  const double z0 = truth["z0_m"];
  const double scale = read("set/test/000000/scene_camera.json")["1"]["depth_scale"];
  EXPECT_EQ(z0, pose["translation_m"][2]);
  for (int v = 0; v < 64; ++v) {
    for (int u = 0; u < 64; ++u) {
      if (parts.at<uint16_t>(v, u) == 0) continue;
      const double z_mm = 1000 * (z0 + relative.at<float>(v, u));
      ASSERT_NEAR(depth.at<uint16_t>(v, u) * scale, z_mm, scale / 2 + 0.01);
    }
  }
  const json& features = truth["bodies"][0]["features"];
  ASSERT_EQ(features.size(), 8u);
  EXPECT_EQ(features[3]["name"], "vertex_3");
  // Minimal truth has the numbers alone.
  ASSERT_EQ(render("small", "--count 2 --truth minimal").exit_code, 0);
  EXPECT_FALSE(fs::exists(path("small/sightline/000000/000001_depth.tiff")));
  json small = read("small/sightline/000000/000001.json"), same = truth;
  EXPECT_LT(small["crc32"].size(), same["crc32"].size());
  small.erase("crc32");
  same.erase("crc32");
  EXPECT_EQ(small, same);
  EXPECT_EQ(verify("small").exit_code, 0) << verify("small").output;
}

TEST_F(ImageSet, SpeedIsWhatItsPaperSays) {
  ASSERT_EQ(render("set", "--count 3 --format speed --seed 4").exit_code, 0);
  const json list = read("set/train.json");
  ASSERT_EQ(list.size(), 3u);
  const json camera = read("set/camera.json");
  EXPECT_EQ(camera["ccx"], 32.0);  // half of 64: the corner's convention
  for (size_t i = 0; i < 3; ++i) {
    const cv::Mat image = picture("set/images/" + list[i]["filename"].get<std::string>());
    ASSERT_EQ(image.size(), cv::Size(64, 64));
    const json& q = list[i]["q_vbs2tango_true"];
    const Eigen::Quaterniond rotation(q[0].get<double>(), q[1].get<double>(), q[2].get<double>(),
                                      q[3].get<double>());
    const json truth = read(fmt::format("set/sightline/000000/{:06}.json", i));
    const json& stated = truth["bodies"][0]["cam_from_target"];
    EXPECT_LT((rotation.toRotationMatrix() - matrix_of(stated["rotation"])).norm(), 1e-14);
    EXPECT_EQ(list[i]["r_Vo2To_vbs_true"], stated["translation_m"]);
  }
  EXPECT_EQ(verify("set").exit_code, 0) << verify("set").output;
}

TEST_F(ImageSet, JobsAndShardsGiveTheSameBytes) {
  const std::string count = "--count 9 --scene-size 4 --quiet ";
  ASSERT_EQ(render("one", count + "--jobs 1").exit_code, 0);
  ASSERT_EQ(render("jobs", count + "--jobs 3").exit_code, 0);
  expect_same("one", "jobs");
  for (const int shards : {2, 7}) {
    const std::string set = "shards" + std::to_string(shards);
    for (int i = shards - 1; i >= 0; --i) {
      EXPECT_FALSE(fs::exists(path(set + "/test_targets_bop19.json")));
      const Outcome outcome = render(set, count + fmt::format("--shard {}/{}", i, shards));
      ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
    }
    expect_same("one", set);
  }
  // An engine's variables say the same.
  for (int rank = 0; rank < 2; ++rank) {
    const Outcome outcome =
        run_shell(fmt::format("PMI_RANK={} PMI_SIZE=2 {} render cube {} --out {} {} --shard auto",
                              rank, SIGHTLINE_PROGRAM, kQuick, path("engine"), count));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  }
  expect_same("one", "engine");
  ASSERT_EQ(render("other", count + "--seed 2").exit_code, 0);
  EXPECT_NE(tree("one").at("test/000000/scene_gt.json"),
            tree("other").at("test/000000/scene_gt.json"));
}

// Starts the program in a process of its own, its words into a file.
pid_t start(const std::string& arguments, const std::string& words = "/dev/null") {
  const pid_t process = fork();
  if (process != 0) return process;
  setpgid(0, 0);
  const int file = open(words.c_str(), O_WRONLY | O_CREAT, 0600);
  dup2(file, 1);
  dup2(file, 2);
  execl("/bin/sh", "sh", "-c", (std::string("exec ") + SIGHTLINE_PROGRAM + " " + arguments).c_str(),
        nullptr);
  _exit(127);
}

// The truths of a set and when they were written.
std::map<std::string, fs::file_time_type> truths_in(const std::string& set) {
  std::map<std::string, fs::file_time_type> truths;
  if (!fs::exists(set + "/sightline")) return truths;
  for (const auto& entry : fs::recursive_directory_iterator(set + "/sightline")) {
    if (entry.path().extension() == ".json") truths[entry.path()] = entry.last_write_time();
  }
  return truths;
}

TEST_F(ImageSet, KillsLoseNothingAndRepeatNothing) {
  constexpr size_t kImages = 600;
  const std::string arguments = fmt::format("--count {} --scene-size 100 --quiet ", kImages);
  ASSERT_EQ(render("whole", arguments + "--jobs 2").exit_code, 0);
  RandomStream random(7, "kills", 0);
  const std::string command =
      "render cube" + kQuick + "--out " + path("killed") + " " + arguments + "--resume --jobs 2";
  std::map<std::string, fs::file_time_type> written;
  int kills_at_work = 0;
  for (int kill_number = 0; kill_number < 10; ++kill_number) {
    const pid_t process = start(command);
    bool is_at_work = true;
    while (truths_in(path("killed")).size() <= written.size() && is_at_work) {
      is_at_work = waitpid(process, nullptr, WNOHANG) == 0;
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(random.uniform(0, 0.03)));
    if (is_at_work) {
      kill(process, SIGKILL);
      waitpid(process, nullptr, 0);
      ++kills_at_work;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50));  // its workers end
    const auto there = truths_in(path("killed"));
    for (const auto& [truth, time] : written) {
      ASSERT_EQ(there.at(truth), time) << truth << " was made again";
    }
    written = there;
  }
  EXPECT_GE(kills_at_work, 3);
  const Outcome outcome = run(command);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  expect_same("whole", "killed");
  EXPECT_EQ(verify("killed").exit_code, 0) << verify("killed").output;
}

TEST_F(ImageSet, WhatIsNotTheSameSetIsRefused) {
  ASSERT_EQ(render("set", "--count 3 --shard 0/2").exit_code, 0);
  EXPECT_THAT(render("set", "--count 3 --shard 0/2").output, HasSubstr("--resume"));
  EXPECT_THAT(render("set", "--count 4 --shard 1/2").output, HasSubstr("count 3, not 4"));
  EXPECT_THAT(render("set", "--count 3 --seed 2 --resume").output, HasSubstr("seed 1, not 2"));
  EXPECT_THAT(render("set", "--count 3 --resume --set background.level=0.5").output,
              HasSubstr("other keys"));
  EXPECT_THAT(render("set", "--count 3 --resume --format bob").output,
              HasSubstr("did you mean 'bop'"));
  EXPECT_EQ(render("set", "--count 3 --resume").exit_code, 0);
  EXPECT_EQ(verify("set").exit_code, 0);
  fs::create_directory(path("mine"));
  folder_.write("mine/note.txt", "mine");
  const Outcome foreign = render("mine", "--count 3");
  EXPECT_EQ(foreign.exit_code, 1);
  EXPECT_THAT(foreign.output, HasSubstr("not empty"));
  EXPECT_EQ(lines_of(foreign.output), 1u);
  EXPECT_FALSE(fs::exists(path("mine/.lock")));
  EXPECT_EQ(render("mine/note.txt", "--count 3").exit_code, 1);
  EXPECT_EQ(run("render cube --count 3").exit_code, 2);
  EXPECT_THAT(run("render cubr --count 3 --out " + path("x")).output, HasSubstr("'cube'"));
  EXPECT_EQ(run("render cube-noise --count 3 --out " + path("x")).exit_code, 1);
}

TEST_F(ImageSet, TwoRunsIntoOneFolderAreRefused) {
  const std::string arguments = "--count 100000 --quiet ";
  const pid_t process =
      start("render cube" + kQuick + "--out " + path("set") + " " + arguments + "--shard 0/2");
  while (!fs::exists(path("set/sightline/000000"))) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  for (const char* shard : {"", "--shard 0/2", "--shard 1/3"}) {
    const Outcome outcome = render("set", arguments + "--resume " + shard);
    EXPECT_EQ(outcome.exit_code, 1) << shard;
    EXPECT_THAT(outcome.output, HasSubstr("another run")) << shard;
  }
  kill(process, SIGKILL);
  waitpid(process, nullptr, 0);
}

// A process that knows the set as it was before it grew neither says that it is whole nor lists it.
TEST_F(ImageSet, GrowsUnderARunThatKnowsTheShorterOne) {
  const std::string scenes = "--scene-size 100 --quiet --set image.samples_per_pixel=64 ";
  const std::string shorter =
      "render cube" + kQuick + "--out " + path("set") + " " + scenes + "--count 120 --shard 1/2 ";
  const pid_t process = start(shorter + "--resume", path("words"));
  while (truths_in(path("set")).empty() && waitpid(process, nullptr, WNOHANG) == 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  const bool is_stopped = kill(-process, SIGSTOP) == 0;  // in the middle of its images
  if (!is_stopped || truths_in(path("set")).size() >= 60) {
    GTEST_SKIP() << "the run was over before it could be stopped";
  }
  EXPECT_EQ(render("set", scenes + "--count 121 --resume --shard 0/2").exit_code, 0);
  EXPECT_EQ(kill(-process, SIGCONT), 0);
  int status = 0;
  waitpid(process, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_THAT(read_whole(path("words")),
              AllOf(HasSubstr("was made another set while this run made its images"),
                    HasSubstr("count 121, not 120")));
  EXPECT_FALSE(fs::exists(path("set/test_targets_bop19.json")));
  EXPECT_THAT(run(shorter + "--resume").output, HasSubstr("count 121, not 120"));
  const Outcome last = render("set", scenes + "--count 121 --resume --shard 1/2");
  EXPECT_EQ(last.exit_code, 0) << last.output;
  EXPECT_EQ(verify("set").exit_code, 0) << verify("set").output;
}

// A set that somebody sent may be made to hang or to crash whoever continues it, or to have it
// write elsewhere.
TEST_F(ImageSet, ThatWasTamperedWithIsNotContinued) {
  ASSERT_EQ(render("set", "--count 2 --quiet").exit_code, 0);
  const std::string manifest = read_whole(path("set/sightline.json"));
  const auto output_with = [&](const std::string& file, const auto& make) {
    const std::string before = read_whole(path("set/" + file));
    fs::remove(path("set/" + file));
    make(path("set/" + file));
    const Outcome outcome = render("set", "--count 2 --quiet --resume");
    fs::remove(path("set/" + file));
    folder_.write("set/" + file, before);
    EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
    EXPECT_EQ(lines_of(outcome.output), 1u) << outcome.output;
    return outcome.output;
  };
  const auto pipe = [](const std::string& file) { mkfifo(file.c_str(), 0600); };
  EXPECT_THAT(output_with("sightline.json", pipe), HasSubstr("no manifest that can be read"));
  EXPECT_THAT(output_with("sightline.json",
                          [&](const std::string& file) {
                            const std::string deep =
                                std::string(100'000, '[') + std::string(100'000, ']');
                            std::ofstream(file) << "{\"count\": " << deep << "}";
                          }),
              HasSubstr("no manifest that can be read"));
  EXPECT_THAT(output_with("scene.toml", pipe), HasSubstr("other keys of the scene"));
  EXPECT_THAT(output_with("sightline/000000/000001.json", pipe),
              HasSubstr("cannot be read as a truth"));
  EXPECT_THAT(
      output_with(".lock",
                  [&](const std::string& file) { fs::create_symlink(path("victim"), file); }),
      HasSubstr("cannot be written"));
  EXPECT_FALSE(fs::exists(path("victim")));
  EXPECT_EQ(render("set", "--count 2 --quiet --resume").exit_code, 0);
  EXPECT_EQ(verify("set").exit_code, 0) << verify("set").output;
}

TEST_F(ImageSet, VerifyFindsWhatIsWrong) {
  ASSERT_EQ(render("set", "--count 4 --quiet").exit_code, 0);
  ASSERT_EQ(verify("set").exit_code, 0) << verify("set").output;
  const auto with = [this](const std::string& file, const std::string& bytes) {
    const std::string before = read_whole(path("set/" + file));
    const bool was_there = fs::exists(path("set/" + file));
    folder_.write("set/" + file, bytes);
    const Outcome outcome = verify("set");
    was_there ? (void)folder_.write("set/" + file, before) : (void)fs::remove(path("set/" + file));
    EXPECT_EQ(outcome.exit_code, 1) << file;
    return outcome.output;
  };
  const auto changed = [this](const std::string& file, const std::string& from,
                              const std::string& to) {
    std::string text = read_whole(path("set/" + file));
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << file << ": " << from;
    return text.replace(at, from.size(), to);
  };
  const std::string gray = "test/000000/gray/000002.png";
  const std::string png = read_whole(path("set/" + gray));
  for (const size_t size : {size_t{0}, png.size() / 2, png.size() - 5}) {
    EXPECT_THAT(with(gray, png.substr(0, size)), HasSubstr(gray)) << size;
  }
  EXPECT_THAT(
      with("test/000000/depth/000001.png", read_whole(path("set/test/000000/depth/000000.png"))),
      HasSubstr("image 1"));
  EXPECT_THAT(with("test/000000/mask_visib/000001_000000.png",
                   read_whole(path("set/test/000000/mask_visib/000002_000000.png"))),
              HasSubstr("mask_visib/000001_000000.png"));
  const std::string gt = "test/000000/scene_gt.json";
  EXPECT_THAT(with(gt, changed(gt, "\"obj_id\":1", "\"obj_id\":2")), HasSubstr(gt));
  const std::string truth = "sightline/000000/000003.json";
  EXPECT_THAT(with(truth, changed(truth, "\"visible_pixels\":", "\"visible_pixels\":1")),
              HasSubstr("000003"));
  const double x = read("set/" + truth)["bodies"][0]["cam_from_target"]["translation_m"][0];
  EXPECT_THAT(with(truth, changed(truth, json(x).dump(), json(x + 1e-6).dump())),
              HasSubstr("000003.json: body 0"));
  EXPECT_THAT(with(truth, "{"), HasSubstr("torn"));
  EXPECT_THAT(with("notes.txt", "mine"), HasSubstr("notes.txt: does not belong here"));
  EXPECT_THAT(with("camera.json", "{}"), HasSubstr("camera.json"));
  ASSERT_EQ(verify("set").exit_code, 0) << verify("set").output;
  fs::remove(path("set/sightline/000000/000001.json"));
  fs::remove(path("set/test/000000/mask/000003_000000.png"));
  const Outcome missing = verify("set");
  EXPECT_THAT(missing.output, HasSubstr("image 1: is missing"));
  EXPECT_THAT(missing.output, HasSubstr("mask/000003_000000.png: is missing"));
  EXPECT_THAT(missing.output, HasSubstr("2 of 4 images are there"));
  EXPECT_THAT(run("render --verify " + path("nowhere")).output, HasSubstr("cannot be read"));
}

// What lies behind a link is not of the set, and a pipe would be read for ever.
TEST_F(ImageSet, VerifyStaysWithinTheSet) {
  ASSERT_EQ(render("set", "--count 1 --quiet").exit_code, 0);
  const fs::path outside = folder_.write("outside.json", "{}");
  const auto output_with = [&](const auto& make, const std::string& file) {
    make(path("set/" + file));
    const Outcome outcome = verify("set");
    fs::remove(path("set/" + file));
    EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
    return outcome.output;
  };
  const auto link_to = [](const fs::path& there) {
    return [there](const fs::path& file) { fs::create_symlink(there, file); };
  };
  EXPECT_THAT(output_with(link_to(outside), "link.json"), HasSubstr("link.json: is a link out of"));
  EXPECT_THAT(output_with(link_to(fs::path("/")), "root"), HasSubstr("root: is a link out of"));
  EXPECT_THAT(output_with(link_to("nowhere"), "dangling"), HasSubstr("neither a file nor"));
  EXPECT_THAT(output_with(link_to("camera.json"), "alias"), HasSubstr("alias: does not belong"));
  EXPECT_THAT(output_with([](const fs::path& file) { mkfifo(file.c_str(), 0600); }, "pipe"),
              HasSubstr("pipe: is neither a file nor a folder"));
  EXPECT_EQ(verify("set").exit_code, 0);
  fs::remove(path("set/.lock"));
  EXPECT_THAT(output_with([](const fs::path& file) { fs::create_directory(file); }, ".lock"),
              HasSubstr(".lock: is a folder, must be a file"));
}

TEST_F(ImageSet, AFullDiskOrAForbiddenFolderIsOneLine) {
  const Outcome full =
      run_shell(fmt::format("ulimit -f 1; {} render cube {} --count 3 --out {} --set "
                            "camera.width_px=256 --set camera.height_px=256 --jobs 1 --quiet",
                            SIGHTLINE_PROGRAM, kQuick, path("full")));
  EXPECT_EQ(full.exit_code, 1);
  EXPECT_EQ(lines_of(full.output), 1u) << full.output;
  EXPECT_THAT(full.output, HasSubstr("cannot be written (File too large)"));
  for (const auto& entry : fs::recursive_directory_iterator(path("full"))) {
    EXPECT_NE(entry.path().extension(), ".partial") << entry.path();
  }
  const Outcome forbidden = run("render cube --count 1 --out /proc/set");
  EXPECT_EQ(forbidden.exit_code, 1);
  EXPECT_EQ(lines_of(forbidden.output), 1u) << forbidden.output;
  EXPECT_THAT(forbidden.output, HasSubstr("cannot be written"));
}

TEST_F(ImageSet, ADryRunSaysWhatASetWillTake) {
  const Outcome outcome = render("set", "--count 1000 --dry-run --jobs 2");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("9000 files"));
  EXPECT_THAT(outcome.output, HasSubstr("depth_scale"));
  EXPECT_FALSE(fs::exists(path("set")));
  EXPECT_THAT(render("set", "--count 9 --dry-run --depth-scale 0.01").output,
              HasSubstr("what is beyond gets depth 0"));
}

TEST_F(ImageSet, AStudysImagesAreThoseOfItsTrials) {
  const Outcome outcome = run("render boeing-table1 --count 5 --truth minimal --out " +
                              path("set") + kQuick + "--set camera.f_px=1250");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const json gt = read("set/test/000000/scene_gt.json");
  EXPECT_NEAR(gt["0"][0]["cam_t_m2c"][2].get<double>(), 1300e3, 1e-6);
  EXPECT_NEAR(gt["3"][0]["cam_t_m2c"][2].get<double>(), 1500e3, 1e-6);
  EXPECT_NEAR(gt["4"][0]["cam_t_m2c"][2].get<double>(), 1300e3, 1e-6);
  const double scale = read("set/camera.json")["depth_scale"];
  EXPECT_GT(scale * 65.535, 1500 + 20);
  EXPECT_LT(scale * 65.535, 1500 + 35);
}

TEST(DepthScale, IsTheFinestOfFourDigitsThatReaches) {
  for (const double far_m : {0.02, 1.0, 65.535, 999.9, 1525.0, 3e6}) {
    const double scale = finest_depth_scale(far_m);
    EXPECT_GE(scale * 65535, 1000 * far_m * (1 - 1e-12)) << far_m;
    EXPECT_LT(scale * 65535, 1000 * far_m * 1.0011) << far_m;
  }
}

}  // namespace
}  // namespace sightline
