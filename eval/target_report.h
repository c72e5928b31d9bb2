// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace sightline {

struct TargetArguments {
  std::string target;
  std::string forward;  ///< for a mesh file: its axis that points forward, such as "-x"; or empty
  std::string up;       ///< and the one that points up
  std::string picture;  ///< a .png to draw; none if empty
  std::vector<double> theta_deg = {-35, 25, 20};
};

/// What `sightline target` prints; draws the picture if one is asked for. Throws InputError for a
/// target that cannot be read or a picture that cannot be written.
std::string report_target(const TargetArguments& arguments);

}  // namespace sightline
