// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/benchmarks/tracker_accuracy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "eval/benchmarks/registration_frames.h"
#include "eval/benchmarks/visp_model.h"
#include "pose/angles.h"
#include "pose/attitude.h"
#include "registration/registration.h"
#include "scenes/files/input_error.h"
#include "scenes/mesh/decimation.h"

namespace sightline {
namespace {

constexpr double kRepeatableDeg = 0.2;

struct TrackedTarget : FramedTarget {
  Mesh coarse_mesh;  // of 300 triangles or so at most
};

TrackedTarget tracked_target(FramedTarget framed) {
  constexpr double kTriangles = 300;
  const auto triangles = static_cast<double>(framed.mesh.triangles.size());
  Mesh coarse_mesh =
      triangles > kTriangles ? decimated(framed.mesh, kTriangles / triangles) : framed.mesh;
  return {std::move(framed), std::move(coarse_mesh)};
}

struct TrackerRequest {
  int frames = 5;
  int priors = 20;
  uint64_t seed = 1;
  std::string targets = "boeing707,cube,photographs";

  bool has(const std::string& target) const {
    return ("," + targets + ",").find("," + target + ",") != std::string::npos;
  }
};

struct TrackedPose {
  std::optional<Pose> pose;
  double cpu_ms = 0;
};

double cpu_ms() {
  return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

// With defaults: noise and blur are estimated.
TrackedPose registered(const TrackedTarget& target, const ShownFrame& frame, const PosePrior& prior,
                       RegistrationRegion region) {
  RegistrationOptions options;
  options.region = region;
  const double before = cpu_ms();
  const Registration found =
      register_mesh({target.mesh, frame.camera, frame.image, 255, prior, std::nullopt}, options);
  TrackedPose tracked;
  tracked.cpu_ms = cpu_ms() - before;
  if (found.is_ok()) tracked.pose = found.cam_from_target;
  return tracked;
}

// Without the time to build ViSP's model, which a tracker does once. On a mesh of 13 000 triangles
// it takes 10 s, so that it gets a coarse one. How far it looks for edges is what served it better
// of 4, 7 and 12 px: on photographs the near, where print and clutter run beside the edges.
TrackedPose tracked_by_visp(const TrackedTarget& target, const ShownFrame& frame,
                            const PosePrior& prior) {
  const Pose& start = prior.cam_from_target;
  const Camera& camera = frame.camera;
  const int reach_px = target.is_photographed ? 7 : 12;
  VispTracker tracker(visp_model(target.coarse_mesh, inverse(start).translation),
                      {camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px}, reach_px);
  VispPose from;
  from << start.rotation, start.translation;
  const double before = cpu_ms();
  const std::optional<VispPose> found = tracker.track(frame.image, from);
  TrackedPose tracked;
  tracked.cpu_ms = cpu_ms() - before;
  if (found) tracked.pose = Pose{found->leftCols<3>(), found->col(3)};
  return tracked;
}

using Method = TrackedPose (*)(const TrackedTarget&, const ShownFrame&, const PosePrior&);

struct NamedMethod {
  const char* name;
  Method method;
};

constexpr std::array<NamedMethod, 3> kMethods = {{
    {"registration_image",
     [](const TrackedTarget& target, const ShownFrame& frame, const PosePrior& prior) {
       return registered(target, frame, prior, RegistrationRegion::kImage);
     }},
    {"registration_outline",
     [](const TrackedTarget& target, const ShownFrame& frame, const PosePrior& prior) {
       return registered(target, frame, prior, RegistrationRegion::kOutline);
     }},
    {"ViSP", tracked_by_visp},
}};

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

// How many of a frame's poses lie by kRepeatableDeg or less from the one that most others do.
int repeatable(const std::vector<Pose>& poses) {
  int most = 0;
  for (const Pose& middle : poses) {
    most = std::max(
        most, static_cast<int>(std::count_if(poses.begin(), poses.end(), [&](const Pose& pose) {
          return geodesic_angle_rad(pose.rotation, middle.rotation) <= kRepeatableDeg * kDegree;
        })));
  }
  return most;
}

struct TrackerTally {
  int tries = 0, repeatable = 0;
  std::vector<double> angles_deg, t_percent, cpu_ms;

  void add(const TrackedTarget& target, size_t frame, const TrackerRequest& request,
           Method method) {
    std::vector<Pose> poses;
    const ShownFrame& shown = target.frames[frame];
    for (int i = 0; i < request.priors; ++i) {
      const uint64_t seed = request.seed * 1000003 + static_cast<uint64_t>(i);
      const TrackedPose tracked = method(target, shown, drawn_prior(target, frame, seed));
      ++tries;
      cpu_ms.push_back(tracked.cpu_ms);
      if (!tracked.pose) continue;
      const Pose& truth = shown.cam_from_target;
      poses.push_back(*tracked.pose);
      angles_deg.push_back(geodesic_angle_rad(tracked.pose->rotation, truth.rotation) / kDegree);
      t_percent.push_back(100 *
                          translation_error_fraction(tracked.pose->translation, truth.translation));
    }
    repeatable += sightline::repeatable(poses);
  }
};

void print_row(const std::string& shown, const char* method, const TrackerTally& tally) {
  fmt::print("{:<14} {:<20} {:>4} {:>8} {:>10} {:>10.4f} {:>10.4f} {:>9.4f} {:>9.4f} {:>7.0f}\n",
             shown, method, tally.tries, tally.tries - static_cast<int>(tally.angles_deg.size()),
             tally.repeatable, quantile(tally.angles_deg, 0.5), quantile(tally.angles_deg, 0.9),
             quantile(tally.t_percent, 0.5), quantile(tally.t_percent, 0.9),
             quantile(tally.cpu_ms, 0.5));
  std::fflush(stdout);
}

// Frames together, or each in a row of its own.
void print_rows(const TrackedTarget& target, const TrackerRequest& request, bool is_by_frame) {
  const size_t rows = is_by_frame ? target.frames.size() : 1;
  for (size_t row = 0; row < rows; ++row) {
    for (const auto& [name, method] : kMethods) {
      TrackerTally tally;
      for (size_t frame = row; frame < target.frames.size(); frame += rows) {
        tally.add(target, frame, request, method);
      }
      print_row(is_by_frame ? fmt::format("{} {}", target.name, row) : target.name, name, tally);
    }
  }
}

void print_tracker_table(const TrackerRequest& request) {
  fmt::print("{:<14} {:<20} {:>4} {:>8} {:>10} {:>10} {:>10} {:>9} {:>9} {:>7}\n", "frames",
             "method", "of", "no pose", "repeatable", "angle/deg", "90 %", "T/%", "90 %", "CPU/ms");
  for (const char* const target : {"boeing707", "cube"}) {
    if (!request.has(target)) continue;
    print_rows(tracked_target(rendered_frames(target, request.frames)), request, false);
  }
  if (!request.has("photographs")) return;
  std::vector<FramedTarget> sets = photographs();
  for (FramedTarget& target : sets) {
    print_rows(tracked_target(std::move(target)), request, true);
  }
}

int positive(const std::string& value) {
  const int number = std::stoi(value);
  if (number < 1) throw std::invalid_argument(value);
  return number;
}

std::string known_targets(const std::string& value) {
  std::istringstream names(value);
  for (std::string name; std::getline(names, name, ',');) {
    if (!TrackerRequest{}.has(name)) throw std::invalid_argument(name);
  }
  return value;
}

void set_tracker_key(TrackerRequest& request, const std::string& key, const std::string& value) {
  if (key == "frames")
    request.frames = positive(value);
  else if (key == "priors")
    request.priors = positive(value);
  else if (key == "seed")
    request.seed = std::stoul(value);
  else if (key == "targets")
    request.targets = known_targets(value);
  else
    throw std::invalid_argument(key);
}

}  // namespace

int run_tracker_accuracy(int argc, char** argv) {
  TrackerRequest request;
  for (int i = 0; i < argc; ++i) {
    const std::string given = argv[i];
    const size_t equals = given.find('=');
    try {
      if (equals == std::string::npos) throw std::invalid_argument(given);
      set_tracker_key(request, given.substr(0, equals), given.substr(equals + 1));
    } catch (const std::exception&) {
      std::cerr << "trackers: " << given
                << ": expected frames=N, priors=N, seed=N, "
                   "targets=boeing707,cube,photographs\n";
      return 2;
    }
  }
  try {
    print_tracker_table(request);
  } catch (const InputError& error) {
    std::cerr << "trackers: " << error.what() << "\n";
    return 1;
  }
  return 0;
}

}  // namespace sightline
