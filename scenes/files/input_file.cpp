// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/files/input_file.h"

#include <array>
#include <fstream>
#include <streambuf>
#include <system_error>

#include <fmt/format.h>
#include <zlib.h>

#include "scenes/files/input_error.h"
#include "scenes/files/pauses.h"

namespace sightline {
namespace {

constexpr const char* kPacked = ".gz";
/// What numbers and names pack to a hundredth of is made to fill the memory.
constexpr uintmax_t kMostUnpacked = 100;
constexpr uintmax_t kAlwaysUnpacked = uintmax_t{16} << 20;

[[noreturn]] void fail_as_too_large(const std::filesystem::path& file, uintmax_t most_bytes) {
  throw InputError(
      fmt::format("{}: is larger than {} MiB", file.string(), most_bytes / (1024 * 1024)));
}

std::string lowered_ending(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  for (char& letter : ending) {
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  }
  return ending;
}

// The bytes that gzip packed into a file, a block after the other.
class UnpackedBytes : public std::streambuf {
 public:
  UnpackedBytes(std::filesystem::path file, uintmax_t most_bytes)
      : file_(std::move(file)),
        most_bytes_(most_bytes),
        packed_size_(std::filesystem::file_size(file_)),
        packed_(gzopen(file_.c_str(), "rb")) {}
  UnpackedBytes(const UnpackedBytes&) = delete;
  UnpackedBytes& operator=(const UnpackedBytes&) = delete;
  ~UnpackedBytes() override { gzclose_r(packed_); }

 protected:
  int_type underflow() override {
    const int count = gzread(packed_, block_.data(), static_cast<unsigned>(block_.size()));
    int problem = Z_OK;
    gzerror(packed_, &problem);
    if (count < 0 || (problem != Z_OK && problem != Z_STREAM_END)) {
      throw InputError(fmt::format("{}: is damaged: gzip cannot unpack it", file_.string()));
    }
    total_ += static_cast<uintmax_t>(count);
    if (total_ > most_bytes_) fail_as_too_large(file_, most_bytes_);
    if (total_ > kAlwaysUnpacked && total_ / kMostUnpacked > packed_size_) {
      throw InputError(
          fmt::format("{}: unpacks to more than {} times its size", file_.string(), kMostUnpacked));
    }
    setg(block_.data(), block_.data(), block_.data() + count);
    return count == 0 ? traits_type::eof() : traits_type::to_int_type(block_.front());
  }

 private:
  std::filesystem::path file_;
  uintmax_t most_bytes_;
  uintmax_t packed_size_;
  uintmax_t total_ = 0;
  gzFile packed_;
  std::array<char, size_t{1} << 16> block_{};
};

class UnpackedStream : public std::istream {
 public:
  UnpackedStream(const std::filesystem::path& file, uintmax_t most_bytes)
      : std::istream(nullptr), bytes_(file, most_bytes) {
    rdbuf(&bytes_);
    exceptions(std::ios::badbit);  // else what the bytes throw would only set it
  }

 private:
  UnpackedBytes bytes_;
};

bool is_packed(std::istream& stream) {
  std::array<char, 2> first{};
  stream.read(first.data(), first.size());
  const bool is_gzip = stream.gcount() == 2 && first[0] == '\x1f' && first[1] == '\x8b';
  stream.clear();
  stream.seekg(0);
  return is_gzip;
}

// Null where it is missing, no regular file, or may not be read.
std::unique_ptr<std::ifstream> open_regular_file(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return nullptr;
  auto stream = std::make_unique<std::ifstream>(file, std::ios::binary);
  return stream->is_open() ? std::move(stream) : nullptr;
}

// What is left in a stream, block by block, so that a signal is heard between two.
std::string rest_of(std::istream& stream, uintmax_t expected_bytes) {
  std::string bytes;
  bytes.reserve(expected_bytes);
  std::array<char, size_t{1} << 16> block;
  while (stream.read(block.data(), block.size()) || stream.gcount() > 0) {
    take_pause();
    bytes.append(block.data(), static_cast<size_t>(stream.gcount()));
  }
  return bytes;
}

}  // namespace

std::unique_ptr<std::istream> open_input_file(const std::filesystem::path& file,
                                              uintmax_t most_bytes) {
  std::unique_ptr<std::ifstream> stream = open_regular_file(file);
  if (!stream) throw InputError(fmt::format("{}: is missing or cannot be read", file.string()));
  std::error_code error;
  const uintmax_t size = std::filesystem::file_size(file, error);
  if (error || size > most_bytes) fail_as_too_large(file, most_bytes);
  if (is_packed(*stream)) return std::make_unique<UnpackedStream>(file, most_bytes);
  return stream;
}

std::filesystem::path plain_or_packed(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::exists(file, error)) return file;
  const std::filesystem::path packed = file.string() + kPacked;
  return std::filesystem::exists(packed, error) ? packed : file;
}

std::filesystem::path unpacked_name(const std::filesystem::path& file) {
  return lowered_ending(file) == kPacked ? file.parent_path() / file.stem() : file;
}

std::string input_ending(const std::filesystem::path& file) {
  return lowered_ending(unpacked_name(file));
}

std::string read_input_file(const std::filesystem::path& file, uintmax_t most_bytes) {
  const std::unique_ptr<std::istream> stream = open_input_file(file, most_bytes);
  return rest_of(*stream, std::filesystem::file_size(file));
}

std::optional<std::string> bytes_of_file(const std::filesystem::path& file, uintmax_t most_bytes) {
  const std::unique_ptr<std::ifstream> stream = open_regular_file(file);
  std::error_code error;
  const uintmax_t size = std::filesystem::file_size(file, error);
  if (!stream || error || size > most_bytes) return std::nullopt;
  std::string bytes = rest_of(*stream, size);
  if (stream->bad() || bytes.size() != size) return std::nullopt;
  return bytes;
}

std::string head_of_file(const std::filesystem::path& file, size_t most_bytes) {
  const std::unique_ptr<std::ifstream> stream = open_regular_file(file);
  if (!stream) return {};
  std::string head(most_bytes, '\0');
  stream->read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<size_t>(stream->gcount()));
  return head;
}

bool read_bounded_line(std::istream& stream, std::string& line) {
  pause_at_times();
  line.clear();
  std::streambuf& buffer = *stream.rdbuf();
  constexpr int kEnd = std::char_traits<char>::eof();
  for (int next = buffer.sbumpc(); next != kEnd; next = buffer.sbumpc()) {
    if (next == '\n') return true;
    if (next == '\r') {
      if (buffer.sgetc() == '\n') buffer.sbumpc();
      return true;
    }
    line += static_cast<char>(next);
    if (line.size() > kLongestLine) return true;
  }
  stream.setstate(std::ios::eofbit);
  return !line.empty();
}

}  // namespace sightline
