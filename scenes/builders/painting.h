// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the builders paint textures with: shapes by their distance, and letters. Here no function of
// the C library's is used but the square root, whose last digit is the same on any machine.
#pragma once

#include <string_view>

#include <Eigen/Core>

namespace sightline {

/// A colour as a picture stores it: red, green and blue, encoded as sRGB, from 0 to 1.
using Ink = Eigen::Vector3d;

/// A distance to a shape is negative within it. All lengths are of one unit.
double box_distance(const Eigen::Vector2d& at, const Eigen::Vector2d& low,
                    const Eigen::Vector2d& high);
double disc_distance(const Eigen::Vector2d& at, const Eigen::Vector2d& middle, double radius);

/// To a line of that width along the border of a shape.
double border_distance(double distance_to_shape, double width);

/// To a word of capitals and digits, the left end of whose base line is at `base`. Lines go along
/// x, down along y; strokes are a fifth of the height wide. Only letters of the liveries that ship
/// are known: SIGHTLNE70 and the hyphen.
double word_distance(const Eigen::Vector2d& at, std::string_view word, const Eigen::Vector2d& base,
                     double height);

/// How long such a word is.
double word_length(std::string_view word, double height);

/// One texel while it is painted: each shape covers what is below it, its border blended over a
/// texel.
class Texel {
 public:
  Texel(double size, const Ink& ground) : size_(size), ink_(ground) {}

  /// Covers with an ink where `distance` is negative.
  Texel& cover(double distance, const Ink& ink);
  /// Darkens instead: multiplies the ink by a factor.
  Texel& shade(double distance, double factor);

  const Ink& ink() const { return ink_; }

 private:
  double share(double distance) const;

  double size_;
  Ink ink_;
};

}  // namespace sightline
