// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <iostream>
#include <string_view>

#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>
#include <unistd.h>

#include "eval/benchmarks/benches.h"
#include "eval/benchmarks/pose_accuracy.h"
#include "eval/benchmarks/tracker_accuracy.h"
#include "eval/work/kept_memory.h"

int main(int argc, char** argv) {
  cv::setNumThreads(1);  // as in the program, both
  sightline::keep_freed_memory();
  if (argc > 1 && std::string_view(argv[1]) == "accuracy") {
    return sightline::run_pose_accuracy(argc - 2, argv + 2);
  }
  if (argc > 1 && std::string_view(argv[1]) == "trackers") {
    return sightline::run_tracker_accuracy(argc - 2, argv + 2);
  }
  const std::vector<sightline::PeerComparison> comparisons = {
      sightline::register_absolute_orientation(),
      sightline::register_alignment(),
      sightline::register_pnp(),
      sightline::register_outlier(),
      sightline::register_render(),
  };
  sightline::register_pipeline();
  sightline::register_door();
  sightline::register_lines();
  sightline::register_registration();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  sightline::RememberingReporter reporter(isatty(STDOUT_FILENO) != 0);
  benchmark::RunSpecifiedBenchmarks(&reporter);
  benchmark::Shutdown();
  std::cout << sightline::ratio_tables(comparisons, reporter.best_ns());
  return 0;
}
