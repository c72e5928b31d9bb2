// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/repeats.h"

#include <bit>

#include "eval/statistics/error_statistics.h"

namespace sightline {
namespace {

// A number that trials share if they are the same draw, and almost surely only then.
class Fingerprint {
 public:
  explicit Fingerprint(const TrialRecord& trial) {
    add(trial.true_cam_from_target);
    if (const auto* pose_trial = std::get_if<PoseTrial>(&trial.kind)) {
      add(pose_trial->prior_cam_from_target);
    }
    for (const ObservationRecord& o : trial.observations()) {
      add(o.is_found());
      add(o.pixel.x());
      add(o.pixel.y());
    }
    for (const OrientationRecord& o : trial.orientations()) add(o.geodesic_deg);
  }
  uint64_t value() const { return value_; }

 private:
  void add(double number) {
    // FNV-1a over words, with a shift as the high bits of doubles hold most.
    value_ = (value_ ^ std::bit_cast<uint64_t>(number)) * 0x100000001b3;
    value_ ^= value_ >> 32;
  }
  void add(const Pose& pose) {
    for (const double element : pose.rotation.reshaped()) add(element);
    for (const double element : pose.translation) add(element);
  }

  uint64_t value_ = 0xcbf29ce484222325;
};

}  // namespace

void Repeats::add(const TrialRecord& trial) {
  if (trial.observations().empty() && trial.orientations().empty()) return;  // nothing was drawn
  const uint64_t fingerprint = Fingerprint(trial).value();
  if (seen_.contains(fingerprint)) {
    ++count_;
  } else if (seen_.size() < ErrorStatistics::kMostValuesKept) {
    seen_.insert(fingerprint);
  }
}

}  // namespace sightline
