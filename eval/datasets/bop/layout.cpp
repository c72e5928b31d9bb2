// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/bop/layout.h"

#include <algorithm>

#include <fmt/format.h>

#include "eval/datasets/pictures.h"

namespace sightline::bop {

std::string model_file(int64_t obj_id) {
  return fmt::format("obj_{}.ply", six_digits(obj_id));
}

std::string scene_name(int64_t scene_id) {
  return six_digits(scene_id);
}

std::string image_name(int64_t im_id) {
  return six_digits(im_id);
}

std::string of_sensor(std::string_view name, std::string_view sensor) {
  if (sensor.empty()) return std::string(name);
  const size_t ending = std::min(name.find('.'), name.size());
  return fmt::format("{}_{}{}", name.substr(0, ending), sensor, name.substr(ending));
}

std::string mask_name(int64_t im_id, int64_t gt_id) {
  return six_digits(im_id) + "_" + six_digits(gt_id);
}

}  // namespace sightline::bop
