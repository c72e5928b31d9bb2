// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/builders/tango.h"

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <tuple>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "pose/angles.h"
#include "scenes/mesh/mesh_soup.h"
#include "scenes/random/random.h"

namespace sightline {
namespace {

// SPEED+'s keypoints, metres.
const std::array<Eigen::Vector3d, 4> kPanelCorners = {{{-0.37, -0.385, 0.3215},
                                                       {-0.37, 0.385, 0.3215},
                                                       {0.37, 0.385, 0.3215},
                                                       {0.37, -0.385, 0.3215}}};
const std::array<Eigen::Vector3d, 4> kBaseCorners = {
    {{-0.37, -0.264, 0}, {-0.37, 0.304, 0}, {0.37, 0.304, 0}, {0.37, -0.264, 0}}};
const std::array<Eigen::Vector3d, 3> kAntennaTips = {
    {{-0.5427, 0.4877, 0.2535}, {0.5427, 0.4877, 0.2591}, {0.305, -0.579, 0.2515}}};

// Estimates.
const std::array<Eigen::Vector3d, 3> kAntennaRoots = {
    {{-0.36, 0.295, 0.25}, {0.36, 0.295, 0.25}, {0.305, -0.255, 0.25}}};
constexpr double kPanelM = 0.02;  // thickness
constexpr double kRodRadiusM = 0.005;
constexpr int kRodSides = 8;
constexpr double kRodPointM = 0.01;  // length of its end
constexpr int kCellsAlongX = 18;
constexpr int kCellsAlongY = 9;
constexpr double kCellXM = 0.039;
constexpr double kCellYM = 0.08;
constexpr double kCellGapM = 0.002;
constexpr double kFoilStepM = 0.04;  // between creases
constexpr double kFoilTilt = 0.3;    // of the normal, largest tangent along each axis
constexpr double kCreaseDeg = 50;    // between a rod's sides there is none
constexpr double kTipReachM = 0.05;  // outline that tells where a tip is
constexpr double kTipClearanceM = 0.01;

using Lines = std::vector<double>;

// From begin to end in steps of about `step`.
Lines even_lines(double begin, double end, double step) {
  const int steps = std::max(1, static_cast<int>(std::lround((end - begin) / step)));
  Lines lines;
  for (int i = 0; i <= steps; ++i) lines.push_back(begin + (end - begin) * i / steps);
  return lines;
}

// The borders of cells with gaps between them, in the middle between begin and end.
Lines cell_lines(double begin, double end, int cells, double cell) {
  const double used = cells * cell + (cells - 1) * kCellGapM;
  Lines lines = {begin};
  for (int i = 0; i < cells; ++i) {
    const double low = (begin + end - used) / 2 + i * (cell + kCellGapM);
    lines.push_back(low);
    lines.push_back(low + cell);
  }
  lines.push_back(end);
  return lines;
}

// Cells lie between lines of odd index and the next.
bool is_cell(int column, int row) {
  return column % 2 == 1 && row % 2 == 1;
}

class TangoMesh {
 public:
  int add_part(const std::string& name, const Material& material) {
    const auto& base = material.base;
    mesh_.parts.push_back({name, luminance(base[0], base[1], base[2]), material});
    return static_cast<int>(mesh_.parts.size()) - 1;
  }

  // The box between the first and the last line of each axis; its sides are cut at the lines.
  // `part_of` is asked with the axis across a side, whether it is the far one, and the place along
  // the two other axes in their order.
  using PartOf = std::function<int(int axis, bool is_far, int column, int row)>;
  void add_box(const std::array<Lines, 3>& lines, const PartOf& part_of) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const bool is_far : {false, true}) add_side(lines, axis, is_far, part_of);
    }
  }

  // A rod that ends in a point.
  void add_rod(const Eigen::Vector3d& root, const Eigen::Vector3d& tip, int part) {
    const Eigen::Vector3d along = (tip - root).normalized();
    const Eigen::Vector3d across = along.unitOrthogonal();
    const Eigen::Vector3d beside = along.cross(across);
    const Eigen::Vector3d neck = tip - kRodPointM * along;
    for (int i = 0; i < kRodSides; ++i) {
      const auto at = [&](const Eigen::Vector3d& middle, int side) {
        const double angle = 2 * std::numbers::pi * side / kRodSides;
        return vertex(middle + kRodRadiusM * (std::cos(angle) * across + std::sin(angle) * beside));
      };
      const int low = at(root, i), next_low = at(root, i + 1);
      const int high = at(neck, i), next_high = at(neck, i + 1);
      add_triangle({low, next_low, next_high}, part);
      add_triangle({low, next_high, high}, part);
      add_triangle({high, next_high, vertex(tip)}, part);
      add_triangle({next_low, low, vertex(root)}, part);
    }
  }

  // Foil's normals are tilted at random, alike where triangles of a side meet.
  Mesh finished(const std::vector<bool>& is_foil) {
    compute_corner_normals(mesh_, kCreaseDeg * kDegree);
    std::map<std::tuple<int, double, double, double>, Eigen::Vector3d> tilts;
    RandomStream stream(1, "foil", 0);
    for (Triangle& triangle : mesh_.triangles) {
      if (!is_foil[static_cast<size_t>(triangle.part)]) continue;
      for (size_t i = 0; i < 3; ++i) {
        Eigen::Vector3d& normal = triangle.normal[i];
        const auto [at, is_new] =
            tilts.try_emplace({triangle.vertex[i], normal.x(), normal.y(), normal.z()}, normal);
        if (is_new) at->second = tilted(normal, stream);
        normal = at->second;
      }
    }
    return mesh_;
  }

 private:
  int vertex(const Eigen::Vector3d& point) {
    const auto micrometres = [](double m) { return std::llround(m * 1e6); };
    const std::tuple key{micrometres(point.x()), micrometres(point.y()), micrometres(point.z())};
    const auto [at, is_new] = index_of_.emplace(key, static_cast<int>(mesh_.vertices.size()));
    if (is_new) {
      const auto [x, y, z] = key;
      mesh_.vertices.push_back(
          Eigen::Vector3d(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)) /
          1e6);
    }
    return at->second;
  }

  void add_triangle(const std::array<int, 3>& corners, int part) {
    mesh_.triangles.push_back({corners, part});
  }

  void add_side(const std::array<Lines, 3>& lines, int axis, bool is_far, const PartOf& part_of) {
    // The other two axes, so that the first crossed with the second points along `axis`.
    const int first = (axis + 1) % 3, second = (axis + 2) % 3;
    const auto at = [&](size_t column, size_t row) {
      Eigen::Vector3d point;
      point[axis] = is_far ? lines[axis].back() : lines[axis].front();
      point[first] = lines[first][column];
      point[second] = lines[second][row];
      return vertex(point);
    };
    for (size_t column = 0; column + 1 < lines[first].size(); ++column) {
      for (size_t row = 0; row + 1 < lines[second].size(); ++row) {
        const int part = part_of(axis, is_far, static_cast<int>(column), static_cast<int>(row));
        const int a = at(column, row), b = at(column + 1, row);
        const int c = at(column + 1, row + 1), d = at(column, row + 1);
        add_triangle(is_far ? std::array{a, b, c} : std::array{a, c, b}, part);
        add_triangle(is_far ? std::array{a, c, d} : std::array{a, d, c}, part);
      }
    }
  }

  // Without the C library's functions, whose last bits differ between machines.
  static Eigen::Vector3d tilted(const Eigen::Vector3d& normal, RandomStream& stream) {
    const Eigen::Vector3d across = normal.unitOrthogonal();
    const double first = stream.uniform(-kFoilTilt, kFoilTilt);
    const double second = stream.uniform(-kFoilTilt, kFoilTilt);
    return (normal + first * across + second * normal.cross(across)).normalized();
  }

  Mesh mesh_;
  std::map<std::tuple<long long, long long, long long>, int> index_of_;
};

Material glossy(double red, double green, double blue, double metallic, double roughness) {
  Material material;
  material.base = {red, green, blue, 1};
  material.has_gloss = true;
  material.metallic = metallic;
  material.roughness = roughness;
  return material;
}

Mesh tango_mesh() {
  TangoMesh mesh;
  const int cells = mesh.add_part("solar_cells", glossy(0.01, 0.02, 0.10, 0, 0.25));
  const int panel = mesh.add_part("panel", glossy(0.80, 0.80, 0.78, 0, 0.6));
  const int sides = mesh.add_part("foil_gold", glossy(1.0, 0.72, 0.30, 1, 0.35));
  const int base = mesh.add_part("foil_black", glossy(0.04, 0.04, 0.045, 0, 0.4));
  const Eigen::Vector3d low = kPanelCorners[0], high = kPanelCorners[2];
  const double underside = low.z() - kPanelM;
  mesh.add_box({cell_lines(low.x(), high.x(), kCellsAlongX, kCellXM),
                cell_lines(low.y(), high.y(), kCellsAlongY, kCellYM), Lines{underside, high.z()}},
               [&](int axis, bool is_far, int column, int row) {
                 return axis == 2 && is_far && is_cell(column, row) ? cells : panel;
               });
  mesh.add_box(
      {even_lines(kBaseCorners[0].x(), kBaseCorners[2].x(), kFoilStepM),
       even_lines(kBaseCorners[0].y(), kBaseCorners[2].y(), kFoilStepM),
       even_lines(0, underside, kFoilStepM)},
      [&](int axis, bool is_far, int, int) { return axis == 2 && !is_far ? base : sides; });
  for (size_t i = 0; i < kAntennaTips.size(); ++i) {
    const int part =
        mesh.add_part(fmt::format("antenna_{}", i + 1), glossy(0.78, 0.78, 0.8, 1, 0.5));
    mesh.add_rod(kAntennaRoots[i], kAntennaTips[i], part);
  }
  return mesh.finished({false, false, true, true, false, false, false});
}

// A corner of a rectangle, with its sides and whatever else begins there.
TargetFeature corner_of(const std::array<Eigen::Vector3d, 4>& corners, size_t i,
                        const std::string& name, double upright_m) {
  std::vector<Eigen::Vector3d> ends = {corners[(i + 1) % 4], corners[(i + 3) % 4]};
  if (upright_m > 0) ends.push_back(corners[i] + upright_m * Eigen::Vector3d::UnitZ());
  return line_intersection(fmt::format("{}_{}", name, i + 1), corners[i], ends);
}

}  // namespace

BuiltTarget build_tango() {
  BuiltTarget tango{"tango",
                    "Tango of the PRISMA mission in SPEED+'s axes and keypoints: published corners "
                    "and antenna tips, the rest estimated",
                    tango_mesh(),
                    {}};
  for (size_t i = 0; i < kPanelCorners.size(); ++i) {
    tango.features.push_back(corner_of(kPanelCorners, i, "panel", 0));
  }
  for (size_t i = 0; i < kBaseCorners.size(); ++i) {
    tango.features.push_back(corner_of(kBaseCorners, i, "base", kPanelCorners[0].z() - kPanelM));
  }
  for (size_t i = 0; i < kAntennaTips.size(); ++i) {
    const std::string name = fmt::format("antenna_{}", i + 1);
    tango.features.push_back(outlined_feature(name + "_tip", FeatureKind::kCorner, kAntennaTips[i],
                                              kTipClearanceM, {name}, kTipReachM));
  }
  return tango;
}

}  // namespace sightline
