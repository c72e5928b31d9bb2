// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <cstring>
#include <stdexcept>
#include <vector>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <opencv2/core.hpp>

#include "scenes/picture/codecs.h"

namespace sightline {
namespace {

// Bytes in memory as the library reads a file.
class ByteStream : public Imf::IStream {
 public:
  explicit ByteStream(std::string_view bytes) : Imf::IStream("picture"), bytes_(bytes) {}

  bool read(char to[], int count) override {
    const auto wanted = static_cast<uint64_t>(count);
    if (at_ > bytes_.size() || wanted > bytes_.size() - at_) {
      throw std::runtime_error("ends too early");
    }
    std::memcpy(to, bytes_.data() + at_, wanted);
    at_ += wanted;
    return at_ < bytes_.size();
  }
  uint64_t tellg() override { return at_; }
  void seekg(uint64_t position) override { at_ = position; }

 private:
  std::string_view bytes_;
  uint64_t at_ = 0;
};

// The channels that are blue, green and red; none where the file has no such.
std::array<const char*, 3> colour_channels(const Imf::ChannelList& channels) {
  const bool is_coloured = channels.findChannel("R") != nullptr &&
                           channels.findChannel("G") != nullptr &&
                           channels.findChannel("B") != nullptr;
  if (is_coloured) return {"B", "G", "R"};
  // Luminance with colour differences at half its resolution is another format.
  const bool is_grey =
      channels.findChannel("Y") != nullptr && channels.findChannel("RY") == nullptr;
  if (is_grey) return {"Y", "Y", "Y"};
  return {nullptr, nullptr, nullptr};
}

PictureReading decode(std::string_view bytes) {
  ByteStream stream(bytes);
  constexpr int kThreads = 0;  // none but the caller's
  Imf::InputFile file(stream, kThreads);
  const Imath::Box2i window = file.header().dataWindow();
  const int64_t width = int64_t{window.max.x} - window.min.x + 1;
  const int64_t height = int64_t{window.max.y} - window.min.y + 1;
  constexpr int kBytesAPixel = 12;
  if (std::string problem = size_problem(width, height, kBytesAPixel); !problem.empty()) {
    return {{}, std::move(problem)};
  }
  const std::array<const char*, 3> names = colour_channels(file.header().channels());
  if (names[0] == nullptr) return {{}, "has no channels R, G and B, nor Y alone"};
  if (!file.isComplete()) return {{}, kTornPicture};
  cv::Mat picture(static_cast<int>(height), static_cast<int>(width), CV_32FC3);
  const bool is_grey = std::string_view(names[0]) == names[1];
  std::vector<cv::Mat> planes;
  Imf::FrameBuffer buffer;
  for (size_t c = 0; c < (is_grey ? 1 : names.size()); ++c) {
    planes.emplace_back(picture.size(), CV_32F, cv::Scalar(0));
    const size_t row_bytes = planes[c].step[0];
    // The library addresses pixels by the window's own coordinates.
    buffer.insert(names[c],
                  Imf::Slice::Make(Imf::FLOAT, planes[c].ptr(), window, sizeof(float), row_bytes));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);
  if (is_grey) planes = {planes[0], planes[0], planes[0]};
  cv::merge(planes, picture);
  return {picture, {}};
}

}  // namespace

PictureReading decode_exr(std::string_view bytes) {
  try {
    return decode(bytes);
  } catch (const std::exception&) {
    return {{}, kTornPicture};
  }
}

}  // namespace sightline
