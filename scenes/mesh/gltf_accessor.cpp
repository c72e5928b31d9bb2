// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/gltf_accessor.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

#include <fmt/format.h>

// As mesh_gltf.cpp has it, which holds the library's code.
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include "scenes/files/input_error.h"

namespace sightline {
namespace {

template <typename Number>
Number number_at(const unsigned char* at) {
  Number value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

// A fraction as glTF has it: -127/127 to 127/127 of signed bytes, 0 to 255/255 of unsigned ones.
template <typename Number>
double whole(const unsigned char* at, bool is_normalised) {
  const auto value = static_cast<double>(number_at<Number>(at));
  if (!is_normalised) return value;
  return std::max(value / static_cast<double>(std::numeric_limits<Number>::max()), -1.0);
}

// The place of elements in a buffer.
struct Place {
  const unsigned char* data = nullptr;
  size_t stride = 0;
};

// `element` bytes each; a stride of 0 means that they lie side by side.
Place place_of(const tinygltf::Model& model, int view_index, size_t offset, size_t element,
               size_t count, const std::filesystem::path& file) {
  if (view_index < 0 || view_index >= static_cast<int>(model.bufferViews.size())) {
    fail_gltf(file, "bad buffer view index");
  }
  const tinygltf::BufferView& view = model.bufferViews[view_index];
  if (view.buffer < 0 || view.buffer >= static_cast<int>(model.buffers.size())) {
    fail_gltf(file, "bad buffer index");
  }
  const auto& bytes = model.buffers[view.buffer].data;
  const size_t stride = view.byteStride == 0 ? element : view.byteStride;
  const size_t begin = view.byteOffset + offset;
  // By division: a lying count must not wrap.
  const bool fits = count == 0 || (element > 0 && stride > 0 && begin >= offset &&
                                   begin <= bytes.size() && element <= bytes.size() - begin &&
                                   count <= 1 + (bytes.size() - begin - element) / stride);
  if (!fits) fail_gltf(file, "an accessor reaches past its buffer");
  return {bytes.data() + (count == 0 ? 0 : begin), stride};
}

constexpr size_t kMaxSparseBytes = size_t{1} << 31;

}  // namespace

void fail_gltf(const std::filesystem::path& file, std::string reason) {
  while (!reason.empty() && reason.back() == '\n') reason.pop_back();
  throw InputError(fmt::format("{}: cannot be read as glTF: {}", file.string(), reason));
}

GltfAccessor::GltfAccessor(const tinygltf::Model& model, int index,
                           const std::filesystem::path& file)
    : file_(file) {
  if (index < 0 || index >= static_cast<int>(model.accessors.size())) {
    fail_gltf(file, "bad accessor");
  }
  const tinygltf::Accessor& accessor = model.accessors[index];
  const int bytes =
      tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(accessor.componentType));
  const int components = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type));
  if (bytes <= 0 || components <= 0) fail_gltf(file, "an accessor of no known type");
  count_ = accessor.count;
  component_type_ = accessor.componentType;
  component_bytes_ = static_cast<size_t>(bytes);
  components_ = static_cast<size_t>(components);
  is_normalised_ = accessor.normalized;
  if (accessor.bufferView >= 0) {
    take_view(model, accessor.bufferView, accessor.byteOffset);
    if (accessor.sparse.isSparse) replace(model, index);
    return;
  }
  if (!accessor.sparse.isSparse) {
    fail_gltf(file, "an accessor without a buffer view (its compression is not known here)");
  }
  replace(model, index);
}

void require_one_each(const GltfAccessor& accessor, const std::string& attribute, size_t vertices,
                      const std::filesystem::path& file) {
  if (accessor.count() == vertices) return;
  fail_gltf(file, fmt::format("a primitive has {} elements of {} for {} vertices", accessor.count(),
                              attribute, vertices));
}

void GltfAccessor::take_view(const tinygltf::Model& model, int view, size_t offset) {
  const Place place = place_of(model, view, offset, component_bytes_ * components_, count_, file_);
  data_ = place.data;
  stride_ = place.stride;
}

// Copies the elements, which without a buffer view are zeros, and puts the sparse ones over them.
void GltfAccessor::replace(const tinygltf::Model& model, int index) {
  const auto& sparse = model.accessors[index].sparse;
  const size_t element = component_bytes_ * components_;
  if (count_ > kMaxSparseBytes / element) fail_gltf(file_, "a sparse accessor is too large");
  own_.assign(count_ * element, 0);
  for (size_t i = 0; data_ != nullptr && i < count_; ++i) {
    std::memcpy(own_.data() + i * element, data_ + i * stride_, element);
  }
  data_ = own_.data();
  stride_ = element;
  if (sparse.count < 0 || sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0) {
    fail_gltf(file_, "a sparse accessor with numbers below zero");
  }
  const auto count = static_cast<size_t>(sparse.count);
  const int index_bytes =
      tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(sparse.indices.componentType));
  if (index_bytes <= 0 || index_bytes > 4) fail_gltf(file_, "a sparse accessor of no known type");
  const Place indices =
      place_of(model, sparse.indices.bufferView, static_cast<size_t>(sparse.indices.byteOffset),
               static_cast<size_t>(index_bytes), count, file_);
  const Place values =
      place_of(model, sparse.values.bufferView, static_cast<size_t>(sparse.values.byteOffset),
               element, count, file_);
  for (size_t i = 0; i < count; ++i) {
    uint32_t at = 0;  // little-endian, as all of glTF
    std::memcpy(&at, indices.data + i * indices.stride, static_cast<size_t>(index_bytes));
    if (at >= count_) fail_gltf(file_, "a sparse accessor replaces what it does not have");
    std::memcpy(own_.data() + at * element, values.data + i * values.stride, element);
  }
}

double GltfAccessor::number(const unsigned char* at, bool is_normalised) const {
  switch (component_type_) {
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return number_at<float>(at);
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return whole<int8_t>(at, is_normalised);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return whole<uint8_t>(at, is_normalised);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return whole<int16_t>(at, is_normalised);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return whole<uint16_t>(at, is_normalised);
    default:
      fail_gltf(file_,
                "positions, normals, coordinates and colours must be floats, or whole "
                "numbers of 8 or 16 bits");
  }
}

Eigen::Vector3d GltfAccessor::vector3(size_t i) const {
  if (components_ != 3) fail_gltf(file_, "positions and normals must be three numbers");
  Eigen::Vector3d out;
  for (int k = 0; k < 3; ++k) {
    out[k] =
        number(data_ + stride_ * i + component_bytes_ * static_cast<size_t>(k), is_normalised_);
  }
  return out;
}

void GltfAccessor::read_numbers(size_t i, std::span<float> out, bool always_normalised) const {
  const bool is_normalised = is_normalised_ || always_normalised;
  for (size_t k = 0; k < std::min(out.size(), components_); ++k) {
    out[k] = static_cast<float>(number(data_ + stride_ * i + component_bytes_ * k, is_normalised));
  }
}

size_t GltfAccessor::index(size_t i, size_t k) const {
  if (k >= components_) fail_gltf(file_, "joints must be four whole numbers");
  const unsigned char* at = data_ + stride_ * i + component_bytes_ * k;
  switch (component_type_) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return *at;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return number_at<uint16_t>(at);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return number_at<uint32_t>(at);
    default:
      fail_gltf(file_, "indices must be unsigned integers");
  }
}

Eigen::Matrix4d GltfAccessor::matrix4(size_t i) const {
  if (components_ != 16 || component_type_ != TINYGLTF_COMPONENT_TYPE_FLOAT) {
    fail_gltf(file_, "matrices must be sixteen floats");
  }
  Eigen::Matrix4f out;  // both column by column
  std::memcpy(out.data(), data_ + stride_ * i, 16 * sizeof(float));
  return out.cast<double>();
}

}  // namespace sightline
