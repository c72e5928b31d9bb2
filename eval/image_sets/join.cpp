// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/image_sets/join.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>

#include <fmt/format.h>

#include "eval/image_sets/truth.h"
#include "eval/output/output_folder.h"
#include "eval/work/interrupt.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

void write_all(const fs::path& folder, const std::vector<SetFile>& files) {
  for (const SetFile& file : files) {
    std::error_code error;  // that of the file will say it
    fs::create_directories((folder / file.path).parent_path(), error);
    write_file(folder / file.path, file.bytes);
  }
}

// The truth of an image, with what its files tell; none where it could not be made.
std::optional<Json> whole_truth(const fs::path& folder, const SetPlan& plan, int64_t index) {
  stop_if_interrupted();
  std::optional<Json> truth = read_truth(folder, plan, index);
  if (!truth) {
    throw InputError(fmt::format("{}: cannot be read as a truth; remove it and --resume",
                                 (folder / truth_path(plan, index)).string()));
  }
  if (truth->contains("failure")) return std::nullopt;
  if (!add_told_by_files(folder, plan, *truth)) {
    throw InputError(
        fmt::format("{}: the files of this image are missing or torn; remove it and --resume",
                    (folder / truth_path(plan, index)).string()));
  }
  return truth;
}

}  // namespace

bool add_told_by_files(const fs::path& folder, const SetPlan& plan, Json& truth) {
  if (plan.format->told_by_files == nullptr) return true;
  Json& told = truth[std::string(kToldByFiles)];
  told = plan.format->told_by_files(plan, folder, truth);
  return !told.is_null();
}

std::vector<Json> read_truths(const fs::path& folder, const SetPlan& plan, int64_t chunk,
                              int jobs) {
  const int64_t begin = chunk * plan.chunk;
  std::vector<std::optional<Json>> all(
      static_cast<size_t>(std::min(plan.count, begin + plan.chunk) - begin));
  std::vector<std::exception_ptr> errors(all.size());
  std::atomic<size_t> first_bad = all.size();  // nothing behind it is asked for any more
  const size_t readers = std::clamp<size_t>(static_cast<size_t>(jobs), 1, all.size());
  const auto read_share = [&](size_t first) {
    for (size_t i = first; i < first_bad; i += readers) {
      try {
        all[i] = whole_truth(folder, plan, begin + static_cast<int64_t>(i));
      } catch (...) {
        errors[i] = std::current_exception();
        for (size_t before = first_bad; i < before;) {
          if (first_bad.compare_exchange_weak(before, i)) break;
        }
      }
    }
  };
  {
    std::vector<std::jthread> others;
    for (size_t i = 1; i < readers; ++i) others.emplace_back(read_share, i);
    read_share(0);
  }
  if (first_bad < all.size()) std::rethrow_exception(errors[first_bad]);
  std::vector<Json> truths;
  for (std::optional<Json>& truth : all) {
    if (truth) truths.push_back(std::move(*truth));
  }
  return truths;
}

std::string list_lines(const SetPlan& plan, std::span<const Json> truths, bool is_first) {
  std::string lines;
  for (const Json& truth : truths) {
    for (const Json& element : plan.format->list_elements(plan, truth)) {
      lines += fmt::format("{}\n  {}", is_first ? "" : ",", element.dump());
      is_first = false;
    }
  }
  return lines;
}

int64_t join_set(const SetPlan& plan, const fs::path& folder, int jobs) {
  int64_t images = 0;
  std::string list(kListBegin);
  bool is_first = true;
  write_all(folder, plan.format->set_files(plan));
  for (int64_t chunk = 0; chunk < plan.chunk_count(); ++chunk) {
    const std::vector<Json> truths = read_truths(folder, plan, chunk, jobs);
    images += static_cast<int64_t>(truths.size());
    write_all(folder, plan.format->chunk_files(plan, chunk, truths));
    const std::string lines = list_lines(plan, truths, is_first);
    is_first = is_first && lines.empty();
    list += lines;
  }
  list += kListEnd;
  write_file(folder / plan.format->list_path, list);
  return plan.count - images;
}

}  // namespace sightline
