// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/sensor.h"

#include <cmath>

namespace sightline {
namespace {

using RowWise = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

}  // namespace

std::vector<Key> keys_of(SensorLaw& law, Sensor& sensor) {
  return {
      {"image",
       "bits",
       &law.bits,
       {1, 16},
       "bit",
       "depth of the grey levels; white is the largest",
       &sensor.bits},
      {"image",
       "psf_sigma_px",
       &law.psf_sigma_px,
       {0, 50},
       "px",
       "standard deviation of the Gaussian point spread",
       &sensor.psf_sigma_px},
      {"image",
       "gain",
       &law.gain,
       {0.001, 1000},
       "",
       "factor on the signal and its noise before rounding",
       &sensor.gain},
      {"noise",
       "read_noise_grey",
       &law.read_noise_grey,
       {0, 255},
       "grey level of 255",
       "standard deviation of the read noise, whatever the depth",
       &sensor.read_noise_grey},
      {"noise",
       "full_well_electrons",
       &law.full_well_electrons,
       {0, 1e9},
       "electron",
       "electrons at white, which make the photon noise; 0: there is none",
       &sensor.full_well_electrons},
      {"noise",
       "dead_fraction",
       &law.dead_fraction,
       {0, 0.5},
       "",
       "share of the pixels that are black",
       &sensor.dead_fraction},
      {"noise",
       "hot_fraction",
       &law.hot_fraction,
       {0, 0.5},
       "",
       "share of the pixels that are white",
       &sensor.hot_fraction},
      {"image",
       "encoding",
       choice(law.is_srgb, {{"linear", false}, {"srgb", true}}),
       {},
       "",
       "how grey levels stand for light; srgb moves edges by some 0.1 px",
       choice(sensor.is_srgb, {{"linear", false}, {"srgb", true}}),
       "is_srgb"},
      {"image",
       "vignetting",
       &law.vignetting,
       {0, 1},
       "",
       "share of the light lost in the corners, growing as the square of the distance from the "
       "middle",
       &sensor.vignetting},
      {"image",
       "jpeg_quality",
       &law.jpeg_quality,
       {0, 100},
       "",
       "what JPEG of this quality leaves of an image of 8 bits; 0: it is not compressed",
       &sensor.jpeg_quality},
      {"image",
       "white_balance",
       &law.white_balance,
       {},
       "",
       "factors from 0 to 16 on red, green and blue before rounding; for pictures in colour",
       {},
       "white_balance"},
      {"image",
       "response",
       &law.response,
       {-8, 8},
       "",
       "three rows of three numbers from -8 to 8: what the sensor's red, green and blue channels "
       "read of red, green and blue light, before noise and mosaic; for pictures in colour",
       {},
       "response"},
      {"noise",
       "scale",
       &law.noise_scale,
       {0, 1000},
       "",
       "factor on the read noise and the photon noise",
       {},
       "read_noise_grey"},
  };
}

SensorLaw read_sensor(const TomlTable& file) {
  SensorLaw law;
  Sensor sensor;
  const std::vector<Key> keys = keys_of(law, sensor);
  read_keys(file, keys);
  const TomlTable image = file.table("image");
  constexpr double kLargestFactor = 16;
  require_within(image, "white_balance", law.white_balance, {0, kLargestFactor});
  require_within(image, "response", law.response, find_key(keys, "response").allowed);
  if (law.jpeg_quality > 0 && law.bits != 8) {
    image.fail("jpeg_quality", "is for images of 8 bits");
  }
  return law;
}

double read_noise_scale(const TomlTable& file) {
  SensorLaw law;
  Sensor sensor;
  read_key(file.table("noise"), find_key(keys_of(law, sensor), "scale"));
  return law.noise_scale;
}

Sensor draw_sensor(SensorLaw law, uint64_t seed, const Draws& draws) {
  Sensor sensor;
  draw_keys(keys_of(law, sensor), draws);
  const double scale = law.noise_scale;
  sensor.read_noise_grey *= scale;
  sensor.full_well_electrons = scale > 0 ? sensor.full_well_electrons / (scale * scale) : 0;
  sensor.defect_seed = seed;
  sensor.white_balance = law.white_balance;
  sensor.response = Eigen::Map<const RowWise>(law.response.data());
  return sensor;
}

std::vector<Fact> facts_of(Sensor sensor) {
  SensorLaw law;
  std::vector<Fact> facts = facts_of(keys_of(law, sensor));
  std::erase_if(facts, [&sensor](const Fact& fact) {
    return (fact.name == "vignetting" && sensor.vignetting == 0) ||
           (fact.name == "jpeg_quality" && sensor.jpeg_quality == 0);
  });
  if (const Eigen::Vector3d& w = sensor.white_balance; w != Sensor{}.white_balance) {
    facts.push_back({"white_balance", std::vector{w.x(), w.y(), w.z()}});
  }
  if (sensor.response != Sensor{}.response) {
    const RowWise rows = sensor.response;
    facts.push_back({"response", std::vector(rows.data(), rows.data() + rows.size())});
  }
  facts.insert(facts.begin() + 1, {"white", std::exp2(sensor.bits) - 1});  // after the bits
  facts.push_back({"defect_seed", static_cast<int64_t>(sensor.defect_seed)});
  return facts;
}

}  // namespace sightline
