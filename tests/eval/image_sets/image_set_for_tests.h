// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core/mat.hpp>

#include "scenes/picture/picture_file.h"
#include "tests/eval/program.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {

// Small and quick: 64 x 64 pixels, one sample.
inline const std::string kQuick =
    " --set camera.width_px=64 --set camera.height_px=64 --set camera.f_px=250 --set "
    "image.samples_per_pixel=1 ";

/// A mask of run lengths as COCO defines them: column by column, background first.
inline cv::Mat decoded(const nlohmann::json& segmentation) {
  const int rows = segmentation.at("size").at(0);
  const int columns = segmentation.at("size").at(1);
  cv::Mat mask = cv::Mat::zeros(rows, columns, CV_8U);
  int at = 0;
  bool is_object = false;
  for (const nlohmann::json& count : segmentation.at("counts")) {
    for (int i = 0; i < count.get<int>(); ++i, ++at) {
      if (is_object) mask.at<uint8_t>(at % rows, at / rows) = 255;
    }
    is_object = !is_object;
  }
  EXPECT_EQ(at, rows * columns);
  return mask;
}

// Sets that the program writes into a folder of their own.
class ImageSet : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  Outcome render(const std::string& out, const std::string& more) const {
    return run("render cube" + kQuick + "--out " + path(out) + " " + more);
  }
  Outcome verify(const std::string& out) const {
    return run("render --quiet --verify " + path(out));
  }
  nlohmann::json read(const std::string& file) const {
    return nlohmann::json::parse(read_whole(folder_.path() / file));
  }
  cv::Mat picture(const std::string& file) const { return read_picture_file(path(file)).pixels; }
  // Every file of a set by its path, but for the lock.
  std::map<std::string, std::string> tree(const std::string& set) const {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_.path() / set)) {
      if (!entry.is_regular_file() || entry.path().filename() == ".lock") continue;
      files[std::filesystem::relative(entry.path(), folder_.path() / set)] =
          read_whole(entry.path());
    }
    return files;
  }
  void expect_same(const std::string& set, const std::string& other) const {
    const auto a = tree(set), b = tree(other);
    EXPECT_EQ(a.size(), b.size()) << other;
    for (const auto& [file, bytes] : a) {
      ASSERT_TRUE(b.contains(file)) << other << "/" << file;
      EXPECT_TRUE(b.at(file) == bytes) << other << "/" << file;
    }
  }
  TemporaryFolder folder_;
};

}  // namespace sightline
