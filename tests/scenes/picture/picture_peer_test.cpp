// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is read and written, beside OpenCV's imgcodecs, which wrap the same libraries. The suite
// itself does without them: with them come 120 more shared libraries, GDAL's among them, and every
// start of the program takes four times as long.
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

cv::Mat noise(int type, int rows = 37, int cols = 53) {
  cv::Mat out(rows, cols, type);
  cv::RNG random(7);
  random.fill(out, cv::RNG::UNIFORM, 0, out.depth() == CV_8U ? 256 : 65536);
  return out;
}

std::string encoded_by_opencv(const char* extension, const cv::Mat& picture,
                              const std::vector<int>& options = {}) {
  std::vector<uchar> bytes;
  cv::imencode(extension, picture, bytes, options);
  return {bytes.begin(), bytes.end()};
}

cv::Mat decoded_by_opencv(const std::string& bytes, int flags = cv::IMREAD_UNCHANGED) {
  return cv::imdecode(std::vector<uchar>(bytes.begin(), bytes.end()), flags);
}

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() &&
         cv::norm(a.reshape(1), b.reshape(1), cv::NORM_INF) == 0;
}

class PicturePeers : public testing::TestWithParam<int> {};

TEST_P(PicturePeers, PngHasTheSamePixelsAndWithEffortTheSameBytes) {
  const cv::Mat picture = noise(GetParam());
  const std::string bytes = png_bytes(picture);
  EXPECT_TRUE(same(decoded_by_opencv(bytes), picture));  // printed, they would fill the screen
  EXPECT_TRUE(png_bytes(picture, PngEffort::kSmall) ==
              encoded_by_opencv(".png", picture,
                                {cv::IMWRITE_PNG_COMPRESSION, 9, cv::IMWRITE_PNG_STRATEGY,
                                 cv::IMWRITE_PNG_STRATEGY_DEFAULT}));
  EXPECT_TRUE(same(decode_picture(bytes).pixels, picture));
  EXPECT_TRUE(same(decode_picture(bytes, PictureChannels::kGrey).pixels,
                   decoded_by_opencv(bytes, cv::IMREAD_GRAYSCALE)));
}
INSTANTIATE_TEST_SUITE_P(Types, PicturePeers,
                         testing::Values(CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1, CV_16UC3, CV_16UC4));

// One that is packed in parts.
TEST(PicturePeersOf, ALargePngHasTheSamePixels) {
  const cv::Mat picture = noise(CV_8UC1, 4100, 4200);
  EXPECT_TRUE(same(decoded_by_opencv(png_bytes(picture)), picture));
}

TEST(PicturePeersOf, JpegHasTheSameBytesAndPixels) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    const cv::Mat picture = noise(type);
    const std::string bytes = jpeg_bytes(picture);
    EXPECT_TRUE(bytes == encoded_by_opencv(".jpg", picture));
    EXPECT_TRUE(same(decode_picture(bytes).pixels, decoded_by_opencv(bytes)));
    EXPECT_TRUE(same(decode_picture(bytes, PictureChannels::kGrey).pixels,
                     decoded_by_opencv(bytes, cv::IMREAD_GRAYSCALE)));
  }
}

TEST(PicturePeersOf, TiffHasTheSameBytesAndPixels) {
  const cv::Mat metres = noise(CV_32F);
  EXPECT_TRUE(tiff_bytes(metres) == encoded_by_opencv(".tiff", metres));
  for (const int type : {CV_8UC1, CV_16UC1, CV_32FC1}) {
    const std::string packed = tiff_bytes(noise(type, 301, 203), TiffPacking::kDeflate);
    EXPECT_TRUE(same(decoded_by_opencv(packed), noise(type, 301, 203))) << type;
    EXPECT_TRUE(same(decode_picture(packed).pixels, noise(type, 301, 203))) << type;
  }
  for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1, CV_16UC3, CV_32FC1}) {
    const cv::Mat picture = noise(type);
    EXPECT_TRUE(same(decode_picture(encoded_by_opencv(".tiff", picture)).pixels, picture)) << type;
  }
}

TEST(PicturePeersOf, WebpAndBmpHaveTheSamePixels) {
  for (const int type : {CV_8UC3, CV_8UC4}) {
    const std::string webp =
        encoded_by_opencv(".webp", noise(type), {cv::IMWRITE_WEBP_QUALITY, 101});
    EXPECT_TRUE(same(decode_picture(webp).pixels, decoded_by_opencv(webp)));
    EXPECT_EQ(picture_size(std::string_view(webp)), cv::Size(53, 37));
  }
  const cv::Mat coloured = noise(CV_8UC3);
  const std::string bmp = encoded_by_opencv(".bmp", coloured);
  EXPECT_TRUE(same(decode_picture(bmp).pixels, coloured));
  EXPECT_EQ(picture_size(std::string_view(bmp)), cv::Size(53, 37));
  for (const std::string& whole : {encoded_by_opencv(".webp", coloured), bmp}) {
    for (const double share : {0.35, 0.7, 0.95}) {
      EXPECT_EQ(decode_picture(whole.substr(0, static_cast<size_t>(share * whole.size()))).problem,
                "is torn or damaged");
    }
  }
}

TEST(PicturePeersOf, ColoursAreTheSame) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4}) {
    const std::string bytes = png_bytes(noise(type));
    EXPECT_TRUE(same(decode_picture(bytes, PictureChannels::kColour).pixels,
                     decoded_by_opencv(bytes, cv::IMREAD_COLOR)));
  }
}

}  // namespace
}  // namespace sightline
