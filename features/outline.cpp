// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/outline.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "pose/angles.h"

namespace sightline {
namespace {

// Faces that turn more make a crease, which is seen also inside the outline.
const double kCreaseCosine = std::cos(55 * kDegree);
constexpr double kMaxOffsetPx = 4;          // of an outline from the rounded edge that makes it
constexpr double kMaxCreaseOffsetPx = 0.3;  // a crease is its own outline
constexpr double kParallelCosine = 0.8;     // of an outline's normal with that of its edge
constexpr double kLookStepPx = 6;           // between samples whose visibility is looked up
constexpr double kClearancePx = 1;          // of an outline from the surface that makes it
constexpr double kBevelPx = 4;              // the widest that blurs into its edge
// Where it is asked what lies beyond the outline: at the nearer a part may end before the farther.
constexpr double kBeyondPx = 3;
constexpr double kJustBeyondPx = 1.2;

// An edge of the mesh in the image: of the outline, with the target on the left of its direction as
// seen, or a crease inside it.
struct MeshSegment {
  Eigen::Vector2d begin, end;
  Eigen::Vector3d begin_m, end_m;
  Eigen::Vector2d normal;  // unit, out of the target

  Eigen::Vector3d at_m(double t) const { return begin_m + t * (end_m - begin_m); }
};

// Looks from the camera at the target.
class Eye {
 public:
  explicit Eye(const PredictedView& view)
      : view_(view), target_from_cam_(inverse(view.cam_from_target)) {}

  const Eigen::Vector3d& position_m() const { return target_from_cam_.translation; }

  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point_m) const {
    return sightline::project(view_.camera, view_.cam_from_target * point_m);
  }

  double depth_m(const Eigen::Vector3d& point_m) const {
    return (view_.cam_from_target * point_m).z();
  }

  double metres_per_px(const Eigen::Vector3d& point_m) const {
    return (point_m - position_m()).norm() / view_.camera.fx_px;
  }

  bool sees(const Eigen::Vector3d& point_m) const {
    return !view_.target->occluder.hides(point_m, position_m(),
                                         kClearancePx * metres_per_px(point_m));
  }

  bool sees_target_at(const Eigen::Vector2d& pixel) const {
    const auto ray = bearing(view_.camera, pixel);
    if (!ray) return false;
    const double beyond_m = 2 * position_m().norm();
    const Eigen::Vector3d far_m = target_from_cam_ * Eigen::Vector3d(beyond_m * *ray);
    return view_.target->occluder.hides(far_m, position_m(), 0);
  }

 private:
  const PredictedView& view_;
  Pose target_from_cam_;
};

const FeatureShape* shape_of(const PredictedView& view, const FeaturePrediction& prediction) {
  if (view.target == nullptr || view.target->shapes.empty()) return nullptr;
  return &view.target->shapes[prediction.feature];
}

// That edge in the image, unless it is farther than `reach_px` from a pixel.
std::optional<MeshSegment> segment_of(const Eye& eye, const MeshEdge& edge, bool is_reversed,
                                      const Eigen::Vector2d& centre, double reach_px) {
  const auto begin = eye.project(edge.begin_m);
  const auto end = eye.project(edge.end_m);
  if (!begin || !end) return std::nullopt;
  MeshSegment segment{*begin, *end, edge.begin_m, edge.end_m, {}};
  if (is_reversed) {
    std::swap(segment.begin, segment.end);
    std::swap(segment.begin_m, segment.end_m);
  }
  const Eigen::Vector2d along = segment.end - segment.begin;
  const double squared_length = along.squaredNorm();
  if (!(squared_length > 0)) return std::nullopt;
  const double nearest = std::clamp((centre - segment.begin).dot(along) / squared_length, 0., 1.);
  if ((segment.begin + nearest * along - centre).norm() > reach_px) return std::nullopt;
  // A face turned to the eye winds counter-clockwise as seen, so that the target is on the left;
  // v points down.
  segment.normal = Eigen::Vector2d(-along.y(), along.x()) / std::sqrt(squared_length);
  return segment;
}

// The edges of the mesh between a face turned to the eye and one turned away, near a pixel.
std::vector<MeshSegment> outline_segments(const Eye& eye, const FeatureShape& shape,
                                          const Eigen::Vector2d& centre, double reach_px) {
  std::vector<MeshSegment> segments;
  for (const MeshEdge& edge : shape.edges) {
    const bool is_first_seen = edge.is_face_towards(0, eye.position_m());
    const bool is_second_seen = !edge.is_open && edge.is_face_towards(1, eye.position_m());
    if (is_first_seen == is_second_seen && !edge.is_open) continue;
    const auto segment = segment_of(eye, edge, !is_first_seen, centre, reach_px);
    if (segment) segments.push_back(*segment);
  }
  return segments;
}

// The creases between two faces that are both turned to the eye, near a pixel.
std::vector<MeshSegment> seen_creases(const Eye& eye, const FeatureShape& shape,
                                      const Eigen::Vector2d& centre, double reach_px) {
  std::vector<MeshSegment> segments;
  for (const MeshEdge& edge : shape.edges) {
    if (edge.is_open || edge.cos_turn() > kCreaseCosine) continue;
    if (!edge.is_face_towards(0, eye.position_m()) || !edge.is_face_towards(1, eye.position_m())) {
      continue;
    }
    const auto segment = segment_of(eye, edge, false, centre, reach_px);
    if (segment) segments.push_back(*segment);
  }
  return segments;
}

struct Crossing {
  double offset_px;
  Eigen::Vector3d point_m;
  bool is_normal_reversed;
};

// Where the outline, running along with an edge, crosses the edge's normal at a pixel: nearest.
std::optional<Crossing> crossing_at(const std::vector<MeshSegment>& segments,
                                    const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal,
                                    double max_offset_px) {
  const Eigen::Vector2d along(-normal.y(), normal.x());
  std::optional<Crossing> nearest;
  for (const MeshSegment& segment : segments) {
    const double cosine = segment.normal.dot(normal);
    if (std::abs(cosine) < kParallelCosine) continue;
    const double from = along.dot(segment.begin - pixel);
    const double to = along.dot(segment.end - pixel);
    if (from * to > 0 || from == to) continue;
    const double t = from / (from - to);
    const double offset_px = normal.dot(segment.begin + t * (segment.end - segment.begin) - pixel);
    if (std::abs(offset_px) > (nearest ? std::abs(nearest->offset_px) : max_offset_px)) continue;
    nearest = {offset_px, segment.at_m(t), cosine < 0};
  }
  return nearest;
}

// The point of a straight edge seen at a pixel of its projection.
Eigen::Vector3d point_on(const Edge& edge, const Eye& eye, const Eigen::Vector2d& begin,
                         const Eigen::Vector2d& direction, double along_px) {
  // The projection of a straight line is a fraction of two linear functions of its parameter.
  const Eigen::Vector2d end = *eye.project(edge.end_m);
  const double length_px = direction.dot(end - begin);
  const double near_m = eye.depth_m(edge.begin_m);
  const double far_m = eye.depth_m(edge.end_m);
  const double s = along_px / length_px;
  const double t = s * near_m / (far_m + s * (near_m - far_m));
  return edge.begin_m + t * (edge.end_m - edge.begin_m);
}

// True where another edge runs so near.
bool has_neighbour(const std::vector<MeshSegment>& segments, const Eigen::Vector2d& on_outline,
                   const Eigen::Vector2d& normal, double apart_px) {
  constexpr double kItselfPx = 0.5;
  const Eigen::Vector2d along(-normal.y(), normal.x());
  for (const MeshSegment& segment : segments) {
    const double from = along.dot(segment.begin - on_outline);
    const double to = along.dot(segment.end - on_outline);
    if (from * to > 0 || from == to) continue;
    const double t = from / (from - to);
    const double across =
        std::abs(normal.dot(segment.begin + t * (segment.end - segment.begin) - on_outline));
    if (across > kItselfPx && across < apart_px) return true;
  }
  return false;
}

// By length: a wing's tip is rounded amidst and sharp at its trailing end.
bool is_mostly_rounded(const std::vector<MeshEdge>& edges) {
  double rounded_m = 0;
  double length_m = 0;
  for (const MeshEdge& edge : edges) {
    const double edge_m = (edge.end_m - edge.begin_m).norm();
    length_m += edge_m;
    if (!edge.is_open && edge.cos_turn() > kCreaseCosine) rounded_m += edge_m;
  }
  return 2 * rounded_m > length_m;
}

// What is seen at a point of an edge or of the outline.
struct Looked {
  bool is_seen = false;
  bool borders_target = false;
};

// One of a feature's edges that is to be predicted, with what of the mesh is near it.
struct EdgeAsked {
  const Edge& own;
  const std::vector<MeshEdge>& along;  // the edges of the mesh that it consists of
  const Eye& eye;
  const EdgeStretch& stretch;
  bool is_rounded;
  int count;  // of places a pixel apart along it, from its gap on
  std::vector<MeshSegment> outline;
  std::vector<MeshSegment> creases;  // that the stretch is to be apart from

  double along_px(int place) const { return stretch.gap_px + place; }

  std::optional<Crossing> outline_at(const PredictedEdge& predicted, int place) const {
    return crossing_at(outline, predicted.begin + along_px(place) * predicted.direction,
                       predicted.normal, is_rounded ? kMaxOffsetPx : kMaxCreaseOffsetPx);
  }

  bool is_apart(const PredictedEdge& predicted, const Eigen::Vector2d& on_edge) const {
    return !has_neighbour(outline, on_edge, predicted.normal, stretch.apart_px) &&
           !has_neighbour(creases, on_edge, predicted.normal, stretch.apart_px);
  }

  // True where a crease between two faces runs along the edge that are both turned to the eye; the
  // mesh may also have no edge there.
  bool is_seen_as_crease() const {
    if (is_rounded) return false;
    return along.empty() || (along.front().is_face_towards(0, eye.position_m()) &&
                             along.front().is_face_towards(1, eye.position_m()));
  }
};

// Where the outline runs along the edge: at how many of its places, and at how many of these with
// the target on the other side of it than the predicted normal says.
struct OutlinedPlaces {
  int outlined = 0;
  int reversed = 0;
};

OutlinedPlaces outlined_places(const EdgeAsked& asked, const PredictedEdge& predicted) {
  OutlinedPlaces places;
  for (int i = 0; i < asked.count; ++i) {
    const auto crossing = asked.outline_at(predicted, i);
    places.outlined += crossing.has_value();
    places.reversed += crossing && crossing->is_normal_reversed;
  }
  return places;
}

// The places of the edge that are to be seen.
std::vector<PredictedEdge::Sample> seen_samples(const EdgeAsked& asked,
                                                const PredictedEdge& predicted) {
  std::vector<PredictedEdge::Sample> samples;
  samples.reserve(asked.count);
  const Eye& eye = asked.eye;
  Looked looked;
  double look_px = asked.stretch.gap_px;
  for (int i = 0; i < asked.count; ++i) {
    const double along_px = asked.along_px(i);
    double offset_px = 0;
    Eigen::Vector3d point_m;
    if (!predicted.is_crease) {
      const auto crossing = asked.outline_at(predicted, i);
      if (!crossing || crossing->is_normal_reversed) continue;
      offset_px = crossing->offset_px;
      point_m = crossing->point_m;
    }
    const Eigen::Vector2d on_edge =
        predicted.begin + along_px * predicted.direction + offset_px * predicted.normal;
    if (!asked.is_apart(predicted, on_edge)) continue;
    if (along_px >= look_px) {
      look_px = along_px + kLookStepPx;
      if (predicted.is_crease) {
        point_m = point_on(asked.own, eye, predicted.begin, predicted.direction, along_px);
      }
      looked.is_seen = eye.sees(point_m);
      looked.borders_target = predicted.is_crease ||
                              eye.sees_target_at(on_edge + kBeyondPx * predicted.normal) ||
                              eye.sees_target_at(on_edge + kJustBeyondPx * predicted.normal);
    }
    if (looked.is_seen) samples.push_back({along_px, offset_px, looked.borders_target});
  }
  return samples;
}

}  // namespace

PredictedEdge predict_edge(const PredictedView& view, const FeaturePrediction& prediction, int edge,
                           const EdgeStretch& stretch) {
  PredictedEdge predicted;
  predicted.begin = prediction.pixel;
  const FeatureShape* shape = shape_of(view, prediction);
  if (shape == nullptr) return predicted;
  const Edge& own = view.target->features[prediction.feature].edges[edge];
  predicted.direction = image_direction(view.camera, view.cam_from_target, own);
  predicted.normal = Eigen::Vector2d(-predicted.direction.y(), predicted.direction.x());
  const Eye eye(view);
  const auto end = eye.project(own.end_m);
  if (!end) return predicted;
  const double length_px = predicted.direction.dot(*end - predicted.begin);
  const double last_px = std::min(stretch.reach_px, length_px - stretch.gap_px);
  if (!(last_px > stretch.gap_px)) return predicted;

  const std::vector<MeshEdge>& along = shape->along[edge];
  const bool is_rounded = is_mostly_rounded(along);
  predicted.is_soft =
      is_rounded || shape->bevel_m[edge] < kBevelPx * eye.metres_per_px(own.begin_m);
  const double near_px = last_px + kMaxOffsetPx;
  const EdgeAsked asked{own,
                        along,
                        eye,
                        stretch,
                        is_rounded,
                        static_cast<int>(last_px - stretch.gap_px) + 1,
                        outline_segments(eye, *shape, predicted.begin, near_px),
                        stretch.is_apart_from_creases
                            ? seen_creases(eye, *shape, predicted.begin, near_px)
                            : std::vector<MeshSegment>()};
  const OutlinedPlaces places = outlined_places(asked, predicted);
  predicted.is_crease = 2 * places.outlined < asked.count;
  if (predicted.is_crease && !asked.is_seen_as_crease()) {
    predicted.is_crease = false;
    return predicted;
  }
  if (2 * places.reversed > places.outlined) predicted.normal = -predicted.normal;
  predicted.samples = seen_samples(asked, predicted);
  return predicted;
}

std::vector<EdgeSegment> edges_beside(const PredictedView& view,
                                      const FeaturePrediction& prediction, int edge,
                                      double reach_px) {
  std::vector<EdgeSegment> beside;
  const FeatureShape* shape = shape_of(view, prediction);
  if (shape == nullptr) return beside;
  const std::vector<MeshEdge>& own = shape->along[edge];
  const auto is_own = [&](const MeshSegment& segment) {
    return std::any_of(own.begin(), own.end(), [&](const MeshEdge& part) {
      return (segment.begin_m == part.begin_m && segment.end_m == part.end_m) ||
             (segment.begin_m == part.end_m && segment.end_m == part.begin_m);
    });
  };
  const Eye eye(view);
  for (const auto& segments : {outline_segments(eye, *shape, prediction.pixel, reach_px),
                               seen_creases(eye, *shape, prediction.pixel, reach_px)}) {
    for (const MeshSegment& segment : segments) {
      if (!is_own(segment)) beside.push_back({segment.begin, segment.end});
    }
  }
  return beside;
}

std::vector<OutlineSample> predict_outline(const PredictedView& view,
                                           const FeaturePrediction& prediction, double reach_px) {
  std::vector<OutlineSample> samples;
  const FeatureShape* shape = shape_of(view, prediction);
  if (shape == nullptr) return samples;
  const Eye eye(view);
  double to_next_px = 0.5;  // samples stay a pixel apart over the bends of the outline
  double to_look_px = 0;
  for (const MeshSegment& segment : outline_segments(eye, *shape, prediction.pixel, reach_px)) {
    const Eigen::Vector2d along = segment.end - segment.begin;
    const double length_px = along.norm();
    Looked looked;
    to_look_px = 0;
    double at_px = to_next_px;
    for (; at_px < length_px; ++at_px) {
      const double t = at_px / length_px;
      const Eigen::Vector2d pixel = segment.begin + t * along;
      if ((pixel - prediction.pixel).norm() > reach_px) continue;
      if (at_px >= to_look_px) {
        to_look_px = at_px + kLookStepPx;
        looked.is_seen = eye.sees(segment.at_m(t));
        looked.borders_target = eye.sees_target_at(pixel + kBeyondPx * segment.normal);
      }
      if (looked.is_seen) samples.push_back({pixel, segment.normal, looked.borders_target});
    }
    to_next_px = at_px - length_px;
  }
  return samples;
}

}  // namespace sightline
