// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/visibility.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pose/multiversion.h"

namespace sightline {
namespace {

// What a second-level cache holds beside the triangles.
constexpr size_t kStripBytes = 256 * 1024;

// How far samples may lie from their pixel's centre along an axis, px.
constexpr double kHalfPixel = 0.5;

// One sample lies at the centre: small triangles then touch half as many pixels or none. A little
// more, so that rounding leaves out no pixel whose centre lies on an edge: samples decide.
double reach_of(const SamplePattern& pattern) {
  constexpr double kRounding = 1e-6;
  return pattern.count == 1 ? kRounding : kHalfPixel;
}

// A triangle ready to be sampled.
struct FlatTriangle {
  double a[3], b[3], c[3];  // a x + b y + c >= 0 on the inside of each edge
  double nearness_x, nearness_y, nearness_0;
  int left, right, top, bottom;  // the pixels it can touch, all inclusive
  uint32_t id;
};

// The pixels of one row, from `lo` to `hi`, that a triangle can touch.
struct Span {
  int lo, hi;
};

// The samples of a pixel lie within the pattern's reach of its centre: an edge function falls by at
// most that times (|a| + |b|) towards them.
inline Span span_of_row(const FlatTriangle& t, const double* row, const double* reach,
                        const double* inverse_a) {
  double lo = t.left;
  double hi = t.right;
  for (int i = 0; i < 3; ++i) {
    const double rest = row[i] + reach[i];
    if (t.a[i] > 0) {
      lo = std::max(lo, -rest * inverse_a[i]);
    } else if (t.a[i] < 0) {
      hi = std::min(hi, -rest * inverse_a[i]);
    } else if (rest < 0) {
      return {0, -1};
    }
  }
  if (!(lo <= hi)) return {0, -1};
  return {static_cast<int>(std::ceil(lo)), static_cast<int>(std::floor(hi))};
}

template <int N>
inline void clear(float* nearness, uint32_t* ids) {
  for (int k = 0; k < N; ++k) {
    nearness[k] = -std::numeric_limits<float>::max();
    ids[k] = 0;
  }
}

// `limits`: what is as near or nearer than that is not painted; used where HasLimits.
template <int N, bool HasLimits>
inline void paint_triangle(const FlatTriangle& t, double reach_px, const float* x_offset,
                           const float* y_offset, const PixelBox& box, const float* limits,
                           float* nearness, uint32_t* ids, uint8_t* is_touched) {
  alignas(64) float edge0[N], edge1[N], edge2[N], depth[N];
  const float a0 = static_cast<float>(t.a[0]), b0 = static_cast<float>(t.b[0]);
  const float a1 = static_cast<float>(t.a[1]), b1 = static_cast<float>(t.b[1]);
  const float a2 = static_cast<float>(t.a[2]), b2 = static_cast<float>(t.b[2]);
  const float zx = static_cast<float>(t.nearness_x), zy = static_cast<float>(t.nearness_y);
  for (int k = 0; k < N; ++k) {
    edge0[k] = a0 * x_offset[k] + b0 * y_offset[k];
    edge1[k] = a1 * x_offset[k] + b1 * y_offset[k];
    edge2[k] = a2 * x_offset[k] + b2 * y_offset[k];
    depth[k] = zx * x_offset[k] + zy * y_offset[k];
  }
  const uint32_t id = t.id;
  double reach[3], inverse_a[3];
  for (int i = 0; i < 3; ++i) {
    reach[i] = reach_px * (std::abs(t.a[i]) + std::abs(t.b[i]));
    inverse_a[i] = t.a[i] == 0 ? 0 : 1 / t.a[i];
  }
  const int bottom = std::min(t.bottom, box.bottom - 1);
  for (int y = std::max(t.top, box.top); y <= bottom; ++y) {
    double row[3];
    for (int i = 0; i < 3; ++i) row[i] = t.b[i] * y + t.c[i];
    const double depth_row = t.nearness_y * y + t.nearness_0;
    const Span span = span_of_row(t, row, reach, inverse_a);
    size_t at = static_cast<size_t>(y - box.top) * (box.right - box.left) + (span.lo - box.left);
    for (int x = span.lo; x <= span.hi; ++x, ++at) {
      float* __restrict near_at = nearness + at * N;
      const float* __restrict limit_at = HasLimits ? limits + at * N : nullptr;
      uint32_t* __restrict ids_at = ids + at * N;
      if (!is_touched[at]) {
        is_touched[at] = 1;
        clear<N>(near_at, ids_at);
      }
      const float e0 = static_cast<float>(t.a[0] * x + row[0]);
      const float e1 = static_cast<float>(t.a[1] * x + row[1]);
      const float e2 = static_cast<float>(t.a[2] * x + row[2]);
      const float z = static_cast<float>(t.nearness_x * x + depth_row);
#pragma GCC ivdep
#pragma GCC unroll 1
      for (int k = 0; k < N; ++k) {
        const float inside = std::min(std::min(e0 + edge0[k], e1 + edge1[k]), e2 + edge2[k]);
        const float near_k = z + depth[k];
        bool is_nearest = (inside >= 0) & (near_k > near_at[k]);
        if constexpr (HasLimits) is_nearest &= near_k < limit_at[k];
        near_at[k] = is_nearest ? near_k : near_at[k];
        ids_at[k] = is_nearest ? id : ids_at[k];
      }
    }
  }
}

template <int N>
inline void paint_all(const FlatTriangle* triangles, const int* order, size_t count,
                      double reach_px, const float* x_offset, const float* y_offset,
                      const PixelBox& box, const float* limits, float* nearness, uint32_t* ids,
                      uint8_t* is_touched) {
  for (size_t i = 0; i < count; ++i) {
    const FlatTriangle& triangle = triangles[order[i]];
    if (limits == nullptr) {
      paint_triangle<N, false>(triangle, reach_px, x_offset, y_offset, box, limits, nearness, ids,
                               is_touched);
    } else {
      paint_triangle<N, true>(triangle, reach_px, x_offset, y_offset, box, limits, nearness, ids,
                              is_touched);
    }
  }
}

SIGHTLINE_MULTIVERSION
void paint(int samples, const FlatTriangle* triangles, const int* order, size_t count,
           double reach_px, const float* x_offset, const float* y_offset, const PixelBox& box,
           const float* limits, float* nearness, uint32_t* ids, uint8_t* is_touched) {
  switch (samples) {
    case 1:
      return paint_all<1>(triangles, order, count, reach_px, x_offset, y_offset, box, limits,
                          nearness, ids, is_touched);
    case 4:
      return paint_all<4>(triangles, order, count, reach_px, x_offset, y_offset, box, limits,
                          nearness, ids, is_touched);
    case 8:
      return paint_all<8>(triangles, order, count, reach_px, x_offset, y_offset, box, limits,
                          nearness, ids, is_touched);
    case 16:
      return paint_all<16>(triangles, order, count, reach_px, x_offset, y_offset, box, limits,
                           nearness, ids, is_touched);
    case 32:
      return paint_all<32>(triangles, order, count, reach_px, x_offset, y_offset, box, limits,
                           nearness, ids, is_touched);
    case 64:
      return paint_all<64>(triangles, order, count, reach_px, x_offset, y_offset, box, limits,
                           nearness, ids, is_touched);
    default:
      return paint_all<256>(triangles, order, count, reach_px, x_offset, y_offset, box, limits,
                            nearness, ids, is_touched);
  }
}

// Grows by triangles.
class Extent {
 public:
  explicit Extent(const PixelBox& box)
      : box_(box),
        left_(box.right),
        top_(box.bottom),
        right_(box.left - 1.0),
        bottom_(box.top - 1.0) {}

  void add(const std::array<ScreenPoint, 3>& corners) {
    const auto& [p, q, r] = corners;
    left_ = std::min({left_, p.x, q.x, r.x});
    right_ = std::max({right_, p.x, q.x, r.x});
    top_ = std::min({top_, p.y, q.y, r.y});
    bottom_ = std::max({bottom_, p.y, q.y, r.y});
  }

  // Those of the box that have samples in it.
  PixelBox pixels(double reach_px) const {
    // Samples of pixel x lie from x - reach to x + reach. Cut before the cast: far points exceed an
    // int.
    const auto first = [reach_px](double x, int low, int high) {
      return static_cast<int>(std::ceil(std::clamp<double>(x - reach_px, low, high)));
    };
    const auto end = [reach_px](double x, int low, int high) {
      const double last = std::clamp<double>(x + reach_px, low - 1.0, high - 1.0);
      return static_cast<int>(std::floor(last)) + 1;
    };
    return {first(left_, box_.left, box_.right), first(top_, box_.top, box_.bottom),
            end(right_, box_.left, box_.right), end(bottom_, box_.top, box_.bottom)};
  }

 private:
  PixelBox box_;
  double left_, top_, right_, bottom_;
};

PixelBox touched_box(const std::array<ScreenPoint, 3>& corners, const PixelBox& box,
                     double reach_px) {
  Extent extent(box);
  extent.add(corners);
  return extent.pixels(reach_px);
}

// Twice the area, with the sign of the winding.
double signed_area(const std::array<ScreenPoint, 3>& corners) {
  const auto& [p, q, r] = corners;
  return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
}

// Of a triangle that has an area and touches the box.
FlatTriangle flattened(const std::array<ScreenPoint, 3>& corners, uint32_t id, const PixelBox& box,
                       double reach_px) {
  const auto& [p, q, r] = corners;
  const double area = signed_area(corners);
  const PixelBox touched = touched_box(corners, box, reach_px);
  FlatTriangle t;
  t.left = touched.left;
  t.top = touched.top;
  t.right = touched.right - 1;
  t.bottom = touched.bottom - 1;
  const double sign = area > 0 ? 1 : -1;
  const auto set_edge = [&](int i, const ScreenPoint& from, const ScreenPoint& to) {
    t.a[i] = sign * (from.y - to.y);
    t.b[i] = sign * (to.x - from.x);
    t.c[i] = sign * (from.x * to.y - to.x * from.y);
  };
  set_edge(0, p, q);
  set_edge(1, q, r);
  set_edge(2, r, p);
  const double to_q = (q.nearness - p.nearness) / area;
  const double to_r = (r.nearness - p.nearness) / area;
  t.nearness_x = to_q * (r.y - p.y) - to_r * (q.y - p.y);
  t.nearness_y = to_r * (q.x - p.x) - to_q * (r.x - p.x);
  t.nearness_0 = p.nearness - t.nearness_x * p.x - t.nearness_y * p.y;
  t.id = id;
  return t;
}

class OwnPainter : public SamplePainter {
 public:
  void start(const ScreenMesh& mesh, const PixelBox& box, const SamplePattern& pattern) override {
    mesh_ = &mesh;
    box_ = box;
    pattern_ = &pattern;
    reach_px_ = reach_of(pattern);
    next_ = 0;
    batch_begin_ = batch_end_ = 0;
    begin_.clear();
    if (box.is_empty()) return;
    const size_t row_bytes =
        static_cast<size_t>(box.width()) * pattern.count * (sizeof(float) + sizeof(uint32_t));
    rows_ = static_cast<int>(std::clamp<size_t>(kStripBytes / row_bytes, 1, box.height()));
    sort_into_strips();
  }

  bool next(VisibleStrip& strip) override {
    if (next_ + 1 >= static_cast<int>(begin_.size())) return false;
    strip.box = box_;
    strip.box.top = box_.top + next_ * rows_;
    strip.box.bottom = std::min(strip.box.top + rows_, box_.bottom);
    const size_t pixels = static_cast<size_t>(strip.box.width()) * strip.box.height();
    strip.is_touched.assign(pixels, 0);
    strip.ids.resize(std::max(strip.ids.size(), pixels * pattern_->count));
    strip.nearness.resize(std::max(strip.nearness.size(), pixels * pattern_->count));
    paint_strip(next_, nullptr, strip);
    ++next_;
    return true;
  }

  bool paint_behind(VisibleStrip& strip) override {
    limits_.assign(strip.nearness.begin(), strip.nearness.end());
    std::fill(strip.is_touched.begin(), strip.is_touched.end(), uint8_t{0});
    paint_strip(next_ - 1, limits_.data(), strip);
    return true;
  }

  std::string description() const override { return "own rasteriser"; }

 private:
  void paint_strip(int index, const float* limits, VisibleStrip& strip) {
    const int strip_end = begin_[index + 1];
    for (int at = begin_[index]; at < strip_end;) {
      if (at < batch_begin_ || at >= batch_end_) flatten_from(at);
      const int end = std::min(batch_end_, strip_end);
      paint(pattern_->count, flat_.data(), flat_order_.data() + (at - batch_begin_),
            static_cast<size_t>(end - at), reach_px_, pattern_->x.data(), pattern_->y.data(),
            strip.box, limits, strip.nearness.data(), strip.ids.data(), strip.is_touched.data());
      at = end;
    }
  }

  // The strips that a triangle touches; none where `last` is before `first`.
  struct Strips {
    int first = 0, last = -1;
  };

  Strips strips_of(const ScreenTriangle& triangle) const {
    const auto corners = mesh_->corners_of(triangle);
    if (signed_area(corners) == 0) return {};
    const PixelBox touched = touched_box(corners, box_, reach_px_);
    if (touched.is_empty()) return {};
    return {(touched.top - box_.top) / rows_, (touched.bottom - 1 - box_.top) / rows_};
  }

  // A counting sort; a triangle is in every strip that it touches.
  void sort_into_strips() {
    const int strips = (box_.height() + rows_ - 1) / rows_;
    begin_.assign(strips + 1, 0);
    strips_.clear();
    for (const ScreenTriangle& triangle : mesh_->triangles) {
      strips_.push_back(strips_of(triangle));
      for (int s = strips_.back().first; s <= strips_.back().last; ++s) ++begin_[s + 1];
    }
    for (int s = 0; s < strips; ++s) begin_[s + 1] += begin_[s];
    order_.resize(begin_.back());
    std::vector<int> fill(begin_.begin(), begin_.end() - 1);
    for (size_t i = 0; i < strips_.size(); ++i) {
      for (int s = strips_[i].first; s <= strips_[i].last; ++s) {
        order_[fill[s]++] = static_cast<int>(i);
      }
    }
  }

  // Makes a batch of triangles ready, from that place of order_ on, each once: of millions all at
  // once would be the largest thing in memory.
  void flatten_from(int begin) {
    constexpr int kMostFlat = 1 << 18;
    batch_begin_ = begin;
    batch_end_ = std::min(begin_.back(), begin + kMostFlat);
    flat_.clear();
    source_.clear();
    flat_order_.clear();
    flat_of_.resize(mesh_->triangles.size());
    for (int at = batch_begin_; at < batch_end_; ++at) {
      const int triangle = order_[at];
      const auto known = static_cast<size_t>(flat_of_[triangle]);
      if (known >= source_.size() || source_[known] != triangle) {
        const ScreenTriangle& from = mesh_->triangles[triangle];
        flat_of_[triangle] = static_cast<int>(flat_.size());
        flat_.push_back(flattened(mesh_->corners_of(from), from.id, box_, reach_px_));
        source_.push_back(triangle);
      }
      flat_order_.push_back(flat_of_[triangle]);
    }
  }

  const ScreenMesh* mesh_ = nullptr;
  PixelBox box_;
  const SamplePattern* pattern_ = nullptr;
  double reach_px_ = kHalfPixel;
  int rows_ = 1;
  int next_ = 0;
  std::vector<Strips> strips_;           // of each triangle
  std::vector<int> begin_;               // of each strip's triangles in order_, and the end
  std::vector<int> order_;               // triangles of the mesh
  int batch_begin_ = 0, batch_end_ = 0;  // what of order_ is ready
  std::vector<FlatTriangle> flat_;       // the triangles there
  std::vector<int> source_;              // of each in flat_ the triangle of the mesh
  std::vector<int> flat_of_;             // of each triangle its place in flat_, if source_ agrees
  std::vector<int> flat_order_;          // places in flat_, of what is ready of order_
  std::vector<float> limits_;            // of what is painted behind
};

}  // namespace

PixelBox touched_box(const ScreenMesh& mesh, const PixelBox& box) {
  Extent extent(box);
  for (const ScreenTriangle& triangle : mesh.triangles) extent.add(mesh.corners_of(triangle));
  return extent.pixels(kHalfPixel);
}

PixelBox touched_box(const std::array<ScreenPoint, 3>& corners, const PixelBox& box) {
  return touched_box(corners, box, kHalfPixel);
}

std::unique_ptr<SamplePainter> make_own_painter() {
  return std::make_unique<OwnPainter>();
}

}  // namespace sightline
