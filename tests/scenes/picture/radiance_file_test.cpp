// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/picture/radiance_file.h"

#include <cmath>
#include <cstdlib>

#include <OpenEXR/ImfArray.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::HasSubstr;

const std::string kHdrHead = "#?RADIANCE\nEXPOSURE=1\nFORMAT=32-bit_rle_rgbe\n\n";

std::string packed(std::initializer_list<int> bytes) {
  std::string out;
  for (const int byte : bytes) out.push_back(static_cast<char>(byte));
  return out;
}

std::filesystem::path write_exr(const TemporaryFolder& folder,
                                const std::vector<const char*>& names,
                                const std::vector<float>& values, int width, int height) {
  const std::filesystem::path file = folder.path() / "light.exr";
  Imf::Header header(width, height);
  header.dataWindow() = {{3, -2}, {3 + width - 1, -2 + height - 1}};  // need not begin at 0
  Imf::FrameBuffer buffer;
  for (size_t c = 0; c < names.size(); ++c) {
    header.channels().insert(names[c], Imf::Channel(Imf::FLOAT));
    buffer.insert(names[c], Imf::Slice::Make(Imf::FLOAT, values.data() + c, header.dataWindow(),
                                             names.size() * sizeof(float),
                                             names.size() * sizeof(float) * width));
  }
  Imf::OutputFile out(file.c_str(), header);
  out.setFrameBuffer(buffer);
  out.writePixels(height);
  return file;
}

TEST(RadianceFile, AnExrHasItsNumbersBlueFirst) {
  const TemporaryFolder folder;
  const auto file = write_exr(folder, {"R", "G", "B"}, {1, 0.25f, 3000, -1, 0, 0.125f}, 2, 1);
  const auto [pixels, problem] = read_radiance_file(file);
  ASSERT_EQ(problem, "");
  ASSERT_EQ(pixels.size(), cv::Size(2, 1));
  EXPECT_EQ(pixels.at<cv::Vec3f>(0, 0), cv::Vec3f(3000, 0.25f, 1));
  EXPECT_EQ(pixels.at<cv::Vec3f>(0, 1), cv::Vec3f(0.125f, 0, 0));  // below zero is no light
}

TEST(RadianceFile, AnExrOfLuminanceIsGreyAndOneWithoutEitherIsRefused) {
  const TemporaryFolder folder;
  const auto grey = read_radiance_file(write_exr(folder, {"Y"}, {0.5f, 7}, 1, 2));
  ASSERT_EQ(grey.problem, "");
  EXPECT_EQ(grey.pixels.at<cv::Vec3f>(1, 0), cv::Vec3f(7, 7, 7));
  const auto depth = read_radiance_file(write_exr(folder, {"Z"}, {0.5f}, 1, 1));
  EXPECT_THAT(depth.problem, HasSubstr("no channels R, G and B"));
  const auto bad = read_radiance_file(write_exr(folder, {"Y"}, {std::nanf("")}, 1, 1));
  EXPECT_THAT(bad.problem, HasSubstr("no finite numbers"));
}

TEST(RadianceFile, ATornExrIsRefusedWhereverItEnds) {
  const TemporaryFolder folder;
  std::vector<float> values(3 * 40 * 20, 0.5f);
  for (size_t i = 0; i < values.size(); ++i) values[i] = std::sin(static_cast<float>(i * i));
  const std::string whole = read_whole(write_exr(folder, {"R", "G", "B"}, values, 40, 20));
  ASSERT_EQ(decode_radiance(whole).problem, "");
  for (size_t kept = 4; kept < whole.size(); kept += 97) {
    EXPECT_EQ(decode_radiance(whole.substr(0, kept)).problem, "is torn or damaged") << kept;
  }
}

TEST(RadianceFile, AnHdrIsMantissasTimesTheirCommonPower) {
  // Two pixels as they are: 128 / 256 of 2^1 is 1, of 2^8 is 128.
  const std::string text = kHdrHead + "-Y 1 +X 2\n" + packed({128, 64, 0, 129, 128, 1, 2, 136});
  const auto [pixels, problem] = decode_radiance(text);
  ASSERT_EQ(problem, "");
  EXPECT_EQ(pixels.at<cv::Vec3f>(0, 0), cv::Vec3f(0, 0.5f, 1));
  EXPECT_EQ(pixels.at<cv::Vec3f>(0, 1), cv::Vec3f(2, 1, 128));
}

TEST(RadianceFile, RunsOfAnHdrAreUnpackedAsItsMakerPackedThem) {
  // By channel: red a run of 8, green 3 and 5, blue eight values, the exponent a run.
  const std::string row = packed({2, 2, 0, 8, 128 + 8, 200, 128 + 3, 10, 128 + 5, 20, 8,
                                  1, 2, 3, 4, 5,       6,   7,       8,  128 + 8, 136});
  const auto [pixels, problem] = decode_radiance(kHdrHead + "-Y 1 +X 8\n" + row);
  ASSERT_EQ(problem, "");
  EXPECT_EQ(pixels.at<cv::Vec3f>(0, 2), cv::Vec3f(3, 10, 200));
  EXPECT_EQ(pixels.at<cv::Vec3f>(0, 7), cv::Vec3f(8, 20, 200));
  // The older way: a pixel, then that it comes three times more.
  const auto old = decode_radiance(kHdrHead + "-Y 1 +X 4\n" + packed({9, 8, 7, 136, 1, 1, 1, 3}));
  ASSERT_EQ(old.problem, "");
  EXPECT_EQ(old.pixels.at<cv::Vec3f>(0, 3), cv::Vec3f(7, 8, 9));
}

TEST(RadianceFile, ABadHdrGetsOneClearLine) {
  const std::string size = "-Y 1 +X 2\n";
  EXPECT_EQ(decode_radiance(kHdrHead + size + packed({1, 2, 3, 4})).problem, "is torn or damaged");
  EXPECT_EQ(decode_radiance(kHdrHead).problem, "is torn or damaged");
  EXPECT_THAT(decode_radiance(kHdrHead + "+Y 1 +X 2\n").problem, HasSubstr("must be -Y HEIGHT"));
  EXPECT_THAT(decode_radiance("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n" + size).problem,
              HasSubstr("must be 32-bit_rle_rgbe"));
  EXPECT_THAT(decode_radiance(kHdrHead + "-Y 100000 +X 200000\n").problem, HasSubstr("at most"));
  EXPECT_THAT(decode_radiance("P6 1 1 255\n").problem, HasSubstr("no OpenEXR"));
  // A run that is longer than the row, and one of no length.
  const std::string eight = "-Y 1 +X 8\n";
  EXPECT_EQ(decode_radiance(kHdrHead + eight + packed({2, 2, 0, 8, 128 + 9, 1})).problem,
            "is torn or damaged");
  EXPECT_EQ(decode_radiance(kHdrHead + eight + packed({2, 2, 0, 8, 0, 1})).problem,
            "is torn or damaged");
}

}  // namespace
}  // namespace sightline
