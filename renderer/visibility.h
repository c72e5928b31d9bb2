// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "renderer/sample_pattern.h"

namespace sightline {

/// Whole pixels, right and bottom exclusive.
struct PixelBox {
  int left = 0, top = 0, right = 0, bottom = 0;
  int width() const { return right - left; }
  int height() const { return bottom - top; }
  bool is_empty() const { return left >= right || top >= bottom; }
};

/// A corner on the image plane: pixel, and how near it is. Nearness must be linear across the image
/// (1/z of a perspective, -z of a parallel projection); the larger hides the smaller.
struct ScreenPoint {
  double x = 0, y = 0, nearness = 0;
};

/// A triangle on the image plane, of either winding. Samples that see it get its id, which is not
/// 0.
struct ScreenTriangle {
  std::array<uint32_t, 3> corners{};  ///< indices into ScreenMesh::points
  uint32_t id = 0;
};

/// Triangles on the image plane. They share their corners, as those of a mesh do: of millions of
/// them each corner would else be there six times.
struct ScreenMesh {
  std::vector<ScreenPoint> points;
  std::vector<ScreenTriangle> triangles;

  void clear() {
    points.clear();
    triangles.clear();
  }
  std::array<ScreenPoint, 3> corners_of(const ScreenTriangle& triangle) const {
    const auto& [a, b, c] = triangle.corners;
    return {points[a], points[b], points[c]};
  }
};

/// The pixels that samples of the triangles may lie in, cut to `box`.
PixelBox touched_box(const ScreenMesh& mesh, const PixelBox& box);
/// The same of one triangle.
PixelBox touched_box(const std::array<ScreenPoint, 3>& corners, const PixelBox& box);

/// Some rows of an image: what each sample sees. Samples of a pixel lie together, in the pattern's
/// order.
struct VisibleStrip {
  PixelBox box;
  std::vector<uint32_t> ids;        ///< 0 where nothing is; undefined in untouched pixels
  std::vector<float> nearness;      ///< of what is seen; alike. Only our own painter tells it
  std::vector<uint8_t> is_touched;  ///< of each pixel: some sample of it may see something
  double readback_ms = 0;           ///< what fetching it from OpenGL cost

  size_t pixel(int x, int y) const {
    return static_cast<size_t>(y - box.top) * box.width() + (x - box.left);
  }
};

/// Finds what every sample of an image sees.
class SamplePainter {
 public:
  virtual ~SamplePainter() = default;
  /// Begins an image of `box`, which ends with the last next() or paint_behind(): as long as that,
  /// `mesh` and `pattern` must stay.
  virtual void start(const ScreenMesh& mesh, const PixelBox& box, const SamplePattern& pattern) = 0;
  /// Paints the next rows, top to bottom; false when there are none left.
  virtual bool next(VisibleStrip& strip) = 0;
  /// Paints the rows of the last next() again: of each sample what lies behind `strip.nearness`,
  /// nothing where that is -FLT_MAX. False of a painter that cannot: all but our own.
  virtual bool paint_behind(VisibleStrip&) { return false; }
  /// Who paints, for a manifest.
  virtual std::string description() const = 0;
};

/// Our own painter. It keeps to the pixels that triangles touch, works in strips that fit the
/// processor's cache, and computes the same ids on every processor: edges in double precision, the
/// samples' offsets from a pixel's centre in single (6e-8 px). Edge functions of a shared edge are
/// exact negatives of each other, so that no sample falls between two triangles.
std::unique_ptr<SamplePainter> make_own_painter();

}  // namespace sightline
