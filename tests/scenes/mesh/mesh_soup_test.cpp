// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/mesh_soup.h"

#include <csignal>
#include <cstring>
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
  const SoupTriangle triangle{
      .corner = {Eigen::Vector3d(0.1, 0, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, -3)},
      .normal = {up, Eigen::Vector3d::Zero(), -up},
      .part = 1};
  return {.triangles = {triangle}, .parts = {{"hull", 0.25}, {"Flügel", 1}}};
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
  EXPECT_EQ(back.triangles[0].corner, soup.triangles[0].corner);
  EXPECT_EQ(back.triangles[0].normal, soup.triangles[0].normal);
  EXPECT_EQ(back.triangles[0].part, 1);
}

TEST(MeshSoup, TheDecoderTrustsNothing) {
  const std::string whole = encode(one_triangle());
  for (size_t size = 0; size < whole.size(); ++size) {
    EXPECT_THAT(error_of([&] { decode(whole.substr(0, size), kFile); }), HasSubstr("mesh.obj"));
  }
  EXPECT_THAT(error_of([&] { decode(whole + "x", kFile); }), HasSubstr("torn"));
  for (const size_t count_at : {8, 16}) {  // of parts, of triangles
    std::string lying = whole;
    const uint64_t huge = std::numeric_limits<uint64_t>::max() / 3;
    std::memcpy(lying.data() + count_at, &huge, sizeof huge);
    EXPECT_THAT(error_of([&] { decode(lying, kFile); }), HasSubstr("too large"));
  }
  MeshSoup soup = one_triangle();
  soup.triangles[0].part = 2;
  EXPECT_THAT(decode_error(soup), HasSubstr("no part"));
  soup = one_triangle();
  soup.triangles[0].corner[2].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(decode_error(soup), HasSubstr("finite"));
  soup = one_triangle();
  soup.triangles[0].corner[2].y() = -1e13;
  EXPECT_THAT(decode_error(soup), HasSubstr("at most"));
  for (const double wrong : {1.5, std::numeric_limits<double>::quiet_NaN()}) {
    soup = one_triangle();
    soup.triangles[0].normal[0].x() = wrong;
    EXPECT_THAT(decode_error(soup), HasSubstr("normal"));
    soup = one_triangle();
    soup.parts[0].albedo = wrong;
    EXPECT_THAT(decode_error(soup), HasSubstr("albedo"));
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
  EXPECT_THAT(error_of_reader([] { pause(); }, {.wall_s = 1}), HasSubstr("more than 1 s"));
  const auto spin = [] {
    volatile bool is_done = false;
    while (!is_done) {
    }
  };
  EXPECT_THAT(error_of_reader(spin, {.cpu_s = 1}), HasSubstr("more than 1 s"));
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
