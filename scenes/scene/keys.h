// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The keys of a file, one line each. A part of a scene (light.h, sensor.h, ...) has three things
// side by side: a struct with what a frame has, a law with what a file says of it, and the table of
// its keys, `keys_of(law, part)`. The table is all there is to say of a key: it reads the file,
// draws the frame, writes the truth, and is what `sightline list keys` prints.
//
// A table points into the law and the part that it is made for, and must not outlive them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "scenes/files/toml_table.h"
#include "scenes/random/random.h"
#include "scenes/scene/range.h"

namespace sightline {

/// A value as the truth of an image states it.
using FactValue = std::variant<bool, int64_t, double, std::string, std::vector<double>>;

/// Something that is true of a frame, by name.
struct Fact {
  std::string name;
  FactValue value;
};

/// One of several values, each of which has a word in files.
struct Choice {
  std::vector<std::string> words;
  std::function<void(size_t)> choose;  ///< by the word's place
  std::function<size_t()> chosen;
  std::function<FactValue()> fact;  ///< the word, or the value itself where that is true or false
};

/// A choice of `value`, an enum or a bool, among pairs of a word and what it stands for.
template <typename Value>
Choice choice(Value& value, std::vector<std::pair<std::string, Value>> worded) {
  Choice out;
  for (const auto& [word, meant] : worded) out.words.push_back(word);
  out.choose = [&value, worded](size_t place) { value = worded[place].second; };
  out.chosen = [&value, worded] {
    size_t place = 0;
    while (place + 1 < worded.size() && worded[place].second != value) ++place;
    return place;
  };
  out.fact = [&value, chosen = out.chosen, words = out.words]() -> FactValue {
    if constexpr (std::is_same_v<Value, bool>) return value;
    return words[chosen()];
  };
  return out;
}

/// A range that files must state as [low, high], even where it has no width.
struct LowHigh {
  Range* range = nullptr;
};
struct OptionalLowHigh {
  std::optional<Range>* range = nullptr;
};

/// A fraction that files state in percent.
struct Percent {
  double* fraction = nullptr;
};

/// A key that its part reads in code of its own; the table says in words what the file may say.
struct Described {
  std::string fallback;
  std::string range = {};  ///< empty: a number of the allowed interval
};

/// Where a key's value goes, which says also how the file must state it. Until it is read, what
/// stands there is the default. A Range may be a number or [low, high] in the file; what is
/// optional stays without value where the file has no such key.
using KeyValue = std::variant<double*, int*, bool*, std::string*, std::filesystem::path*, Choice,
                              Range*, LowHigh, Percent, std::optional<double>*, std::optional<int>*,
                              std::optional<Range>*, OptionalLowHigh, Eigen::Vector3d*,
                              std::vector<double>*, Described>;

/// Where a frame has the value: drawn, where the law has a Range, else as it stands in the law.
using FrameValue = std::variant<std::monostate, double*, int*, bool*, Choice>;

/// A key of a file.
struct Key {
  std::string table;  ///< "image" for a key of [image], "a.b" of [a.b]; empty above all tables
  std::string name;
  KeyValue value;
  Interval allowed;  ///< of each of its numbers
  std::string unit;  ///< empty: it has none
  std::string meaning;
  FrameValue frame = {};  ///< none: the part's own code makes of the key what the frame has
  /// What the key makes in the truth of an image. A key with `frame` makes its own name there where
  /// this is empty; any other key without makes nothing in a picture.
  std::string truth = {};
  bool is_required = false;
  std::string if_absent = {};  ///< the default in words, where it is not what stands in `value`

  /// "image.gain": the name of its random stream too.
  std::string path() const { return table + "." + name; }
};

/// Reads one key from the table that it stands in. Throws InputError.
void read_key(const TomlTable& table, const Key& key);
/// Reads every key from its table of a file.
void read_keys(const TomlTable& file, std::span<const Key> keys);
/// The key of that name or path; it must be there.
const Key& find_key(std::span<const Key> keys, std::string_view name);

/// [low, high] within the allowed interval.
Range read_range(const TomlTable& table, std::string_view key, Interval allowed);

/// Throws InputError, saying what was given, where one of the numbers of a key is out of range.
void require_within(const TomlTable& table, std::string_view key, std::span<const double> numbers,
                    Interval allowed);
void require_within(const TomlTable& table, std::string_view key, const Eigen::Vector3d& numbers,
                    Interval allowed);

/// Draws of one scene. Every quantity has a random stream of its own, keyed by (seed, its name,
/// index), so that widening one range leaves all other draws as they were.
struct Draws {
  uint64_t seed = 0;
  int64_t index = 0;

  RandomStream stream(std::string_view name) const;
  double operator()(const Range& range, std::string_view name) const;
};

/// Gives the frame what the keys' laws say of it.
void draw_keys(std::span<const Key> keys, const Draws& draws);

/// What the frame has of the keys, in their order.
std::vector<Fact> facts_of(std::span<const Key> keys);

/// A key in words, for the program's list and the page of the docs.
struct KeyText {
  std::string table;  ///< "[image]", "[[other]]"
  std::string name;
  std::string unit;
  std::string range;  ///< what the file may say
  std::string fallback;
  std::string meaning;
  std::string truth;  ///< its place in the truth of an image, "scene.sensor.gain"; empty: none
};

/// The keys in words. `object` is where the truth of an image has what they make.
std::vector<KeyText> texts_of(std::span<const Key> keys, std::string_view object);

}  // namespace sightline
