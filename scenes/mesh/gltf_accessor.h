// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace tinygltf {
class Model;
}  // namespace tinygltf

namespace sightline {

/// Throws InputError: the file, and why it cannot be read as glTF.
[[noreturn]] void fail_gltf(const std::filesystem::path& file, std::string reason);

/// The elements of a glTF accessor, sparse ones with their replacements. Everything is checked
/// against the buffers' ends when it is made, since files lie.
class GltfAccessor {
 public:
  /// The model and the path must outlive it.
  GltfAccessor(const tinygltf::Model& model, int index, const std::filesystem::path& file);

  size_t count() const { return count_; }

  /// An element of three numbers. Whole ones are what they are, or, where the accessor says that
  /// they are normalised, fractions of their type's greatest.
  Eigen::Vector3d vector3(size_t i) const;

  /// As many numbers of element i as `out` has; what the accessor lacks stays. Whole numbers are
  /// taken as normalised where the accessor or `always_normalised` says so.
  void read_numbers(size_t i, std::span<float> out, bool always_normalised = false) const;

  /// A whole number: an index, or the k-th joint of a vertex.
  size_t index(size_t i, size_t k = 0) const;

  /// A matrix of 4 x 4.
  Eigen::Matrix4d matrix4(size_t i) const;

 private:
  void take_view(const tinygltf::Model& model, int view, size_t offset);
  void replace(const tinygltf::Model& model, int index);
  double number(const unsigned char* at, bool is_normalised) const;

  std::filesystem::path file_;
  size_t count_ = 0;
  int component_type_ = 0;
  size_t component_bytes_ = 0;
  size_t components_ = 0;
  bool is_normalised_ = false;
  std::vector<unsigned char> own_;  // of a sparse accessor, or of one without a buffer view
  const unsigned char* data_ = nullptr;
  size_t stride_ = 0;
};

/// Throws InputError unless an attribute has one element for each vertex of its primitive.
void require_one_each(const GltfAccessor& accessor, const std::string& attribute, size_t vertices,
                      const std::filesystem::path& file);

}  // namespace sightline
