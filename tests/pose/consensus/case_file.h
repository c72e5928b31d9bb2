// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The pose problems of cases/, each a text file: the camera and the noise, an initial pose where
// there is one, and a row for each point. Lines that begin with # say what the next rows are.
#pragma once

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "pose/solver.h"

namespace sightline {

/// The numbers of a line; also "nan", which streams do not read.
inline std::vector<double> numbers_of(const std::string& line) {
  std::istringstream stream(line);
  std::vector<double> numbers;
  for (std::string word; stream >> word;) numbers.push_back(std::strtod(word.c_str(), nullptr));
  return numbers;
}

inline PoseProblem read_case(const std::string& name) {
  std::ifstream file(SIGHTLINE_SOURCE_DIR "/tests/pose/consensus/cases/" + name + ".txt");
  if (!file) throw std::runtime_error("no case " + name);
  PoseProblem problem;
  Pose initial;
  std::string heading;
  int row = 0;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("#")) {
      heading = line;
      continue;
    }
    const std::vector<double> x = numbers_of(line);
    if (heading.starts_with("# w")) {
      problem.camera = {static_cast<int>(x.at(0)),
                        static_cast<int>(x.at(1)),
                        x.at(2),
                        x.at(3),
                        x.at(4),
                        x.at(5),
                        0,
                        {}};
      problem.camera.lens = BrownConrady{x.at(6), x.at(7), x.at(8), x.at(9), x.at(10)};
      problem.sigma_px = x.at(11);
    } else if (heading.starts_with("# initial")) {
      initial.rotation.row(row) << x.at(0), x.at(1), x.at(2);
      initial.translation[row++] = x.at(3);
      if (row == 3) problem.initial_cam_from_target = initial;
    } else {
      problem.points_in_target.emplace_back(x.at(0), x.at(1), x.at(2));
      problem.pixels.emplace_back(x.at(3), x.at(4));
    }
  }
  return problem;
}

}  // namespace sightline
