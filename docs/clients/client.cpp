// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The smallest solver and extractor that Sightline can ask: the protocol of docs/external.md.
//
//   g++ -std=c++17 -O2 docs/clients/client.cpp -o client     (package nlohmann-json3-dev)
//   sightline study boeing-random --solver mine=./client
//
// Put your own code into solve() and extract(). Print to std::cerr only: it goes to a log.
#include <iostream>
#include <string>

#include <nlohmann/json.hpp>

using nlohmann::json;

// A pose from question["points_m"] and question["pixels"]: here merely where to start.
static json solve(const json& question) {
  if (!question.contains("initial")) {
    return {{"status", "no estimate"}, {"reason", "there is no initial pose"}};
  }
  return {{"rotation", question["initial"]["rotation"]},
          {"translation_m", question["initial"]["translation_m"]}};
}

// The features in the file question["image"]: here merely where they are predicted.
static json extract(const json& question) {
  json found = json::array();
  for (const json& feature : question["features"]) {
    if (!feature.contains("pixel") || feature["is_hidden"]) continue;
    found.push_back({{"feature", feature["name"]},
                     {"u", feature["pixel"][0]},
                     {"v", feature["pixel"][1]},
                     {"covariance_px2", feature["covariance_px2"]}});
  }
  return {{"observations", found}};
}

int main() {
  for (std::string line; std::getline(std::cin, line);) {
    const json question = json::parse(line);
    json answer = {{"protocol", 1}};
    if (question["type"] != "hello") {
      answer = question["type"] == "solve" ? solve(question) : extract(question);
      answer["id"] = question["id"];
    }
    std::cout << answer.dump() << std::endl;
  }
}
