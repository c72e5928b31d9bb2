// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Real photographs of printed cubes, as `evaluate` registers them with default settings. They are
// not part of the project: SIGHTLINE_TEST_REAL names the folder with vispcube/ and rbtcube/, sets
// in BOP's layout.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "pose/angles.h"
#include "tests/eval/program.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// The registered poses of a run and how far each is from the stated one, by image.
struct Registered {
  std::string status;
  Eigen::Quaterniond attitude;
  double error_deg = 0;
};

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream in(line);
  for (std::string field; std::getline(in, field, ',');) fields.push_back(field);
  return fields;
}

std::map<std::string, Registered> registered(const fs::path& results) {
  std::ifstream in(results);
  std::string line;
  std::getline(in, line);
  std::map<std::string, size_t> column;
  const std::vector<std::string> names = fields_of(line);
  for (size_t i = 0; i < names.size(); ++i) column[names[i]] = i;
  std::map<std::string, Registered> found;
  while (std::getline(in, line)) {
    const std::vector<std::string> row = fields_of(line);
    if (row[column["solver"]] != "registration_image") continue;
    Registered& image = found[row[column["image"]]];
    image.status = row[column["status"]];
    if (image.status != "ok") continue;
    const auto number = [&](const char* name) { return std::stod(row[column[name]]); };
    image.error_deg = number("geodesic_deg");
    image.attitude = Eigen::Quaterniond(number("qw"), number("qx"), number("qy"), number("qz"));
  }
  return found;
}

TEST(Photographs, OfPrintedCubesAreRegisteredFromAnyPrior) {
  const char* const real = std::getenv("SIGHTLINE_TEST_REAL");
  if (real == nullptr) GTEST_SKIP() << "SIGHTLINE_TEST_REAL names no folder of photographs";
  // The stated poses were made by hand and are good to some half a degree; that of vispcube's
  // frame 120 is in doubt: two other programs lie 1.3 and 1.5 degrees from it.
  const std::map<std::string, double> most_deg = {{"vispcube/test/000001/gray/000000.png", 0.6},
                                                  {"vispcube/test/000001/gray/000120.png", 1.6},
                                                  {"rbtcube/test/000001/rgb/000000.png", 1.1},
                                                  {"rbtcube/test/000001/rgb/000098.png", 0.6}};
  constexpr double kRepeatableDeg = 0.2;
  const TemporaryFolder folder;
  std::map<std::string, Registered> first;
  for (const std::string set : {"vispcube", "rbtcube"}) {
    const std::string given = std::string(real) + "/" + set;
    const std::string target = (folder.path() / set).string();
    ASSERT_EQ(
        run("target " + given + "/models/obj_000001.ply --unit mm --propose " + target).exit_code,
        0);
    for (const std::string seed : {"1", "2", "16", "23"}) {
      const fs::path out = folder.path() / (set + "-" + seed);
      const Outcome outcome =
          run("evaluate " + given + " --target " + target + "/target.toml --solvers lspe --quiet " +
              "--set extraction.registration=image --seed " + seed + " --out " + out.string());
      ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
      for (const auto& [image, pose] : registered(out / "results.csv")) {
        const std::string name = set + "/" + image;
        ASSERT_EQ(pose.status, "ok") << name << ", seed " << seed;
        EXPECT_LT(pose.error_deg, most_deg.at(name)) << name;
        const auto [before, is_new] = first.try_emplace(name, pose);
        if (is_new) continue;
        EXPECT_LT(pose.attitude.angularDistance(before->second.attitude) / kDegree, kRepeatableDeg)
            << name;
      }
    }
  }
  EXPECT_EQ(first.size(), most_deg.size());
}

}  // namespace
}  // namespace sightline
