// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/image_sets/extras.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <opencv2/core.hpp>

#include "eval/image_sets/set_plan.h"
#include "renderer/truth.h"
#include "scenes/files/input_error.h"
#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

struct Extra {
  std::string_view name;
  bool SetExtras::*is_there;
};

constexpr std::array<Extra, 5> kExtras = {{{"itodd", &SetExtras::has_itodd_tif},
                                           {"tiff", &SetExtras::has_grey_tiff},
                                           {"rgb", &SetExtras::has_rgb_of_grey},
                                           {"normals", &SetExtras::has_normals},
                                           {"nocs", &SetExtras::has_coordinates}}};

// Each component from 0 to 1, in steps of 16 bits; red is the first.
cv::Vec3w pixel_of(const Eigen::Vector3d& components) {
  cv::Vec3w pixel;
  for (int i = 0; i < 3; ++i) {
    pixel[2 - i] = static_cast<uint16_t>(std::lround(65535 * std::clamp(components[i], 0.0, 1.0)));
  }
  return pixel;
}

std::vector<Eigen::AlignedBox3d> boxes_of(const Scene& scene) {
  std::vector<Eigen::AlignedBox3d> boxes;
  const auto add = [&boxes](const Mesh& mesh) {
    Eigen::AlignedBox3d& box = boxes.emplace_back();
    for (const Eigen::Vector3d& vertex : mesh.vertices) box.extend(vertex);
  };
  add(scene.target->mesh);
  for (const OtherBody& other : scene.others) add(other.target->mesh);
  return boxes;
}

// The pixels of a picture that `colour` gives each pixel that sees something.
template <typename Colour>
cv::Mat picture_of(const cv::Mat& body_ids, const Colour& colour) {
  cv::Mat picture = cv::Mat::zeros(body_ids.size(), CV_16UC3);
  for (int v = 0; v < picture.rows; ++v) {
    for (int u = 0; u < picture.cols; ++u) {
      const int body = body_ids.at<uint8_t>(v, u);
      if (body > 0) picture.at<cv::Vec3w>(v, u) = pixel_of(colour(u, v, body - 1));
    }
  }
  return picture;
}

Eigen::Vector3d vector_at(const cv::Mat& map, int u, int v) {
  const cv::Vec3d& at = map.at<cv::Vec3d>(v, u);
  return {at[0], at[1], at[2]};
}

}  // namespace

std::vector<std::string> extra_names() {
  std::vector<std::string> names;
  for (const Extra& extra : kExtras) names.emplace_back(extra.name);
  return names;
}

std::vector<std::string> names_of(const SetExtras& extras) {
  std::vector<std::string> names;
  for (const Extra& extra : kExtras) {
    if (extras.*extra.is_there) names.emplace_back(extra.name);
  }
  return names;
}

SetExtras extras_named(std::span<const std::string> names) {
  SetExtras extras;
  for (const std::string& name : names) {
    bool is_known = false;
    for (const Extra& extra : kExtras) {
      if (name != extra.name) continue;
      extras.*extra.is_there = true;
      is_known = true;
    }
    if (!is_known) {
      throw InputError(fmt::format("--also {}: must be of {}{}", name,
                                   fmt::join(extra_names(), ", "),
                                   suggestion(name, extra_names())));
    }
  }
  return extras;
}

SetExtras joined(const SetExtras& a, const SetExtras& b) {
  SetExtras all;
  for (const Extra& extra : kExtras) {
    all.*extra.is_there = a.*extra.is_there || b.*extra.is_there;
  }
  return all;
}

std::vector<SetFile> extra_files(const SetExtras& extras, const SetImage& image,
                                 const std::string& stem) {
  std::vector<SetFile> files;
  if (!extras.has_normals && !extras.has_coordinates) return files;
  const Scene& scene = image.drawn.scene;
  const cv::Mat& body_ids = image.frame.body_ids;
  const SurfaceMaps maps = surface_maps(scene);
  if (extras.has_normals) {
    const cv::Mat normals = picture_of(body_ids, [&](int u, int v, int) -> Eigen::Vector3d {
      return (vector_at(maps.normals, u, v).array() + 1) / 2;
    });
    files.push_back({stem + "_normals.png", png_bytes(normals)});
  }
  if (extras.has_coordinates) {
    const std::vector<Eigen::AlignedBox3d> boxes = boxes_of(scene);
    const cv::Mat places = picture_of(body_ids, [&](int u, int v, int body) -> Eigen::Vector3d {
      const Eigen::AlignedBox3d& box = boxes[static_cast<size_t>(body)];
      const Eigen::Vector3d from_middle = vector_at(maps.positions_m, u, v) - box.center();
      return from_middle.array() / box.diagonal().norm() + 0.5;
    });
    files.push_back({stem + "_nocs.png", png_bytes(places)});
  }
  return files;
}

std::vector<std::string> extra_paths(const SetExtras& extras, const std::string& stem) {
  std::vector<std::string> paths;
  if (extras.has_normals) paths.push_back(stem + "_normals.png");
  if (extras.has_coordinates) paths.push_back(stem + "_nocs.png");
  return paths;
}

std::string extras_text(const SetExtras& extras) {
  std::string text;
  if (extras.has_itodd_tif) {
    text +=
        "- gray/ and depth/ have each picture as .tif too: BOP's toolkit reads this set under the\n"
        "  name of itodd, the one of its own that is grey.\n";
  }
  if (extras.has_grey_tiff) {
    text += "- Each grey picture is there as .tiff too, as BOP's readers of folders want it.\n";
  }
  if (extras.has_rgb_of_grey) text += "- Each grey picture is there as one in colour too.\n";
  if (extras.has_normals) {
    text +=
        "- sightline/*/*_normals.png: normals as they are lit, towards the camera; red, green and\n"
        "  blue are 65535 (n + 1) / 2 of x, y and z in the camera's axes, black is background.\n";
  }
  if (extras.has_coordinates) {
    text +=
        "- sightline/*/*_nocs.png: where on its body each pixel lies; red, green and blue are\n"
        "  65535 ((x - m) / d + 1/2) of x, y and z in the body's frame, m the middle and d the\n"
        "  diagonal of its mesh's box; black is background.\n";
  }
  return text;
}

}  // namespace sightline
