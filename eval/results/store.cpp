// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/results/store.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string_view>
#include <utility>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "eval/output/output_error.h"
#include "eval/results/store_rows.h"
#include "eval/results/store_schema.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

constexpr int kApplicationId = 0x53474854;  // "SGHT"
// Programs of version 4 know columns by their place, and read no other version. Since version 5
// columns are known by their names: more of them make no new version.
constexpr int kOldestSchema = 4;
constexpr int kSchemaVersion = 5;
constexpr const char* kMetaSchema =
    "CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID";

// SQLite's header stays out of sight as SQLiteCpp does.
constexpr int kSqliteFull = 13, kSqliteNotADatabase = 26;
constexpr int kSqliteCannotWrite = 10 + (3 << 8);  // extended: such as beyond a quota

// For another process that looks into the file.
constexpr int kMostWaitMs = 30'000;

// Runs `action`; what SQLite says went wrong becomes an InputError about the file.
template <typename Action>
auto on_file(const std::filesystem::path& file, const char* what_failed, const Action& action) {
  try {
    return action();
  } catch (const SQLite::Exception& error) {
    if (error.getErrorCode() == kSqliteNotADatabase) {
      throw InputError(fmt::format("{}: not an SQLite file", file.string()));
    }
    const std::string text = fmt::format("{}: {} ({})", file.string(), what_failed, error.what());
    if (error.getErrorCode() == kSqliteFull || error.getExtendedErrorCode() == kSqliteCannotWrite) {
      throw OutputError(text);
    }
    throw InputError(text);
  } catch (const UnknownName& error) {
    throw InputError(fmt::format("{}: {} ({})", file.string(), what_failed, error.what()));
  } catch (const nlohmann::json::exception& error) {
    throw InputError(fmt::format("{}: {} ({})", file.string(), what_failed, error.what()));
  }
}

// What SQLite puts beside a file that it writes, and takes for its own when it opens the file.
constexpr std::array kJournalEndings = {"-journal", "-wal", "-shm"};

// Before a new file: what lies there is of none that is there.
void remove_journals(const std::filesystem::path& file) {
  std::error_code ignored;
  for (const char* ending : kJournalEndings) {
    std::filesystem::remove(file.string() + ending, ignored);
  }
}

// Makes an empty file, which is an empty SQLite database.
void make_empty_file(const std::filesystem::path& file) {
  std::error_code ignored;
  std::filesystem::remove(file, ignored);  // what a killed writer left, or a link
  std::FILE* const handle = std::fopen(file.c_str(), "wx");
  if (handle == nullptr) {
    throw InputError(fmt::format("{}: cannot be created ({})", file.string(), strerror(errno)));
  }
  std::fclose(handle);
}

// A journal of several databases ends with the path of a file that SQLite reads, and removes, when
// it rolls the journal back (https://sqlite.org/fileformat2.html, "the super-journal"): any file at
// all, in a folder of others. Runs of ours change one database at a time and leave none. Nor is a
// pipe waited for.
void require_own_journals(const std::filesystem::path& file) {
  std::error_code error;
  const std::string real = std::filesystem::canonical(file, error).string();
  for (const char* ending : kJournalEndings) {
    const std::filesystem::path beside = real + ending;
    const auto type = std::filesystem::symlink_status(beside, error).type();
    if (type == std::filesystem::file_type::not_found) continue;
    if (type == std::filesystem::file_type::regular) continue;
    throw InputError(fmt::format("{}: must be a file, or not be there", beside.string()));
  }
  constexpr std::string_view kMagic = "\xd9\xd5\x05\xf9\x20\xa1\x63\xd7";
  std::ifstream journal(real + "-journal", std::ios::binary);
  std::string end(kMagic.size(), '\0');
  journal.seekg(-static_cast<std::streamoff>(end.size()), std::ios::end);
  if (!journal.read(end.data(), static_cast<std::streamsize>(end.size())) || end != kMagic) return;
  throw InputError(
      fmt::format("{}-journal: is of several databases, which no run leaves, and names a file that "
                  "SQLite would remove: to read the run, remove the journal instead",
                  real));
}

// SQLite writes even to a file that is only read: it rolls back, and ends logs. So what a link may
// lead to is looked at before: a database begins with these words, and has its application's
// number, with the highest byte first, at 68. An empty file is an empty database.
void require_own_file(const std::filesystem::path& file) {
  constexpr std::string_view kBeginning("SQLite format 3\0", 16);
  constexpr size_t kApplicationIdAt = 68, kReadBytes = kApplicationIdAt + 4;
  std::string head(kReadBytes, '\0');
  std::ifstream stream(file, std::ios::binary);
  if (!stream.is_open()) return;  // SQLite says why not
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  if (stream.gcount() > 0 && !head.starts_with(kBeginning)) {
    throw InputError(fmt::format("{}: not an SQLite file", file.string()));
  }
  int64_t application_id = 0;
  for (size_t i = kApplicationIdAt; i < kReadBytes; ++i) {
    application_id = 256 * application_id + static_cast<unsigned char>(head[i]);
  }
  if (application_id == kApplicationId) return;
  throw InputError(fmt::format("{}: an SQLite file, but not one of sightline's", file.string()));
}

void write_schema(SQLite::Database& database, const std::map<std::string, std::string>& meta) {
  SQLite::Transaction transaction(database);
  database.exec(kMetaSchema);
  create_tables(database);
  database.exec(fmt::format("PRAGMA application_id = {}", kApplicationId));
  database.exec(fmt::format("PRAGMA user_version = {}", kSchemaVersion));
  SQLite::Statement insert(database, "INSERT INTO meta VALUES (?, ?)");
  for (const auto& [key, value] : meta) {
    insert.bind(1, key);
    insert.bind(2, value);
    insert.exec();
    insert.reset();
  }
  transaction.commit();
}

void check_schema(SQLite::Database& database, const std::filesystem::path& file) {
  const int version = database.execAndGet("PRAGMA user_version").getInt();
  if (version < kOldestSchema || version > kSchemaVersion) {
    throw InputError(fmt::format("{}: results of version {}; this program reads versions {} to {}",
                                 file.string(), version, kOldestSchema, kSchemaVersion));
  }
  const std::string problem = why_not_readable(database);
  if (problem.empty()) return;
  throw InputError(fmt::format("{}: not a store of trials ({})", file.string(), problem));
}

// Before anything is added: nothing of it may be lost for want of a column.
void bring_up_to_date(SQLite::Database& database) {
  add_what_is_lacking(database);
  if (database.execAndGet("PRAGMA user_version").getInt() == kSchemaVersion) return;
  database.exec(fmt::format("PRAGMA user_version = {}", kSchemaVersion));
}

}  // namespace

struct Store::Impl {
  explicit Impl(std::filesystem::path path)
      : file(beside_own_journals(std::move(path))),
        database(file.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_NOMUTEX, kMostWaitMs) {
    database.exec("PRAGMA foreign_keys = ON");
    database.exec("PRAGMA trusted_schema = OFF");  // a file of others names no functions to call
  }

  static std::filesystem::path beside_own_journals(std::filesystem::path file) {
    require_own_journals(file);
    return file;
  }

  // Adds in one transaction what `write` writes. The default journal is named because the faster
  // one (WAL) breaks on network file systems.
  template <typename Write>
  void add(const Write& write) {
    if (std::filesystem::is_symlink(file)) {
      throw InputError(
          fmt::format("{}: is a link, which nothing is written through", file.string()));
    }
    database.exec("PRAGMA main.journal_mode = DELETE");
    SQLite::Transaction transaction(database);
    bring_up_to_date(database);
    write();
    transaction.commit();
  }

  std::filesystem::path file;
  SQLite::Database database;
};

Store::Store(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Store::Store(Store&&) noexcept = default;
Store& Store::operator=(Store&&) noexcept = default;
Store::~Store() = default;

Store Store::create(const std::filesystem::path& file,
                    const std::map<std::string, std::string>& meta) {
  if (std::filesystem::exists(file)) {
    throw InputError(fmt::format("{}: exists already; name a new file", file.string()));
  }
  const std::filesystem::path partial = file.string() + ".partial";
  std::error_code error;
  remove_journals(partial);
  remove_journals(file);
  make_empty_file(partial);
  return on_file(file, "cannot be written", [&] {
    {
      Impl impl(partial);
      write_schema(impl.database, meta);
    }
    std::filesystem::rename(partial, file, error);
    if (error) {
      throw InputError(fmt::format("{}: cannot be created ({})", file.string(), error.message()));
    }
    return Store(std::make_unique<Impl>(file));
  });
}

Store Store::open(const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file)) {
    const bool exists = std::filesystem::exists(file);
    throw InputError(fmt::format("{}: {}", file.string(), exists ? "not a file" : "no such file"));
  }
  return on_file(file, "cannot be read", [&] {
    require_own_file(file);
    auto impl = std::make_unique<Impl>(file);
    check_schema(impl->database, file);
    return Store(std::move(impl));
  });
}

void Store::add(std::span<const TrialRecord> trials) {
  on_file(impl_->file, "cannot be written", [&] {
    impl_->add([&] { write_trials(impl_->database, trials, impl_->file.string()); });
  });
}

void Store::add_all_of(const std::filesystem::path& file) {
  Store::open(file);  // says what is wrong with it, and rolls back what a killed writer left
  on_file(impl_->file, "cannot be written", [&] {
    SQLite::Database& database = impl_->database;
    SQLite::Statement attach(database, "ATTACH DATABASE ? AS other");
    attach.bind(1, file.string());
    attach.exec();
    impl_->add([&] { copy_trials_of_other(database); });
    database.exec("DETACH DATABASE other");
  });
}

std::vector<TrialRecord> Store::trials() const {
  std::vector<TrialRecord> records;
  for_each([&records](const TrialRecord& record) { records.push_back(record); });
  return records;
}

void Store::for_each(const TrialVisitor& visit) const {
  const NextTrial next = reader();
  for (auto trial = next(); trial; trial = next()) visit(*trial);
}

NextTrial Store::reader() const {
  const NextTrial next =
      on_file(impl_->file, "cannot be read", [&] { return trial_reader(impl_->database); });
  return [this, next] { return on_file(impl_->file, "cannot be read", next); };
}

int64_t Store::size() const {
  return on_file(impl_->file, "cannot be read", [&]() -> int64_t {
    return impl_->database.execAndGet("SELECT count(*) FROM trials").getInt64();
  });
}

std::vector<bool> Store::held(int64_t end) const {
  return on_file(impl_->file, "cannot be read", [&] {
    std::vector<bool> held(static_cast<size_t>(end));
    SQLite::Statement select(impl_->database, "SELECT trial FROM trials");
    while (select.executeStep()) {
      const int64_t trial = select.getColumn(0).getInt64();
      if (trial >= 0 && trial < end) held[static_cast<size_t>(trial)] = true;
    }
    return held;
  });
}

std::optional<int64_t> Store::first_trial() const {
  return on_file(impl_->file, "cannot be read", [&]() -> std::optional<int64_t> {
    SQLite::Statement select(impl_->database, "SELECT min(trial) FROM trials");
    if (!select.executeStep() || select.getColumn(0).isNull()) return std::nullopt;
    return select.getColumn(0).getInt64();
  });
}

bool Store::holds(int64_t trial) const {
  return on_file(impl_->file, "cannot be read", [&] {
    SQLite::Statement select(impl_->database, "SELECT 1 FROM trials WHERE trial = ?");
    select.bind(1, trial);
    return select.executeStep();
  });
}

const std::filesystem::path& Store::file() const {
  return impl_->file;
}

std::map<std::string, std::string> Store::meta() const {
  return on_file(impl_->file, "cannot be read", [&] {
    std::map<std::string, std::string> meta;
    SQLite::Statement select(impl_->database, "SELECT key, value FROM meta");
    while (select.executeStep())
      meta[select.getColumn(0).getString()] = select.getColumn(1).getString();
    return meta;
  });
}

}  // namespace sightline
