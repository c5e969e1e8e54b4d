#include "roomwise/home/home.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "roomwise/base/put_in_place.h"
#include "roomwise/base/shell_word.h"
#include "roomwise/home/content_digest.h"
#include "roomwise/home/page_checksums.h"
#include "roomwise/home/schema.h"
#include "roomwise/home/stored_values.h"

namespace roomwise::home {
namespace {

// A file beside the home that holds a part of it that is not in the one file yet.
bool has_part_beside(const std::string& file, const char* suffix) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file + suffix, error);
  return !error && size > 0;
}

Expected<void> check_version(const std::string& file, int version) {
  if (version <= kHomeVersion) return {};
  return fail(
      "{}: was written by another Roomwise (home version {}; this one reads version {}); update "
      "Roomwise, or map the recordings again into a new home",
      file, version, kHomeVersion);
}

// Refuses what is no home by its first bytes, so that SQLite need not touch it.
Expected<void> check_header(const Database& database) {
  const std::string& file = database.file();
  ROOMWISE_TRY(const DatabaseHeader header, database.header());
  if (header.file_bytes == 0) {
    const auto lock = WriterLock::take(file);
    if (!lock && lock.error().code == ErrorCode::kRefused) return Unexpected(lock.error());
    return fail(
        "{}: is empty, perhaps left by a run that was stopped as it began; delete it and "
        "make the home anew",
        file);
  }
  if (!header.is_sqlite) {
    return fail(
        "{}: is no home file (not a SQLite database); give a file that 'roomwise map' wrote", file);
  }
  if (header.application_id != kApplicationId) {
    return fail(
        "{}: is a SQLite database, but not a home of Roomwise; give a file that 'roomwise "
        "map' wrote",
        file);
  }
  if (header.reserved_bytes != kChecksumBytes) {
    return fail(
        "{}: is damaged, or was made before this version: its pages have no checksums; put back a "
        "copy of it, or map its recordings anew",
        file);
  }
  ROOMWISE_RETURN_IF_ERROR(check_version(file, header.user_version));
  // A write-ahead log or a journal may make it whole.
  if (header.file_bytes < header.expected_bytes && !has_part_beside(file, "-wal") &&
      !has_part_beside(file, "-journal")) {
    return fail("{}: is truncated: {} of {} bytes are there; copy it again", file,
                header.file_bytes, header.expected_bytes);
  }
  return {};
}

// Once SQLite has read it, write-ahead log and all.
Expected<void> check_again(const Database& database) {
  ROOMWISE_TRY(const std::int64_t application, database.get<std::int64_t>("PRAGMA application_id"));
  ROOMWISE_TRY(const int version, database.get<int>("PRAGMA user_version"));
  if (application != kApplicationId || version < 1) {
    return fail("{}: is no home, or was never completed; delete it and make the home anew",
                database.file());
  }
  return check_version(database.file(), version);
}

// Runs one of SQLite's checks, which answers with 'ok' or with lines of complaint.
Expected<void> run_check(const Database& database, const std::string& pragma) {
  ROOMWISE_TRY(const std::string answer, database.get<std::string>(pragma));
  if (answer == "ok") return {};
  return fail(
      "{}: is damaged ({}); put back a copy of it, or see what is left of it with: roomwise "
      "check {}",
      database.file(), answer.substr(answer.rfind('\n') + 1), shell_word(database.file()));
}

Expected<void> check_all_but_images(const Database& database) {
  ROOMWISE_TRY(const auto checks,
               collect<std::vector<std::string>>(
                   database,
                   "SELECT printf('PRAGMA quick_check(\"%w\")', name) FROM sqlite_schema "
                   "WHERE type = 'table' AND name NOT IN ('keyframe_images', "
                   "'keyframe_depth_views')",
                   [](const Statement& row) { return row.column<std::string>(0); }));
  for (const std::string& check : checks) ROOMWISE_RETURN_IF_ERROR(run_check(database, check));
  return {};
}

Expected<void> configure(Database& database) {
  return database.run_script(
      "PRAGMA foreign_keys = ON;"
      "PRAGMA trusted_schema = OFF;"    // a home from elsewhere cannot make SQLite run functions
      "PRAGMA cell_size_check = ON;");  // finds damage sooner
}

// A write-ahead log while the home is written, so that others can read it meanwhile.
Expected<void> begin_writing(Database& database) {
  ROOMWISE_TRY(const std::string mode, database.get<std::string>("PRAGMA journal_mode = WAL"));
  if (mode != "wal") {
    return fail(
        "{}: its disk cannot hold a home that is written (no write-ahead log); put it on a "
        "local disk",
        database.file());
  }
  return database.run_script(
      "PRAGMA synchronous = FULL;"    // a commit waits for the disk, so a power cut takes nothing
      "PRAGMA secure_delete = ON;");  // what is removed is overwritten
}

// Puts the write-ahead log into the one file, which then needs no other file and can be read from a
// medium that cannot be written. Where a reader holds it, the log stays and is still part of the
// home.
void end_writing(Database& database) {
  sqlite3_busy_timeout(database.handle(), 0);
  if (!database.run("PRAGMA journal_mode = DELETE")) {
    (void)database.run("PRAGMA wal_checkpoint(TRUNCATE)");
  }
}

void set_checkpoint_on_close(Database& database, bool on) {
  sqlite3_db_config(database.handle(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, on ? 0 : 1, nullptr);
}

Expected<void> make_empty_file(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file < 0 && errno == EEXIST) {
    return fail("{}: exists already; choose another name, or go on with it by --resume",
                path.string());
  }
  if (file < 0) {
    return fail("{}: cannot be made: {}; check its folder", path.string(), std::strerror(errno));
  }
  ::close(file);
  return {};
}

// A writer that was killed in the middle of a change leaves a journal that takes it back. Who
// writes does that on opening; so does who may write, before reading.
Expected<void> take_back_what_was_begun(const std::filesystem::path& path) {
  ROOMWISE_TRY(const WriterLock lock, WriterLock::take(path));
  ROOMWISE_TRY(const Database database, Database::open(path, Database::Access::kReadWrite));
  return database.get<int>("PRAGMA user_version").map([](int) {});
}

Expected<Database> open_for_reading(const std::filesystem::path& path) {
  ROOMWISE_TRY(Database database, Database::open(path, Database::Access::kReadOnly));
  ROOMWISE_RETURN_IF_ERROR(check_header(database));
  auto version = database.get<int>("PRAGMA user_version");
  if (version) return database;
  // A home that was not closed wants files beside it, which a read-only medium cannot make.
  const int code = sqlite3_errcode(database.handle()) & 0xff;
  if (code != SQLITE_CANTOPEN && code != SQLITE_READONLY) {
    return Unexpected(std::move(version).error());
  }
  if (has_part_beside(database.file(), "-journal") && take_back_what_was_begun(path)) {
    return Database::open(path, Database::Access::kReadOnly);
  }
  for (const char* suffix : {"-wal", "-journal"}) {
    if (!has_part_beside(database.file(), suffix)) continue;
    return fail(
        "{0}: was not closed, and its folder cannot be written; copy {0} and {0}{1} to a folder "
        "that can",
        database.file(), suffix);
  }
  return Database::open(path, Database::Access::kImmutable);
}

}  // namespace

Expected<Home> Home::create(const std::filesystem::path& path, const OpenOptions& options) {
  // Before the file is there: who finds it empty knows by the lock that it is in the making.
  auto lock = WriterLock::take(path);
  if (!lock && lock.error().code == ErrorCode::kRefused) return Unexpected(lock.error());
  ROOMWISE_RETURN_IF_ERROR(make_empty_file(path));
  const auto make = [&]() -> Expected<Home> {
    if (!lock) return Unexpected(lock.error());
    ROOMWISE_TRY(Database database, Database::open(path, Database::Access::kReadWrite));
    ROOMWISE_RETURN_IF_ERROR(keep_checksums(database.handle(), database.file()));
    ROOMWISE_RETURN_IF_ERROR(configure(database));
    ROOMWISE_RETURN_IF_ERROR(create_tables(database));
    ROOMWISE_RETURN_IF_ERROR(begin_writing(database));
    Home home(*std::move(lock), std::move(database));
    if (options.passphrase) {
      ROOMWISE_RETURN_IF_ERROR(
          home.begin_protection(*options.passphrase, ProtectionState::kEncrypted, {}));
    }
    return home;
  };
  Expected<Home> home = make();
  if (!home) ::unlink(path.c_str());
  return home;
}

Expected<Home> Home::open(const std::filesystem::path& path, const OpenOptions& options) {
  ROOMWISE_TRY(Database database, Database::open(path, Database::Access::kReadWrite));
  ROOMWISE_RETURN_IF_ERROR(check_header(database));
  ROOMWISE_TRY(WriterLock lock, WriterLock::take(path));
  // Until all is found well, closing must not carry a log into the file.
  set_checkpoint_on_close(database, false);
  ROOMWISE_RETURN_IF_ERROR(configure(database));
  ROOMWISE_RETURN_IF_ERROR(check_again(database));
  ROOMWISE_RETURN_IF_ERROR(check_all_but_images(database));
  ROOMWISE_RETURN_IF_ERROR(check_tables(database));
  set_checkpoint_on_close(database, true);
  ROOMWISE_RETURN_IF_ERROR(begin_writing(database));
  ROOMWISE_RETURN_IF_ERROR(add_later_tables(database));
  return with_protection_state(Home(std::move(lock), std::move(database)), options);
}

Expected<Home> Home::open_read_only(const std::filesystem::path& path, const OpenOptions& options) {
  ROOMWISE_TRY(Database database, open_for_reading(path));
  ROOMWISE_RETURN_IF_ERROR(configure(database));
  ROOMWISE_RETURN_IF_ERROR(check_again(database));
  ROOMWISE_RETURN_IF_ERROR(check_tables(database));
  return with_protection_state(Home(std::nullopt, std::move(database)), options);
}

Expected<Home> Home::another_reader() const {
  ROOMWISE_TRY(Database database, open_for_reading(file()));
  ROOMWISE_RETURN_IF_ERROR(configure(database));
  Home reader(std::nullopt, std::move(database));
  reader.is_protected_ = is_protected_;
  reader.cipher_ = cipher_;
  reader.protection_state_ = protection_state_;
  return reader;
}

Home::~Home() {
  if (lock_ && database_.handle() != nullptr) end_writing(database_);
}

Expected<void> Home::atomically(const std::function<Expected<void>()>& work) {
  ROOMWISE_TRY(Transaction transaction, Transaction::begin(database_));
  ROOMWISE_RETURN_IF_ERROR(work());
  return transaction.commit();
}

Expected<void> Home::put_setting(std::string_view key, std::string_view value) {
  if (key == kProtectionSetting) {
    return fail("{}: '{}' is no setting of a map; use protect()", file(), key);
  }
  if (key == kErasingSetting) {
    return fail("{}: '{}' is no setting of a map; use owe_erasing()", file(), key);
  }
  return database_.put("settings (key, value)", key, value);
}

Expected<std::map<std::string, std::string>> Home::settings() const {
  return collect<std::map<std::string, std::string>>(
      database_, "SELECT key, value FROM settings WHERE key NOT IN (?, ?)",
      [](const Statement& row) {
        return std::pair(row.column<std::string>(0), row.column<std::string>(1));
      },
      kProtectionSetting, kErasingSetting);
}

Expected<void> Home::add_stage_timings(const std::map<std::string, StageClock::Stage>& stages) {
  return atomically([&]() -> Expected<void> {
    for (const auto& [name, stage] : stages) {
      ROOMWISE_RETURN_IF_ERROR(database_.run(
          "INSERT INTO stage_timings (stage, calls, wall_s, cpu_s) VALUES (?, ?, ?, ?) "
          "ON CONFLICT (stage) DO UPDATE SET calls = calls + excluded.calls, "
          "wall_s = wall_s + excluded.wall_s, cpu_s = cpu_s + excluded.cpu_s",
          name, stage.calls, stage.wall_s, stage.cpu_s));
    }
    return {};
  });
}

Expected<std::map<std::string, StageClock::Stage>> Home::stage_timings() const {
  return collect<std::map<std::string, StageClock::Stage>>(
      database_, "SELECT stage, calls, wall_s, cpu_s FROM stage_timings", [](const Statement& row) {
        return std::pair(row.column<std::string>(0),
                         StageClock::Stage{.calls = row.column<std::uint64_t>(1),
                                           .wall_s = row.column<double>(2),
                                           .cpu_s = row.column<double>(3)});
      });
}

Expected<std::string> Home::content_digest() const {
  if (is_locked()) return Unexpected(locked_error());
  return home::content_digest(database_, [this](KeyframeId id, PictureKind kind, Bytes stored) {
    return decrypt_if_sealed(id, kind, std::move(stored));
  });
}

Expected<void> Home::copy_to(const std::filesystem::path& path) const {
  std::filesystem::path partial = path;
  partial += ".part";
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored)) {
    return fail("{}: exists already; choose another name", path.string());
  }
  std::filesystem::remove(partial, ignored);  // of a copy that was stopped
  const auto copy = [&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(make_empty_file(partial));
    {
      ROOMWISE_TRY(Database target, Database::open(partial, Database::Access::kReadWrite));
      ROOMWISE_RETURN_IF_ERROR(keep_checksums(target.handle(), target.file()));
      // The first page is copied last; with it on the disk before, the others get their checksums.
      ROOMWISE_RETURN_IF_ERROR(target.run_script("PRAGMA user_version = 1"));
      ROOMWISE_RETURN_IF_ERROR(database_.copy_to(target));
      // The copy of a home that is written would want a log beside it.
      ROOMWISE_RETURN_IF_ERROR(target.run("PRAGMA journal_mode = DELETE"));
    }
    ROOMWISE_TRY(const Home copied, open_read_only(partial));
    return copied.verify();
  };
  Expected<void> copied = copy();
  if (copied) copied = put_in_place(partial, path);
  if (copied) return {};
  std::filesystem::remove(partial, ignored);
  return copied;
}

Expected<void> Home::owe_erasing() {
  return database_.put("settings (key, value)", kErasingSetting, std::string_view("1"));
}

Expected<bool> Home::owes_erasing() const {
  return database_.get<bool>("SELECT EXISTS (SELECT 1 FROM settings WHERE key = ?)",
                             kErasingSetting);
}

Expected<void> Home::erase_removed() {
  ROOMWISE_RETURN_IF_ERROR(database_.run("VACUUM"));
  // The pages as they were lie in the log and in the main file until both are written over.
  ROOMWISE_TRY(const auto busy, database_.get<bool>("PRAGMA wal_checkpoint(TRUNCATE)"));
  if (busy) {
    return fail("{}: another program reads the home; close it, then do this again", file());
  }
  return database_.run("DELETE FROM settings WHERE key = ?", kErasingSetting);
}

}  // namespace roomwise::home
