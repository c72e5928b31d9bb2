// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "scenes/scene/scene.h"

namespace sightline {

struct TargetArguments {
  std::string target;
  MeshUse mesh;         ///< how its mesh is taken
  std::string picture;  ///< a .png to draw; none if empty
  std::vector<double> theta_deg = {-35, 25, 20};
  std::optional<std::string> propose;  ///< a folder for a proposed target; the target's name if ""
  int max_features = 16;               ///< of a proposal
  double kept_percent = 100;           ///< of the triangles, in a coarser mesh that is written
  std::string coarser;                 ///< to this .glb; none if empty
};

/// Of a target for studies: with fewer in sight a wrong one cannot be told.
constexpr size_t kWantedFeatures = 6;

struct TargetReport {
  std::string text;
  std::filesystem::path proposed;  ///< the target.toml of a proposal; empty without one
};

/// What `sightline target` prints; draws the picture and writes the proposal if they are asked for.
/// Throws InputError for a target that cannot be read, has nothing to propose, or a file that
/// cannot be written.
TargetReport report_target(const TargetArguments& arguments);

/// A scene that fills a picture with a target through a long lens, at this attitude.
Scene picture_scene(const std::shared_ptr<const Target>& target,
                    const std::vector<double>& theta_deg);

/// Writes an image. Throws InputError when it does not end in .png or cannot be written.
void write_picture(const cv::Mat& image, const std::string& file);

/// What report_target says of the target itself, as JSON. Throws what it throws.
std::string target_json(const std::string& target, const MeshUse& mesh);

}  // namespace sightline
