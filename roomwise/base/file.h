#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise {

using Bytes = std::vector<std::uint8_t>;

// The whole file. Fails, naming it, where it is missing, no file, or unreadable.
[[nodiscard]] Expected<Bytes> read_file(const std::filesystem::path& path);
[[nodiscard]] Expected<std::string> read_text_file(const std::filesystem::path& path);

// Whether it is an SQLite database, as a home is, by its first bytes. False where it cannot be
// read.
[[nodiscard]] bool is_database(const std::filesystem::path& path);

// Writes beside `path`, flushes to the disk and renames, so that the file is whole or unchanged
// whatever happens (killed process, full disk). A device or a pipe is written to as it is; a
// database is never overwritten: a slip of the hand must not cost a home.
[[nodiscard]] Expected<void> write_file(const std::filesystem::path& path,
                                        std::span<const std::uint8_t> bytes);
[[nodiscard]] Expected<void> write_file(const std::filesystem::path& path, std::string_view text);

// Fails where write_file() would, short of a full disk, and leaves everything as it is: to be asked
// before long work.
[[nodiscard]] Expected<void> check_can_write(const std::filesystem::path& path);

// What a call that wrote a file tells by errno: kDiskFull where there is no room (on the disk, of
// the user's share, or for a file so large), else kFailed.
[[nodiscard]] ErrorCode code_of_write_error(int error);

// Lower-case hexadecimal SHA-256.
[[nodiscard]] std::string sha256_hex(std::span<const std::uint8_t> bytes);

}  // namespace roomwise
