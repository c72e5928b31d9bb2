// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/imaging.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sightline {
namespace {

BrownConrady lens_of(const std::vector<double>& k) {
  return {.k1 = k[0], .k2 = k[1], .p1 = k[2], .p2 = k[3], .k3 = k[4]};
}

// A lens that folds the image over would image points twice.
void require_invertible(const TomlTable& table, const Camera& camera) {
  for (const double u : {-0.5, camera.cx_px, camera.width_px - 0.5}) {
    for (const double v : {-0.5, camera.cy_px, camera.height_px - 0.5}) {
      if (normalised_from_pixel(camera, {u, v})) continue;
      table.fail(camera.distortion.is_zero() ? "principal_point_px" : "distortion",
                 fmt::format("cannot be undone at pixel ({}, {})", u, v));
    }
  }
}

}  // namespace

std::vector<Key> keys_of(CameraLaw& law) {
  return {
      {"camera",
       "width_px",
       &law.width_px,
       {16, 16384},
       "px",
       "width of the image",
       {},
       "width_px"},
      {"camera",
       "height_px",
       &law.height_px,
       {16, 16384},
       "px",
       "height of the image",
       {},
       "height_px"},
      {"camera", "f_px", &law.f_px, {1, 1e7}, "px", "focal length", {}, "fx_px", true},
      {"camera",
       "principal_point_px",
       &law.principal_point_px,
       {},
       "px",
       "where the optical axis meets the image; (0, 0) is the centre of the top-left pixel",
       {},
       "cx_px",
       false,
       "the image's centre"},
      {"camera",
       "distortion",
       &law.distortion,
       {},
       "",
       "k1, k2, p1, p2, k3 of the lens (Brown and Conrady, with OpenCV's signs)",
       {},
       "distortion_k1_k2_p1_p2_k3"},
  };
}

std::vector<Key> keys_of_sampling(int& law, int& samples_per_pixel) {
  return {
      {"image",
       "samples_per_pixel",
       &law,
       {kSampleCounts.front(), kSampleCounts.back()},
       "",
       fmt::format("rays that a pixel is averaged over, one of {}", fmt::join(kSampleCounts, ", ")),
       &samples_per_pixel}};
}

Camera read_camera(const TomlTable& table) {
  CameraLaw law;
  for (const Key& key : keys_of(law)) read_key(table, key);
  Camera camera = centred_camera(law.width_px, law.height_px, law.f_px);
  if (table.has("principal_point_px")) {
    camera.cx_px = law.principal_point_px[0];
    camera.cy_px = law.principal_point_px[1];
  }
  camera.distortion = lens_of(law.distortion);
  require_invertible(table, camera);
  return camera;
}

BrownConrady read_lens(const TomlTable& table) {
  CameraLaw law;
  read_key(table, find_key(keys_of(law), "distortion"));
  return lens_of(law.distortion);
}

int read_samples_per_pixel(const TomlTable& file) {
  int samples = kSamplesPerPixel;
  int unused = 0;
  read_keys(file, keys_of_sampling(samples, unused));
  const auto end = kSampleCounts.end();
  if (std::find(kSampleCounts.begin(), end, samples) == end) {
    file.table("image").fail("samples_per_pixel", fmt::format("is {}, must be one of {}", samples,
                                                              fmt::join(kSampleCounts, ", ")));
  }
  return samples;
}

std::vector<Fact> facts_of(const Camera& camera) {
  const BrownConrady& k = camera.distortion;
  return {{"width_px", int64_t{camera.width_px}},
          {"height_px", int64_t{camera.height_px}},
          {"fx_px", camera.fx_px},
          {"fy_px", camera.fy_px},
          {"cx_px", camera.cx_px},
          {"cy_px", camera.cy_px},
          {"distortion_k1_k2_p1_p2_k3", std::vector{k.k1, k.k2, k.p1, k.p2, k.k3}}};
}

}  // namespace sightline
