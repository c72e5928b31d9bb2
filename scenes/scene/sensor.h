// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The sensor: the keys of [image] but for the samples of a pixel, and those of [noise].
#pragma once

#include <cstdint>
#include <vector>

#include "scenes/scene/keys.h"

namespace sightline {

/// What lies between the light on the focal plane and the numbers in the file.
struct Sensor {
  double psf_sigma_px = 0.7;       ///< Gaussian point spread
  double gain = 1;                 ///< of the signal and its noise, before rounding
  double read_noise_grey = 3;      ///< standard deviation in grey levels of 255, whatever the depth
  double full_well_electrons = 0;  ///< photon noise: electrons at white; 0 is none
  int bits = 8;                    ///< 1 to 16; white is the largest number
  bool is_srgb = false;            ///< numbers encoded as sRGB says; moves edges by some 0.1 px
  double dead_fraction = 0;        ///< of the pixels are black
  double hot_fraction = 0;         ///< of the pixels are white
  double vignetting = 0;  ///< share of the light lost in the corners, as the square of the distance
  int jpeg_quality = 0;   ///< 1 to 100: what JPEG leaves of images of 8 bits; 0: not compressed
  /// Factors on red, green and blue of what a sensor for colours read.
  Eigen::Vector3d white_balance = Eigen::Vector3d::Ones();
  /// What its red, green and blue channels (rows) read of red, green and blue light (columns).
  Eigen::Matrix3d response = Eigen::Matrix3d::Identity();
  uint64_t defect_seed = 0;  ///< which pixels those are: the same in all of a sensor's frames
};

/// What a file says of the sensor. The defaults are those of a frame.
struct SensorLaw {
  Range psf_sigma_px = Sensor{}.psf_sigma_px;
  Range gain = Sensor{}.gain;
  Range read_noise_grey = Sensor{}.read_noise_grey;
  Range full_well_electrons = Sensor{}.full_well_electrons;
  Range dead_fraction = Sensor{}.dead_fraction;
  Range hot_fraction = Sensor{}.hot_fraction;
  Range vignetting = Sensor{}.vignetting;
  int jpeg_quality = Sensor{}.jpeg_quality;
  Eigen::Vector3d white_balance = Sensor{}.white_balance;
  std::vector<double> response{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row by row
  int bits = Sensor{}.bits;
  bool is_srgb = Sensor{}.is_srgb;
  double noise_scale = 1;  ///< multiplies the applied noise
};

std::vector<Key> keys_of(SensorLaw& law, Sensor& sensor);

/// Throws InputError.
SensorLaw read_sensor(const TomlTable& file);

/// The key noise.scale, which studies without images have too. Throws InputError.
double read_noise_scale(const TomlTable& file);

/// The sensor of one scene. `seed` is that of all scenes, which share their defects.
Sensor draw_sensor(SensorLaw law, uint64_t seed, const Draws& draws);

/// What the truth states of a sensor; of vignetting, JPEG, white balance and a
/// response other than the identity where there are such.
std::vector<Fact> facts_of(Sensor sensor);

}  // namespace sightline
