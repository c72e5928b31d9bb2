// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/image_sets/set_format.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "scenes/files/input_error.h"

namespace sightline {

// Each in the file of its name in formats/.
SetFormat bop_format();
SetFormat bop_imagewise_format();
SetFormat speed_format();
SetFormat yolo_format();

EncodingText encoding_text(const SetPlan& plan) {
  const auto& setups = plan.images().setups;
  const auto encoded = std::count_if(setups.begin(), setups.end(), [](const ImageSetup& setup) {
    return setup.scene.sensor.is_srgb;
  });
  if (encoded == 0) return {"linear grey", "Nothing is gamma-encoded."};
  if (encoded == std::ssize(setups)) {
    return {"sRGB-encoded grey", "Grey levels stand for light as IEC 61966-2-1 says."};
  }
  return {"grey",
          "Some images are linear, others sRGB-encoded: see is_srgb of each image in sightline/."};
}

std::span<const SetFormat> set_formats() {
  static const std::array kCatalogue = {bop_format(), bop_imagewise_format(), speed_format(),
                                        yolo_format()};
  return kCatalogue;
}

const SetFormat& find_set_format(const std::string& name) {
  std::vector<std::string> names;
  for (const SetFormat& format : set_formats()) {
    if (format.name == name) return format;
    names.emplace_back(format.name);
  }
  throw InputError(fmt::format("--format {}: is not known{}", name, suggestion(name, names)));
}

}  // namespace sightline
