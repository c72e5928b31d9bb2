// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/pictures.h"

#include <map>
#include <system_error>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "scenes/mesh/mesh_folder.h"
#include "scenes/picture/picture_file.h"

namespace sightline {

std::string six_digits(int64_t number) {
  return fmt::format("{:06}", number);
}

cv::Mat read_picture(const std::filesystem::path& file) {
  return read_picture_file(file).pixels;
}

cv::Mat read_grey_picture(const std::filesystem::path& file) {
  return grey_of(read_picture(file));
}

cv::Mat grey_of(const cv::Mat& picture) {
  if (picture.depth() != CV_8U && picture.depth() != CV_16U) return {};
  cv::Mat grey;
  switch (picture.channels()) {
    case 1:
      return picture;
    case 3:
      cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
      return grey;
    case 4:
      cv::cvtColor(picture, grey, cv::COLOR_BGRA2GRAY);
      return grey;
    default:
      return {};
  }
}

std::string note_on_links(const std::filesystem::path& set,
                          std::span<const std::filesystem::path> pictures) {
  namespace fs = std::filesystem;
  std::map<fs::path, bool> is_outside;  // folders of pictures
  std::error_code error;
  size_t count = 0;
  const fs::path* first = nullptr;
  for (const fs::path& picture : pictures) {
    const auto [folder, is_new] = is_outside.emplace(picture.parent_path(), false);
    if (is_new) folder->second = !is_inside(set, folder->first);
    const bool is_link = fs::is_symlink(picture, error);
    if (!(is_link ? !is_inside(set, picture) : folder->second)) continue;
    if (count++ == 0) first = &picture;
  }
  if (count == 0) return "";
  return fmt::format(
      "{}: {} behind links out of the set, the first of which is {}: they are read and may be "
      "shown in the report",
      set.string(), count == 1 ? "a picture lies" : fmt::format("{} pictures lie", count),
      fs::weakly_canonical(*first, error).string());
}

}  // namespace sightline
