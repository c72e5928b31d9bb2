// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/work/progress.h"

#include <algorithm>
#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

namespace sightline {
namespace {

constexpr int kBarWidth = 30;
constexpr std::chrono::milliseconds kRedrawInterval(100);

std::string clock_text(double seconds) {
  const int whole = static_cast<int>(std::max(0.0, seconds) + 0.5);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

Progress::Progress(std::string label, int64_t total, bool is_wanted)
    : label_(std::move(label)),
      total_(std::max<int64_t>(1, total)),
      is_shown_(is_wanted && isatty(STDERR_FILENO) != 0),
      start_(std::chrono::steady_clock::now()),
      last_draw_(start_) {
  if (is_shown_) draw();
}

Progress::~Progress() {
  if (!is_shown_) return;
  draw();
  fmt::print(stderr, "\n");
}

void Progress::advance(int64_t steps) {
  done_ += steps;
  if (!is_shown_) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - last_draw_ < kRedrawInterval) return;
  last_draw_ = now;
  draw();
}

void Progress::draw() {
  const double elapsed_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  const double fraction = static_cast<double>(done_) / static_cast<double>(total_);
  const int filled = std::clamp(static_cast<int>(fraction * kBarWidth), 0, kBarWidth);
  const std::string bar = std::string(filled, '#') + std::string(kBarWidth - filled, '.');
  std::string rest;
  if (done_ > 0 && elapsed_s > 0) {
    const double rate = static_cast<double>(done_) / elapsed_s;
    const double left_s = static_cast<double>(total_ - done_) / rate;
    rest = done_ < total_ ? fmt::format("{:.1f}/s, {} left", rate, clock_text(left_s))
                          : fmt::format("{:.1f}/s, took {}", rate, clock_text(elapsed_s));
  }
  fmt::print(stderr, "\r\033[K{} [{}] {}/{} {}", label_, bar, done_, total_, rest);
  std::fflush(stderr);
}

}  // namespace sightline
