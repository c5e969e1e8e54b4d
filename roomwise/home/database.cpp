#include "roomwise/home/database.h"

#include <algorithm>
#include <cstring>

#include "roomwise/base/file.h"
#include "roomwise/base/shell_word.h"
#include "roomwise/home/page_checksums.h"

namespace roomwise::home {
namespace {

// How long a statement waits for another process that writes, before it gives up.
constexpr int kBusyTimeoutMs = 2000;

std::uint32_t big_endian_32(const unsigned char* bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 |
         std::uint32_t{bytes[2]} << 8 | std::uint32_t{bytes[3]};
}

// The file as a URI, since that is how SQLite is told that a file is immutable.
std::string uri(const std::filesystem::path& path, bool immutable) {
  std::string result = "file:";
  for (const char c : std::filesystem::absolute(path).string()) {
    if (c == '%' || c == '?' || c == '#') {
      result += fmt::format("%{:02X}", static_cast<unsigned>(c));
    } else {
      result += c;
    }
  }
  return immutable ? result + "?immutable=1" : result;
}

}  // namespace

Error describe_error(sqlite3* connection, const std::string& file) {
  const int code = sqlite3_extended_errcode(connection);
  const int system_error = sqlite3_system_errno(connection);
  const std::string detail =
      system_error != 0 ? std::strerror(system_error) : sqlite3_errmsg(connection);
  if (code == kSqliteChecksumError) {
    return {
        fmt::format("{}: is damaged (a page differs from its checksum); put back a copy of it, or "
                    "see what is left of it with: roomwise check {}",
                    file, shell_word(file)),
        ErrorCode::kDamaged};
  }
  switch (code & 0xff) {
    case SQLITE_FULL:
      return {fmt::format("{}: the disk is full; free some space and run again, what was stored "
                          "before is kept",
                          file),
              ErrorCode::kDiskFull};
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {fmt::format("{}: in use by another process; end that one and try again", file)};
    case SQLITE_NOTADB:
      return {fmt::format("{}: is not a database, or its first bytes are damaged; give a home file "
                          "that 'roomwise map' wrote",
                          file),
              ErrorCode::kDamaged};
    case SQLITE_CORRUPT:
      return {fmt::format("{}: is damaged ({}); put back a copy of it, or see what is left of it "
                          "with: roomwise check {}",
                          file, sqlite3_errmsg(connection), shell_word(file)),
              ErrorCode::kDamaged};
    case SQLITE_READONLY:
      return {
          fmt::format("{}: cannot be written; it was opened for reading only, or the file or "
                      "its folder lack the permission",
                      file)};
    case SQLITE_PERM:
    case SQLITE_AUTH:
    case SQLITE_CANTOPEN:
      return {
          fmt::format("{}: cannot be opened: {}; check that it exists and that you may read "
                      "and write it and its folder",
                      file, detail)};
    case SQLITE_IOERR:
      return {fmt::format("{}: the disk cannot be read or written: {}; check the disk and its free "
                          "space, what was stored before is kept",
                          file, detail),
              code_of_write_error(system_error)};
    case SQLITE_NOMEM:
      return {fmt::format("{}: not enough memory; end other programs and try again", file)};
    case SQLITE_CONSTRAINT:
      return {fmt::format("{}: refused, because it contradicts what is stored ({})", file,
                          sqlite3_errmsg(connection))};
    default:
      return {fmt::format("{}: {}", file, sqlite3_errmsg(connection))};
  }
}

Expected<bool> Statement::step() {
  if (bind_result_ != SQLITE_OK) {
    return fail("{}: a value cannot be stored: {}", file_, sqlite3_errstr(bind_result_));
  }
  const int result = sqlite3_step(statement_.get());
  if (result == SQLITE_ROW) return true;
  if (result == SQLITE_DONE) return false;
  return Unexpected(describe_error(sqlite3_db_handle(statement_.get()), file_));
}

void Statement::bind_integer(std::int64_t value) {
  note(sqlite3_bind_int64(statement_.get(), parameters_ + 1, value));
}

void Statement::bind_real(double value) {
  note(sqlite3_bind_double(statement_.get(), parameters_ + 1, value));
}

void Statement::bind_text(std::string_view value) {
  // A null pointer would bind NULL.
  const char* data = value.data() == nullptr ? "" : value.data();
  note(sqlite3_bind_text64(statement_.get(), parameters_ + 1, data, value.size(), SQLITE_TRANSIENT,
                           SQLITE_UTF8));
}

void Statement::bind_blob(std::span<const std::uint8_t> value) {
  const void* data = value.empty() ? static_cast<const void*>("") : value.data();
  note(
      sqlite3_bind_blob64(statement_.get(), parameters_ + 1, data, value.size(), SQLITE_TRANSIENT));
}

void Statement::bind_null() {
  note(sqlite3_bind_null(statement_.get(), parameters_ + 1));
}

void Statement::note(int result) {
  ++parameters_;
  if (bind_result_ == SQLITE_OK) bind_result_ = result;
}

std::string Statement::text(int index) const {
  const auto* data = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), index));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), index));
  return data == nullptr ? std::string() : std::string(data, size);
}

Bytes Statement::blob(int index) const {
  const auto* data = static_cast<const std::uint8_t*>(sqlite3_column_blob(statement_.get(), index));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), index));
  return data == nullptr ? Bytes() : Bytes(data, data + size);
}

Expected<Database> Database::open(const std::filesystem::path& path, Access access) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    return fail("{}: is a folder; expected a home file", path.string());
  }
  if (!std::filesystem::exists(path, ignored)) return fail("{}: no such file", path.string());
  if (!std::filesystem::is_regular_file(path, ignored)) {
    return fail("{}: is a pipe or a device; expected a home file", path.string());
  }
  if (checksum_vfs() == nullptr) return fail("SQLite cannot be made ready on this machine");
  const int flags = access == Access::kReadWrite ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READONLY;
  sqlite3* connection = nullptr;
  const int result =
      sqlite3_open_v2(uri(path, access == Access::kImmutable).c_str(), &connection,
                      flags | SQLITE_OPEN_URI | SQLITE_OPEN_EXRESCODE, checksum_vfs());
  Database database(connection, path.string());
  if (result != SQLITE_OK) return Unexpected(describe_error(connection, database.file_));
  // SQLite falls back to reading where it may not write.
  if (access == Access::kReadWrite && sqlite3_db_readonly(connection, "main") == 1) {
    return fail("{}: you may not write it; change its permissions", path.string());
  }
  sqlite3_busy_timeout(connection, kBusyTimeoutMs);
  return database;
}

Expected<Database> Database::in_memory() {
  sqlite3* connection = nullptr;
  const int result =
      sqlite3_open_v2(":memory:", &connection, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
  Database database(connection, "a database in memory");
  if (result != SQLITE_OK) return Unexpected(describe_error(connection, database.file_));
  return database;
}

Expected<DatabaseHeader> Database::header() const {
  // Through SQLite's own descriptor: closing another one on the same file would drop the locks that
  // this process holds on it (POSIX).
  sqlite3_file* file = nullptr;
  sqlite3_file_control(handle(), "main", SQLITE_FCNTL_FILE_POINTER, &file);
  sqlite3_int64 size = 0;
  if (file == nullptr || file->pMethods == nullptr ||
      file->pMethods->xFileSize(file, &size) != SQLITE_OK) {
    return fail("{}: cannot be read", file_);
  }
  constexpr int kHeaderBytes = 100;
  DatabaseHeader header;
  header.file_bytes = static_cast<std::uint64_t>(size);
  if (size < kHeaderBytes) return header;
  std::array<unsigned char, kHeaderBytes> bytes{};
  if (file->pMethods->xRead(file, bytes.data(), kHeaderBytes, 0) != SQLITE_OK) {
    return fail("{}: cannot be read: {}", file_, std::strerror(sqlite3_system_errno(handle())));
  }
  // The layout: https://www.sqlite.org/fileformat2.html, section 1.3.
  header.is_sqlite = std::memcmp(bytes.data(), "SQLite format 3", 16) == 0;
  header.user_version = static_cast<std::int32_t>(big_endian_32(&bytes[60]));
  header.reserved_bytes = bytes[20];
  header.application_id = big_endian_32(&bytes[68]);
  const std::uint64_t page_size = std::uint64_t{bytes[16]} << 8 | std::uint64_t{bytes[17]};
  const bool page_count_is_valid = big_endian_32(&bytes[24]) == big_endian_32(&bytes[92]);
  if (page_count_is_valid) {
    header.expected_bytes = (page_size == 1 ? 65536 : page_size) * big_endian_32(&bytes[28]);
  }
  return header;
}

Expected<void> Database::run_script(const std::string& sql) {
  if (sqlite3_exec(handle(), sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK) return {};
  return Unexpected(describe_error(handle(), file_));
}

Expected<void> Database::copy_to(Database& copy) const {
  struct Finisher {
    void operator()(sqlite3_backup* backup) const { sqlite3_backup_finish(backup); }
  };
  std::unique_ptr<sqlite3_backup, Finisher> backup(
      sqlite3_backup_init(copy.handle(), "main", handle(), "main"));
  if (!backup) return Unexpected(describe_error(copy.handle(), copy.file_));
  const int result = sqlite3_backup_step(backup.get(), -1);
  if (result == SQLITE_DONE) return {};
  backup.reset();  // puts the error on the copy, wherever it arose
  // What is new is not damaged.
  const int kind = result & 0xff;
  const bool is_source =
      kind == SQLITE_CORRUPT || kind == SQLITE_NOTADB || result == kSqliteChecksumError;
  return Unexpected(describe_error(copy.handle(), is_source ? file_ : copy.file_));
}

Expected<Statement> Database::prepare_sql(std::string_view sql) const {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(handle(), sql.data(), static_cast<int>(sql.size()), &statement, nullptr) !=
      SQLITE_OK) {
    return Unexpected(describe_error(handle(), file_));
  }
  return Statement(statement, file_);
}

std::string Database::insert_sql(std::string_view verb, std::string_view into) {
  std::string parameters = "?";
  for (auto left = std::ranges::count(into, ','); left > 0; --left) parameters += ", ?";
  return fmt::format("{} INTO {} VALUES ({})", verb, into, parameters);
}

Expected<Transaction> Transaction::begin(Database& database) {
  const bool nested = sqlite3_get_autocommit(database.handle()) == 0;
  ROOMWISE_RETURN_IF_ERROR(database.run(nested ? "SAVEPOINT nested" : "BEGIN IMMEDIATE"));
  return Transaction(database, nested);
}

Transaction::~Transaction() {
  if (database_ == nullptr) return;
  // After some errors (full disk, broken disk) SQLite has rolled back by itself.
  if (sqlite3_get_autocommit(database_->handle()) != 0) return;
  sqlite3_exec(database_->handle(), nested_ ? "ROLLBACK TO nested; RELEASE nested" : "ROLLBACK",
               nullptr, nullptr, nullptr);
}

Expected<void> Transaction::commit() {
  // Where it fails, the destructor rolls back.
  ROOMWISE_RETURN_IF_ERROR(database_->run(nested_ ? "RELEASE nested" : "COMMIT"));
  database_ = nullptr;
  return {};
}

}  // namespace roomwise::home
