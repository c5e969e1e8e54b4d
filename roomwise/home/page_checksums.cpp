#include "roomwise/home/page_checksums.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <string>

#include "roomwise/home/database.h"

namespace roomwise::home {
namespace {

static_assert(crypto_shorthash_BYTES == kChecksumBytes);
using PageChecksum = std::array<unsigned char, kChecksumBytes>;

PageChecksum checksum_of(std::span<const unsigned char> page, std::uint64_t number) {
  std::array<unsigned char, crypto_shorthash_KEYBYTES> key{};
  std::memcpy(key.data(), &number, sizeof(number));
  PageChecksum checksum{};
  crypto_shorthash(checksum.data(), page.data(), page.size() - kChecksumBytes, key.data());
  return checksum;
}

bool is_intact(std::span<const unsigned char> page, std::uint64_t number) {
  const PageChecksum checksum = checksum_of(page, number);
  return std::memcmp(checksum.data(), page.last(kChecksumBytes).data(), kChecksumBytes) == 0;
}

// The size of the pages, where they have checksums, by the first bytes of a database: see
// https://www.sqlite.org/fileformat2.html, section 1.3. Otherwise 0.
std::uint32_t checked_page_bytes(std::span<const unsigned char> header) {
  constexpr std::size_t kHeaderBytes = 100;
  if (header.size() < kHeaderBytes || std::memcmp(header.data(), "SQLite format 3", 16) != 0)
    return 0;
  const std::uint32_t bytes = std::uint32_t{header[16]} << 8 | std::uint32_t{header[17]};
  return header[20] == kChecksumBytes ? (bytes == 1 ? 65536 : bytes) : 0;
}

// A database file; the system's own file lies behind it in memory.
struct CheckedFile {
  sqlite3_file methods;      // what SQLite knows of it
  std::uint32_t page_bytes;  // 0: no checksums, or not known yet

  [[nodiscard]] static CheckedFile& of(sqlite3_file* file) {
    return *reinterpret_cast<CheckedFile*>(file);
  }
  [[nodiscard]] sqlite3_file* inner() { return reinterpret_cast<sqlite3_file*>(this + 1); }
  [[nodiscard]] const sqlite3_io_methods& io() { return *inner()->pMethods; }

  void learn(std::span<const unsigned char> bytes, sqlite3_int64 offset) {
    if (offset != 0) return;
    // Once known it stays so: a header that is damaged must not end the checks.
    if (const std::uint32_t found = checked_page_bytes(bytes); found != 0) page_bytes = found;
  }
  // Whether this is a whole page with a checksum.
  [[nodiscard]] bool is_page(std::size_t size, sqlite3_int64 offset) const {
    return page_bytes != 0 && size == page_bytes && offset % page_bytes == 0;
  }
  [[nodiscard]] std::uint64_t number(sqlite3_int64 offset) const {
    return static_cast<std::uint64_t>(offset) / page_bytes + 1;
  }
};

int close_file(sqlite3_file* file) {
  return CheckedFile::of(file).io().xClose(CheckedFile::of(file).inner());
}

int read_file_part(sqlite3_file* file, void* to, int size, sqlite3_int64 offset) {
  CheckedFile& checked = CheckedFile::of(file);
  const int result = checked.io().xRead(checked.inner(), to, size, offset);
  if (result != SQLITE_OK) return result;
  const std::span page(static_cast<const unsigned char*>(to), static_cast<std::size_t>(size));
  checked.learn(page, offset);
  if (!checked.is_page(page.size(), offset)) return result;
  return is_intact(page, checked.number(offset)) ? SQLITE_OK : kSqliteChecksumError;
}

// SQLite gives up what is written, so the checksum may go into its bytes (they are reserved).
int write_file_part(sqlite3_file* file, const void* from, int size, sqlite3_int64 offset) {
  CheckedFile& checked = CheckedFile::of(file);
  auto* bytes = static_cast<unsigned char*>(const_cast<void*>(from));
  const std::span page(bytes, static_cast<std::size_t>(size));
  checked.learn(page, offset);
  if (checked.is_page(page.size(), offset)) {
    const PageChecksum checksum = checksum_of(page, checked.number(offset));
    std::memcpy(page.last(kChecksumBytes).data(), checksum.data(), kChecksumBytes);
  }
  return checked.io().xWrite(checked.inner(), from, size, offset);
}

// One that passes a call on as it is.
template <auto kMethod>
struct Forward;
template <typename... Arguments, int (*sqlite3_io_methods::*kMethod)(sqlite3_file*, Arguments...)>
struct Forward<kMethod> {
  static int call(sqlite3_file* file, Arguments... arguments) {
    CheckedFile& checked = CheckedFile::of(file);
    return (checked.io().*kMethod)(checked.inner(), arguments...);
  }
};
template <auto kMethod>
constexpr auto kForward = &Forward<kMethod>::call;

void memory_barrier(sqlite3_file* file) {
  CheckedFile::of(file).io().xShmBarrier(CheckedFile::of(file).inner());
}

// Version 2: without pages that are mapped into memory, which nothing would check.
constexpr sqlite3_io_methods kFileMethods = {
    .iVersion = 2,
    .xClose = close_file,
    .xRead = read_file_part,
    .xWrite = write_file_part,
    .xTruncate = kForward<&sqlite3_io_methods::xTruncate>,
    .xSync = kForward<&sqlite3_io_methods::xSync>,
    .xFileSize = kForward<&sqlite3_io_methods::xFileSize>,
    .xLock = kForward<&sqlite3_io_methods::xLock>,
    .xUnlock = kForward<&sqlite3_io_methods::xUnlock>,
    .xCheckReservedLock = kForward<&sqlite3_io_methods::xCheckReservedLock>,
    .xFileControl = kForward<&sqlite3_io_methods::xFileControl>,
    .xSectorSize = kForward<&sqlite3_io_methods::xSectorSize>,
    .xDeviceCharacteristics = kForward<&sqlite3_io_methods::xDeviceCharacteristics>,
    .xShmMap = kForward<&sqlite3_io_methods::xShmMap>,
    .xShmLock = kForward<&sqlite3_io_methods::xShmLock>,
    .xShmBarrier = memory_barrier,
    .xShmUnmap = kForward<&sqlite3_io_methods::xShmUnmap>,
    .xFetch = nullptr,
    .xUnfetch = nullptr,
};

sqlite3_vfs* system_vfs() {
  static sqlite3_vfs* const vfs = sqlite3_vfs_find(nullptr);
  return vfs;
}

// Logs, journals and temporary files are the system's own.
int open_file(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  sqlite3_vfs* system = system_vfs();
  if ((flags & SQLITE_OPEN_MAIN_DB) == 0)
    return system->xOpen(system, name, file, flags, out_flags);
  CheckedFile& checked = CheckedFile::of(file);
  checked = {};
  const int result = system->xOpen(system, name, checked.inner(), flags, out_flags);
  if (checked.inner()->pMethods != nullptr) file->pMethods = &kFileMethods;
  return result;
}

const char* register_vfs() {
  static constexpr const char* kName = "roomwise-checksums";
  sqlite3_vfs* system = system_vfs();
  if (system == nullptr || sodium_init() < 0) return nullptr;
  static sqlite3_vfs vfs = *system;  // all but the opening of files is the system's
  vfs.zName = kName;
  vfs.szOsFile = system->szOsFile + static_cast<int>(sizeof(CheckedFile));
  vfs.pNext = nullptr;
  vfs.xOpen = open_file;
  return sqlite3_vfs_register(&vfs, 0) == SQLITE_OK ? kName : nullptr;
}

}  // namespace

const char* checksum_vfs() {
  static const char* const name = register_vfs();
  return name;
}

Expected<void> keep_checksums(sqlite3* connection, const std::string& file) {
  int bytes = kChecksumBytes;
  if (sqlite3_file_control(connection, "main", SQLITE_FCNTL_RESERVE_BYTES, &bytes) == SQLITE_OK)
    return {};
  return Unexpected(describe_error(connection, file));
}

Expected<PageCheck> check_pages(sqlite3* connection, const std::string& file) {
  sqlite3_file* main = nullptr;
  sqlite3_file_control(connection, "main", SQLITE_FCNTL_FILE_POINTER, &main);
  sqlite3_int64 size = 0;
  if (main == nullptr || main->pMethods == nullptr ||
      main->pMethods->xFileSize(main, &size) != SQLITE_OK) {
    return fail("{}: cannot be read", file);
  }
  const std::uint32_t page_bytes = CheckedFile::of(main).page_bytes;
  if (main->pMethods != &kFileMethods || page_bytes == 0) {
    return fail("{}: its pages have no checksums; it was made before this version", file);
  }
  constexpr int kTries = 3;  // another program may be writing the page just now
  PageCheck check{.pages = static_cast<std::uint64_t>(size) / page_bytes, .damaged = {}};
  Bytes page(page_bytes);
  for (std::uint64_t i = 0; i < check.pages; ++i) {
    int result = SQLITE_OK;
    for (int tries = 0; tries < kTries; ++tries) {
      result = main->pMethods->xRead(main, page.data(), static_cast<int>(page_bytes),
                                     static_cast<sqlite3_int64>(i) * sqlite3_int64{page_bytes});
      if (result == SQLITE_OK) break;
    }
    // A page that is free may never have been written; one in use is found when it is read.
    const bool is_blank = std::ranges::all_of(page, [](std::uint8_t byte) { return byte == 0; });
    if (result != SQLITE_OK && !is_blank) check.damaged.push_back(i + 1);
  }
  return check;
}

}  // namespace roomwise::home
