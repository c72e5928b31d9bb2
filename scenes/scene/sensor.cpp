// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/sensor.h"

#include <cmath>

namespace sightline {

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
  return sensor;
}

std::vector<Fact> facts_of(Sensor sensor) {
  SensorLaw law;
  std::vector<Fact> facts = facts_of(keys_of(law, sensor));
  facts.insert(facts.begin() + 1, {"white", std::exp2(sensor.bits) - 1});  // after the bits
  facts.push_back({"defect_seed", static_cast<int64_t>(sensor.defect_seed)});
  return facts;
}

}  // namespace sightline
