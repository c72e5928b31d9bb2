// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/imaging.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "pose/lenses/catalogue.h"
#include "scenes/camera/calibration_file.h"
#include "scenes/camera/lens_numbers.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

std::string joined_coefficients(const LensModel& model) {
  return fmt::format("{}", fmt::join(model.coefficients, "_"));
}

// A lens that folds the image over would image points twice.
void require_invertible(const TomlTable& table, const Camera& camera) {
  const std::string reason = why_folded(camera);
  if (reason.empty()) return;
  table.fail(is_pinhole(camera.lens) ? "principal_point_px" : "distortion", reason);
}

// A calibration beside this file, or where the program runs; FILE#NAME is one of its cameras.
Camera camera_of_file(const TomlTable& table) {
  for (const std::string& key : table.keys()) {
    if (key != "file") table.fail(key, "cannot stand beside file, whose calibration has it");
  }
  const std::filesystem::path given = table.text("file");
  const std::filesystem::path beside = table.file().parent_path() / given;
  const std::string name = beside.string();
  const bool is_beside =
      std::filesystem::exists(beside) || std::filesystem::exists(name.substr(0, name.rfind('#')));
  try {
    return read_calibration_file(is_beside ? beside : given);
  } catch (const InputError& error) {
    table.fail("file",
               fmt::format("is \"{}\", which cannot be used: {}", given.string(), error.what()));
  }
}

Choice lens_choice(std::string& name) {
  std::vector<std::pair<std::string, std::string>> words;
  for (const LensModel& model : lens_models()) words.emplace_back(model.name, model.name);
  return choice(name, std::move(words));
}

// brown_conrady takes 5 numbers here, as it always did.
Lens lens_in(const TomlTable& table, const std::string& name) {
  const LensModel& model = *find_lens_model(name);
  if (!table.has("distortion")) return model.make(std::vector<double>(model.coefficients.size()));
  const std::vector<double> coefficients =
      name == "brown_conrady" ? table.numbers("distortion", model.coefficients.size())
                              : table.numbers("distortion", model.counts);
  return *make_lens(model, coefficients);
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
       "skew_px",
       &law.skew_px,
       {-1e6, 1e6},
       "px",
       "by how much x of a pixel grows with the height y/z of its ray: 0 of nearly all cameras",
       {},
       "skew_px"},
      {"camera",
       "lens",
       lens_choice(law.lens),
       {},
       "",
       "model of the lens: brown_conrady bends the image, as most do; rational is OpenCV's with 8 "
       "coefficients or, with a thin prism, 12; fisheye is Kannala's and Brandt's, up to "
       "90 degrees from the axis",
       {},
       "distortion_k1_k2_p1_p2_k3"},
      {"camera",
       "distortion",
       Described{"[0, 0, 0, 0, 0]", "5 numbers; 8 or 12 of lens = \"rational\", 4 of \"fisheye\""},
       {},
       "",
       "coefficients of the lens with OpenCV's signs: k1, k2, p1, p2, k3 of brown_conrady; k1, k2, "
       "p1, p2, k3, k4, k5, k6 (and s1, s2, s3, s4) of rational; k1, k2, k3, k4 of fisheye",
       {},
       "distortion_k1_k2_p1_p2_k3"},
      {"camera",
       "file",
       &law.file,
       {},
       "",
       "calibration instead of all other keys: of OpenCV (.yaml, .json, .xml), Kalibr's camchain "
       "(.yaml) or COLMAP's cameras.txt, beside this file; FILE#NAME where it has several cameras",
       {},
       "width_px",
       false,
       "none"},
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
  if (table.has("file")) return camera_of_file(table);
  CameraLaw law;
  for (const Key& key : keys_of(law)) read_key(table, key);
  Camera camera = centred_camera(law.width_px, law.height_px, law.f_px);
  if (table.has("principal_point_px")) {
    camera.cx_px = law.principal_point_px[0];
    camera.cy_px = law.principal_point_px[1];
  }
  camera.skew_px = law.skew_px;
  camera.lens = lens_in(table, law.lens);
  require_invertible(table, camera);
  return camera;
}

Lens read_lens(const TomlTable& table) {
  CameraLaw law;
  read_key(table, find_key(keys_of(law), "lens"));
  return lens_in(table, law.lens);
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
  const LensModel& model = model_of(camera.lens);
  std::vector<Fact> facts = {{"width_px", int64_t{camera.width_px}},
                             {"height_px", int64_t{camera.height_px}},
                             {"fx_px", camera.fx_px},
                             {"fy_px", camera.fy_px},
                             {"cx_px", camera.cx_px},
                             {"cy_px", camera.cy_px}};
  // Of the cameras that most have, the truth says no more than it always did.
  if (camera.skew_px != 0) facts.push_back({"skew_px", camera.skew_px});
  if (!std::holds_alternative<BrownConrady>(camera.lens)) facts.push_back({"lens", model.name});
  facts.push_back({"distortion_" + joined_coefficients(model), coefficients_of(camera.lens)});
  return facts;
}

}  // namespace sightline
