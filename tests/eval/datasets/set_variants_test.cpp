// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// One small set in BOP's formats, written in random combinations of all the legal ways that people
// write such sets: each must be read to the same poses, and the same results must get the same
// scores, to the digit. What is damaged at random is read, or refused in one line of ours.
#include <array>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "eval/datasets/bop/read.h"
#include "eval/datasets/model_file.h"
#include "eval/score/score.h"
#include "eval/score/scored_set.h"
#include "scenes/files/input_error.h"
#include "scenes/mesh/diameter.h"
#include "scenes/picture/picture_file.h"
#include "tests/eval/cube_of_100_mm.h"
#include "tests/scenes/packed_file.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

constexpr uint32_t kPlain = 0;  // the seed of the set as its documentation has it

// What one seed makes of each way to write; the plain set is the first of all of them.
class Ways {
 public:
  explicit Ways(uint32_t seed) : is_plain_(seed == kPlain), engine_(seed) {}

  template <typename Value, size_t N>
  Value one_of(const std::array<Value, N>& ways) {
    return is_plain_ ? ways.front() : ways[engine_() % N];
  }
  bool other() { return one_of(std::array{false, true}); }
  // Seldom, so that most of a set's numbers stay as they are written mostly.
  uint32_t below(uint32_t count) { return static_cast<uint32_t>(engine_() % count); }

 private:
  bool is_plain_;
  std::mt19937 engine_;
};

enum class Layout { kScenes, kSensors, kImages };

// An image of the set: two cubes, the second of which is hardly to be seen in some.
struct Shot {
  int scene_id, im_id;
  std::array<double, 2> visible;
};
constexpr std::array<Shot, 4> kShots = {
    {{1, 0, {1, 0.5}}, {1, 3, {0.7, 0.05}}, {2, 0, {1, 1}}, {2, 17, {1, 1}}}};

Pose true_pose(const Shot& shot, int instance) {
  const double turn = 0.3 + 0.1 * shot.im_id + shot.scene_id + instance;
  return {rotation_from_vector({0.2 * turn, turn, -0.1}),
          Eigen::Vector3d(250.0 * instance - 100, 3.5 * shot.im_id, 1000)};
}

class VariedSet {
 public:
  VariedSet(fs::path folder, uint32_t seed) : folder_(std::move(folder)), ways_(seed) {
    fs::create_directories(set());
    layout_ = ways_.one_of(std::array{Layout::kScenes, Layout::kSensors, Layout::kImages});
    split_ = ways_.one_of(std::array<std::string, 2>{"test", "test_all"});
    if (layout_ == Layout::kImages && ways_.other()) split_ = ".";
    kind_ = ways_.one_of(std::array<std::string, 2>{"rgb", "gray"});
    picture_digits_ = ways_.one_of(std::array{6, 4, 1});
    ending_ = ways_.one_of(std::array<std::string, 4>{"png", "PNG", "jpg", "JPEG"});
    fs::create_directories(set() / split_);
    layout_ == Layout::kImages ? write_images() : write_scenes();
    write_targets();
    write_models();
    if (ways_.other()) write("camera.json", json{{"width", 64}, {"height", 48}, {"cx", 32}});
    write_results();
  }

  fs::path set() const { return folder_ / "set"; }
  fs::path results() const { return results_; }
  const std::vector<fs::path>& files() const { return files_; }

 private:
  void write_bytes(const fs::path& name, const std::string& bytes, bool may_be_packed) {
    fs::create_directories((set() / name).parent_path());
    files_.push_back(set() / name);
    if (may_be_packed && ways_.other()) {
      write_packed((set() / name).string() + ".gz", bytes);
      files_.back() += ".gz";
      return;
    }
    std::ofstream(set() / name, std::ios::binary) << bytes;
  }

  void write(const fs::path& name, const json& content) {
    const std::string mark = ways_.other() ? "\xEF\xBB\xBF" : "";
    const std::string end = ways_.other() ? "\r\n" : "";
    write_bytes(name, mark + content.dump(ways_.one_of(std::array{2, -1, 0})) + end, true);
  }

  std::string key(int number) {
    return fmt::format("{:0{}}", number, ways_.one_of(std::array{1, 6, 3}));
  }

  json matrix(const Eigen::Matrix3d& m) {
    if (!ways_.other()) {
      return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
    }
    json rows;
    for (int row = 0; row < 3; ++row) rows.push_back({m(row, 0), m(row, 1), m(row, 2)});
    return rows;
  }

  json vector(const Eigen::Vector3d& v) {
    const json flat = {v.x(), v.y(), v.z()};
    const json column = {{v.x()}, {v.y()}, {v.z()}};
    const json row = json::array({flat});
    return ways_.one_of(std::array<json, 3>{flat, column, row});
  }

  json camera() {
    json entry = {{"depth_scale", 0.5}};
    Eigen::Matrix3d k = k_of(500, 0);
    k(0, 2) = 32;
    k(1, 2) = 24.5;
    const json model = {{"projection_model_type", "CameraModelType.PINHOLE"},
                        {"projection_params", {500, 500, 32, 24.5}}};
    const json linear = {{"projection_model_type", "CameraModelType.LINEAR"},
                         {"projection_params", {500, 32, 24.5}}};
    switch (ways_.one_of(std::array{0, 1, 2})) {
      case 0:
        entry["cam_K"] = matrix(k);
        break;
      case 1:
        entry["cam_model"] = model;
        break;
      default:
        entry["cam_model"] = linear;
    }
    if (ways_.other()) entry["cam_R_w2c"] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    return entry;
  }

  json truth(const Shot& shot) {
    json entries;
    for (int i = 0; i < 2; ++i) {
      const Pose pose = true_pose(shot, i);
      entries.push_back({{"obj_id", 5},
                         {"cam_R_m2c", matrix(pose.rotation)},
                         {"cam_t_m2c", vector(pose.translation)}});
    }
    return entries;
  }

  static json info(const Shot& shot) {
    return {{{"visib_fract", shot.visible[0]}, {"bbox_obj", {0, 0, 1, 1}}},
            {{"visib_fract", shot.visible[1]}}};
  }

  std::string picture() const {
    const cv::Mat image = kind_ == "rgb" ? cv::Mat(cv::Mat::zeros(48, 64, CV_8UC3))
                                         : cv::Mat(cv::Mat::zeros(48, 64, CV_8U));
    return ending_.starts_with("p") || ending_.starts_with("P") ? png_bytes(image)
                                                                : jpeg_bytes(image);
  }
  std::string depth() const {
    return png_bytes(cv::Mat(48, 64, CV_16U, cv::Scalar(1900)));  // 950 mm
  }
  std::string depth_ending() const { return ending_ == "PNG" ? "PNG" : "png"; }

  // An image that is wholly visible may be left out.
  bool may_lack_info(const Shot& shot) const { return shot.visible == std::array<double, 2>{1, 1}; }

  void write_images() {
    const std::string camera_ending = ways_.one_of(std::array<std::string, 2>{"camera", "cam"});
    for (const Shot& shot : kShots) {
      const std::string name = fmt::format("{}/{:06}_{:06}.", split_, shot.scene_id, shot.im_id);
      write(name + "gt.json", truth(shot));
      write(name + camera_ending + ".json", camera());
      if (!may_lack_info(shot) || !ways_.other()) write(name + "gt_info.json", info(shot));
      write_bytes(name + kind_ + "." + ending_, picture(), false);
      write_bytes(name + "depth." + depth_ending(), depth(), false);
    }
  }

  void write_scenes() {
    const std::string sensor = layout_ == Layout::kSensors ? "_cam1" : "";
    const int scene_digits = ways_.one_of(std::array{6, 4, 1});
    for (const int scene_id : {1, 2}) {
      const fs::path scene = fs::path(split_) / fmt::format("{:0{}}", scene_id, scene_digits);
      json truths, cameras, infos;
      for (const Shot& shot : kShots) {
        if (shot.scene_id != scene_id) continue;
        truths[key(shot.im_id)] = truth(shot);
        cameras[key(shot.im_id)] = camera();
        if (!may_lack_info(shot) || !ways_.other()) infos[key(shot.im_id)] = info(shot);
        const std::string name = fmt::format("{:0{}}.", shot.im_id, picture_digits_);
        write_bytes(scene / (kind_ + sensor) / (name + ending_), picture(), false);
        write_bytes(scene / ("depth" + sensor) / (name + depth_ending()), depth(), false);
      }
      write(scene / ("scene_gt" + sensor + ".json"), truths);
      write(scene / ("scene_camera" + sensor + ".json"), cameras);
      if (!infos.is_null()) write(scene / ("scene_gt_info" + sensor + ".json"), infos);
    }
  }

  // What is visible by a tenth, in words of either list or of none.
  void write_targets() {
    const std::string list =
        ways_.one_of(std::array<std::string, 3>{"", "test_targets_bop19", "test_targets_bop24"});
    if (list.empty()) return;
    json targets;
    for (const Shot& shot : kShots) {
      json target = {{"scene_id", shot.scene_id}, {"im_id", shot.im_id}};
      if (list == "test_targets_bop19") {
        target["obj_id"] = 5;
        const int count = shot.visible[1] < 0.1 ? 1 : 2;
        if (count > 1 || !ways_.other()) target["inst_count"] = count;
      }
      targets.push_back(target);
    }
    write(list + ".json", targets);
  }

  void write_models() {
    Mesh cube;
    const Eigen::Matrix3Xd points = cube_points();
    for (int i = 0; i < points.cols(); ++i) cube.vertices.emplace_back(1e-3 * points.col(i));
    for (const std::array<int, 3>& face : {std::array{0, 1, 3}, std::array{4, 5, 7}}) {
      cube.triangles.push_back({.vertex = face});
    }
    const fs::path models =
        ways_.one_of(std::array<std::string, 4>{"models_eval", "models", "models_cad", "models_x"});
    const std::string name = ways_.one_of(
        std::array<std::string, 3>{"obj_000005.ply", "obj_000005.PLY", "obj_0005.ply"});
    write_bytes(models / name, ply_bytes(cube), true);
    if (ways_.other()) return;  // the diameter is measured then
    std::vector<Eigen::Vector3d> vertices;
    for (int i = 0; i < points.cols(); ++i) vertices.emplace_back(points.col(i));
    json infos = {{key(5), {{"diameter", diameter(vertices)}}}};
    if (ways_.other()) infos["77"] = {{"diameter", 1}};
    write(models / "models_info.json", infos);
  }

  // Each instance but one is found, at growing errors.
  void write_results() {
    const std::string end = ways_.one_of(std::array<std::string, 3>{"\n", "\r\n", "\n\n"});
    const std::string quote = ways_.other() ? "\"" : "";
    const std::string blank = ways_.other() ? " " : "";
    std::string text = ways_.other() ? "\xEF\xBB\xBF" : "";
    if (!ways_.other()) text += "scene_id,im_id,obj_id,score,R,t,time" + end;
    int n = 0;
    for (const Shot& shot : kShots) {
      for (int i = 0; i < 2 && ++n < 8; ++i) {
        const Pose pose = shifted(true_pose(shot, i), {2.5 * n, 0, -1.0 * n});
        const Eigen::Matrix3d& r = pose.rotation;
        text += fmt::format(
            "{2},{3},{0}5,{0}{4},{1}{5} {6} {7} {8} {9} {10} {11} {12} {13}{1},"
            "{0}{14} {0}{15} {16}{0},-1{17}",
            blank, quote, shot.scene_id, shot.im_id, 1.0 / n, r(0, 0), r(0, 1), r(0, 2), r(1, 0),
            r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2), pose.translation.x(), pose.translation.y(),
            pose.translation.z(), end);
      }
    }
    results_ = folder_ / ways_.one_of(std::array<std::string, 2>{"r.csv", "R.CSV"});
    if (ways_.other()) {
      write_packed(results_.string() + ".gz", text);
      results_ += ".gz";
    } else {
      std::ofstream(results_, std::ios::binary) << text;
    }
  }

  fs::path folder_;
  Ways ways_;
  Layout layout_ = Layout::kScenes;
  std::string split_, kind_, ending_;
  int picture_digits_ = 6;
  fs::path results_;
  std::vector<fs::path> files_;
};

std::string numbers(const Eigen::MatrixXd& matrix) {
  return fmt::format("{} ", fmt::join(matrix.data(), matrix.data() + matrix.size(), " "));
}

// All that is read of a set, and the scores of its results, as text, to the last digit.
std::string digest(const VariedSet& varied) {
  const ScoredSet set = read_scored_set(varied.set(), "");
  std::string text;
  for (const BopImage& image : set.dataset.images) {
    text += fmt::format("{} {} {} {} ", image.scene_id, image.im_id, image.width_px,
                        image.depth_scale) +
            numbers(image.k) + fmt::format("targets {}\n", fmt::join(image.targets, " "));
    for (const BopInstance& instance : image.instances) {
      text += fmt::format("  {} {} ", instance.obj_id, instance.visible_fraction) +
              numbers(instance.cam_from_model.rotation) +
              numbers(instance.cam_from_model.translation) + "\n";
    }
  }
  for (const auto& [id, model] : set.dataset.models) {
    text += fmt::format("{} {} ", id, model.diameter_mm) + numbers(model.points_mm) + "\n";
  }
  const BopScores scores = score_bop(set.dataset, read_estimates(varied.results(), set), 15);
  const BopSummary s = summarise(scores);
  return text + fmt::format("{} {} {} {} {} {} {} {} {}", s.targets, s.estimated, s.ar.value,
                            s.ar_mssd.value, s.ar_mspd.value, s.ar_vsd.value, s.add.value,
                            s.adi.value, s.geodesic_deg.mean);
}

// The twin of the test below: were the digest blind, all sets would agree.
TEST(SetVariants, HaveADigestThatTellsSetsApart) {
  const TemporaryFolder folder;
  const VariedSet plain(folder.path(), kPlain);
  const std::string before = digest(plain);
  EXPECT_THAT(before, HasSubstr("\n7 6 "));  // seven targets, of which six are estimated
  const fs::path truth = plain.set() / "test/000002/scene_gt.json";
  json truths = json::parse(read_whole(truth));
  truths["17"][1]["cam_t_m2c"][2] = 1001;
  std::ofstream(truth) << truths.dump();
  EXPECT_NE(digest(plain), before);
}

TEST(SetVariants, AreReadToThePosesAndScoresOfThePlainSet) {
  const TemporaryFolder folder;
  const std::string plain = digest(VariedSet(folder.path() / "plain", kPlain));
  for (uint32_t seed = 1; seed <= 60; ++seed) {
    const fs::path varied = folder.path() / std::to_string(seed);
    EXPECT_EQ(digest(VariedSet(varied, seed)), plain) << "the variant of seed " << seed;
    fs::remove_all(varied);
  }
}

// A value that cannot stand in place of another, and may be none at all.
json nonsense(Ways& ways) {
  const std::array<json, 10> values = {json(nullptr),   json("x"),           json(-7),
                                       json(1e300),     json::object(),      json(1.5),
                                       json(true),      json(json::array()), json({1, "two"}),
                                       json(1ULL << 63)};
  return values[ways.below(values.size())];
}

// A JSON text with one value replaced, one entry removed, or its end cut off.
std::string damaged(const std::string& text, Ways& ways) {
  if (ways.below(4) == 0) return text.substr(0, ways.below(static_cast<uint32_t>(text.size())));
  const json flat = json::parse(text).flatten();
  auto value = flat.begin();
  std::advance(value, ways.below(static_cast<uint32_t>(flat.size())));
  json::json_pointer place(value.key());
  json all = json::parse(text);
  for (uint32_t up = ways.below(4); up > 0 && !place.parent_pointer().empty(); --up) {
    place = place.parent_pointer();
  }
  if (ways.below(3) > 0) {
    all[place] = nonsense(ways);
  } else if (all[place.parent_pointer()].is_object()) {
    all[place.parent_pointer()].erase(place.back());
  } else {
    all[place.parent_pointer()].erase(all[place.parent_pointer()].size() - 1);
  }
  return all.dump();
}

TEST(SetVariants, ThatAreDamagedAreReadOrRefusedInOneLineOfOurs) {
  const TemporaryFolder folder;
  const VariedSet plain(folder.path(), kPlain);
  std::vector<fs::path> files;
  for (const fs::path& file : plain.files()) {
    if (file.extension() == ".json") files.push_back(file);
  }
  Ways ways(1);
  int refused = 0;
  for (int round = 0; round < 300; ++round) {
    const fs::path& file = files[ways.below(static_cast<uint32_t>(files.size()))];
    const std::string good = read_whole(file);
    const std::string bad = damaged(good, ways);
    std::ofstream(file, std::ios::binary) << bad;
    try {
      digest(plain);
    } catch (const InputError& error) {
      ++refused;
      std::string line = error.what();
      const size_t at = line.find(plain.set().string());
      ASSERT_NE(at, line.npos) << line << "\n" << bad;
      line.erase(at, plain.set().string().size());
      EXPECT_LT(line.size(), 300u) << line;
      for (const char* foreign :
           {"\n", "[json", "exception", "std::", "type_error", "parse error"}) {
        EXPECT_THAT(line, Not(HasSubstr(foreign)));
      }
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what() << "\n" << file << "\n" << bad;
    }
    std::ofstream(file, std::ios::binary) << good;
  }
  EXPECT_GT(refused, 100);
  EXPECT_LT(refused, 300);
}

}  // namespace
}  // namespace sightline
