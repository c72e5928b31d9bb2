// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a frame says of itself, against a slow ray caster that shares no code with it.
#include "renderer/truth.h"

#include <cmath>
#include <limits>
#include <optional>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "renderer/renderer.h"
#include "scenes/builders/cube.h"
#include "tests/renderer/scenes_for_tests.h"

namespace sightline {
namespace {

constexpr double kDepthToleranceM = 1e-4;

// One body's mesh in the camera's frame.
class Caster {
 public:
  Caster(const Mesh& mesh, const Pose& cam_from_mesh) {
    for (const Triangle& triangle : mesh.triangles) {
      const auto corner = [&](int i) {
        const Eigen::Vector3d x = cam_from_mesh * mesh.vertices[triangle.vertex[i]];
        return Kernel::Point_3(x.x(), x.y(), x.z());
      };
      const Kernel::Triangle_3 placed(corner(0), corner(1), corner(2));
      if (placed.is_degenerate()) continue;
      triangles_.push_back(placed);
      parts_.push_back(triangle.part);
    }
    tree_.insert(triangles_.begin(), triangles_.end());
    tree_.build();
  }
  Caster(const Caster&) = delete;
  Caster& operator=(const Caster&) = delete;

  struct Hit {
    double depth_m;
    int part;
  };

  std::optional<Hit> cast(const Eigen::Vector2d& normalised) const {
    const Kernel::Ray_3 ray(Kernel::Point_3(0, 0, 0),
                            Kernel::Vector_3(normalised.x(), normalised.y(), 1));
    const auto hit = tree_.first_intersection(ray);
    if (!hit) return std::nullopt;
    const auto* point = boost::get<Kernel::Point_3>(&hit->first);
    if (point == nullptr) return std::nullopt;
    return Hit{point->z(), parts_[hit->second - triangles_.begin()]};
  }

 private:
  using Kernel = CGAL::Simple_cartesian<double>;
  using Triangles = std::vector<Kernel::Triangle_3>;
  using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;

  Triangles triangles_;
  std::vector<int> parts_;
  CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>> tree_;
};

std::vector<std::unique_ptr<Caster>> casters_of(const Scene& scene) {
  std::vector<std::unique_ptr<Caster>> casters;
  casters.push_back(std::make_unique<Caster>(scene.target->mesh, scene.cam_from_target));
  for (const OtherBody& other : scene.others) {
    casters.push_back(std::make_unique<Caster>(other.target->mesh, other.cam_from_target));
  }
  return casters;
}

// A Boeing of 1 km range, another before it, and a cube at half the range.
Scene busy_scene(int index, const BrownConrady& lens = {}) {
  static const auto boeing = load_target("boeing707");
  static const auto cube = scaled(load_target("cube"), 8);
  RandomStream stream(1, "busy scenes", index);
  Scene scene;
  scene.camera = centred_camera(160, 120, 2500);
  scene.camera.lens = lens;
  scene.target = boeing;
  const auto place = [&](double z, double spread_m) {
    Pose pose = at(stream.uniform(-spread_m, spread_m), stream.uniform(-spread_m, spread_m), z);
    pose.rotation = stream.rotation();
    return pose;
  };
  scene.cam_from_target = place(1400, 8);
  scene.others.push_back({boeing, place(1330, 20), false});
  scene.others.push_back({cube, place(700, 10), true});
  return scene;
}

struct Comparison {
  int seen = 0;        // pixels that anybody says see a body
  int other_body = 0;  // where the two name different bodies
  int other_part = 0;  // the same body, different parts
  double depth_m = 0;  // the worst difference where body and part agree
};

Comparison compare(const Scene& scene, const Frame& frame) {
  const auto casters = casters_of(scene);
  Comparison result;
  for (int y = 0; y < scene.camera.height_px; ++y) {
    for (int x = 0; x < scene.camera.width_px; ++x) {
      const Eigen::Vector2d ray = *normalised_from_pixel(scene.camera, {x, y});
      Caster::Hit nearest{std::numeric_limits<double>::infinity(), 0};
      int body = 0;
      for (size_t b = 0; b < casters.size(); ++b) {
        const auto hit = casters[b]->cast(ray);
        if (!hit || hit->depth_m >= nearest.depth_m) continue;
        nearest = *hit;
        body = static_cast<int>(b) + 1;
      }
      const int stated_body = frame.body_ids.at<uint8_t>(y, x);
      if (body == 0 && stated_body == 0) {
        EXPECT_EQ(frame.depth_m.at<double>(y, x), 0);
        EXPECT_EQ(frame.part_ids.at<uint16_t>(y, x), 0);
        continue;
      }
      ++result.seen;
      if (stated_body != body) {
        ++result.other_body;
      } else if (frame.part_ids.at<uint16_t>(y, x) != nearest.part + 1) {
        ++result.other_part;
      } else {
        result.depth_m =
            std::max(result.depth_m, std::abs(frame.depth_m.at<double>(y, x) - nearest.depth_m));
      }
    }
  }
  return result;
}

Frame frame_of(const Scene& scene) {
  return Renderer().render(scene, RandomStream(1, "sensor", 0));
}

TEST(Truth, DepthAndIdsAreThoseOfARayCaster) {
  for (int i = 0; i < 6; ++i) {
    const Scene scene = busy_scene(i);
    const Comparison result = compare(scene, frame_of(scene));
    EXPECT_GT(result.seen, 1500);
    EXPECT_EQ(result.other_body, 0);
    // Where parts touch, either is in front by less than the nearness resolves.
    EXPECT_LE(result.other_part, result.seen / 500);
    EXPECT_LT(result.depth_m, kDepthToleranceM);
    EXPECT_GT(result.depth_m, 0);  // not a comparison of a thing with itself
  }
}

TEST(Truth, ThroughALensToo) {
  for (int i = 0; i < 3; ++i) {
    const Scene scene = busy_scene(i, {.k1 = -30, .k2 = 4000, .p1 = 0.1, .p2 = -0.2, .k3 = 0});
    const Comparison result = compare(scene, frame_of(scene));
    EXPECT_GT(result.seen, 1500);
    // Chords leave the curves by up to 5e-4 px: of some 1000 pixels on an outline half a pixel.
    EXPECT_LE(result.other_body, 4);
    EXPECT_LE(result.other_part, result.seen / 300);
    EXPECT_LT(result.depth_m, kDepthToleranceM);
    Scene without = scene;
    without.camera.lens = {};
    EXPECT_GT(compare(without, frame_of(scene)).other_body, 50);  // the lens does something
  }
}

// The bodies of a busy scene round a wide camera: some of each is in front, some behind.
Scene scene_all_round(int index, const BrownConrady& lens) {
  Scene scene = busy_scene(index, lens);
  scene.camera.fx_px = scene.camera.fy_px = 120;
  RandomStream stream(1, "all round", index);
  const auto place = [&stream] {
    return at(stream.uniform(-9, 9), stream.uniform(-9, 9), stream.uniform(-9, 9),
              {stream.uniform(-3, 3), stream.uniform(-1, 1), 0});
  };
  scene.cam_from_target = place();
  scene.others.pop_back();  // the nearer Boeing is 1330 m away
  scene.others[0] = {load_target("cube"), at(1.2, 0.3, 0.2, {0.4, 0.5, 0.6}), true};
  return scene;
}

int vertices_behind(const Target& target, const Pose& cam_from_target) {
  const auto& vertices = target.mesh.vertices;
  return static_cast<int>(std::count_if(
      vertices.begin(), vertices.end(),
      [&](const Eigen::Vector3d& vertex) { return (cam_from_target * vertex).z() < 0; }));
}

TEST(Truth, OfBodiesThatReachBehindTheCameraIsThatOfARayCaster) {
  const BrownConrady lens{.k1 = -0.1, .k2 = 0.01, .p1 = 0.001, .p2 = 0, .k3 = 0};
  int compared = 0;
  for (int i = 0; i < 40 && compared < 4; ++i) {
    const bool has_lens = compared >= 3;
    const Scene scene = scene_all_round(i, has_lens ? lens : BrownConrady{});
    if (vertices_behind(*scene.target, scene.cam_from_target) < 100) continue;
    if (!why_not_imageable(scene).empty()) continue;
    const int cube_behind = vertices_behind(*scene.others[0].target, at(1.2, 0.3, 0.2));
    EXPECT_TRUE(cube_behind > 0 && cube_behind < 8) << cube_behind;
    const Comparison result = compare(scene, frame_of(scene));
    if (result.seen < 1500) continue;
    ++compared;
    EXPECT_LE(result.other_body, has_lens ? 4 : 0) << i;
    EXPECT_LE(result.other_part, result.seen / 300) << i;
    EXPECT_LT(result.depth_m, kDepthToleranceM) << i;
  }
  EXPECT_EQ(compared, 4);
}

// A floor of two triangles, both of which go on behind the camera.
TEST(Truth, OfTrianglesThatCrossTheCamerasPlaneIsThatOfARayCaster) {
  const BrownConrady bent{.k1 = -0.1, .k2 = 0.01, .p1 = 0.001, .p2 = 0, .k3 = 0};
  for (const BrownConrady& lens : {BrownConrady{}, bent}) {
    Scene scene = coverage_scene(plate(60), at(0.5, 1.5, 3, {std::numbers::pi / 2 - 0.1, 0, 0.3}));
    scene.camera = centred_camera(160, 120, 120);
    scene.camera.lens = lens;
    const Comparison result = compare(scene, frame_of(scene));
    EXPECT_GT(result.seen, 160 * 120 / 3);
    EXPECT_LE(result.other_body, lens.is_zero() ? 0 : 4);
    EXPECT_LT(result.depth_m, kDepthToleranceM);
  }
}

TEST(Truth, APoseAMillimetreOffWouldBeSeen) {
  Scene scene = busy_scene(0);
  const Frame frame = frame_of(scene);
  scene.cam_from_target.translation.z() += 1e-3;
  EXPECT_GT(compare(scene, frame).depth_m, 5e-4);
}

TEST(Truth, AmodalTruthIsThatOfTheBodyAloneAndReachesBeyondTheImage) {
  Scene scene = busy_scene(1);
  scene.cam_from_target.translation.x() = 40;  // 2500 px / 1400 m: 71 px to the right of 80
  const Frame frame = frame_of(scene);
  const auto casters = casters_of(scene);
  const int w = scene.camera.width_px, h = scene.camera.height_px;
  for (size_t b = 0; b < casters.size(); ++b) {
    const BodyTruth& truth = frame.truth.bodies[b];
    int count = 0, in_image = 0, wrong = 0, visible = 0;
    cv::Rect box;
    for (int y = -h; y < 2 * h; ++y) {
      for (int x = -w; x < 2 * w; ++x) {
        const bool is_inside = x >= 0 && y >= 0 && x < w && y < h;
        const bool is_hit =
            casters[b]->cast(*normalised_from_pixel(scene.camera, {x, y})).has_value();
        if (is_hit) {
          ++count;
          box |= cv::Rect(x, y, 1, 1);
        }
        if (!is_inside) continue;
        in_image += is_hit;
        wrong += is_hit != (truth.amodal_mask.at<uint8_t>(y, x) == 255);
        visible += frame.body_ids.at<uint8_t>(y, x) == b + 1;
      }
    }
    EXPECT_EQ(truth.amodal_pixels, count);
    EXPECT_EQ(truth.amodal_box, box);
    EXPECT_EQ(wrong, 0);
    EXPECT_EQ(truth.visible_pixels, visible);
    EXPECT_EQ(truth.visible_box, cv::boundingRect(frame.body_ids == b + 1));
    EXPECT_EQ(truth.is_occluder, b == 2);
    if (b > 0) continue;
    EXPECT_GT(count, in_image + 50);  // some of it is beyond the border
    EXPECT_LT(truth.visible_fraction(), 0.95);
  }
}

TEST(Truth, AFreeBodysAmodalTruthIsWhatIsSeen) {
  Scene scene = busy_scene(1);
  scene.others.clear();
  const Frame frame = frame_of(scene);
  const BodyTruth& truth = frame.truth.target();
  EXPECT_EQ(truth.amodal_pixels, truth.visible_pixels);
  EXPECT_EQ(truth.amodal_box, truth.visible_box);
  EXPECT_EQ(cv::countNonZero(truth.amodal_mask), truth.amodal_pixels);
  EXPECT_EQ(truth.visible_fraction(), 1);
}

// Features on a plate: in its middle, and 0.4 m to the right.
Scene plate_behind_a_plate() {
  TargetFeature middle;
  middle.name = "middle";
  middle.kind = FeatureKind::kLineIntersection;
  middle.edges = {Edge{{0, 0, 0}, {0.4, 0, 0}}, Edge{{0, 0, 0}, {0, 0.4, 0}}};
  TargetFeature right;
  right.name = "right";
  right.position_m = {0.4, 0, 0};
  Scene scene = coverage_scene(plate(1), at(0, 0, 60));
  scene.target = target_of(plate(1), {middle, right});
  scene.others.push_back({target_of(plate(0.2)), at(0, 0, 50), true});
  return scene;
}

TEST(Truth, AFeatureBehindAnotherBodyIsHiddenByIt) {
  const Frame frame = frame_of(plate_behind_a_plate());
  const auto& features = frame.truth.target().features;
  EXPECT_TRUE(features[0].is_in_image);
  EXPECT_TRUE(features[0].is_hidden_by_other);
  EXPECT_FALSE(features[0].is_visible);
  EXPECT_FALSE(features[1].is_hidden_by_other);
  EXPECT_TRUE(features[1].is_visible);
  // The id image agrees.
  EXPECT_EQ(frame.body_ids.at<uint8_t>(256, 256), 2);
  EXPECT_EQ(frame.body_ids.at<uint8_t>(256, static_cast<int>(features[1].pixel.x()) - 1), 1);
}

TEST(Truth, ABodyBehindHidesNothing) {
  Scene scene = plate_behind_a_plate();
  scene.others[0].cam_from_target.translation.z() = 70;
  const Frame frame = frame_of(scene);
  EXPECT_FALSE(frame.truth.target().features[0].is_hidden_by_other);
  EXPECT_TRUE(frame.truth.target().features[0].is_visible);
}

TEST(Truth, EdgesEndWhereTheCameraPutsThem) {
  const Scene scene = plate_behind_a_plate();
  const Frame frame = frame_of(scene);
  const auto& features = frame.truth.target().features;
  ASSERT_EQ(features[0].edges.size(), 2u);
  EXPECT_TRUE(features[1].edges.empty());
  for (int i = 0; i < 2; ++i) {
    const Edge& edge = scene.target->features[0].edges[i];
    EXPECT_EQ(features[0].edges[i].begin,
              *project(scene.camera, scene.cam_from_target * edge.begin_m));
    EXPECT_EQ(features[0].edges[i].end, *project(scene.camera, scene.cam_from_target * edge.end_m));
  }
}

// The livery's paint changes pictures, and nothing that is said of them.
TEST(Truth, OfAPaintedTargetIsThatOfThePlainOne) {
  const auto plain = load_target("boeing707");
  const auto painted = load_target("boeing707_livery");
  Renderer renderer;
  for (int i = 0; i < 4; ++i) {
    RandomStream stream(1, "painted poses", i);
    Scene scene;
    scene.camera = centred_camera(320, 240, 6000);
    scene.cam_from_target = at(0, 0, 1400);
    scene.cam_from_target.rotation = stream.rotation();
    scene.colouring.mode = i < 2 ? ColourMode::kGrey : ColourMode::kRgb;
    const auto frame_of = [&](const std::shared_ptr<const Target>& target, bool draws_textures) {
      scene.target = target;
      scene.colouring.draws_textures = draws_textures;
      return renderer.render(scene, RandomStream(1, "sensor", i));
    };
    const Frame a = frame_of(plain, true);
    const Frame b = frame_of(painted, true);
    EXPECT_EQ(cv::norm(a.depth_m, b.depth_m, cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(a.part_ids, b.part_ids, cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(a.body_ids, b.body_ids, cv::NORM_INF), 0);
    const BodyTruth& of_a = a.truth.target();
    const BodyTruth& of_b = b.truth.target();
    EXPECT_EQ(cv::norm(of_a.amodal_mask, of_b.amodal_mask, cv::NORM_INF), 0);
    ASSERT_EQ(of_a.features.size(), of_b.features.size());
    for (size_t f = 0; f < of_a.features.size(); ++f) {
      EXPECT_EQ(of_a.features[f].pixel, of_b.features[f].pixel);
      EXPECT_EQ(of_a.features[f].is_visible, of_b.features[f].is_visible);
    }
    EXPECT_GT(cv::norm(a.image, b.image, cv::NORM_INF), 50);
    if (scene.colouring.mode == ColourMode::kGrey) {
      EXPECT_EQ(cv::norm(a.image, frame_of(painted, false).image, cv::NORM_INF), 0);
    }
  }
}

}  // namespace
}  // namespace sightline
