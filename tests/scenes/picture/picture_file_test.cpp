// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/picture/picture_file.h"

#include <filesystem>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <sys/stat.h>

#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::HasSubstr;
using namespace std::string_literals;

// Grey levels that differ everywhere; 8 wide, 6 high.
cv::Mat ramp() {
  cv::Mat out(6, 8, CV_8U);
  for (int i = 0; i < 48; ++i) out.at<uint8_t>(i / 8, i % 8) = static_cast<uint8_t>(5 * i);
  return out;
}

// A PNG of zero pixels that claims a size: its head alone, with a true check sum.
std::string png_head(uint32_t width, uint32_t height) {
  std::string bytes = png_bytes(ramp());
  const size_t at_size = 16, at_sum = 29;
  for (int i = 0; i < 4; ++i) {
    bytes[at_size + i] = static_cast<char>(width >> (24 - 8 * i));
    bytes[at_size + 4 + i] = static_cast<char>(height >> (24 - 8 * i));
  }
  uint32_t sum = 0xffffffff;  // CRC-32 over the chunk's name and data
  for (size_t i = 12; i < at_sum; ++i) {
    sum ^= static_cast<uint8_t>(bytes[i]);
    for (int bit = 0; bit < 8; ++bit) sum = (sum & 1) != 0 ? sum >> 1 ^ 0xedb88320 : sum >> 1;
  }
  for (int i = 0; i < 4; ++i) bytes[at_sum + i] = static_cast<char>(~sum >> (24 - 8 * i));
  return bytes;
}

// A JPEG whose Exif block says how the camera was held, in either byte order.
std::string turned_jpeg(char orientation, bool is_big_endian) {
  const std::string tiff =
      is_big_endian ? "MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0"s + orientation + "\0\0"s
                    : "II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0"s + orientation + "\0\0\0"s;
  const std::string body = "Exif\0\0"s + tiff;
  const std::string segment = "\xff\xe1\0"s + static_cast<char>(body.size() + 2) + body;
  const std::string plain = jpeg_bytes(ramp(), 100);
  return plain.substr(0, 2) + segment + plain.substr(2);
}

TEST(PictureFile, WhatIsTornIsRefused) {
  cv::Mat coloured;
  cv::merge(std::vector<cv::Mat>{ramp(), ramp(), ramp()}, coloured);
  cv::Mat metres;
  ramp().convertTo(metres, CV_32F);
  for (const std::string& whole : {png_bytes(coloured), jpeg_bytes(coloured), tiff_bytes(metres)}) {
    EXPECT_TRUE(decode_picture(whole).problem.empty());
    for (const size_t share : {1, 2, 3, 9, 10}) {
      const PictureReading torn = decode_picture(whole.substr(0, whole.size() * share / 11));
      EXPECT_TRUE(torn.pixels.empty());
      EXPECT_FALSE(torn.problem.empty());
    }
  }
}

TEST(PictureFile, ItsSizeIsReadBeforeItsPixels) {
  EXPECT_THAT(decode_picture(png_head(30000, 30000)).problem,
              HasSubstr("is 30000 x 30000 pixels, must be at most"));
  EXPECT_THAT(decode_picture(png_head(0x7fffffff, 0x7fffffff)).problem, HasSubstr("pixels"));
  EXPECT_EQ(decode_picture(png_head(8, 60)).problem,
            "is torn or damaged");  // allowed, but not there
}

TEST(PictureFile, ItsSizeIsWhatItStates) {
  const TemporaryFolder folder;
  cv::Mat metres;
  ramp().convertTo(metres, CV_32F);
  for (const std::string& whole : {png_bytes(ramp()), jpeg_bytes(ramp()), tiff_bytes(metres)}) {
    EXPECT_EQ(picture_size(folder.write("whole", whole)), cv::Size(8, 6));
  }
  // A JPEG's comments may be longer than what is read of it at first.
  std::string late = jpeg_bytes(ramp());
  for (int i = 0; i < 3; ++i) late.insert(2, "\xff\xfe\x7f\xff" + std::string(0x7fff - 2, ' '));
  EXPECT_EQ(picture_size(folder.write("late.jpg", late)), cv::Size(8, 6));
  EXPECT_EQ(picture_size(folder.write("bomb.png", png_head(30000, 30001))), cv::Size(30000, 30001));
  EXPECT_EQ(picture_size(folder.write("words.png", "not a picture")), std::nullopt);
  EXPECT_EQ(picture_size(folder.path() / "none.png"), std::nullopt);
}

TEST(PictureFile, IsUprightWhereGreyIsAsked) {
  const cv::Mat upright = decode_picture(turned_jpeg(1, false), PictureChannels::kGrey).pixels;
  ASSERT_EQ(upright.size(), cv::Size(8, 6));
  for (const bool is_big_endian : {false, true}) {
    const auto turned = [&](char how) {
      return decode_picture(turned_jpeg(how, is_big_endian), PictureChannels::kGrey).pixels;
    };
    // Exif 2.3, table of "Orientation": where the stored first row and first column belong.
    EXPECT_EQ(turned(2).at<uint8_t>(0, 7), upright.at<uint8_t>(0, 0));  // top, right
    EXPECT_EQ(turned(3).at<uint8_t>(5, 7), upright.at<uint8_t>(0, 0));  // bottom, right
    EXPECT_EQ(turned(4).at<uint8_t>(5, 0), upright.at<uint8_t>(0, 0));  // bottom, left
    const cv::Mat left_top = turned(5), right_top = turned(6), right_bottom = turned(7),
                  left_bottom = turned(8);
    ASSERT_EQ(right_top.size(), cv::Size(6, 8));
    EXPECT_EQ(left_top.at<uint8_t>(7, 0), upright.at<uint8_t>(0, 7));
    EXPECT_EQ(right_top.at<uint8_t>(0, 5), upright.at<uint8_t>(0, 0));
    EXPECT_EQ(right_top.at<uint8_t>(7, 5), upright.at<uint8_t>(0, 7));
    EXPECT_EQ(right_bottom.at<uint8_t>(7, 5), upright.at<uint8_t>(0, 0));
    EXPECT_EQ(left_bottom.at<uint8_t>(7, 0), upright.at<uint8_t>(0, 0));
    EXPECT_EQ(turned(9).size(), upright.size());  // no such value
  }
  EXPECT_EQ(decode_picture(turned_jpeg(6, false)).pixels.size(), cv::Size(8, 6));  // as stored
}

TEST(PictureFile, WhatIsNoPictureIsSaid) {
  const TemporaryFolder folder;
  const auto problem = [&](const std::string& name) {
    return read_picture_file(folder.path() / name).problem;
  };
  folder.write("words.png", "not a picture");
  EXPECT_EQ(problem("words.png"), "is no PNG, JPEG, TIFF, WebP or BMP");
  EXPECT_EQ(problem("none.png"), "is not there");
  EXPECT_EQ(problem("."), "is no file");
  ASSERT_EQ(mkfifo((folder.path() / "pipe.png").c_str(), 0600), 0);
  EXPECT_EQ(problem("pipe.png"), "is no file");  // and nobody waits for a writer
  folder.write("empty.png", "");
  EXPECT_EQ(problem("empty.png"), "is no PNG, JPEG, TIFF, WebP or BMP");
  folder.write("true.png", png_bytes(ramp()));
  EXPECT_EQ(problem("true.png"), "");
}

TEST(PictureFile, WhatNoFormatHoldsIsNotWritten) {
  EXPECT_THROW(png_bytes(cv::Mat(2, 2, CV_32F)), std::runtime_error);
  EXPECT_THROW(png_bytes(cv::Mat(2, 2, CV_8UC2)), std::runtime_error);
  EXPECT_THROW(jpeg_bytes(cv::Mat(2, 2, CV_16U)), std::runtime_error);
  EXPECT_THROW(tiff_bytes(cv::Mat(2, 2, CV_8UC3)), std::runtime_error);
  EXPECT_THROW(tiff_bytes(cv::Mat(2, 2, CV_64F)), std::runtime_error);
  EXPECT_THROW(png_bytes(cv::Mat()), std::runtime_error);
}

}  // namespace
}  // namespace sightline
