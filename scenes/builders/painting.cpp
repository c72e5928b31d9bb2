// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/builders/painting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace sightline {
namespace {

// Pens go from point to point; heights are 1, from the top (0) to the base line (1).
using PenLine = std::vector<Eigen::Vector2d>;

struct Glyph {
  char letter;
  double width;
  std::vector<PenLine> lines;
};

constexpr double kStroke = 0.2;
constexpr double kGap = 0.42;  // between the lines of two letters

const std::vector<Glyph>& glyphs() {
  static const std::vector<Glyph> kGlyphs = {
      {'S',
       0.6,
       {{{0.6, 0.1},
         {0.5, 0},
         {0.1, 0},
         {0, 0.1},
         {0, 0.4},
         {0.1, 0.5},
         {0.5, 0.5},
         {0.6, 0.6},
         {0.6, 0.9},
         {0.5, 1},
         {0.1, 1},
         {0, 0.9}}}},
      {'I', 0, {{{0, 0}, {0, 1}}}},
      {'G',
       0.6,
       {{{0.6, 0.1},
         {0.5, 0},
         {0.1, 0},
         {0, 0.1},
         {0, 0.9},
         {0.1, 1},
         {0.5, 1},
         {0.6, 0.9},
         {0.6, 0.55},
         {0.35, 0.55}}}},
      {'H', 0.6, {{{0, 0}, {0, 1}}, {{0.6, 0}, {0.6, 1}}, {{0, 0.5}, {0.6, 0.5}}}},
      {'T', 0.6, {{{0, 0}, {0.6, 0}}, {{0.3, 0}, {0.3, 1}}}},
      {'L', 0.5, {{{0, 0}, {0, 1}, {0.5, 1}}}},
      {'N', 0.6, {{{0, 1}, {0, 0}, {0.6, 1}, {0.6, 0}}}},
      {'E', 0.5, {{{0.5, 0}, {0, 0}, {0, 1}, {0.5, 1}}, {{0, 0.5}, {0.45, 0.5}}}},
      {'7', 0.6, {{{0, 0}, {0.6, 0}, {0.2, 1}}}},
      {'0',
       0.6,
       {{{0.1, 0},
         {0.5, 0},
         {0.6, 0.1},
         {0.6, 0.9},
         {0.5, 1},
         {0.1, 1},
         {0, 0.9},
         {0, 0.1},
         {0.1, 0}}}},
      {'-', 0.4, {{{0, 0.5}, {0.4, 0.5}}}},
  };
  return kGlyphs;
}

const Glyph& glyph_of(char letter) {
  const auto& all = glyphs();
  return *std::find_if(all.begin(), all.end() - 1,
                       [&](const Glyph& glyph) { return glyph.letter == letter; });
}

double line_distance(const Eigen::Vector2d& at, const Eigen::Vector2d& begin,
                     const Eigen::Vector2d& end) {
  const Eigen::Vector2d along = end - begin;
  const double t = std::clamp((at - begin).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (at - begin - t * along).norm();
}

double glyph_distance(const Eigen::Vector2d& at, const Glyph& glyph) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const PenLine& line : glyph.lines) {
    for (size_t i = 0; i + 1 < line.size(); ++i) {
      nearest = std::min(nearest, line_distance(at, line[i], line[i + 1]));
    }
  }
  return nearest - kStroke / 2;
}

}  // namespace

double box_distance(const Eigen::Vector2d& at, const Eigen::Vector2d& low,
                    const Eigen::Vector2d& high) {
  return (low - at).cwiseMax(at - high).maxCoeff();
}

double disc_distance(const Eigen::Vector2d& at, const Eigen::Vector2d& middle, double radius) {
  return (at - middle).norm() - radius;
}

double border_distance(double distance_to_shape, double width) {
  return std::abs(distance_to_shape) - width / 2;
}

double word_length(std::string_view word, double height) {
  double length = -kGap;
  for (const char letter : word) length += glyph_of(letter).width + kGap;
  return height * length;
}

double word_distance(const Eigen::Vector2d& at, std::string_view word, const Eigen::Vector2d& base,
                     double height) {
  const Eigen::Vector2d place = (at - base) / height + Eigen::Vector2d(0, 1);
  const Eigen::Vector2d end(word_length(word, 1), 1);
  const double outside = box_distance(place, Eigen::Vector2d::Zero(), end) - kStroke;
  if (outside > 0) return height * (outside + kStroke / 2);
  double nearest = std::numeric_limits<double>::infinity();
  double left = 0;
  for (const char letter : word) {
    const Glyph& glyph = glyph_of(letter);
    nearest = std::min(nearest, glyph_distance(place - Eigen::Vector2d(left, 0), glyph));
    left += glyph.width + kGap;
  }
  return height * nearest;
}

double Texel::share(double distance) const {
  return std::clamp(0.5 - distance / size_, 0.0, 1.0);
}

Texel& Texel::cover(double distance, const Ink& ink) {
  const double covered = share(distance);
  ink_ = (1 - covered) * ink_ + covered * ink;
  return *this;
}

Texel& Texel::shade(double distance, double factor) {
  ink_ *= 1 - share(distance) * (1 - factor);
  return *this;
}

}  // namespace sightline
