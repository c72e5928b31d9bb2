// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/mesh_soup.h"

#include <csignal>
#include <cstring>
#include <ctime>
#include <iostream>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "scenes/files/input_error.h"
#include "scenes/mesh/mesh_folder.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::filesystem::path kFile = "some/mesh.obj";

MeshSoup one_triangle() {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  return {
      .points = {Eigen::Vector3d(0.1, 0, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, -3)},
      .triangles = {{.point = {0, 1, 2}, .part = 1}},
      .normals = {{up, Eigen::Vector3d::Zero(), -up}},
      .parts = {{"hull", 0.25}, {"Flügel", 1}}};
}

std::string decode_error(const MeshSoup& soup) {
  return error_of([&] { decode(encode(soup), kFile); });
}

TEST(MeshSoup, CrossesAsBytes) {
  const MeshSoup soup = one_triangle();
  const MeshSoup back = decode(encode(soup), kFile);
  ASSERT_EQ(back.parts.size(), 2u);
  EXPECT_EQ(back.parts[1].name, "Flügel");
  EXPECT_EQ(back.parts[0].albedo, 0.25);
  ASSERT_EQ(back.triangles.size(), 1u);
  EXPECT_EQ(back.points, soup.points);
  EXPECT_EQ(back.triangles[0].point, soup.triangles[0].point);
  EXPECT_EQ(back.normals, soup.normals);
  EXPECT_EQ(back.triangles[0].part, 1);
}

TEST(MeshSoup, TheDecoderTrustsNothing) {
  const std::string whole = encode(one_triangle());
  for (size_t size = 0; size < whole.size(); ++size) {
    EXPECT_THAT(error_of([&] { decode(whole.substr(0, size), kFile); }), HasSubstr("mesh.obj"));
  }
  EXPECT_THAT(error_of([&] { decode(whole + "x", kFile); }), HasSubstr("torn"));
  for (const size_t count_at : {8, 16, 24, 32}) {  // of parts, triangles, points and normals
    std::string lying = whole;
    const uint64_t huge = std::numeric_limits<uint64_t>::max() / 3;
    std::memcpy(lying.data() + count_at, &huge, sizeof huge);
    EXPECT_THAT(error_of([&] { decode(lying, kFile); }), HasSubstr("too large"));
  }
  MeshSoup soup = one_triangle();
  soup.triangles[0].part = 2;
  EXPECT_THAT(decode_error(soup), HasSubstr("no part"));
  soup = one_triangle();
  for (const int nowhere : {-1, 3}) {
    soup = one_triangle();
    soup.triangles[0].point[1] = nowhere;
    EXPECT_THAT(decode_error(soup), HasSubstr("nowhere"));
  }
  soup = one_triangle();
  soup.points[2].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(decode_error(soup), HasSubstr("finite"));
  soup = one_triangle();
  soup.points[2].y() = -1e13;
  EXPECT_THAT(decode_error(soup), HasSubstr("at most"));
  for (const double wrong : {1.5, std::numeric_limits<double>::quiet_NaN()}) {
    soup = one_triangle();
    soup.normals[0][0].x() = wrong;
    EXPECT_THAT(decode_error(soup), HasSubstr("normal"));
    soup = one_triangle();
    soup.parts[0].albedo = wrong;
    EXPECT_THAT(decode_error(soup), HasSubstr("albedo"));
  }
}

// A strip of so many triangles, each with corners of its own, as .stl files have them.
MeshSoup strip_of(int triangles, const Eigen::Vector3d& normal) {
  MeshSoup soup;
  soup.parts = {{"strip"}};
  SoupTransform as_it_is(Eigen::Matrix4d::Identity(), static_cast<size_t>(triangles), 0);
  for (int i = 0; i < triangles; ++i) {
    const auto corner = [i](int k) { return Eigen::Vector3d((i + k) / 2, (i + k) % 2, 0); };
    as_it_is.add(soup, {.corner = {corner(0), corner(1 + i % 2), corner(2 - i % 2)},
                        .normal = {normal, normal, normal}});
  }
  return soup;
}

TEST(MeshSoup, APointIsThereOnce) {
  const MeshSoup soup = strip_of(1000, Eigen::Vector3d::Zero());
  EXPECT_EQ(soup.points.size(), 1002u);
  EXPECT_EQ(soup.triangles.back().point, (std::array<int, 3>{999, 1001, 1000}));
  EXPECT_TRUE(soup.normals.empty());
  EXPECT_EQ(strip_of(3, Eigen::Vector3d::UnitZ()).normals.size(), 3u);
}

// A vertex that comes again is known by its place, and lies where it lay; one elsewhere in the list
// with the same coordinates is the same point.
TEST(MeshSoup, VerticesOfAListAreCarriedOnce) {
  const std::vector<Eigen::Vector3d> list = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0, 0}};
  const std::vector<std::array<int, 3>> triangles = {{0, 1, 2}, {2, 3, 0}, {4, 2, 3}};
  Eigen::Matrix4d mirrored = Eigen::Matrix4d::Identity();
  mirrored(0, 0) = -2;
  const auto soup_of = [&](size_t vertices) {
    MeshSoup soup;
    soup.parts = {{"square"}};
    SoupTransform transform(mirrored, triangles.size(), vertices);
    for (const auto& [a, b, c] : triangles) {
      transform.add(
          soup,
          {.corner = {list[a], list[b], list[c]}, .normal = no_normals(), .vertex = {a, b, c}});
    }
    return soup;
  };
  const MeshSoup soup = soup_of(list.size());
  EXPECT_EQ(encode(soup), encode(soup_of(0)));  // each looked for by its coordinates
  EXPECT_EQ(soup.points.size(), 4u);
  EXPECT_EQ(soup.points[soup.triangles[2].point[2]], Eigen::Vector3d(-2, 0, 0));
}

TEST(MeshSoup, ALargeOneCrossesInPieces) {
  const MeshSoup soup = strip_of(30'000, Eigen::Vector3d::UnitZ());
  size_t longest = 0, whole = 0;
  std::string bytes;
  encode(soup, [&](std::string_view piece) { bytes += piece; });
  std::string_view rest = bytes;
  const MeshSoup back = decode(
      [&](char* to, size_t most) {
        const size_t size = rest.copy(to, std::min<size_t>(most, 1001));  // an odd number
        rest.remove_prefix(size);
        longest = std::max(longest, size);
        whole += size;
        return size;
      },
      kFile);
  EXPECT_EQ(encode(back), bytes);
  EXPECT_EQ(whole, bytes.size());
  EXPECT_LE(longest, 1001u);
  EXPECT_EQ(encode(read_in_child(kFile, [&](const std::filesystem::path&) { return soup; }, {})),
            bytes);
}

TEST(MeshSoup, WhatIsNearIsWeldedAndWhatIsNotIsKept) {
  const double size = std::hypot(15'000, 1);  // of the strip, whose tolerance is a millionth
  for (const auto& [gap, vertices] : {std::pair(0.9e-6 * size, 30'002), {1.1e-6 * size, 30'003}}) {
    MeshSoup soup = strip_of(30'000, Eigen::Vector3d::Zero());
    soup.triangles.back().point[1] = static_cast<int>(soup.points.size());
    soup.points.push_back(soup.points.back() + Eigen::Vector3d(0, 0, gap));
    const LoadedMesh loaded = clean(std::move(soup), {}, kFile);
    EXPECT_EQ(loaded.mesh.vertices.size(), static_cast<size_t>(vertices));
    EXPECT_EQ(loaded.mesh.triangles.size(), 30'000u);
  }
}

TEST(MeshSoup, NamesComeOutPrintable) {
  MeshSoup soup = one_triangle();
  soup.parts[0].name = "a\nb\x1b[31m\xff";
  soup.parts[1].name = std::string(1000, 'x');
  const MeshSoup back = decode(encode(soup), kFile);
  EXPECT_EQ(back.parts[0].name, "a_b_[31m");
  EXPECT_EQ(back.parts[1].name, std::string(256, 'x'));
}

TEST(MeshSoup, KnowsWhatLiesInAFolder) {
  const TemporaryFolder folder;
  folder.write("a", "");
  EXPECT_TRUE(is_inside(folder.path(), folder.path() / "a"));
  EXPECT_TRUE(is_inside(folder.path(), folder.path() / "b/../a"));
  EXPECT_FALSE(is_inside(folder.path(), folder.path() / "../a"));
  EXPECT_FALSE(is_inside(folder.path(), folder.path().string() + "-twin/a"));
  std::filesystem::create_symlink("/etc/passwd", folder.path() / "link");
  EXPECT_FALSE(is_inside(folder.path(), folder.path() / "link"));
}

class ReadInChild : public testing::Test {
 protected:
  std::string error_of_reader(const std::function<void()>& act, const ReaderLimits& limits = {}) {
    const auto reader = [&](const std::filesystem::path&) {
      act();
      return one_triangle();
    };
    return error_of([&] { read_in_child(kFile, reader, limits); });
  }
};

TEST_F(ReadInChild, LimitsGrowWithTheFile) {
  const ReaderLimits small = limits_for(1000), large = limits_for(uint64_t{10} << 20);
  EXPECT_EQ(small.cpu_s, 2);
  EXPECT_EQ(large.cpu_s, 12);
  EXPECT_GT(large.memory_bytes, small.memory_bytes);
  EXPECT_EQ(limits_for(uint64_t{1} << 30).cpu_s, 120);
  EXPECT_EQ(limits_for(uint64_t{1} << 40).memory_bytes, uint64_t{4} << 30);
}

TEST_F(ReadInChild, GivesWhatTheReaderGives) {
  const MeshSoup soup =
      read_in_child(kFile, [](const std::filesystem::path&) { return one_triangle(); }, {});
  EXPECT_EQ(encode(soup), encode(one_triangle()));
}

TEST_F(ReadInChild, AReadersErrorIsOneLine) {
  EXPECT_EQ(error_of_reader([] { throw InputError("f: bad\nworse"); }), "f: bad worse");
  EXPECT_THAT(error_of_reader([] { throw std::runtime_error("boom"); }),
              AllOf(HasSubstr("mesh.obj"), HasSubstr("boom")));
}

TEST_F(ReadInChild, ACrashIsOneLine) {
  for (const int signal : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL}) {
    EXPECT_THAT(error_of_reader([signal] { raise(signal); }),
                AllOf(HasSubstr("mesh.obj"), HasSubstr("crashed"), Not(HasSubstr("\n"))));
  }
  EXPECT_THAT(error_of_reader([] { std::terminate(); }), HasSubstr("crashed"));
  EXPECT_THAT(error_of_reader([] { _exit(3); }), HasSubstr("crashed"));
  EXPECT_THAT(error_of_reader([] { _exit(0); }), HasSubstr("without a word"));
  EXPECT_THAT(error_of_reader([] { raise(SIGKILL); }), HasSubstr("killed"));
}

TEST_F(ReadInChild, AReaderThatHangsIsEnded) {
  EXPECT_THAT(error_of_reader([] { pause(); }, {.wait_s = 1}), HasSubstr("waited for 1 s"));
  const auto spin = [] {
    volatile bool is_done = false;
    while (!is_done) {
    }
  };
  EXPECT_THAT(error_of_reader(spin, {.cpu_s = 1}), HasSubstr("more than 1 s"));
}

TEST_F(ReadInChild, AReaderThatWorksIsWaitedForLonger) {
  const auto work_and_wait = [](const std::filesystem::path&) {
    const std::clock_t begin = std::clock();
    while (std::clock() - begin < CLOCKS_PER_SEC / 10) {
    }
    usleep(1'500'000);  // as if other programs had the processors
    return one_triangle();
  };
  const MeshSoup soup = read_in_child(kFile, work_and_wait, {.wait_s = 1});
  EXPECT_EQ(soup.triangles.size(), 1u);
}

TEST_F(ReadInChild, AReaderThatDevoursMemoryIsEnded) {
  const auto devour = [] {
    std::vector<std::string> all;
    for (int i = 0; i < 4096; ++i) all.emplace_back(size_t{1} << 20, 'x');  // 4 GiB
  };
  EXPECT_NE(error_of_reader(devour, {.memory_bytes = uint64_t{256} << 20}), "");
  EXPECT_THAT(
      error_of_reader([] { std::vector<char>().resize(std::numeric_limits<size_t>::max()); }),
      HasSubstr("MiB"));
}

TEST_F(ReadInChild, AReaderCannotPrintOrWriteOrChangeUs) {
  const TemporaryFolder folder;
  int here = 0;
  testing::internal::CaptureStdout();
  EXPECT_EQ(error_of_reader([&] {
              here = 1;
              std::cout << "noise" << std::endl;
              std::signal(SIGXFSZ, SIG_IGN);
              folder.write("stray", "text");
            }),
            "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(here, 0);
  EXPECT_EQ(read_whole(folder.path() / "stray"), "");
}

}  // namespace
}  // namespace sightline
