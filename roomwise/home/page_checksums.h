#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <vector>

#include "roomwise/base/expected.h"

// A checksum in each page of a database file, in bytes that SQLite reserves at the page's end. It
// is written with the page and checked whenever the page is read, so what a disk or a copy damaged
// is refused and never used. The log beside the file has SQLite's own checksums.
namespace roomwise::home {

// The reserved bytes of a page: a SipHash-2-4 of the rest, keyed with the number of the page, so
// that a page in the place of another is noticed, too.
constexpr int kChecksumBytes = 8;

// The name of the SQLite VFS that does it: the system's own with the checksums about it. A database
// without reserved bytes is read and written as it is. Absent where SQLite refuses it.
[[nodiscard]] const char* checksum_vfs();

// What SQLite reports of a page whose checksum is wrong.
constexpr int kSqliteChecksumError = SQLITE_IOERR_DATA;

// Makes a new database, into which nothing was written yet, keep checksums.
[[nodiscard]] Expected<void> keep_checksums(sqlite3* connection, const std::string& file);

// The pages of the main file, from 1, whose checksums are wrong; blank ones are left out. Pages
// that only the log has yet are not looked at. Fails where pages have no checksums.
struct PageCheck {
  std::uint64_t pages = 0;
  std::vector<std::uint64_t> damaged;
};
[[nodiscard]] Expected<PageCheck> check_pages(sqlite3* connection, const std::string& file);

}  // namespace roomwise::home
