// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "scenes/mesh/mesh_io.h"
#include "scenes/mesh/point_table.h"

namespace sightline {

/// A triangle on its way from a file into a soup: its own three corners, in the file's axes and
/// unit.
struct SoupTriangle {
  std::array<Eigen::Vector3d, 3> corner;
  std::array<Eigen::Vector3d, 3> normal;  ///< unit, or zero where the file has none
  int part = 0;
  Coat coat = {};  ///< means something where the soup has coats
  /// Of the corners, the places in the file's list of vertices; -1: there is none.
  std::array<int, 3> vertex{-1, -1, -1};
};

/// A triangle as a soup has it.
struct SoupFace {
  std::array<int, 3> point{};  ///< indices into MeshSoup::points
  int part = 0;
};

/// The normals of a triangle without any.
std::array<Eigen::Vector3d, 3> no_normals();

/// What the readers of mesh files hand to the one place that cleans meshes. It is compact, since
/// the readers' process and the program's each have one for a moment.
struct MeshSoup {
  std::vector<Eigen::Vector3d> points;  ///< no two alike
  std::vector<SoupFace> triangles;      ///< in the file's order
  /// Of the triangles' corners, unit, or zero where the file has none; those of the last triangles
  /// may be missing.
  std::vector<std::array<Eigen::Vector3d, 3>> normals = {};
  /// Of the parts, whether all their corners have the normals of their triangles; those of the last
  /// parts may be missing.
  std::vector<uint8_t> is_flat = {};
  std::vector<Coat> coats = {};  ///< of the triangles; those of the last ones may be missing
  std::vector<Part> parts;
  bool has_coats = false;
  double unit_m = 1;  ///< metres in a unit, as far as the file says
  std::vector<Texture> textures = {};
  std::vector<std::string> lost_textures = {};  ///< as in a Mesh
  std::vector<std::string> notes = {};          ///< alike
  PointTable numbers = {};                      ///< of the points, while triangles are added
};

constexpr size_t kMaxTriangles = 12'000'000;  ///< 10 million take 2 GB, the child and the program
constexpr size_t kMaxParts = 65535;           ///< ids of parts have 16 bits, 0 is background
constexpr double kSmallestUnitM = 1e-6;
constexpr double kLargestUnitM = 1e6;
constexpr double kLargestCoordinate = 1e12;  ///< sizes and cells remain numbers that doubles hold

/// The two readers; `read_mesh` chooses and runs them in a process of their own. Nothing outside
/// the file's folder is opened (see MeshFolder). Both throw InputError with the library's own
/// words.
MeshSoup read_gltf(const std::filesystem::path& file);
MeshSoup read_with_assimp(const std::filesystem::path& file);

/// The content of a .glb or .gltf (told apart by its first bytes); `file` names it in errors, and
/// its folder is where its buffers may lie.
MeshSoup read_gltf_bytes(std::string_view bytes, const std::filesystem::path& file);

/// Carries triangles from a mesh's own axes into the file's. A mirroring transform reverses the
/// winding so that it stays counter-clockwise from outside.
class SoupTransform {
 public:
  /// For a mesh of so many triangles over a list of so many vertices.
  SoupTransform(const Eigen::Matrix4d& file_from_mesh, size_t triangles, size_t vertices);

  /// Adds a triangle whose corners and normals are carried. All are of the same list of vertices,
  /// and all for the same soup.
  void add(MeshSoup& soup, const SoupTriangle& triangle);

 private:
  int number_of(const SoupTriangle& triangle, int corner, MeshSoup& soup);

  // Of each vertex the number of its point, -1 where no triangle had it: most come six times.
  // Empty where few come again.
  std::vector<int> numbers_;
  Eigen::Matrix3d linear_;
  Eigen::Vector3d offset_;
  Eigen::Matrix3d cofactors_;  // these carry normals, also by singular and mirroring transforms
  bool is_mirroring_;
};

/// Throws InputError when the soup with `more` triangles and one more part would be too large.
void require_room(const MeshSoup& soup, size_t more, const std::filesystem::path& file);

/// The shares of linear red, green and blue in their luminance (Rec. 709).
constexpr std::array kLuminanceShares = {0.2126, 0.7152, 0.0722};

/// Linear luminance of a linear RGB colour, clamped to [0, 1].
double luminance(double red, double green, double blue);

/// A soup as bytes, to cross from one process to another of the same machine: as a whole, or piece
/// by piece to where they are written.
std::string encode(const MeshSoup& soup);
void encode(const MeshSoup& soup, const std::function<void(std::string_view)>& write);

/// Gives the next bytes, at most so many, and how many they are: none at the end alone.
using ByteSource = std::function<size_t(char* to, size_t most)>;

/// The soup of such bytes, which may be anything: throws InputError, naming the file, when the
/// counts disagree with the length or pass the limits above, a number is not finite, a corner lies
/// beyond kLargestCoordinate, a normal is longer than a unit, an albedo is not in [0, 1] or a part
/// does not exist. Names come out as printable UTF-8 of at most 256 bytes.
MeshSoup decode(std::string_view bytes, const std::filesystem::path& file);
MeshSoup decode(const ByteSource& bytes, const std::filesystem::path& file);

/// The mesh of a soup, as `read_mesh` tells. Throws InputError for one without size or triangles
/// and for a wrong frame.
LoadedMesh clean(MeshSoup soup, const MeshFrame& frame, const std::filesystem::path& file);

/// What a reader's process may use.
struct ReaderLimits {
  uint64_t memory_bytes = uint64_t{4} << 30;  ///< beyond what the calling process has mapped
  int cpu_s = 120;
  /// How long it may be waited for, in all, before it has worked. A reader that works, if slowly
  /// since other programs have the processors, gets kWaitPerWork seconds more for each of its
  /// processor time.
  int wait_s = 300;
};

constexpr int kWaitPerWork = 30;  ///< so slow is a reader beside thirty other programs

/// Limits that no honest file of this size comes near, and a broken one meets soon: 512 MiB and 64
/// times the file, at most 4 GiB; 2 s of processor time and 1 s for each MiB, at most 120 s; waited
/// for is 60 s and twice that.
ReaderLimits limits_for(uint64_t file_bytes);

/// Runs a reader in a child process and returns its soup: what crashes, hangs or devours memory in
/// there ends as an InputError that names the file, as do the reader's own errors. The child is a
/// fork: it reads, writes into a pipe and leaves by _exit without running a destructor, so that
/// the caller may hold an OpenGL context, which the child never touches, and other threads, as long
/// as none of them holds a lock that reading a file needs (malloc's own is safe). It cannot write a
/// file, sees no other descriptor of the caller, and dies with it.
MeshSoup read_in_child(const std::filesystem::path& file,
                       const std::function<MeshSoup(const std::filesystem::path&)>& reader,
                       const ReaderLimits& limits);

}  // namespace sightline
